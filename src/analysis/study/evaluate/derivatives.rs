//! Exact derivatives of quantities of rigid shots by parameters of the deck.

use super::{HistorySink, ReusablePlan, SampleEvaluator};
use crate::kernel::dual::derivative_along;
use crate::output::RunHistory;
use crate::plan::Plan;
use crate::solve::{FinalRow, Instant, ShotInputs, Sink as _};
use crate::study::StudyError;
use crate::study::quantity::{FinishedRun, Quantity};

/// Quantities of a sample with their derivatives.
#[derive(Clone, Debug, PartialEq)]
pub struct SampleDerivatives {
    /// Value of each quantity.
    pub values: Vec<f64>,
    /// For each quantity the derivative by each parameter.
    pub slopes: Vec<Vec<f64>>,
}

/// Change of a parameter, relative to its value, over which the inputs of a shot are differentiated. These are products,
/// powers and roots of parameters: the error of central differences is about 1e-10.
const STEP: f64 = 1e-5;
/// Relative error of the derivatives, from these differences and rounding.
pub const RELATIVE_ERROR: f64 = 1e-9;
/// Number of parameters whose derivatives are computed together.
const TOGETHER: usize = 4;

impl SampleEvaluator {
    /// Returns the quantities of a sample with their exact derivatives by all parameters. `None` if the runs are not shots
    /// [by stages](crate::solve::StagedShots), or if a parameter changes more than velocities, masses, resistances and
    /// friction.
    pub fn derivatives(&self, sample: &[f64]) -> Option<Result<SampleDerivatives, StudyError>> {
        let mut worker = self.worker();
        let derivatives = worker.plan.as_mut().and_then(|plan| plan.derivatives(self, sample));
        self.return_worker(worker);
        derivatives
    }
}

impl ReusablePlan {
    fn derivatives(
        &mut self,
        evaluator: &SampleEvaluator,
        sample: &[f64],
    ) -> Option<Result<SampleDerivatives, StudyError>> {
        self.reviser.as_ref()?;
        let slopes: Vec<ShotInputs> =
            (0..sample.len()).map(|parameter| self.input_slopes(sample, parameter)).collect::<Option<_>>()?;
        let is_valid = self.revise(evaluator, sample);
        self.staged.as_ref().filter(|_| is_valid)?;
        let mut derivatives = SampleDerivatives { values: Vec::new(), slopes: Vec::new() };
        for together in slopes.chunks(TOGETHER) {
            let row = match together {
                [one] => self.final_row([one]),
                _ => self.final_row(std::array::from_fn::<_, TOGETHER, _>(|i| &together[i.min(together.len() - 1)])),
            }?;
            if let Err(reason) = self.add_quantities(evaluator, &row, together.len(), &mut derivatives) {
                return Some(Err(reason));
            }
        }
        Some(Ok(derivatives))
    }

    /// Returns the derivatives of the inputs of a shot by a parameter: central differences or, if one of the values is not
    /// allowed, differences of second order to one side.
    fn input_slopes(&mut self, sample: &[f64], parameter: usize) -> Option<ShotInputs> {
        let value = sample[parameter];
        let step = STEP * if value == 0.0 { 1.0 } else { value.abs() };
        let mut moved = sample.to_vec();
        let mut inputs = |steps: f64| {
            moved[parameter] = value + steps * step;
            self.revise_plan(&moved).then(|| ShotInputs::of(&self.state))?
        };
        let quotient = |terms: [(f64, Option<ShotInputs>); 3]| {
            let terms: Vec<(f64, ShotInputs)> =
                terms.into_iter().map(|(factor, term)| Some((factor / step, term?))).collect::<Option<_>>()?;
            let terms: Vec<(f64, &ShotInputs)> = terms.iter().map(|(factor, term)| (*factor, term)).collect();
            ShotInputs::combined(&terms)
        };
        match [inputs(-1.0), inputs(1.0)] {
            [Some(below), Some(above)] => ShotInputs::combined(&[(-0.5 / step, &below), (0.5 / step, &above)]),
            [None, above @ Some(_)] => quotient([(-1.5, inputs(0.0)), (2.0, above), (-0.5, inputs(2.0))]),
            [below @ Some(_), None] => quotient([(1.5, inputs(0.0)), (-2.0, below), (0.5, inputs(-2.0))]),
            [None, None] => None,
        }
    }

    fn final_row<const N: usize>(&self, slopes: [&ShotInputs; N]) -> Option<FinalRow> {
        self.staged.as_ref()?.derivatives(&self.plan, &self.state, &slopes)
    }

    /// Adds the derivatives of the quantities by the first `count` parameters of a row.
    fn add_quantities(
        &mut self,
        evaluator: &SampleEvaluator,
        row: &FinalRow,
        count: usize,
        derivatives: &mut SampleDerivatives,
    ) -> Result<(), StudyError> {
        let is_first = derivatives.values.is_empty();
        for (index, quantity) in evaluator.quantities.iter().enumerate() {
            let mut number = |values: &[f64]| quantity_of(quantity, &mut self.history, values);
            let value = number(&row.values)?;
            if is_first {
                derivatives.values.push(value);
                derivatives.slopes.push(Vec::new());
            }
            for slopes in &row.slopes[..count] {
                let slopes = of_operands(quantity, &self.plan, slopes);
                let slope = derivative_along(&row.values, &slopes, &mut |values| number(values).ok());
                let missing = || StudyError::Comparison(format!("{}: no derivative at this value", quantity.text));
                derivatives.slopes[index].push(slope.filter(|slope| slope.is_finite()).ok_or_else(missing)?);
            }
        }
        Ok(())
    }
}

/// Returns the slopes of the columns that a quantity uses; zero for the others.
fn of_operands(quantity: &Quantity, plan: &Plan, slopes: &[f64]) -> Vec<f64> {
    let is_used = |name: &str| quantity.columns().any(|column| column.eq_ignore_ascii_case(name));
    let slope = |(column, slope): (_, &f64)| if is_used(column) { *slope } else { 0.0 };
    plan.columns.iter().map(|column| column.name.as_str()).zip(slopes).map(slope).collect()
}

/// Returns a quantity of final values.
fn quantity_of(quantity: &Quantity, history: &mut RunHistory, values: &[f64]) -> Result<f64, StudyError> {
    history.clear();
    let mut sink = HistorySink { history, look: &mut || {} };
    // A history in memory accepts every row.
    let _ = sink.row(&Instant::default(), values);
    quantity.number(FinishedRun { history, end: None })
}
