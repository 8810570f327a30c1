//! Entry points of a convergence study: parsing of the exact value, and the study itself.

use std::time::Instant as Stopwatch;

use super::StudyError;
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

/// Runs all levels, or refines until the error target is reached. Returns the study, the result of the target and the
/// time spent.
pub fn refine(
    bench: &mut StudyRunner<'_>,
    axes: &[StudyAxis],
    exact: Option<f64>,
    target: Option<ErrorTarget>,
) -> Result<(RefinementStudy, Option<TargetResult>, StudyTiming), StudyError> {
    let begin = Stopwatch::now();
    let (results, met) = match target {
        Some(target) => {
            let (results, met) = target::refine_to_target(bench, axes, exact, target)?;
            (results, Some(met))
        }
        None => (refinement::grid(bench, axes, exact)?, None),
    };
    let timing = StudyTiming { runs: bench.spent(), total: begin.elapsed().as_secs_f64(), repeat: bench.repeat() };
    Ok((results, met, timing))
}
