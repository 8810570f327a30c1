//! Charts of histories, with few lines each, thinned without losing peaks.

use std::io::{BufRead as _, BufReader};
use std::path::Path;

use indexmap::IndexMap;

use crate::deck::files;
use crate::deck::names::nearest;
use crate::output::csv;
use crate::output::history::STEP;
use crate::study::chart::{Chart, ChartSeries, SeriesForm};
use crate::variables::statistic::Statistic;
use crate::variables::{VariableComponent, VariablePlace};

use super::data::ColumnSummaryRow;
use super::read::in_file;
use super::shorten;
use super::units::UnitNames;

const LINES: usize = 8;
const CHARTS: usize = 12;
/// Number of intervals of a thinned line; each keeps its smallest and largest value.
const INTERVALS: usize = 300;

/// Requested columns of a history file.
#[derive(Clone, Debug, Default)]
pub struct HistoryColumns {
    pub times: Vec<f64>,
    pub columns: IndexMap<String, Vec<f64>>,
}

/// Reads the column names of `<job>_history.csv`, without time and step.
pub fn names(path: &Path) -> Result<Vec<String>, String> {
    let mut names = header(path)?;
    names.drain(..leading(&names));
    Ok(names)
}

/// Returns a hint for an unknown column name.
pub fn hint(wanted: &str, names: &[String]) -> String {
    let like = nearest(wanted, names.iter().map(String::as_str));
    like.map_or_else(|| format!("the columns are {}", names.join(", ")), |name| format!("did you mean `{name}`?"))
}

fn header(path: &Path) -> Result<Vec<String>, String> {
    let mut header = String::new();
    in_file(path, files::open(path).and_then(|file| BufReader::new(file).read_line(&mut header)))?;
    Ok(csv::fields(&header))
}

/// Returns the number of leading columns: time, and step, which old files do not have.
fn leading(names: &[String]) -> usize {
    names.len().min(if names.get(1).is_some_and(|name| name == STEP) { 2 } else { 1 })
}

/// Reads the requested columns.
pub fn read(path: &Path, wanted: &[String]) -> Result<HistoryColumns, String> {
    let file_columns = header(path)?;
    let first = leading(&file_columns);
    let position_of = |name: &String| Some(first + file_columns[first..].iter().position(|n| n == name)?);
    let places: Vec<usize> = wanted.iter().filter_map(position_of).collect();
    let file = in_file(path, files::open(path))?;
    let mut history = HistoryColumns::default();
    let mut columns = vec![Vec::new(); places.len()];
    for (i, line) in BufReader::new(file).lines().enumerate().skip(1) {
        let line = in_file(path, line)?;
        let numbers: Vec<f64> = line.split(',').map_while(|f| f.trim().parse().ok()).collect();
        if numbers.len() != file_columns.len() || line.split(',').count() != numbers.len() {
            let (line, expected) = (i + 1, file_columns.len());
            return in_file(path, Err(format!("line {line}: expected {expected} numbers: the file is damaged")));
        }
        history.times.push(numbers[0]);
        for (column, position_of) in columns.iter_mut().zip(&places) {
            column.push(numbers[*position_of]);
        }
    }
    history.columns = places.iter().map(|p| file_columns[*p].clone()).zip(columns).collect();
    Ok(history)
}

/// Selection of charts: one for the energies and one for each variable.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ChartChoice {
    /// Title and columns of each chart.
    pub charts: Vec<(String, Vec<String>)>,
    /// Number of columns that are not drawn.
    pub left_out: usize,
}

/// Selects the columns to draw. Of more than eight columns of a variable those with the largest range are drawn.
pub fn choose(names: &[String], summary: &[ColumnSummaryRow]) -> ChartChoice {
    let mut groups: IndexMap<String, Vec<String>> = IndexMap::new();
    groups.insert("Energy".into(), Vec::new());
    for name in names {
        groups.entry(group(name)).or_default().push(name.clone());
    }
    groups.retain(|_, members| !members.is_empty());
    let mut choice = ChartChoice::default();
    for (title, mut members) in groups {
        let count = members.len();
        if title == "Energy" {
            drop_zero_energies(&mut members, summary);
        } else {
            keep_largest_ranges(&mut members, summary);
        }
        if choice.charts.len() == CHARTS {
            members.clear();
        }
        choice.left_out += count - members.len();
        if !members.is_empty() {
            choice.charts.push((title, members));
        }
    }
    choice
}

/// Returns the variable of a column, without node, set and statistic; all energies are one group.
fn group(name: &str) -> String {
    let variable = Statistic::split(name.split('@').next().unwrap_or(name)).0;
    let energy = !name.contains('@')
        && VariableComponent::parse(variable).is_some_and(|p| p.variable.place() == VariablePlace::Energy);
    if energy { "Energy".into() } else { variable.to_owned() }
}

fn extent(name: &str, summary: &[ColumnSummaryRow]) -> f64 {
    summary.iter().find(|c| c.name == name).map_or(0.0, |c| c.max - c.min)
}

/// Removes energies that are zero up to rounding.
fn drop_zero_energies(members: &mut Vec<String>, summary: &[ColumnSummaryRow]) {
    let size = |name: &String| summary.iter().find(|c| c.name == *name).map(|c| c.max.abs().max(c.min.abs()));
    let largest = members.iter().filter_map(size).fold(0.0, f64::max);
    members.retain(|name| size(name).is_none_or(|s| s > 1e-12 * largest));
}

fn keep_largest_ranges(members: &mut Vec<String>, summary: &[ColumnSummaryRow]) {
    if members.len() > LINES {
        let mut extents: Vec<f64> = members.iter().map(|m| extent(m, summary)).collect();
        extents.sort_by(|a, b| b.total_cmp(a));
        members.retain(|m| extent(m, summary) >= extents[LINES - 1]);
        members.truncate(LINES);
    }
}

pub fn chart(title: &str, columns: &[String], history: &HistoryColumns, units: &UnitNames) -> Chart {
    let line = |name: &String| {
        let values = history.columns.get(name)?;
        Some(ChartSeries::new(name, SeriesForm::Line, thin(&history.times, values)))
    };
    let series = columns.iter().filter_map(line).collect();
    let y_label = if title == "Energy" { "energy" } else { title };
    let words = VariableComponent::parse(title).map_or(String::new(), |part| part.variable.row().words.to_owned());
    Chart { units: units.over_time(title), words, ..Chart::new(title, ["time", y_label], series) }
}

/// Reduces a curve to the smallest and largest value of each of `INTERVALS` intervals, and the end points.
fn thin(times: &[f64], values: &[f64]) -> Vec<(f64, f64)> {
    let mut drawn_rows: Vec<usize> = Vec::new();
    if values.len() <= 2 * INTERVALS {
        drawn_rows.extend(0..values.len());
    } else {
        drawn_rows.push(0);
        let width = values.len().div_ceil(INTERVALS);
        for start in (0..values.len()).step_by(width) {
            let part = start..(start + width).min(values.len());
            let low = part.clone().min_by(|&a, &b| values[a].total_cmp(&values[b])).unwrap_or(start);
            let high = part.max_by(|&a, &b| values[a].total_cmp(&values[b])).unwrap_or(start);
            drawn_rows.extend([low.min(high), low.max(high)]);
        }
        drawn_rows.push(values.len() - 1);
        drawn_rows.dedup();
    }
    drawn_rows.iter().filter(|&&i| values[i].is_finite()).map(|&i| (shorten(times[i]), shorten(values[i]))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn columns(names: &[&str]) -> (Vec<String>, Vec<ColumnSummaryRow>) {
        let column =
            |(i, n): (usize, &&str)| ColumnSummaryRow { name: (*n).into(), last: 0.0, min: 0.0, max: i as f64 };
        (names.iter().map(|n| (*n).into()).collect(), names.iter().enumerate().map(column).collect())
    }

    #[test]
    fn energies_share_a_chart_and_columns_with_the_largest_range_are_kept() {
        let mut names = vec!["ALLWK".to_owned(), "U2@A".into(), "ALLKE".into()];
        names.extend((0..20).map(|i| format!("S11@{i}")));
        let (names, summary) = columns(&names.iter().map(String::as_str).collect::<Vec<_>>());
        let choice = choose(&names, &summary);
        assert_eq!(choice.charts[0], ("Energy".into(), vec!["ALLKE".into()]), "ALLWK stays zero");
        assert_eq!(choice.charts[1], ("U2".into(), vec!["U2@A".into()]));
        assert_eq!(choice.charts[2].1, (12..20).map(|i| format!("S11@{i}")).collect::<Vec<_>>());
        assert_eq!(choice.left_out, 13);
    }

    #[test]
    fn thinning_keeps_a_single_peak() {
        let times: Vec<f64> = (0..100_000).map(f64::from).collect();
        let mut values = vec![0.0; 100_000];
        values[54_321] = 7.0;
        let points = thin(&times, &values);
        assert!(points.len() <= 2 * INTERVALS + 2, "{}", points.len());
        assert_eq!(points.iter().find(|p| p.1 == 7.0).map(|p| p.0), Some(54_321.0));
        assert!(points.is_sorted_by_key(|p| p.0));
    }
}
