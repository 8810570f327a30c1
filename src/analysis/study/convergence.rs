//! Entry points of a convergence study: parsing of the exact value, and the study itself.

use std::time::Instant as Stopwatch;

use super::StudyError;
use super::noise::{self, NoiseRequest};
use super::quantity::Quantity;
use super::record::StudyTiming;
use super::refinement::{self, RefinementStudy};
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
    /// Function that shows the cost of the perturbed runs before they start.
    pub announce: &'a dyn Fn(&str),
}

/// Runs all levels, or refines until the error target is reached, then measures the noise. Returns the study, the result
/// of the target and the time spent.
pub fn refine(
    bench: &mut StudyRunner<'_>,
    request: &RefinementRequest<'_>,
) -> Result<(RefinementStudy, Option<TargetResult>, StudyTiming), StudyError> {
    let begin = Stopwatch::now();
    let (axes, exact) = (request.axes, request.exact);
    let (mut results, mut met) = match request.target {
        Some(target) => {
            let (results, met) = target::refine_to_target(bench, axes, exact, target)?;
            (results, Some(met))
        }
        None => (refinement::grid(bench, axes, exact)?, None),
    };
    results.causes.clone_from(&request.causes);
    if let Some(row) = noise::level(&results, request.noise, bench.repeat()) {
        (request.announce)(&noise::announcement(&results, row, request.noise.runs));
        results.noise = Some(noise::measure(bench, axes, &results, row, request.noise)?);
        refinement::evaluate_errors(&mut results, exact, bench.measure().is_norm());
        met = request.target.map(|target| TargetResult::of(target, &results));
    }
    let timing = StudyTiming { runs: bench.spent(), total: begin.elapsed().as_secs_f64(), repeat: bench.repeat() };
    Ok((results, met, timing))
}
