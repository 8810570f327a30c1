//! A study as it is asked for: the exact value, and the way to the results.

use std::time::Instant as Stopwatch;

use super::StudyError;
use super::quantity::Quantity;
use super::record::StudyTiming;
use super::refinement::{self, Study};
use super::runner::StudyRunner;
use super::settings::Axis;
use super::target::{self, Target, TargetResult};
use crate::deck::expression::Expression;

/// The exact value of a quantity, a number or an expression; of a norm against an expression it is zero.
pub fn exact(text: Option<&str>, quantity: &Quantity) -> Result<Option<f64>, StudyError> {
    let Some(text) = text else {
        return Ok((quantity.is_norm() && !quantity.compares_fields()).then_some(0.0));
    };
    if quantity.compares_fields() {
        let message = "--exact: a norm against the finest level has no exact value; give the norm an expression";
        return Err(StudyError::Setting(message.into()));
    }
    let value = Expression::parse(text).and_then(|e| e.evaluate(&|_| None, &|_, _| None));
    value.map(Some).map_err(|e| StudyError::Setting(format!("--exact `{text}`: {}", e.message)))
}

/// Refines until a target is reached, or all that is given; says what it took.
pub fn refine(
    bench: &mut StudyRunner<'_>,
    axes: &[Axis],
    exact: Option<f64>,
    target: Option<Target>,
) -> Result<(Study, Option<TargetResult>, StudyTiming), StudyError> {
    let begin = Stopwatch::now();
    let (results, met) = match target {
        Some(target) => {
            let (results, met) = target::reach(bench, axes, exact, target)?;
            (results, Some(met))
        }
        None => (refinement::grid(bench, axes, exact)?, None),
    };
    let timing = StudyTiming { runs: bench.spent(), total: begin.elapsed().as_secs_f64(), repeat: bench.repeat() };
    Ok((results, met, timing))
}
