//! Reference tables for the results of sweeps and for histories.

use std::path::Path;

use serde::Serialize;

use super::StudyError;
use super::table::digits;
use crate::deck::files;
use crate::output::csv;

/// Reference table; its first column is the swept parameter or the time. The rows of measured samples belong to the
/// runs of a sweep in their order.
#[derive(Clone, Debug, PartialEq)]
pub struct ReferenceTable {
    /// Names of the columns, without the first.
    pub columns: Vec<String>,
    /// Value in the first column, and the values of the other columns.
    pub rows: Vec<(f64, Vec<f64>)>,
    /// Whether the last line has no line end; the file may then be truncated and its last number wrong.
    pub is_open: bool,
    /// Whether row i belongs to run i; otherwise a row belongs to the runs with its value in the first column.
    pub by_run: bool,
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
        Ok(ReferenceTable { columns, rows, is_open: !text.ends_with('\n'), by_run: false })
    }

    /// Creates the table of one measured value per run; `first` are the values of the first parameter.
    pub fn of_runs(column: &str, first: &[f64], measured: &[f64]) -> ReferenceTable {
        let rows = first.iter().zip(measured).map(|(first, measured)| (*first, vec![*measured])).collect();
        ReferenceTable { columns: vec![column.to_owned()], rows, is_open: false, by_run: true }
    }

    /// Returns the values of a run, given by its index and the value of its first parameter.
    pub fn of_run(&self, index: usize, parameter: Option<f64>) -> Option<&[f64]> {
        if self.by_run { self.rows.get(index).map(|row| row.1.as_slice()) } else { self.at(parameter?) }
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

/// Agreement of predicted with measured values. Relative values are divided by the measured value; rows measured as
/// zero have none.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Agreement {
    /// Number of rows.
    pub count: usize,
    /// Mean of predicted less measured values.
    pub bias: f64,
    /// Root mean square of the differences.
    pub rms: f64,
    /// Mean relative difference.
    pub relative_bias: f64,
    /// Root mean square of the relative differences.
    pub relative_rms: f64,
    /// Fractions of the rows with a relative difference of at most 10 % and of at most 20 %.
    pub within: [f64; 2],
}

impl Agreement {
    /// Compares pairs of a predicted and a measured value; `None` without pairs.
    pub fn of(pairs: &[(f64, f64)]) -> Option<Agreement> {
        let differences: Vec<f64> = pairs.iter().map(|(predicted, measured)| predicted - measured).collect();
        let relative: Vec<f64> = pairs.iter().filter(|p| p.1 != 0.0).map(|p| (p.0 - p.1) / p.1.abs()).collect();
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        // The tolerance keeps a difference of exactly 10 % inside.
        let inside = |most: f64| relative.iter().filter(|r| r.abs() <= most * (1.0 + 1e-12)).count() as f64;
        Some(Agreement {
            count: pairs.len(),
            bias: mean(&differences),
            rms: rms(&differences)?,
            relative_bias: mean(&relative),
            relative_rms: rms(&relative).unwrap_or(f64::NAN),
            within: [0.1, 0.2].map(|most| inside(most) / pairs.len() as f64),
        })
    }

    /// Returns the agreement as text; the last part is left out if all values were measured as zero.
    pub fn text(&self) -> String {
        let percent = |share: f64| digits(100.0 * share, 3);
        let absolute = format!("bias {}, rms {} of {} rows", digits(self.bias, 4), digits(self.rms, 4), self.count);
        if self.relative_bias.is_nan() {
            return absolute;
        }
        let [ten, twenty] = self.within.map(percent);
        format!(
            "{absolute}; relative bias {} %, rms {} %; {ten} % of the rows within 10 %, {twenty} % within 20 %",
            percent(self.relative_bias),
            percent(self.relative_rms)
        )
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
        let measured = ReferenceTable::of_runs("depth", &[5.0, 5.0], &[58.0, 60.0]);
        assert_eq!([0, 1].map(|run| measured.of_run(run, Some(5.0))), [Some(&[58.0][..]), Some(&[60.0][..])]);
        assert_eq!((reference.of_run(7, Some(570.0)), reference.of_run(0, None)), (Some(&[55.0][..]), None));
    }

    #[test]
    fn agreement_counts_relative_differences() {
        let agreement = Agreement::of(&[(110.0, 100.0), (-80.0, -100.0), (150.0, 100.0), (1.0, 0.0)]).expect("rows");
        assert_eq!((agreement.count, agreement.bias, agreement.within), (4, 20.25, [0.25, 0.5]));
        assert!(
            (agreement.relative_bias - 0.8 / 3.0).abs() < 1e-12 && (agreement.rms - 750.25_f64.sqrt()).abs() < 1e-12
        );
        assert!((agreement.relative_rms - (0.3_f64 / 3.0).sqrt()).abs() < 1e-12, "{agreement:?}");
        assert!(agreement.text().contains("25 % of the rows within 10 %, 50 % within 20 %"), "{}", agreement.text());
        assert_eq!(Agreement::of(&[]), None);
        assert!(!Agreement::of(&[(1.0, 0.0)]).expect("a row").text().contains('%'));
    }
}
