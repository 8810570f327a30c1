//! `sweep`: a deck over a grid of parameters, spread over the threads, with references beside the results.

use std::ops::Range;
use std::path::Path;

use rayon::prelude::*;

use super::StudyError;
use super::chart::{Chart, Form, Series};
use super::compare::{Reference, rms};
use super::error::accepted;
use super::grid::Grid;
use super::quantity::{self, FinishedRun, Quantity};
use super::table::{Table, number};
use crate::job;
use crate::model::Precision;
use crate::output::{History, Job};
use crate::user::compile::Compiled;

/// The results of a sweep, in the grid's order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Results {
    /// Values of the parameters of each run, as given.
    pub parameters: Vec<Vec<String>>,
    /// Value of each quantity of each run, or why there is none.
    pub values: Vec<Result<Vec<f64>, StudyError>>,
    /// What is to be known of each run's values: its warnings, and bodies that are still on their way.
    pub doubts: Vec<Vec<String>>,
}

/// Runs combinations of a grid, by their indices; with a job, writes summary and histories of each run into its own folder. The
/// results do not depend on the number of threads: user subroutines start afresh in each run.
///
/// ```
/// use revolve::model::Precision;
/// use revolve::study::{StudyError, grid::Grid, quantity::Quantity, sweep};
///
/// let grid = Grid::parse(&["V=569,781".into()])?;
/// let depth = Quantity::parse("-1000*final(U2@REF)")?;
/// let deck = ("input/ogive.inp".as_ref(), Precision::Double);
/// let results = sweep::run(deck, (&grid, 0..2), &[depth], None, None, &|| {});
/// let depths = results.values.into_iter().collect::<Result<Vec<_>, StudyError>>()?;
/// assert!(depths[1][0] > depths[0][0]); // The faster one goes deeper.
/// # Ok::<(), StudyError>(())
/// ```
pub fn run(
    deck: (&Path, Precision),
    (grid, cases): (&Grid, Range<usize>),
    quantities: &[Quantity],
    user: Option<&Compiled>,
    kept: Option<&Job>,
    done: &(dyn Fn() + Sync),
) -> Results {
    let runs: Vec<_> = cases
        .into_par_iter()
        .map(|index| {
            let combination = grid.combination(index);
            let job = kept.map(|job| Job { folder: job.path(&format!("_{:05}", index + 1)), name: job.name.clone() });
            let result = one(deck, &combination, quantities, user, job.as_ref());
            done();
            let (value, doubts) = result.map_or_else(|e| (Err(e), Vec::new()), |(value, doubts)| (Ok(value), doubts));
            (combination.into_iter().map(|p| p.1).collect(), value, doubts)
        })
        .collect();
    let mut results = Results::default();
    for (parameters, value, doubts) in runs {
        results.parameters.push(parameters);
        results.values.push(value);
        results.doubts.push(doubts);
    }
    results
}

/// One run: the quantities and what is to be known of them, or the first thing that was wrong.
fn one(
    (deck, precision): (&Path, Precision),
    overrides: &job::Overrides,
    quantities: &[Quantity],
    user: Option<&Compiled>,
    kept: Option<&Job>,
) -> Result<(Vec<f64>, Vec<String>), StudyError> {
    let routines = Compiled::open_any(user)?;
    let prepared = accepted(job::prepare_in(precision, deck, overrides, &routines))?;
    let mut history = match kept {
        None => quantity::history(quantities, &prepared.plan),
        Some(_) => History::of_rows(prepared.plan.column_names()),
    };
    let (outcome, state) = job::run_into(&prepared, &mut history);
    let run = FinishedRun { history: &history, end: Some((outcome.total_time(), &state)) };
    let values = quantities.iter().map(|q| q.number(run)).collect::<Result<_, _>>();
    let doubts = outcome.unfinished.iter().chain(&outcome.warnings).cloned().collect();
    let halt = outcome.halt.clone();
    if let Some(job) = kept {
        let written = job::write_run(&prepared, job, outcome, history);
        written.map_err(|e| StudyError::Setting(e.to_string()))?;
    }
    halt.map_or(Ok(()), |halt| Err(StudyError::Halted(halt)))?;
    Ok((values?, doubts))
}

/// What keeps a reference table from standing beside a sweep: none of its rows has a value of the first parameter.
pub fn comparable(grid: &Grid, path: &Path, reference: &Reference) -> Result<(), StudyError> {
    let Some((first, swept)) = grid.axes().first() else { return Ok(()) };
    if swept.iter().any(|v| v.parse().is_ok_and(|v| reference.at(v).is_some())) {
        return Ok(());
    }
    let known: Vec<String> = reference.rows.iter().take(5).map(|r| number(r.0)).collect();
    let more = if reference.rows.len() > 5 { ", …" } else { "" };
    let (swept, known) = (swept.join(" or "), known.join(", "));
    let message = format!("no row of it has {first} = {swept}; its first column has {known}{more}");
    Err(StudyError::file("--compare", path, message))
}

/// A sweep's results with reference columns.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ComparedTable {
    /// Parameters, quantities, references and differences from them.
    pub table: Table,
    /// Root mean square of the differences from each reference column.
    pub rms: Vec<(String, f64)>,
}

/// Puts results (of the first quantity) beside the references: for each a column and the difference from it.
pub fn table(grid: &Grid, quantities: &[Quantity], results: &Results, reference: Option<&Reference>) -> ComparedTable {
    let mut header: Vec<String> = grid.names().into_iter().map(str::to_owned).collect();
    header.extend(quantities.iter().map(|q| q.text.clone()));
    let columns = reference.map_or(&[][..], |r| &r.columns);
    for column in columns {
        header.extend([column.clone(), format!("difference from {column}")]);
    }
    let mut differences = vec![Vec::new(); columns.len()];
    let mut rows = Vec::new();
    for (parameters, values) in results.parameters.iter().zip(&results.values) {
        let Ok(values) = values else { continue };
        let mut row = parameters.clone();
        row.extend(values.iter().map(|v| number(*v)));
        let key = parameters.first().and_then(|p| p.parse::<f64>().ok());
        let beside = reference.and_then(|r| r.at(key?));
        for (i, list) in differences.iter_mut().enumerate() {
            match beside {
                Some(known) => {
                    list.push(values[0] - known[i]);
                    row.extend([number(known[i]), number(values[0] - known[i])]);
                }
                None => row.extend([String::new(), String::new()]),
            }
        }
        rows.push(row);
    }
    let rms = columns.iter().zip(&differences).filter_map(|(c, d)| Some((c.clone(), rms(d)?))).collect();
    ComparedTable { table: Table { header, rows }, rms }
}

/// Results and references over the first swept parameter: a line for each combination of the others, marks for scattered cases.
pub fn chart(
    title: &str,
    grid: &Grid,
    quantities: &[Quantity],
    results: &Results,
    reference: Option<&Reference>,
) -> Chart {
    let names = grid.names();
    let mut series: Vec<Series> = Vec::new();
    let scattered = grid.is_scattered();
    let form = if scattered { Form::Marks } else { Form::Line };
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
                None => series.push(Series::new(name, form, vec![(x, *value)])),
            }
        }
    }
    for (i, column) in reference.map_or(&[][..], |r| &r.columns).iter().enumerate() {
        let points = reference.into_iter().flat_map(|r| &r.rows).map(|r| (r.0, r.1[i])).collect();
        series.push(Series::new(column, Form::Marks, points));
    }
    let y_label = quantities.first().map_or("", |q| &q.text);
    Chart::new(title, [names.first().copied().unwrap_or_default(), y_label], series)
}

#[cfg(test)]
mod tests {
    use super::{Results, chart};
    use crate::study::chart::Form;
    use crate::study::grid::Grid;
    use crate::study::quantity::Quantity;

    #[test]
    fn scattered_cases_are_marks_of_one_series() {
        let quantities = [Quantity::parse("final(U2@REF)").expect("a quantity")];
        let drawn = |grid: &Grid| {
            let parameters = (0..grid.count()).map(|i| grid.combination(i).into_iter().map(|p| p.1).collect());
            let results = Results {
                parameters: parameters.collect(),
                values: (0..grid.count()).map(|i| Ok(vec![i as f64])).collect(),
                doubts: vec![Vec::new(); grid.count()],
            };
            let series = chart("t", grid, &quantities, &results, None).series;
            series.iter().map(|s| (s.points.len(), s.form)).collect::<Vec<_>>()
        };
        let random = Grid::random(&["V=1..2".into(), "mu=0..1".into()], 9, 1).expect("a grid");
        assert_eq!(drawn(&random), [(9, Form::Marks)]);
        let product = Grid::parse(&["V=1,2,3".into(), "mu=0,1".into()]).expect("a grid");
        assert_eq!(drawn(&product), [(3, Form::Line), (3, Form::Line)]);
    }
}
