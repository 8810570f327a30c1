//! Number tables written row by row: CSV, and Parquet if the program has the feature `parquet`.

use std::io::{self, BufWriter, Write as _};
use std::path::Path;

use super::StudyError;
use crate::output::{AtomicFile, csv};

/// Writer of a table file. The file appears under its name only when it is complete.
pub struct TableWriter {
    names: Vec<String>,
    form: TableFormat,
}

enum TableFormat {
    Csv(BufWriter<AtomicFile>),
    #[cfg(feature = "parquet")]
    Parquet(Box<parquet_file::Writer>),
}

impl TableWriter {
    /// Creates a table; the file name extension selects the format.
    pub fn begin(path: &Path, names: Vec<String>) -> Result<TableWriter, StudyError> {
        let wrong = |why: &str| StudyError::Setting(format!("--table {}: {why}", path.display()));
        let file = || AtomicFile::begin(path).map_err(failed);
        let form = match path.extension().and_then(|e| e.to_str()) {
            Some("csv") => {
                let mut file = BufWriter::new(file()?);
                file.write_all(csv::line(&names).as_bytes()).map_err(failed)?;
                TableFormat::Csv(file)
            }
            #[cfg(feature = "parquet")]
            Some("parquet") => TableFormat::Parquet(Box::new(parquet_file::begin(file()?, &names).map_err(failed)?)),
            #[cfg(not(feature = "parquet"))]
            Some("parquet") => {
                return Err(wrong(
                    "this program has no feature `parquet`; \
                     use a file name that ends in .csv, or build the program with `cargo build --release --features parquet`",
                ));
            }
            _ => {
                return Err(wrong(
                    "the file name must end in .csv, or in .parquet if the program has the feature `parquet`",
                ));
            }
        };
        Ok(TableWriter { names, form })
    }

    /// Appends rows, given one after the other; values that are not finite become empty cells.
    pub fn append(&mut self, rows: &[f64]) -> Result<(), StudyError> {
        let width = self.names.len();
        match &mut self.form {
            TableFormat::Csv(file) => rows.chunks_exact(width).try_for_each(|row| line(file, row)).map_err(failed),
            #[cfg(feature = "parquet")]
            TableFormat::Parquet(writer) => parquet_file::append(writer, rows, width).map_err(failed),
        }
    }

    /// Completes the file and gives it its name.
    pub fn finish(self) -> Result<(), StudyError> {
        let file = match self.form {
            TableFormat::Csv(file) => file.into_inner().map_err(io::IntoInnerError::into_error),
            #[cfg(feature = "parquet")]
            TableFormat::Parquet(writer) => parquet_file::end(*writer),
        };
        file.and_then(AtomicFile::finish).map_err(failed)
    }
}

fn failed(error: io::Error) -> StudyError {
    StudyError::Setting(error.to_string())
}

/// Writes a CSV line of numbers with all digits.
fn line(file: &mut impl io::Write, row: &[f64]) -> io::Result<()> {
    for (i, value) in row.iter().enumerate() {
        let comma = if i == 0 { "" } else { "," };
        if value.is_finite() { write!(file, "{comma}{value}")? } else { write!(file, "{comma}")? }
    }
    writeln!(file)
}

/// Parquet files with optional columns of doubles. They are not compressed, because random numbers hardly compress.
#[cfg(feature = "parquet")]
mod parquet_file {
    use std::io;
    use std::sync::Arc;

    use parquet::basic::{Repetition, Type as Physical};
    use parquet::data_type::DoubleType;
    use parquet::errors::Result;
    use parquet::file::writer::SerializedFileWriter;
    use parquet::schema::types::Type;

    use crate::output::AtomicFile;

    pub type Writer = SerializedFileWriter<AtomicFile>;

    pub fn begin(file: AtomicFile, names: &[String]) -> io::Result<Writer> {
        let column = |name: &String| {
            let double = Type::primitive_type_builder(name, Physical::DOUBLE);
            double.with_repetition(Repetition::OPTIONAL).build().map(Arc::new)
        };
        let columns: Result<Vec<_>> = names.iter().map(column).collect();
        let schema = columns.and_then(|columns| Type::group_type_builder("shots").with_fields(columns).build());
        let writer = schema.and_then(|schema| SerializedFileWriter::new(file, Arc::new(schema), Arc::default()));
        writer.map_err(io::Error::other)
    }

    pub fn append(writer: &mut Writer, rows: &[f64], width: usize) -> io::Result<()> {
        let write = || -> Result<()> {
            let mut group = writer.next_row_group()?;
            let mut column = 0;
            while let Some(mut next) = group.next_column()? {
                let column_values = || rows.iter().skip(column).step_by(width).copied();
                let values: Vec<f64> = column_values().filter(|v| v.is_finite()).collect();
                let present: Vec<i16> = column_values().map(|v| i16::from(v.is_finite())).collect();
                next.typed::<DoubleType>().write_batch(&values, Some(&present), None)?;
                next.close()?;
                column += 1;
            }
            group.close().map(|_| ())
        };
        let mut write = write;
        write().map_err(io::Error::other)
    }

    pub fn end(writer: Writer) -> io::Result<AtomicFile> {
        writer.into_inner().map_err(io::Error::other)
    }
}

#[cfg(test)]
mod tests {
    use super::TableWriter;

    #[test]
    fn rows_without_a_number_have_an_empty_cell() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.csv");
        let mut columns = TableWriter::begin(&path, vec!["V".into(), "at(U2, 1)".into()]).expect("a table");
        columns.append(&[1.5, 2.0, 0.1, f64::NAN]).expect("rows");
        assert!(!path.exists());
        columns.finish().expect("a file");
        assert_eq!(std::fs::read_to_string(&path).expect("a file"), "V,\"at(U2, 1)\"\n1.5,2\n0.1,\n");
        assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 1);
        assert!(TableWriter::begin(&folder.path().join("a.txt"), vec![]).is_err());
    }

    #[cfg(feature = "parquet")]
    #[test]
    fn parquet_and_csv_have_the_same_rows() {
        use parquet::file::reader::{FileReader as _, SerializedFileReader};
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.parquet");
        let mut columns = TableWriter::begin(&path, vec!["V".into(), "U".into()]).expect("a table");
        columns.append(&[1.5, 2.0, 0.1, f64::NAN]).expect("rows");
        columns.append(&[3.0, 4.0]).expect("rows");
        columns.finish().expect("a file");
        let reader = SerializedFileReader::new(std::fs::File::open(&path).expect("a file")).expect("a reader");
        let rows: Vec<String> =
            reader.get_row_iter(None).expect("rows").map(|r| r.expect("a row").to_string()).collect();
        assert_eq!(rows, ["{V: 1.5, U: 2.0}", "{V: 0.1, U: null}", "{V: 3.0, U: 4.0}"]);
    }

    #[cfg(not(feature = "parquet"))]
    #[test]
    fn parquet_without_its_feature_names_the_feature_and_csv() {
        let message = TableWriter::begin("a.parquet".as_ref(), vec![]).err().expect("an error").to_string();
        assert!(["a.parquet", "--features parquet", ".csv"].iter().all(|part| message.contains(part)), "{message}");
    }
}
