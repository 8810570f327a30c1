//! `sweep`: runs of a deck over a grid of parameters on all threads, with comparison to a reference table.

use std::path::Path;

use rayon::prelude::*;

use super::StudyError;
use super::chart::{Chart, ChartSeries, SeriesForm};
use super::compare::{Agreement, ReferenceTable};
use super::error::accepted;
use super::grid::CaseGrid;
use super::quantity::{self, FinishedRun, Quantity};
use super::table::{TextTable, number};
use crate::job;
use crate::output::{JobFiles, RunHistory};
use crate::user::compile::Compiled;

/// Results of a sweep, in the order of the grid.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SweepResults {
    /// Parameter values of each run, as given.
    pub parameters: Vec<Vec<String>>,
    /// Values of all quantities of each run, or its error.
    pub values: Vec<Result<Vec<f64>, StudyError>>,
    /// Warnings of each run, and notes on bodies that are still moving in a target.
    pub warnings: Vec<Vec<String>>,
}

/// Result of one case of a sweep.
#[derive(Clone, Debug, PartialEq)]
pub struct CaseResult {
    /// Values of all quantities, or the error of the run.
    pub values: Result<Vec<f64>, StudyError>,
    /// Warnings, and notes on bodies that are still moving in a target.
    pub warnings: Vec<String>,
}

impl SweepResults {
    /// Adds the result of the case with this index in the grid.
    pub fn push(&mut self, grid: &CaseGrid, index: usize, case: CaseResult) {
        self.parameters.push(grid.combination(index).into_iter().map(|pair| pair.1).collect());
        self.values.push(case.values);
        self.warnings.push(case.warnings);
    }
}

/// Runs cases of a grid; `done` receives the index and the result of each case when it ends. With `kept`, the summary
/// and histories of each run are written to a separate
/// folder. The results do not depend on the number of threads: user subroutines are loaded again for each run.
///
/// ```
/// # std::env::set_current_dir("../..").expect("the folder of the project");
/// use revolve::study::{StudyError, grid::CaseGrid, quantity::Quantity, sweep};
///
/// let grid = CaseGrid::parse(&["V=569,781".into()])?;
/// let depth = Quantity::parse("-1000*final(U2@REF)")?;
/// let results = sweep::run("input/ogive.inp".as_ref(), (&grid, &[0, 1]), &[depth], None, None, &|_, _| {});
/// let depths = results.into_iter().map(|case| case.values).collect::<Result<Vec<_>, StudyError>>()?;
/// assert!(depths[1][0] > depths[0][0]); // The faster projectile penetrates deeper.
/// # Ok::<(), StudyError>(())
/// ```
pub fn run(
    deck: &Path,
    (grid, cases): (&CaseGrid, &[usize]),
    quantities: &[Quantity],
    user: Option<&Compiled>,
    kept: Option<&JobFiles>,
    done: &(dyn Fn(usize, &CaseResult) + Sync),
) -> Vec<CaseResult> {
    cases
        .par_iter()
        .map(|&index| {
            let combination = grid.combination(index);
            let job =
                kept.map(|job| JobFiles { folder: job.path(&format!("_{:05}", index + 1)), name: job.name.clone() });
            let result = one(deck, &combination, quantities, user, job.as_ref());
            let (values, warnings) =
                result.map_or_else(|e| (Err(e), Vec::new()), |(values, warnings)| (Ok(values), warnings));
            let case = CaseResult { values, warnings };
            done(index, &case);
            case
        })
        .collect()
}

/// Runs one case. Returns the quantities and warnings, or the first error.
fn one(
    deck: &Path,
    overrides: &job::ParameterOverrides,
    quantities: &[Quantity],
    user: Option<&Compiled>,
    kept: Option<&JobFiles>,
) -> Result<(Vec<f64>, Vec<String>), StudyError> {
    let routines = Compiled::open_any(user)?;
    let prepared = accepted(job::prepare(deck, overrides, &routines))?;
    let mut history = match kept {
        None => quantity::history(quantities, &prepared.plan),
        Some(_) => RunHistory::of_rows(prepared.plan.column_names()),
    };
    let (outcome, state) = job::run_into(&prepared, &mut history);
    let run = FinishedRun { history: &history, end: Some((outcome.total_time(), &state)) };
    let values = quantities.iter().map(|q| q.number(run)).collect::<Result<_, _>>();
    let warnings = outcome.all_warnings();
    let halt = outcome.halt.clone();
    if let Some(job) = kept {
        let written = job::write_run(&prepared, job, outcome, history);
        written.map_err(|e| StudyError::Setting(e.to_string()))?;
    }
    halt.map_or(Ok(()), |halt| Err(StudyError::Halted(halt)))?;
    Ok((values?, warnings))
}

/// Checks that a reference table has a row for at least one value of the first parameter.
pub fn comparable(grid: &CaseGrid, path: &Path, reference: &ReferenceTable) -> Result<(), StudyError> {
    let Some((first, swept)) = grid.axes().first() else { return Ok(()) };
    if swept.iter().any(|v| v.parse().is_ok_and(|v| reference.at(v).is_some())) {
        return Ok(());
    }
    let known: Vec<String> = reference.rows.iter().take(5).map(|r| number(r.0)).collect();
    let more = if reference.rows.len() > 5 { ", …" } else { "" };
    let (swept, known) = (swept.join(" or "), known.join(", "));
    let message = format!("no row has {first} = {swept}; the values of the first column are {known}{more}");
    Err(StudyError::file("--compare", path, message))
}

/// Table of a sweep with reference columns.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ComparedTable {
    /// Parameters, quantities, references and differences.
    pub table: TextTable,
    /// Agreement of the first quantity with each reference column.
    pub agreement: Vec<(String, Agreement)>,
}

/// Creates the table of a sweep, with a column for each reference and for the difference of the first quantity from it.
pub fn table(
    grid: &CaseGrid,
    quantities: &[Quantity],
    results: &SweepResults,
    reference: Option<&ReferenceTable>,
) -> ComparedTable {
    let mut header: Vec<String> = grid.names().into_iter().map(str::to_owned).collect();
    header.extend(quantities.iter().map(|q| q.text.clone()));
    let columns = reference.map_or(&[][..], |r| &r.columns);
    for column in columns {
        header.extend([column.clone(), format!("difference from {column}")]);
    }
    let mut pairs = vec![Vec::new(); columns.len()];
    let mut rows = Vec::new();
    for (index, (parameters, values)) in results.parameters.iter().zip(&results.values).enumerate() {
        let Ok(values) = values else { continue };
        let mut row = parameters.clone();
        row.extend(values.iter().map(|v| number(*v)));
        let key = parameters.first().and_then(|p| p.parse::<f64>().ok());
        let reference_values = reference.and_then(|r| r.of_run(index, key));
        for (i, list) in pairs.iter_mut().enumerate() {
            match reference_values {
                Some(known) => {
                    list.push((values[0], known[i]));
                    row.extend([number(known[i]), number(values[0] - known[i])]);
                }
                None => row.extend([String::new(), String::new()]),
            }
        }
        rows.push(row);
    }
    let agreement = columns.iter().zip(&pairs).filter_map(|(c, p)| Some((c.clone(), Agreement::of(p)?))).collect();
    ComparedTable { table: TextTable { header, rows }, agreement }
}

/// Returns the chart of the first quantity over the measured value of each run, with the line of equal values and the
/// band of 20 % around it.
pub fn measured_chart(
    title: &str,
    quantities: &[Quantity],
    results: &SweepResults,
    measured: &ReferenceTable,
) -> Chart {
    let point = |(index, values): (usize, &Result<Vec<f64>, StudyError>)| {
        Some((measured.of_run(index, None)?[0], values.as_ref().ok()?[0]))
    };
    let points: Vec<(f64, f64)> = results.values.iter().enumerate().filter_map(point).collect();
    let ends = points.iter().fold([0.0_f64, 0.0_f64], |ends, p| [ends[0].min(p.0), ends[1].max(p.0)]);
    let edge = |factor: f64| ends.map(|end| (end, factor * end));
    let band = edge(0.8).into_iter().chain(edge(1.2).into_iter().rev()).collect();
    let (quantity, column) = (quantities.first().map_or("", |q| &q.text), &measured.columns[0]);
    let series = vec![
        ChartSeries::new("within 20 %", SeriesForm::Band, band),
        ChartSeries::new("equal", SeriesForm::Guide, edge(1.0).to_vec()),
        ChartSeries::new("runs", SeriesForm::Marks, points),
    ];
    Chart::new(title, [column, quantity], series)
}

/// Returns the chart of results and references over the first parameter: one line for each combination of the other
/// parameters, or markers for samples.
pub fn chart(
    title: &str,
    grid: &CaseGrid,
    quantities: &[Quantity],
    results: &SweepResults,
    reference: Option<&ReferenceTable>,
) -> Chart {
    let names = grid.names();
    let mut series: Vec<ChartSeries> = Vec::new();
    let scattered = grid.is_scattered();
    let form = if scattered { SeriesForm::Marks } else { SeriesForm::Line };
    for (parameters, values) in results.parameters.iter().zip(&results.values) {
        let (Ok(values), Some(x)) = (values, parameters.first().and_then(|p| p.parse::<f64>().ok())) else { continue };
        let others: Vec<_> = names.iter().zip(parameters).skip(1).map(|(n, p)| format!("{n} = {p}")).collect();
        for (quantity, value) in quantities.iter().zip(values) {
            let name = if others.is_empty() || scattered {
                quantity.text.clone()
            } else {
                format!("{} ({})", quantity.text, others.join(", "))
            };
            match series.iter_mut().find(|s| s.name == name) {
                Some(known) => known.points.push((x, *value)),
                None => series.push(ChartSeries::new(name, form, vec![(x, *value)])),
            }
        }
    }
    for (i, column) in reference.map_or(&[][..], |r| &r.columns).iter().enumerate() {
        let points = reference.into_iter().flat_map(|r| &r.rows).map(|r| (r.0, r.1[i])).collect();
        series.push(ChartSeries::new(column, SeriesForm::Marks, points));
    }
    let y_label = quantities.first().map_or("", |q| &q.text);
    Chart::new(title, [names.first().copied().unwrap_or_default(), y_label], series)
}

#[cfg(test)]
mod tests {
    use super::{SweepResults, chart};
    use crate::study::chart::SeriesForm;
    use crate::study::grid::CaseGrid;
    use crate::study::quantity::Quantity;

    #[test]
    fn samples_are_drawn_as_markers_of_one_series() {
        let quantities = [Quantity::parse("final(U2@REF)").expect("a quantity")];
        let drawn = |grid: &CaseGrid| {
            let parameters = (0..grid.count()).map(|i| grid.combination(i).into_iter().map(|p| p.1).collect());
            let results = SweepResults {
                parameters: parameters.collect(),
                values: (0..grid.count()).map(|i| Ok(vec![i as f64])).collect(),
                warnings: vec![Vec::new(); grid.count()],
            };
            let series = chart("t", grid, &quantities, &results, None).series;
            series.iter().map(|s| (s.points.len(), s.form)).collect::<Vec<_>>()
        };
        let random = CaseGrid::random(&["V=1..2".into(), "mu=0..1".into()], 9, 1).expect("a grid");
        assert_eq!(drawn(&random), [(9, SeriesForm::Marks)]);
        let product = CaseGrid::parse(&["V=1,2,3".into(), "mu=0,1".into()]).expect("a grid");
        assert_eq!(drawn(&product), [(3, SeriesForm::Line), (3, SeriesForm::Line)]);
    }
}
