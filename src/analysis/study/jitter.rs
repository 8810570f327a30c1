//! Perturbed runs of a study: their number, level and cost, and the noise that follows from them.

use super::StudyError;
use super::causes::is_sensitive;
use super::noise::{self, BetterQuantity, NOISY, NoiseEstimate, perturbations};
use super::price::setting;
use super::quantity::Quantity;
use super::refinement::RefinementStudy;
use super::runner::{StudyRun, StudyRunner};
use super::settings::StudyAxis;
use super::table::duration;
use crate::model::Model;

/// Number of perturbed runs of a model with contact, failure, element deletion or new meshes.
pub const DEFAULT_RUNS: usize = 8;
/// Number and level of the perturbed runs of a study.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseRequest {
    /// Number of perturbed runs.
    pub runs: usize,
    /// Whether the finest level is perturbed at any cost; otherwise the finest one that costs no more than the study.
    pub finest: bool,
    /// Total time at the end of the last step.
    pub end: f64,
}

impl NoiseRequest {
    /// Creates the request for `--jitter`; without it, models with contact, failure, element deletion or new
    /// meshes are perturbed.
    pub fn new(jitter: Option<usize>, model: &Model) -> NoiseRequest {
        let default = if is_sensitive(model) { DEFAULT_RUNS } else { 0 };
        let end = model.steps.iter().map(|step| step.duration).sum();
        NoiseRequest { runs: jitter.unwrap_or(default), finest: jitter.is_some(), end }
    }
}

/// Returns the level to perturb: the finest one, or the finest one whose perturbed runs have no more element-cycles
/// than the study itself. `None` without a request or without a number as result.
pub fn level(study: &RefinementStudy, request: NoiseRequest, repeat: usize) -> Option<usize> {
    let run = |row: usize| {
        let run = study.rows[row].run.as_ref().ok()?;
        run.found.number().map(|_| (row, run.element_cycles()))
    };
    let ran: Vec<(usize, f64)> = (0..study.rows.len()).filter_map(run).collect();
    let total: f64 = ran.iter().map(|r| r.1).sum::<f64>() * repeat as f64;
    let family = study.reference.and_then(|r| r.row).map_or(0, |row| study.rows[row].family);
    let candidates = || ran.iter().filter(|r| study.rows[r.0].family == family);
    let affordable = candidates().filter(|r| request.finest || request.runs as f64 * r.1 <= total);
    let finest = affordable.max_by(|a, b| a.1.total_cmp(&b.1));
    let level = finest.or_else(|| candidates().min_by(|a, b| a.1.total_cmp(&b.1)));
    level.filter(|_| request.runs > 0).map(|r| r.0)
}

/// Returns the cost of the perturbed runs, in one line.
pub fn announcement(study: &RefinementStudy, row: usize, runs: usize) -> String {
    let seconds = study.rows[row].run.as_ref().map_or(0.0, |run| run.seconds.median);
    format!(
        "noise: {runs} more runs of {} with perturbations of 1e-9 and 1e-6, about {} of CPU time (--jitter 0 omits them)",
        setting(study, row),
        duration(runs as f64 * seconds)
    )
}

/// Repeats one level of a study with perturbations, and searches a better quantity if the scatter is large.
pub fn measure(
    bench: &mut StudyRunner<'_>,
    axes: &[StudyAxis],
    study: &RefinementStudy,
    row: usize,
    request: NoiseRequest,
) -> Result<NoiseEstimate, StudyError> {
    let averaged = bench.measure().averaged(request.end * 2.0 / 3.0, request.end);
    let quantities: Vec<Quantity> = std::iter::once(bench.measure().clone()).chain(averaged).collect();
    let values = study.rows[row].values.clone();
    let runs = bench.changed(axes, &values, perturbations(request.runs), &quantities)?;
    let unperturbed = study.rows[row].value.unwrap_or_default();
    let mut estimate =
        NoiseEstimate { row, setting: setting(study, row), ..noise::of_runs(unperturbed, column(&runs, 0)) };
    if estimate.relative.is_some_and(|r| r > NOISY) && quantities.len() > 1 {
        let means: Vec<f64> = column(&runs, 1).flatten().collect();
        let relative = noise::deviation(means.iter().copied()) / means.first().map_or(1.0, |m| m.abs());
        let better = BetterQuantity { quantity: quantities[1].text.clone(), relative };
        estimate.better = Some(better).filter(|b| estimate.relative.is_some_and(|r| 3.0 * b.relative < r));
    }
    Ok(estimate)
}

/// Returns the numbers of one quantity; `None` for a run without a result.
fn column(runs: &[Vec<Result<StudyRun, StudyError>>], quantity: usize) -> impl Iterator<Item = Option<f64>> {
    runs.iter().map(move |run| run.get(quantity)?.as_ref().ok()?.found.number())
}
