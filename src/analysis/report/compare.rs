//! Comparison of histories with reference curves from a file.

use std::path::Path;

use super::history::{self, HistoryColumns, hint};
use crate::output::history::between;
use crate::study::compare::{ReferenceTable, rms};

/// Reference curve for a history column.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReferenceCurve {
    /// Name of the history column.
    pub column: String,
    pub points: Vec<(f64, f64)>,
    /// Rms deviation of the run at the times of the curve; `None` if all these times are outside the run.
    pub rms: Option<f64>,
    /// Number of times of the curve outside the run.
    pub outside: usize,
}

impl ReferenceCurve {
    pub fn name(&self) -> String {
        format!("{}, reference", self.column)
    }

    /// Returns a sentence on the deviation.
    pub fn sentence(&self) -> String {
        let Some(rms) = self.rms else {
            return format!("{}: all times of the reference are outside the run", self.column);
        };
        let largest = self.points.iter().fold(0.0_f64, |m, p| m.max(p.1.abs()));
        let part =
            if largest > 0.0 { format!(" ({:.3} % of its largest)", 100.0 * rms / largest) } else { String::new() };
        let outside = if self.outside > 0 {
            format!("; reference times outside the run: {}", self.outside)
        } else {
            String::new()
        };
        format!("rms deviation of {} from the reference: {rms:.5e}{part}{outside}", self.column)
    }
}

/// Reads the curves of a CSV file: time in the first column, then columns named like those of the history.
pub fn curves(file: &Path, history: &Path) -> Result<Vec<ReferenceCurve>, String> {
    let reference = ReferenceTable::read(file).map_err(|e| e.to_string())?;
    let known = history::names(history)?;
    let mut columns = Vec::new();
    for column in &reference.columns {
        let Some(name) = known.iter().find(|n| n.eq_ignore_ascii_case(column)) else {
            let hint = hint(column, &known);
            return Err(format!("--compare {}: the history has no column `{column}`; {hint}", file.display()));
        };
        columns.push(name.clone());
    }
    let history = history::read(history, &columns)?;
    Ok(columns.into_iter().enumerate().map(|(i, column)| curve(&reference, i, column, &history)).collect())
}

fn curve(reference: &ReferenceTable, index: usize, column: String, history: &HistoryColumns) -> ReferenceCurve {
    let mut points: Vec<(f64, f64)> = reference.rows.iter().map(|row| (row.0, row.1[index])).collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    let values = history.columns.get(&column).map_or(&[][..], Vec::as_slice);
    let deviation = |&(time, value): &(f64, f64)| Some(at(&history.times, values, time)? - value);
    let deviations: Vec<f64> = points.iter().filter_map(deviation).collect();
    ReferenceCurve { rms: rms(&deviations), outside: points.len() - deviations.len(), column, points }
}

/// Returns the value at a time by interpolation; `None` outside the run.
fn at(times: &[f64], values: &[f64], time: f64) -> Option<f64> {
    let (first, last) = (*times.first()?, *times.last()?);
    // Reference times may be rounded to a few digits.
    let near = 1e-6 * (last - first).abs();
    let meant = time.clamp(first, last);
    between(times, |row| values[row], if (meant - time).abs() <= near { meant } else { time })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn deviations_use_interpolated_values() {
        let (times, values) = ([0.0, 1.0, 2.0], [0.0, 2.0, 2.0]);
        assert_eq!([0.0, 0.25, 1.5, 2.0].map(|t| at(&times, &values, t)), [Some(0.0), Some(0.5), Some(2.0), Some(2.0)]);
        assert_eq!([-1.0, 2.1].map(|t| at(&times, &values, t)), [None, None]);
        assert_eq!((at(&[1.0], &[5.0], 1.0), at(&[], &[], 1.0)), (Some(5.0), None));
        let columns = [("A".to_owned(), values.to_vec())].into_iter().collect();
        let history = HistoryColumns { times: times.to_vec(), columns };
        let reference = ReferenceTable {
            columns: vec!["A".into()],
            rows: vec![(0.5, vec![4.0]), (9.0, vec![1.0])],
            is_open: false,
            by_run: false,
        };
        let curve = curve(&reference, 0, "A".into(), &history);
        assert_eq!((curve.rms, curve.outside), (Some(3.0), 1));
        assert!(
            curve.sentence().contains("75.000 %") && curve.sentence().contains("the run: 1"),
            "{}",
            curve.sentence()
        );
    }
}
