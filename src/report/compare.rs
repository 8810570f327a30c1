//! Curves from elsewhere beside histories, and how far a run is from them.

use std::path::Path;

use super::history::{self, HistoryColumns, hint};
use crate::output::history::between;
use crate::study::compare::{Reference, rms};

/// A curve beside a history column.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReferenceCurve {
    /// The history column that it stands beside.
    pub column: String,
    pub points: Vec<(f64, f64)>,
    /// Root mean square of the deviation of the run at its times; `None` where the run has none of them.
    pub rms: Option<f64>,
    /// How many of its times the run does not reach.
    pub outside: usize,
}

impl ReferenceCurve {
    pub fn name(&self) -> String {
        format!("{}, reference", self.column)
    }

    /// The deviation in words.
    pub fn sentence(&self) -> String {
        let Some(rms) = self.rms else {
            return format!("{}: the reference has no time that the run reaches", self.column);
        };
        let largest = self.points.iter().fold(0.0_f64, |m, p| m.max(p.1.abs()));
        let part =
            if largest > 0.0 { format!(" ({:.3} % of its largest)", 100.0 * rms / largest) } else { String::new() };
        let outside =
            if self.outside > 0 { format!("; times outside the run: {}", self.outside) } else { String::new() };
        format!("rms deviation of {} from the reference: {rms:.5e}{part}{outside}", self.column)
    }
}

/// The curves of a CSV file: times first, then columns that are named as those of the history.
pub fn curves(file: &Path, history: &Path) -> Result<Vec<ReferenceCurve>, String> {
    let reference = Reference::read(file).map_err(|e| e.to_string())?;
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

fn curve(reference: &Reference, index: usize, column: String, history: &HistoryColumns) -> ReferenceCurve {
    let mut points: Vec<(f64, f64)> = reference.rows.iter().map(|row| (row.0, row.1[index])).collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    let values = history.columns.get(&column).map_or(&[][..], Vec::as_slice);
    let deviation = |&(time, value): &(f64, f64)| Some(at(&history.times, values, time)? - value);
    let deviations: Vec<f64> = points.iter().filter_map(deviation).collect();
    ReferenceCurve { rms: rms(&deviations), outside: points.len() - deviations.len(), column, points }
}

/// The value at a time; `None` outside.
fn at(times: &[f64], values: &[f64], time: f64) -> Option<f64> {
    let (first, last) = (*times.first()?, *times.last()?);
    // Times of references are written with few digits.
    let near = 1e-6 * (last - first).abs();
    let meant = time.clamp(first, last);
    between(times, |row| values[row], if (meant - time).abs() <= near { meant } else { time })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn deviations_are_taken_between_rows() {
        let (times, values) = ([0.0, 1.0, 2.0], [0.0, 2.0, 2.0]);
        assert_eq!([0.0, 0.25, 1.5, 2.0].map(|t| at(&times, &values, t)), [Some(0.0), Some(0.5), Some(2.0), Some(2.0)]);
        assert_eq!([-1.0, 2.1].map(|t| at(&times, &values, t)), [None, None]);
        assert_eq!((at(&[1.0], &[5.0], 1.0), at(&[], &[], 1.0)), (Some(5.0), None));
        let columns = [("A".to_owned(), values.to_vec())].into_iter().collect();
        let history = HistoryColumns { times: times.to_vec(), columns };
        let reference =
            Reference { columns: vec!["A".into()], rows: vec![(0.5, vec![4.0]), (9.0, vec![1.0])], is_open: false };
        let curve = curve(&reference, 0, "A".into(), &history);
        assert_eq!((curve.rms, curve.outside), (Some(3.0), 1));
        assert!(
            curve.sentence().contains("75.000 %") && curve.sentence().contains("the run: 1"),
            "{}",
            curve.sentence()
        );
    }
}
