//! Charts of histories for `revolve chart`.

use std::path::Path;

use super::filter::CutoffFrequency;
use super::{PageOptions, ReportError, balance, compare};
use super::{find, history};
use crate::output::HISTORY;
use crate::output::sums::Checksums;
use crate::study::chart::{Chart, ChartSeries, SeriesForm};

/// Returns a chart of history columns of the run in a folder, filtered on request.
pub fn columns(
    folder: &Path,
    wanted: &[String],
    options: &PageOptions,
    filter: Option<CutoffFrequency>,
) -> Result<ComparedChart, ReportError> {
    let (name, path) = history_file(folder)?;
    let names = history::names(&path)?;
    let find = |wanted: &String| {
        let known = names.iter().find(|n| n.eq_ignore_ascii_case(wanted)).cloned();
        known.ok_or_else(|| missing("column", wanted, &names))
    };
    let columns = wanted.iter().map(find).collect::<Result<Vec<_>, _>>()?;
    options.labels.check(&columns)?;
    let mut chart = chart(&name, &path, &columns, options, filter)?;
    let curves = options.compare.as_ref().map_or(Ok(Vec::new()), |file| compare::curves(file, &path))?;
    for curve in &curves {
        chart.series.push(ChartSeries::new(curve.name(), SeriesForm::Marks, curve.points.clone()));
    }
    Ok(ComparedChart { chart, deviations: curves.iter().map(compare::ReferenceCurve::sentence).collect() })
}

/// A chart, with sentences on the deviation from reference curves.
#[derive(Clone, Debug, Default)]
pub struct ComparedChart {
    pub chart: Chart,
    /// One sentence per reference curve.
    pub deviations: Vec<String>,
}

/// Returns the chart of the energy balance with stacked stored and dissipated energies, or of all energies as lines if
/// the balance has fewer than two.
pub fn energies(folder: &Path) -> Result<Chart, ReportError> {
    let (name, path) = history_file(folder)?;
    let choice = history::choose(&history::names(&path)?, &[]);
    match choice.charts.into_iter().find(|c| c.0 == "Energy") {
        Some((_, columns)) => {
            let balance_columns: Vec<String> = balance::columns().map(str::to_owned).collect();
            if let Some(balance) = balance::chart(&history::read(&path, &balance_columns)?, &find::units(&path)) {
                return Ok(titled(&name, balance));
            }
            Ok(chart(&name, &path, &columns, &PageOptions::default(), None)?)
        }
        None => {
            Err(format!("{} contains no energies: the deck does not request them (*ENERGY OUTPUT)", path.display())
                .into())
        }
    }
}

fn history_file(folder: &Path) -> Result<(String, std::path::PathBuf), String> {
    let name = find::only_run(folder)?;
    let path = folder.join(format!("{name}{HISTORY}"));
    if !path.is_file() {
        return Err(format!("{} is missing", path.display()));
    }
    Checksums::of(folder)?.verify(&path)?;
    Ok((name, path))
}

pub(super) fn missing(what: &str, wanted: &str, names: &[String]) -> String {
    format!("there is no {what} `{wanted}`; {}", history::hint(wanted, names))
}

/// Sets the title of a chart and removes empty series.
fn titled(title: &str, mut chart: Chart) -> Chart {
    chart.series.retain(|s| !s.points.is_empty());
    Chart { title: title.into(), ..chart }
}

fn chart(
    title: &str,
    path: &Path,
    columns: &[String],
    options: &PageOptions,
    filter: Option<CutoffFrequency>,
) -> Result<Chart, String> {
    let (mut history, units) = (history::read(path, columns)?, find::units(path));
    filter.map_or(Ok(()), |filter| filter.filter(&mut history, &units))?;
    let mut chart = titled(title, history::chart("", columns, &history, &units));
    let variable = |name: &String| name.split('@').next().unwrap_or(name).to_owned();
    let all_energies = columns.iter().all(|c| !c.contains('@') && (c.starts_with("ALL") || c == "ETOTAL"));
    let first = columns.first().map(variable).unwrap_or_default();
    let alike = columns.iter().all(|c| variable(c) == first);
    let y_label = if all_energies && columns.len() > 1 {
        "energy".into()
    } else if alike {
        first
    } else {
        String::new()
    };
    chart.units = units.over_time(if y_label == "energy" { "Energy" } else { &y_label });
    // A single line is named by the axis label.
    chart.y_label = if columns.len() == 1 { options.labels.of(&columns[0]).to_owned() } else { y_label };
    chart.series.iter_mut().for_each(|s| s.name = options.labels.of(&s.name).to_owned());
    Ok(chart)
}
