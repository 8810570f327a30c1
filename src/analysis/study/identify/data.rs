//! Measured data for the identification of parameters: a table of shots with scalars and curves.

use std::path::Path;

use indexmap::IndexSet;

use crate::study::StudyError;
use crate::study::grid::records;
use crate::study::quantity::Quantity;
use crate::study::table::TextTable;

/// Placeholder of the abscissa in the quantity of a curve.
const ABSCISSA: &str = "{x}";

/// Request of measured values that have one unit and one computed counterpart.
#[derive(Clone, Debug, PartialEq)]
pub struct SeriesRequest {
    /// Column of the table: measured values, or names of curve files.
    pub column: String,
    /// Computed counterpart. For a curve, `{x}` is replaced by the abscissa of each point.
    pub quantity: String,
    /// Whether the column names files of curves.
    pub is_curve: bool,
    /// Standard deviation of the measurements: a column of the table or a number. Curves may have it as the third
    /// column of their files.
    pub deviation: Option<String>,
}

/// One measured value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observation {
    /// Index of the shot.
    pub shot: usize,
    /// Index of the series.
    pub series: usize,
    /// Abscissa of a point of a curve.
    pub abscissa: Option<f64>,
    /// Index of the computed counterpart in [`MeasuredData::quantities`].
    pub quantity: usize,
    /// Measured value.
    pub value: f64,
    /// Standard deviation of the measurement; 1 if not given.
    pub deviation: f64,
}

/// MeasurementTable of shots: known parameters and measured values.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeasuredData {
    /// Names of the known parameters.
    pub names: Vec<String>,
    /// Values of the known parameters, one row per shot.
    pub shots: Vec<Vec<f64>>,
    /// Names of the series: their columns.
    pub series: Vec<String>,
    /// Whether each series has standard deviations.
    pub has_deviations: Vec<bool>,
    /// Measured values.
    pub observations: Vec<Observation>,
    /// Expressions of the computed counterparts.
    pub quantities: IndexSet<String>,
}

impl MeasuredData {
    /// Parses the CSV table of shots. Columns that no request names are known parameters. Files of curves are relative
    /// to the folder of the table; empty cells of measured columns are measurements that were not made.
    ///
    /// # Errors
    /// If a file cannot be read, a column is absent, a cell is no number, a standard deviation is not above zero, or
    /// one of several series has no standard deviations.
    pub fn parse(path: &Path, text: &str, requests: &[SeriesRequest]) -> Result<MeasuredData, StudyError> {
        let table = MeasurementTable::parse("--shots", path, text)?;
        let mut is_known = vec![true; table.names.len()];
        let mut data = MeasuredData::default();
        for request in requests {
            let column = table.column(&request.column)?;
            is_known[column] = false;
            let deviation = DeviationSource::of(request, &table)?;
            if let DeviationSource::Column(column) = deviation {
                is_known[column] = false;
            }
            data.add_series(request, &table, column, deviation)?;
        }
        if requests.len() > 1
            && let Some(i) = data.has_deviations.iter().position(|has| !has)
        {
            let why = "has no standard deviations; with several measured quantities each needs --deviation, so that \
                       their residuals can be compared";
            return Err(table.wrong(format!("{} {why}", data.series[i])));
        }
        let known: Vec<usize> = (0..table.names.len()).filter(|i| is_known[*i]).collect();
        data.names = known.iter().map(|i| table.names[*i].clone()).collect();
        let row = |row: usize| known.iter().map(|i| table.number(row, *i)).collect::<Result<Vec<f64>, _>>();
        data.shots = (0..table.rows.len()).map(row).collect::<Result<_, _>>()?;
        Ok(data)
    }

    fn add_series(
        &mut self,
        request: &SeriesRequest,
        table: &MeasurementTable,
        column: usize,
        deviation: DeviationSource,
    ) -> Result<(), StudyError> {
        let series = self.series.len();
        let mut has_deviations = !matches!(deviation, DeviationSource::Absent);
        for shot in (0..table.rows.len()).filter(|shot| !table.rows[*shot][column].is_empty()) {
            let common = match deviation {
                DeviationSource::Absent => 1.0,
                DeviationSource::Number(number) => number,
                DeviationSource::Column(column) => table.deviation(shot, column)?,
            };
            if request.is_curve {
                let path = table.path.with_file_name(&table.rows[shot][column]);
                let curve = MeasurementTable::read(&path)?;
                has_deviations |= curve.names.len() > 2;
                for row in 0..curve.rows.len() {
                    let x = curve.number(row, 0)?;
                    let deviation = if curve.names.len() > 2 { curve.deviation(row, 2)? } else { common };
                    let quantity = request.quantity.replace(ABSCISSA, &format!("({x:?})"));
                    self.add(
                        quantity,
                        Observation { abscissa: Some(x), deviation, ..curve.observation(row, 1, [shot, series])? },
                    );
                }
            } else {
                let observation = table.observation(shot, column, [shot, series])?;
                self.add(request.quantity.clone(), Observation { deviation: common, ..observation });
            }
        }
        self.series.push(request.column.clone());
        self.has_deviations.push(has_deviations);
        Ok(())
    }

    fn add(&mut self, quantity: String, observation: Observation) {
        let (quantity, _) = self.quantities.insert_full(quantity);
        self.observations.push(Observation { quantity, ..observation });
    }

    /// Returns the parsed quantities.
    ///
    /// # Errors
    /// If an expression is not valid.
    pub fn parsed_quantities(&self) -> Result<Vec<Quantity>, StudyError> {
        self.quantities.iter().map(|text| Quantity::parse(text)).collect()
    }

    /// Returns the indices of the quantities that each shot needs, in ascending order.
    pub fn selections(&self) -> Vec<Vec<usize>> {
        let of_shot = |shot: usize| {
            let mut needed: Vec<usize> =
                self.observations.iter().filter(|o| o.shot == shot).map(|o| o.quantity).collect();
            needed.sort_unstable();
            needed.dedup();
            needed
        };
        (0..self.shots.len()).map(of_shot).collect()
    }
}

/// Source of the standard deviations of a series.
#[derive(Clone, Copy)]
enum DeviationSource {
    Absent,
    Number(f64),
    Column(usize),
}

impl DeviationSource {
    fn of(request: &SeriesRequest, table: &MeasurementTable) -> Result<DeviationSource, StudyError> {
        let Some(text) = &request.deviation else { return Ok(DeviationSource::Absent) };
        match text.parse::<f64>() {
            Ok(number) if number > 0.0 && number.is_finite() => Ok(DeviationSource::Number(number)),
            Ok(_) => Err(StudyError::Setting(format!("--deviation {text}: a standard deviation must be above zero"))),
            Err(_) => table.column(text).map(DeviationSource::Column),
        }
    }
}

/// Text cells of a CSV file with a header.
struct MeasurementTable<'a> {
    option: &'static str,
    path: &'a Path,
    names: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl MeasurementTable<'_> {
    fn read(path: &Path) -> Result<MeasurementTable<'_>, StudyError> {
        let wrong = |e: std::io::Error| StudyError::file("--curve", path, e.to_string());
        MeasurementTable::parse("--curve", path, &std::fs::read_to_string(path).map_err(wrong)?)
    }

    fn parse<'a>(option: &'static str, path: &'a Path, text: &str) -> Result<MeasurementTable<'a>, StudyError> {
        let wrong = |message: String| StudyError::file(option, path, message);
        let TextTable { header, rows } = records(text.trim_start_matches('\u{feff}'), true).map_err(wrong)?;
        if option == "--curve" && header.len() < 2 {
            return Err(wrong("expected a column of abscissae and a column of measured values".into()));
        }
        Ok(MeasurementTable { option, path, names: header, rows })
    }

    fn wrong(&self, message: String) -> StudyError {
        StudyError::file(self.option, self.path, message)
    }

    fn column(&self, name: &str) -> Result<usize, StudyError> {
        let absent = || self.wrong(format!("there is no column {name}; the columns are {}", self.names.join(", ")));
        self.names.iter().position(|known| known == name).ok_or_else(absent)
    }

    fn number(&self, row: usize, column: usize) -> Result<f64, StudyError> {
        let text = &self.rows[row][column];
        let number = text.parse::<f64>().ok().filter(|number| number.is_finite());
        number.ok_or_else(|| {
            self.wrong(format!("row {}, column {}: `{text}` is not a number", row + 1, self.names[column]))
        })
    }

    fn deviation(&self, row: usize, column: usize) -> Result<f64, StudyError> {
        let number = self.number(row, column)?;
        if number > 0.0 {
            Ok(number)
        } else {
            Err(self.wrong(format!("row {}: a standard deviation must be above zero", row + 1)))
        }
    }

    fn observation(&self, row: usize, column: usize, [shot, series]: [usize; 2]) -> Result<Observation, StudyError> {
        let value = self.number(row, column)?;
        Ok(Observation { shot, series, abscissa: None, quantity: 0, value, deviation: 1.0 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn request(column: &str, deviation: Option<&str>) -> SeriesRequest {
        let (column, deviation) = (column.to_owned(), deviation.map(str::to_owned));
        SeriesRequest { column, quantity: "final(U2)".into(), is_curve: false, deviation }
    }

    #[test]
    fn tables_of_shots_are_parsed() {
        let parse = |text: &str, deviation| MeasuredData::parse("a.csv".as_ref(), text, &[request("P", deviation)]);
        let data = parse("V,P,s,m\n1,2,0.5,3\n4,5,1,6\n7,,2,8\n", Some("s")).expect("shots");
        assert_eq!(data.names, ["V", "m"]);
        assert_eq!((data.shots.len(), data.observations.len()), (3, 2));
        let second = data.observations[1];
        assert_eq!((&data.shots[1][..], second.value, second.deviation), (&[4.0, 6.0][..], 5.0, 1.0));
        assert_eq!(parse("P\n1\n", Some("0.5")).expect("shots").observations[0].deviation, 0.5);
        for (text, deviation) in [
            ("V,Q\n1,2\n", None),
            ("V,P\n1,x\n", None),
            ("V,P\n1\n", None),
            ("V,P\nx,1\n", None),
            ("V,P\n", None),
            ("V,P,s\n1,2,0\n", Some("s")),
            ("V,P\n1,2\n", Some("s")),
        ] {
            assert!(parse(text, deviation).is_err_and(|e| e.to_string().contains("--shots a.csv")), "{text}");
        }
    }

    #[test]
    fn curves_have_one_quantity_for_each_abscissa() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("shots.csv");
        std::fs::write(folder.path().join("c1.csv"), "\u{feff}# time\nt,v\n1,10\n2,20\n").expect("a file");
        std::fs::write(folder.path().join("c2.csv"), "t,v,s\n2,30,0.5\n").expect("a file");
        let curve = SeriesRequest {
            column: "curve".into(),
            quantity: "at(V2@A, {x}*1e-6)".into(),
            is_curve: true,
            deviation: Some("2".into()),
        };
        let text = "V,curve,depth\n100,c1.csv,7\n200,c2.csv,8\n";
        let data = MeasuredData::parse(&path, text, &[curve.clone(), request("depth", Some("1"))]).expect("data");
        assert_eq!(data.quantities.iter().collect::<Vec<_>>()[1], "at(V2@A, (2.0)*1e-6)");
        assert_eq!((data.quantities.len(), data.observations.len()), (3, 5));
        assert_eq!(data.selections(), [vec![0, 1, 2], vec![1, 2]]);
        assert_eq!((data.observations[1].deviation, data.observations[2].deviation), (2.0, 0.5));
        let alone = MeasuredData::parse(&path, text, &[curve.clone(), request("depth", None)]);
        assert!(alone.is_err_and(|e| e.to_string().contains("depth has no standard deviations")));
        let absent = MeasuredData::parse(&path, "V,curve\n1,no.csv\n", &[curve]);
        assert!(absent.is_err_and(|e| e.to_string().contains("--curve") && e.to_string().contains("no.csv")));
    }
}
