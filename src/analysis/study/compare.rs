//! Reference tables for the results of sweeps and for histories.

use std::path::Path;

use super::StudyError;
use crate::deck::files;
use crate::output::csv;

/// Reference table; its first column is the swept parameter or the time.
#[derive(Clone, Debug, PartialEq)]
pub struct ReferenceTable {
    /// Names of the columns, without the first.
    pub columns: Vec<String>,
    /// Value in the first column, and the values of the other columns.
    pub rows: Vec<(f64, Vec<f64>)>,
    /// Whether the last line has no line end; the file may then be truncated and its last number wrong.
    pub is_open: bool,
}

impl ReferenceTable {
    /// Reads a CSV file with a header line.
    pub fn read(path: &Path) -> Result<ReferenceTable, StudyError> {
        let wrong = |message: String| StudyError::file("--compare", path, message);
        let text = files::read_text(path).map_err(|e| wrong(e.to_string()))?;
        ReferenceTable::parse(&text).map_err(wrong)
    }

    fn parse(text: &str) -> Result<ReferenceTable, String> {
        let mut lines = csv::lines(text);
        let (_, header) = lines.next().ok_or("the file is empty")?;
        let columns: Vec<String> = csv::fields(header).iter().skip(1).map(|c| c.trim().to_owned()).collect();
        if columns.is_empty() {
            return Err("line 1: expected a parameter column and at least one reference column".into());
        }
        let rows = lines.map(|(i, line)| row(line, columns.len()).map_err(|e| format!("line {i}: {e}")));
        let rows: Vec<(f64, Vec<f64>)> = rows.collect::<Result<_, String>>()?;
        let mut known: Vec<f64> = rows.iter().map(|row| row.0).collect();
        known.sort_by(f64::total_cmp);
        if let Some(twice) = known.windows(2).find(|pair| pair[0] == pair[1]) {
            return Err(format!("two rows have the same value {} in the first column", twice[0]));
        }
        Ok(ReferenceTable { columns, rows, is_open: !text.ends_with('\n') })
    }

    /// Returns the values of the row whose first column has this value, within a relative tolerance of 1e-9.
    pub fn at(&self, parameter: f64) -> Option<&[f64]> {
        let near = |x: f64| (x - parameter).abs() <= 1e-9 * parameter.abs().max(x.abs());
        self.rows.iter().find(|r| near(r.0)).map(|r| r.1.as_slice())
    }
}

fn row(line: &str, columns: usize) -> Result<(f64, Vec<f64>), String> {
    let parse = |field: &str| {
        let field = field.trim();
        let number = field.parse::<f64>().ok().filter(|number| number.is_finite());
        number.ok_or_else(|| format!("`{field}` is not a number"))
    };
    let values = line.split(',').map(parse).collect::<Result<Vec<_>, _>>()?;
    match values.split_first() {
        Some((parameter, rest)) if rest.len() == columns => Ok((*parameter, rest.to_vec())),
        _ => Err(format!("{} fields, but the header has {}", values.len(), columns + 1)),
    }
}

/// Returns the root mean square of differences; `None` for an empty list.
pub fn rms(differences: &[f64]) -> Option<f64> {
    let sum: f64 = differences.iter().map(|d| d * d).sum();
    (!differences.is_empty()).then(|| (sum / differences.len() as f64).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reference_rows_are_parsed_and_found() {
        let reference = ReferenceTable::parse("v,depth\n569,58\n\n570,55\n").expect("a table");
        assert_eq!(reference.at(569.0), Some(&[58.0][..]));
        assert_eq!(reference.at(571.0), None);
        assert!(!reference.is_open && ReferenceTable::parse("v,depth\n569,5").expect("a table").is_open);
        for wrong in ["", "v", "v,d\n1", "v,d\n1,x", "v,d\n1,2,3", "v,d\n1,nan", "v,d\n1,2\n1,3"] {
            assert!(ReferenceTable::parse(wrong).is_err(), "{wrong:?}");
        }
        assert_eq!(rms(&[3.0, 4.0]), Some(12.5_f64.sqrt()));
    }
}
