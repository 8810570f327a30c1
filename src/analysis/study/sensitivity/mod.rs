//! Sensitivities: derivatives of quantities by parameters of a deck with their numerical uncertainty. Shots by stages are
//! differentiated exactly, all other decks by companion runs with changed parameters.

mod differences;

use std::sync::Arc;
use std::sync::atomic::AtomicUsize;

use rayon::prelude::*;
use serde::Serialize;

use super::StudyError;
use super::causes::is_sensitive;
use super::evaluate::{
    DeckSource, RELATIVE_ERROR, SampleDerivatives, SampleEvaluator, SampleFailure, SampleTable, UserRoutines,
};
use super::log::RunLog;
use super::noise::{self, perturbations};
use super::quantity::Quantity;
use super::runner::RunSource;
use super::table::short;
use crate::job::ParameterOverrides;
use crate::model;
use crate::user::compile::Compiled;
use differences::{CHANGES, DifferenceFit, StepSeries};

/// Number of perturbed runs of a model whose noise is measured.
pub const NOISE_RUNS: usize = 8;
/// Largest change of a parameter relative to its value, in the first companion runs.
const STEP: f64 = 0.04;
/// The same in further companion runs, until the uncertainty is small enough. If noise dominates, only the last serves.
const MORE_STEPS: [f64; 2] = [0.01, 0.12];
/// Uncertainty relative to the derivative above which companion runs with other steps follow.
const CLOSE: f64 = 0.01;
/// Uncertainty of dQ/d ln p relative to Q below which a derivative that it includes counts as zero.
const NEGLIGIBLE: f64 = 1e-6;

/// Request of derivatives of quantities by parameters.
pub struct SensitivityRequest<'a> {
    /// Deck.
    pub deck: &'a DeckSource,
    /// Values of parameters that replace the values in the deck.
    pub settings: &'a ParameterOverrides,
    /// Compiled user subroutines.
    pub user: Option<&'a Arc<Compiled>>,
    /// Quantities to differentiate.
    pub quantities: &'a [Quantity],
    /// Names of the parameters.
    pub names: &'a [String],
    /// Largest change of each parameter in its unit; `None` for an automatic choice.
    pub steps: &'a [Option<f64>],
    /// Number of perturbed runs, from which the noise is estimated; `None` for [`NOISE_RUNS`] of models with contact,
    /// failure, element deletion or new meshes.
    pub jitter: Option<usize>,
    /// List of finished runs of an interrupted command.
    pub log: Option<&'a Arc<RunLog>>,
    /// Whether shots that stages could solve are integrated in increments.
    pub in_increments: bool,
    /// Number of threads.
    pub threads: usize,
    /// A nonzero value halts the runs.
    pub interrupt: &'a AtomicUsize,
}

impl SensitivityRequest<'_> {
    /// Returns the number of runs if the first companion runs suffice, without perturbed runs.
    pub fn expected_runs(&self) -> usize {
        1 + self.names.len() * CHANGES.len()
    }

    /// Creates an evaluator over parameters.
    fn evaluator(&self, names: Vec<String>) -> Result<SampleEvaluator, StudyError> {
        let user = self.user.map_or(UserRoutines::Absent, |user| UserRoutines::Files(Arc::clone(user)));
        let (deck, fixed) = (self.deck.clone(), self.settings.to_vec());
        let evaluator = SampleEvaluator::new(deck, fixed, names, self.quantities.to_vec(), user)?;
        let evaluator = if self.in_increments { evaluator.in_increments() } else { evaluator };
        match self.log {
            Some(log) => evaluator.logged(log),
            None => Ok(evaluator),
        }
    }
}

/// Method of a derivative.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum DerivativeMethod {
    /// Exact derivatives of shots by stages.
    Stages,
    /// Differences of companion runs on both sides of the value.
    Differences,
    /// Differences of companion runs on one side: values on the other side are not allowed.
    OneSided,
}

impl DerivativeMethod {
    /// Returns the words of tables.
    pub fn words(self) -> &'static str {
        match self {
            DerivativeMethod::Stages => "stages",
            DerivativeMethod::Differences => "differences",
            DerivativeMethod::OneSided => "one side",
        }
    }
}

/// Derivative with the half-width of its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DerivativeEstimate {
    /// Value of the derivative.
    pub value: f64,
    /// Half-width of its interval.
    pub uncertainty: f64,
}

impl DerivativeEstimate {
    fn scaled(self, factor: f64) -> DerivativeEstimate {
        // The sum has no negative zero.
        DerivativeEstimate { value: factor * self.value + 0.0, uncertainty: factor.abs() * self.uncertainty }
    }
}

/// Derivative of a quantity by a parameter.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Sensitivity {
    /// Name of the parameter.
    pub parameter: String,
    /// Value of the parameter.
    pub at: f64,
    /// dQ/dp; `None` if it is below the noise.
    pub derivative: Option<DerivativeEstimate>,
    /// dQ/d ln p.
    pub logarithmic: Option<DerivativeEstimate>,
    /// d ln Q/d ln p; `None` also if the quantity is zero.
    pub relative: Option<f64>,
    /// Part of the uncertainty of dQ/d ln p that follows from the noise of perturbed runs.
    pub noise: f64,
    /// Part that follows from the deviation of the companion runs from a smooth curve.
    pub deviation: f64,
    /// Change of dQ/d ln p on a coarser mesh; `None` without companion runs on it.
    pub mesh: Option<f64>,
    /// Method.
    pub method: DerivativeMethod,
    /// Largest change of the parameter in companion runs.
    pub step: Option<f64>,
    /// Parameter and quantity of each companion run.
    pub points: Vec<[f64; 2]>,
    /// Why there is no derivative.
    pub reason: Option<String>,
}

/// Derivatives of a quantity by all parameters.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct QuantitySensitivities {
    /// Expression of the quantity.
    pub quantity: String,
    /// Value of the quantity.
    pub value: f64,
    /// Standard deviation of perturbed runs; `None` if there are none.
    pub noise: Option<f64>,
    /// One entry for each parameter.
    pub parameters: Vec<Sensitivity>,
}

/// Derivatives of all quantities.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SensitivityResults {
    /// One entry for each quantity.
    pub quantities: Vec<QuantitySensitivities>,
    /// Number of runs, without those of a coarser mesh.
    pub runs: usize,
    /// Number of runs at whose end a body still moved in a target.
    pub still_moving: usize,
}

impl SensitivityResults {
    /// Returns whether all derivatives are known.
    pub fn is_complete(&self) -> bool {
        self.quantities.iter().flat_map(|of| &of.parameters).all(|of| of.derivative.is_some())
    }

    /// Returns the derivatives of each quantity by the parameters; `None` if one is unknown.
    pub fn gradients(&self) -> Option<Vec<Vec<f64>>> {
        let gradient = |of: &QuantitySensitivities| {
            of.parameters.iter().map(|parameter| Some(parameter.derivative?.value)).collect()
        };
        self.quantities.iter().map(gradient).collect()
    }

    /// Sets the change of each derivative on a coarser mesh.
    pub fn compare_with(&mut self, coarse: &SensitivityResults) {
        for (fine, coarse) in self.quantities.iter_mut().zip(&coarse.quantities) {
            for (fine, coarse) in fine.parameters.iter_mut().zip(&coarse.parameters) {
                let pair = fine.logarithmic.zip(coarse.logarithmic);
                fine.mesh = pair.map(|(fine, coarse)| (fine.value - coarse.value).abs());
            }
        }
    }
}

/// Noise of a quantity.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct QuantityNoise {
    /// Standard deviation of a run.
    deviation: f64,
    /// Half-width of the 95 % interval of a run.
    uncertainty: f64,
}

/// Differentiates all quantities by all parameters, at the values of the deck.
///
/// # Errors
/// If a parameter is a text, if one with the value zero has no step, if a step is not above zero, if the run at these
/// values fails, or if too few companion runs have a result.
pub fn sensitivities(
    request: &SensitivityRequest<'_>,
    progress: &mut dyn FnMut(usize),
) -> Result<SensitivityResults, StudyError> {
    let evaluator = request.evaluator(request.names.to_vec())?;
    let point = nominal_point(request, &evaluator)?;
    let mut companions = CompanionRuns { request, evaluator: &evaluator, progress, point: &point, runs: 0 };
    let values = companions.values(std::slice::from_ref(&point))?.remove(0)?;
    let exact = exact_slopes(request, &evaluator, &point)?;
    let others: Vec<usize> = (0..point.len()).filter(|parameter| exact[*parameter].is_none()).collect();
    let noises = if others.is_empty() { vec![None; values.len()] } else { companions.noises(&values) };
    let series = companions.all_series(&values, &others, &noises)?;
    let sensitivity = |parameter: usize, quantity: usize| {
        let (name, at, value) = (&request.names[parameter], point[parameter], values[quantity]);
        match &exact[parameter] {
            Some(slopes) => of_stages(name, at, value, slopes[quantity]),
            None => {
                let series = &series[parameter][..];
                let points = series.iter().flat_map(|series| series.points(at, quantity)).collect();
                let fit = best_fit(series, quantity, noises[quantity]);
                Sensitivity { points, ..of_differences(name, at, value, &fit) }
            }
        }
    };
    let of_quantity = |quantity: usize| QuantitySensitivities {
        quantity: request.quantities[quantity].text.clone(),
        value: values[quantity],
        noise: noises[quantity].map(|noise| noise.deviation),
        parameters: (0..point.len()).map(|parameter| sensitivity(parameter, quantity)).collect(),
    };
    let quantities = (0..values.len()).map(of_quantity).collect();
    Ok(SensitivityResults { quantities, runs: companions.runs, still_moving: evaluator.still_moving() })
}

/// Returns the values of the parameters in the deck.
fn nominal_point(request: &SensitivityRequest<'_>, evaluator: &SampleEvaluator) -> Result<Vec<f64>, StudyError> {
    let pairs = request.names.iter().zip(evaluator.nominal_values());
    let number = |(name, value): (&String, &Option<f64>)| {
        let text = || StudyError::Setting(format!("--to {name}: the parameter is a text; derivatives need a number"));
        value.ok_or_else(text)
    };
    pairs.map(number).collect()
}

/// Returns the exact derivatives of all quantities by each parameter; `None` for a parameter without them.
fn exact_slopes(
    request: &SensitivityRequest<'_>,
    evaluator: &SampleEvaluator,
    point: &[f64],
) -> Result<Vec<Option<Vec<f64>>>, StudyError> {
    let of_parameter = |derivatives: &SampleDerivatives, parameter: usize| {
        Some(derivatives.slopes.iter().map(|slopes| slopes[parameter]).collect())
    };
    if let Some(derivatives) = evaluator.derivatives(point) {
        let derivatives = derivatives?;
        return Ok((0..point.len()).map(|parameter| of_parameter(&derivatives, parameter)).collect());
    }
    let alone = |(name, value): (&String, &f64)| {
        if evaluator.deforms() || point.len() == 1 {
            return Ok(None);
        }
        let derivatives = request.evaluator(vec![name.clone()])?.derivatives(&[*value]).transpose()?;
        Ok(derivatives.and_then(|derivatives| of_parameter(&derivatives, 0)))
    };
    request.names.iter().zip(point).map(alone).collect()
}

/// Returns the largest change of a parameter in the first companion runs.
fn first_step(name: &str, value: f64, step: Option<f64>) -> Result<f64, StudyError> {
    match step {
        Some(step) if step > 0.0 && step.is_finite() => Ok(step),
        Some(step) => Err(StudyError::Setting(format!("--step {name}={step}: expected a number above zero"))),
        None if value != 0.0 => Ok(STEP * value.abs()),
        None => Err(StudyError::Setting(format!(
            "--to {name}: the parameter is zero, so that no relative change exists; give the largest change, for example \
             --step {name}=0.01"
        ))),
    }
}

/// Returns the fit with the smallest uncertainty. The scatter of runs over small changes is in larger ones, too.
fn best_fit(series: &[StepSeries], quantity: usize, noise: Option<QuantityNoise>) -> DifferenceFit {
    let noise = noise.map_or(0.0, |noise| noise.uncertainty);
    let smaller = |step: f64| series.iter().filter(move |other| other.step < step);
    let least = |step: f64| smaller(step).map(|other| other.scatter(quantity)).fold(0.0, f64::max);
    let fits = series.iter().map(|series| series.fitted(quantity, noise, least(series.step)));
    fits.reduce(DifferenceFit::best).unwrap_or_else(|| DifferenceFit::of_slope(f64::NAN))
}

/// Returns an exact derivative as a sensitivity.
fn of_stages(name: &str, at: f64, value: f64, slope: f64) -> Sensitivity {
    let fit = DifferenceFit { deviation: RELATIVE_ERROR * slope.abs(), ..DifferenceFit::of_slope(slope) };
    Sensitivity { method: DerivativeMethod::Stages, step: None, ..of_differences(name, at, value, &fit) }
}

/// Returns the sensitivity of a quantity from a fit to companion runs.
fn of_differences(name: &str, at: f64, value: f64, fit: &DifferenceFit) -> Sensitivity {
    let estimate = DerivativeEstimate { value: fit.slope, uncertainty: fit.uncertainty() };
    let reason = refusal(name, at, value, fit);
    let derivative = Some(estimate).filter(|_| reason.is_none());
    Sensitivity {
        parameter: name.to_owned(),
        at,
        derivative,
        logarithmic: derivative.map(|derivative| derivative.scaled(at)),
        relative: derivative.filter(|_| value != 0.0).map(|derivative| derivative.value * at / value + 0.0),
        noise: fit.noise * at.abs(),
        deviation: fit.deviation * at.abs(),
        mesh: None,
        method: if fit.one_sided { DerivativeMethod::OneSided } else { DerivativeMethod::Differences },
        step: Some(fit.step),
        points: Vec::new(),
        reason,
    }
}

/// Returns why a fit gives no derivative: its uncertainty includes zero and is not negligible.
fn refusal(name: &str, at: f64, value: f64, fit: &DifferenceFit) -> Option<String> {
    let scale = if at == 0.0 { fit.step } else { at.abs() };
    let uncertainty = fit.uncertainty();
    if uncertainty < fit.slope.abs() || uncertainty * scale <= NEGLIGIBLE * value.abs() {
        return None;
    }
    let cause = if fit.noise >= fit.deviation {
        "the noise of perturbed runs exceeds the difference"
    } else {
        "the runs follow no smooth curve"
    };
    let bound = short((fit.slope.abs() + uncertainty) * scale);
    let range = if at == 0.0 { short(fit.step) } else { format!("{} %", short(100.0 * fit.step / at.abs())) };
    Some(format!("{cause} over {name} ± {range}: |dQ/d ln {name}| is below {bound}"))
}

/// Runner of companion runs.
struct CompanionRuns<'a> {
    request: &'a SensitivityRequest<'a>,
    evaluator: &'a SampleEvaluator,
    progress: &'a mut dyn FnMut(usize),
    point: &'a [f64],
    /// Number of runs so far.
    runs: usize,
}

/// Values of all quantities in a run.
type RunValues = Result<Vec<f64>, StudyError>;

impl CompanionRuns<'_> {
    /// Evaluates the quantities for values of all parameters.
    fn values(&mut self, samples: &[Vec<f64>]) -> Result<Vec<RunValues>, StudyError> {
        let width = self.request.quantities.len();
        let flat: Vec<f64> = samples.iter().flatten().copied().collect();
        let mut table = vec![f64::NAN; samples.len() * width];
        let samples = SampleTable { values: &flat, count: samples.len() };
        let (previous, progress) = (self.runs, &mut *self.progress);
        let SensitivityRequest { threads, interrupt, .. } = *self.request;
        let mut look = |finished: usize| progress(previous + finished);
        let failures = self.evaluator.run(samples, &mut table, threads, interrupt, &mut look)?;
        let mut rows: Vec<RunValues> = table.chunks(width).map(|row| Ok(row.to_vec())).collect();
        failures.into_iter().for_each(|SampleFailure { row, reason }| rows[row] = Err(reason));
        self.runs += samples.count;
        Ok(rows)
    }

    /// Estimates the noise of each quantity from perturbed runs; `None` without them.
    fn noises(&mut self, values: &[f64]) -> Vec<Option<QuantityNoise>> {
        let SensitivityRequest { deck, settings, quantities, interrupt, .. } = *self.request;
        let read = |overrides: &ParameterOverrides| deck.read(overrides);
        let user = self.request.user.map(|user| &**user);
        let source = RunSource { deck: &read, user, interrupt: Some(interrupt) };
        let by_default = || if is_sensitive(&model::build(&read(settings).0).0) { NOISE_RUNS } else { 0 };
        let edits = perturbations(self.request.jitter.unwrap_or_else(by_default));
        let run = |edit: &_| source.run(settings, &[std::slice::from_ref(edit)], quantities);
        let runs: Vec<_> = edits.par_iter().map(run).collect();
        self.runs += runs.len();
        let of_quantity = |(index, value): (usize, &f64)| {
            let numbers = runs.iter().map(|run| run.get(index)?.as_ref().ok()?.found.number());
            let estimate = noise::of_runs(*value, numbers);
            let noise = QuantityNoise { deviation: estimate.deviation, uncertainty: estimate.uncertainty };
            (estimate.runs > 0).then_some(noise)
        };
        values.iter().enumerate().map(of_quantity).collect()
    }

    /// Runs the companion runs of some parameters until all derivatives are close enough. Returns the series of each
    /// parameter.
    fn all_series(
        &mut self,
        values: &[f64],
        parameters: &[usize],
        noises: &[Option<QuantityNoise>],
    ) -> Result<Vec<Vec<StepSeries>>, StudyError> {
        let SensitivityRequest { names, steps, .. } = *self.request;
        let mut series = vec![Vec::new(); names.len()];
        let first = |parameter: &usize| {
            first_step(&names[*parameter], self.point[*parameter], steps[*parameter]).map(|step| (*parameter, step))
        };
        let mut next = parameters.iter().map(first).collect::<Result<Vec<(usize, f64)>, _>>()?;
        for more in MORE_STEPS {
            self.add_series(values, &next, &mut series)?;
            let point = self.point;
            let is_open = |parameter: &usize| {
                let of_parameter: &[StepSeries] = &series[*parameter];
                let fits = (0..values.len()).map(|quantity| best_fit(of_parameter, quantity, noises[quantity]));
                let open: Vec<_> = fits.filter(|fit| fit.uncertainty() > CLOSE * fit.slope.abs()).collect();
                // Smaller steps have more noise.
                let serves = more > STEP || open.iter().any(|fit| fit.noise < fit.deviation);
                steps[*parameter].is_none() && !open.is_empty() && serves
            };
            let open = parameters.iter().filter(|parameter| is_open(parameter));
            next = open.map(|parameter| (*parameter, more * point[*parameter].abs())).collect();
        }
        self.add_series(values, &next, &mut series)?;
        Ok(series)
    }

    /// Runs one series for each parameter with its largest change.
    fn add_series(
        &mut self,
        values: &[f64],
        steps: &[(usize, f64)],
        series: &mut [Vec<StepSeries>],
    ) -> Result<(), StudyError> {
        let mut samples = Vec::new();
        for (parameter, step) in steps {
            for change in CHANGES {
                let mut sample = self.point.to_vec();
                sample[*parameter] += change * step;
                samples.push(sample);
            }
        }
        let rows = self.values(&samples)?;
        for (rows, (parameter, step)) in rows.chunks(CHANGES.len()).zip(steps) {
            let of_parameter = &mut series[*parameter];
            match StepSeries::new(values, *step, rows) {
                Ok(found) => of_parameter.push(found),
                // A further series is not necessary.
                Err(_) if !of_parameter.is_empty() => {}
                Err(failure) => return Err(failure.error(&self.request.names[*parameter])),
            }
        }
        Ok(())
    }
}
