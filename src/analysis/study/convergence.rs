//! Entry points of a convergence study: parsing of the exact value, and the study itself.

use std::time::Instant as Stopwatch;

use super::StudyError;
use super::jitter::{self, NoiseRequest};
use super::quantity::Quantity;
use super::record::{CompletedStudy, StudyTiming};
use super::refinement::{self, RefinementStudy, StudyRow};
use super::richardson::{ConvergenceBehaviour, LimitEstimate};
use super::runner::StudyRunner;
use super::settings::StudyAxis;
use super::target::{self, ErrorTarget, TargetResult};
use crate::deck::expression::Expression;

/// Parses the exact value of a quantity, a number or an expression. A norm against an expression has the exact value
/// zero.
pub fn exact(text: Option<&str>, quantity: &Quantity) -> Result<Option<f64>, StudyError> {
    let Some(text) = text else {
        return Ok((quantity.is_norm() && !quantity.compares_fields()).then_some(0.0));
    };
    if quantity.compares_fields() {
        let message = "--exact: a norm against the finest level has no exact value; use norm(VARIABLE, EXPR)";
        return Err(StudyError::Setting(message.into()));
    }
    let value = Expression::parse(text).and_then(|e| e.evaluate(&|_| None, &|_, _| None));
    value.map(Some).map_err(|e| StudyError::Setting(format!("--exact `{text}`: {}", e.message)))
}

/// Request of a convergence study.
pub struct RefinementRequest<'a> {
    /// Parameters with their levels or choices.
    pub axes: &'a [StudyAxis],
    /// Exact value of the quantity.
    pub exact: Option<f64>,
    /// Error target.
    pub target: Option<ErrorTarget>,
    /// Perturbed runs.
    pub noise: NoiseRequest,
    /// Properties of the model that can limit the order of convergence.
    pub causes: Vec<&'static str>,
    /// Whether a level with twice as many elements along each edge is added if the order is not confirmed.
    pub around: bool,
    /// Function that shows the cost of the perturbed runs before they start.
    pub announce: &'a dyn Fn(&str),
}

/// Runs all levels, or refines until the error target is reached, then measures the noise.
pub fn refine(bench: &mut StudyRunner<'_>, request: &RefinementRequest<'_>) -> Result<CompletedStudy, StudyError> {
    let begin = Stopwatch::now();
    let (axes, exact) = (request.axes, request.exact);
    let (mut study, mut target) = match request.target {
        Some(target) => {
            let (study, result) = target::refine_to_target(bench, axes, exact, target)?;
            (study, Some(result))
        }
        None if request.around => (around(bench, axes, exact)?, None),
        None => (refinement::grid(bench, axes, exact)?, None),
    };
    study.causes.clone_from(&request.causes);
    if let Some(row) = jitter::level(&study, request.noise, bench.repeat()) {
        (request.announce)(&jitter::announcement(&study, row, request.noise.runs));
        study.noise = Some(jitter::measure(bench, axes, &study, row, request.noise)?);
        refinement::evaluate_errors(&mut study, exact, bench.measure().is_norm());
        target = request.target.map(|target| TargetResult::of(target, &study));
    }
    let timing = StudyTiming { runs: bench.spent(), total: begin.elapsed().as_secs_f64(), repeat: bench.repeat() };
    Ok(CompletedStudy { study, target, timing })
}

/// Runs the levels of the mesh, and a finer one if their order is not confirmed.
fn around(bench: &mut StudyRunner<'_>, axes: &[StudyAxis], exact: Option<f64>) -> Result<RefinementStudy, StudyError> {
    let mut study = refinement::grid(bench, axes, exact)?;
    let (Some(series), [axis]) = (study.series.first_mut(), axes) else { return Ok(study) };
    let is_confirmed =
        |e: LimitEstimate| matches!(e.behaviour, ConvergenceBehaviour::Asymptotic | ConvergenceBehaviour::Settled);
    let finest = axis.sizes.last().copied().unwrap_or(1.0);
    if !series.estimate.is_some_and(is_confirmed) {
        let values = vec![(2.0 / finest).to_string()];
        let run = bench.at(axes, &values, None);
        series.rows.push(study.rows.len());
        series.sizes.push(0.5 * finest);
        study.rows.push(StudyRow::new(values, run, 0));
        refinement::evaluate_errors(&mut study, exact, bench.measure().is_norm());
    }
    Ok(study)
}
