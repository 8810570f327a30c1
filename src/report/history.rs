//! Histories as charts: few lines each, thinned so that no peak is lost.

use std::io::{BufRead as _, BufReader};
use std::path::Path;

use indexmap::IndexMap;

use crate::deck::files;
use crate::deck::names::nearest;
use crate::output::csv;
use crate::output::history::STEP;
use crate::study::chart::{Chart, Form, Series};
use crate::variables::statistic::Statistic;
use crate::variables::{Part, Place};

use super::data::Column;
use super::shorten;
use super::units::UnitNames;

const LINES: usize = 8;
const CHARTS: usize = 12;
/// Intervals a thinned line is cut into; each keeps its smallest and its largest value.
const INTERVALS: usize = 300;

/// A history file: the columns that were asked for.
#[derive(Clone, Debug, Default)]
pub struct HistoryColumns {
    pub times: Vec<f64>,
    pub columns: IndexMap<String, Vec<f64>>,
}

/// Names of the columns of a `<job>_history.csv`, without time and step.
pub fn names(path: &Path) -> Result<Vec<String>, String> {
    let mut names = header(path)?;
    names.drain(..leading(&names));
    Ok(names)
}

/// What may have been meant by a name that is not there.
pub fn hint(wanted: &str, names: &[String]) -> String {
    let like = nearest(wanted, names.iter().map(String::as_str));
    like.map_or_else(|| format!("there are {}", names.join(", ")), |name| format!("did you mean `{name}`?"))
}

fn header(path: &Path) -> Result<Vec<String>, String> {
    let file = files::open(path).map_err(|e| format!("{}: {e}", path.display()))?;
    let mut header = String::new();
    BufReader::new(file).read_line(&mut header).map_err(|e| format!("{}: {e}", path.display()))?;
    Ok(csv::fields(&header))
}

/// How many columns are before those of the deck: the time, and the step that files of today have.
fn leading(names: &[String]) -> usize {
    names.len().min(if names.get(1).is_some_and(|name| name == STEP) { 2 } else { 1 })
}

/// Reads the chosen columns.
pub fn read(path: &Path, wanted: &[String]) -> Result<HistoryColumns, String> {
    let all = header(path)?;
    let first = leading(&all);
    let place = |name: &String| Some(first + all[first..].iter().position(|n| n == name)?);
    let places: Vec<usize> = wanted.iter().filter_map(place).collect();
    let file = files::open(path).map_err(|e| format!("{}: {e}", path.display()))?;
    let mut history = HistoryColumns::default();
    let mut columns = vec![Vec::new(); places.len()];
    for (i, line) in BufReader::new(file).lines().enumerate().skip(1) {
        let line = line.map_err(|e| format!("{}: {e}", path.display()))?;
        let numbers: Vec<f64> = line.split(',').map_while(|f| f.trim().parse().ok()).collect();
        if numbers.len() != all.len() || line.split(',').count() != numbers.len() {
            let expected = all.len();
            return Err(format!("{}: line {} is not {expected} numbers: the file is damaged", path.display(), i + 1));
        }
        history.times.push(numbers[0]);
        for (column, place) in columns.iter_mut().zip(&places) {
            column.push(numbers[*place]);
        }
    }
    history.columns = places.iter().map(|p| all[*p].clone()).zip(columns).collect();
    Ok(history)
}

/// Charts to draw: the energies together, then one for each variable.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ChartChoice {
    /// Title and columns of each chart.
    pub charts: Vec<(String, Vec<String>)>,
    /// How many columns are not drawn.
    pub left_out: usize,
}

/// Which columns to draw. Of more than eight of one variable those that vary most are drawn.
pub fn choose(names: &[String], summary: &[Column]) -> ChartChoice {
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
            drop_silent(&mut members, summary);
        } else {
            keep_liveliest(&mut members, summary);
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

/// The variable of a column, whatever of a set it is; all energies are one group.
fn group(name: &str) -> String {
    let variable = Statistic::split(name.split('@').next().unwrap_or(name)).0;
    let energy = !name.contains('@') && Part::parse(variable).is_some_and(|p| p.variable.place() == Place::Energy);
    if energy { "Energy".into() } else { variable.to_owned() }
}

fn extent(name: &str, summary: &[Column]) -> f64 {
    summary.iter().find(|c| c.name == name).map_or(0.0, |c| c.max - c.min)
}

/// Energies that stay zero, up to rounding, need no line.
fn drop_silent(members: &mut Vec<String>, summary: &[Column]) {
    let size = |name: &String| summary.iter().find(|c| c.name == *name).map(|c| c.max.abs().max(c.min.abs()));
    let largest = members.iter().filter_map(size).fold(0.0, f64::max);
    members.retain(|name| size(name).is_none_or(|s| s > 1e-12 * largest));
}

fn keep_liveliest(members: &mut Vec<String>, summary: &[Column]) {
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
        Some(Series::new(name, Form::Line, thin(&history.times, values)))
    };
    let series = columns.iter().filter_map(line).collect();
    let y_label = if title == "Energy" { "energy" } else { title };
    let words = Part::parse(title).map_or(String::new(), |part| part.variable.row().words.to_owned());
    Chart { units: units.over_time(title), words, ..Chart::new(title, ["time", y_label], series) }
}

/// Smallest and largest value of each of a few hundred intervals, the ends always.
fn thin(times: &[f64], values: &[f64]) -> Vec<(f64, f64)> {
    let mut kept: Vec<usize> = Vec::new();
    if values.len() <= 2 * INTERVALS {
        kept.extend(0..values.len());
    } else {
        kept.push(0);
        let width = values.len().div_ceil(INTERVALS);
        for start in (0..values.len()).step_by(width) {
            let part = start..(start + width).min(values.len());
            let low = part.clone().min_by(|&a, &b| values[a].total_cmp(&values[b])).unwrap_or(start);
            let high = part.max_by(|&a, &b| values[a].total_cmp(&values[b])).unwrap_or(start);
            kept.extend([low.min(high), low.max(high)]);
        }
        kept.push(values.len() - 1);
        kept.dedup();
    }
    kept.iter().filter(|&&i| values[i].is_finite()).map(|&i| (shorten(times[i]), shorten(values[i]))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn columns(names: &[&str]) -> (Vec<String>, Vec<Column>) {
        let column = |(i, n): (usize, &&str)| Column { name: (*n).into(), last: 0.0, min: 0.0, max: i as f64 };
        (names.iter().map(|n| (*n).into()).collect(), names.iter().enumerate().map(column).collect())
    }

    #[test]
    fn energies_go_together_and_a_crowd_is_thinned_to_its_liveliest() {
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
