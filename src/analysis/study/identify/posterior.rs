//! Posterior distribution of the identified parameters by an affine-invariant ensemble sampler (Goodman and Weare,
//! Comm. App. Math. Comp. Sci. 5 (2010) 65, doi:10.2140/camcos.2010.5.65).

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use hammer_and_sample::{MinChainLen, Model, Parallel, Stretch, auto_corr_time, sample};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::RngCore as _;
use rayon::iter::{IntoParallelRefIterator as _, ParallelIterator as _};

use super::IdentificationProblem;
use crate::study::StudyError;
use crate::study::statistics::cholesky::CholeskyFactor;
use crate::study::statistics::design::{draws, unit};
use crate::study::statistics::least_squares::ParameterFit;
use crate::study::statistics::summary::between;
use crate::study::statistics::{IntervalEstimate, TAIL, normal};
use crate::user::thread_pool;

/// Number of independent ensembles; R-hat compares them.
const ENSEMBLES: usize = 4;
/// Steps of the first round. Each further round adds at least half of the previous steps.
const FIRST_STEPS: usize = 250;
/// Largest R-hat of a converged posterior (Vehtari and others 2021, doi:10.1214/20-BA1221).
const CONVERGED: f64 = 1.01;
/// Ratio of the largest and the smallest standard deviation of a residual to that of the fit.
const DEVIATION_RANGE: f64 = 1e3;
/// Number of posterior draws for the prediction bands.
const PREDICTIONS: usize = 400;
/// Attempts to find an initial position that can be evaluated.
const ATTEMPTS: usize = 100;

/// Settings of the sampler.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PosteriorRequest {
    /// Smallest effective sample size of each parameter.
    pub effective: f64,
    /// Largest number of runs.
    pub most_runs: usize,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Whether each series with standard deviations has an unknown model error in addition.
    pub model_error: bool,
}

/// Draws from the posterior distribution, with diagnostics.
#[derive(Clone, Debug, PartialEq)]
pub struct Posterior {
    /// Names of the unknown parameters, followed by those of the standard deviations of residuals.
    pub names: Vec<String>,
    /// Draws after the warm-up, each with one number per name.
    pub draws: Vec<Vec<f64>>,
    /// Potential scale reduction of each parameter over the halves of independent ensembles.
    pub r_hat: Vec<f64>,
    /// Effective sample size of each parameter.
    pub effective: Vec<f64>,
    /// Fraction of accepted moves.
    pub acceptance: f64,
    /// Number of runs.
    pub runs: usize,
    /// Whether R-hat and the effective sample sizes reached their limits.
    pub converged: bool,
    /// Limits of the central 95 % of a new measurement of each observation: posterior of the parameters, measurement
    /// error and model error.
    pub predictions: Vec<[f64; 2]>,
}

impl Posterior {
    /// Returns the median of each parameter with the central 95 % interval.
    pub fn estimates(&self) -> Vec<IntervalEstimate> {
        let estimate = |i: usize| {
            let mut values: Vec<f64> = self.draws.iter().map(|draw| draw[i]).collect();
            values.sort_by(f64::total_cmp);
            let [low, value, high] = [TAIL, 0.5, 1.0 - TAIL].map(|part| between(&values, part));
            IntervalEstimate { value, low, high }
        };
        (0..self.names.len()).map(estimate).collect()
    }

    /// Returns the largest R-hat of all parameters.
    pub fn worst_r_hat(&self) -> f64 {
        self.r_hat.iter().copied().fold(0.0, f64::max)
    }

    /// Returns the smallest effective sample size of all parameters.
    pub fn least_effective(&self) -> f64 {
        self.effective.iter().copied().fold(f64::INFINITY, f64::min)
    }
}

/// Draws from the posterior distribution. The prior is uniform within the bounds of the parameters, and unbounded
/// without bounds. An unknown standard deviation s of residuals has the prior 1/s, a model error in addition to known
/// standard deviations a uniform prior. Residuals are independent and normal. `look` receives the number of runs.
///
/// # Errors
/// If a parameter without bounds is not determined by the data, if no initial position can be evaluated, or if
/// `most_runs` is too small for the first round.
pub fn posterior(
    problem: &IdentificationProblem<'_>,
    fit: &ParameterFit,
    request: PosteriorRequest,
    look: &(dyn Fn(usize) + Sync),
) -> Result<Posterior, StudyError> {
    let wrong = |e: rayon::ThreadPoolBuildError| StudyError::Setting(format!("cannot start threads: {e}"));
    let pool = thread_pool(problem.threads).build().map_err(wrong)?;
    let likelihood = PosteriorDensity::new(problem, fit, request.model_error, look);
    let mut posterior = pool.install(|| ensembles(&likelihood, fit, request))?;
    posterior.predictions = likelihood.predictions(&posterior.draws, request.seed)?;
    posterior.runs = likelihood.runs.load(Ordering::Relaxed);
    let width = problem.unknowns.len();
    posterior.draws.iter_mut().for_each(|draw| draw[width..].iter_mut().for_each(|s| *s = libm::exp(*s)));
    Ok(posterior)
}

/// Runs all ensembles until they agree.
fn ensembles(
    likelihood: &PosteriorDensity<'_>,
    fit: &ParameterFit,
    request: PosteriorRequest,
) -> Result<Posterior, StudyError> {
    let walkers = (2 * likelihood.size() + 2).max(12);
    let initial = |ensemble: usize| {
        let mut draws = draws(request.seed, stream(0, ensemble, walkers));
        (0..walkers).map(|_| likelihood.initial(fit, &mut draws)).collect::<Result<Vec<_>, _>>()
    };
    let mut chains: Vec<Vec<Vec<f64>>> = (0..ENSEMBLES).map(initial).collect::<Result<_, _>>()?;
    let (mut steps, mut accepted, mut diagnostics) = (0, 0, ChainDiagnostics::default());
    for round in 1.. {
        let more = FIRST_STEPS.max(steps / 2);
        let runs = ENSEMBLES * walkers * (more + 1) * likelihood.problem.data.shots.len();
        if likelihood.runs.load(Ordering::Relaxed) + runs > request.most_runs {
            if steps > 0 {
                break;
            }
            let allowed = request.most_runs;
            return Err(StudyError::Setting(format!(
                "--posterior needs at least {runs} runs, but --most-runs allows {allowed}"
            )));
        }
        let numbered: Vec<(usize, &Vec<Vec<f64>>)> = chains.iter().enumerate().collect();
        let run = |(ensemble, chain): &(usize, &Vec<Vec<f64>>)| {
            let last = chain[chain.len() - walkers..].iter().cloned().enumerate();
            let positions = last.map(|(i, state)| (state, draws(request.seed, stream(round, *ensemble, i))));
            sample(likelihood, &Stretch::default(), positions, MinChainLen(more * walkers), Parallel)
        };
        let extensions: Vec<(Vec<Vec<f64>>, usize)> = numbered.par_iter().map(run).collect();
        likelihood.check()?;
        if steps == 0 {
            chains.iter_mut().for_each(Vec::clear);
        }
        for (chain, (extension, moves)) in chains.iter_mut().zip(extensions) {
            chain.extend(extension);
            accepted += moves;
        }
        steps += more;
        diagnostics = likelihood.diagnose(&chains, walkers);
        if diagnostics.is_converged(request.effective) {
            break;
        }
    }
    let warm = |chain: Vec<Vec<f64>>| chain.into_iter().skip(steps / 2 * walkers);
    Ok(Posterior {
        names: likelihood.names(),
        draws: chains.into_iter().flat_map(warm).collect(),
        converged: diagnostics.is_converged(request.effective),
        r_hat: diagnostics.r_hat,
        effective: diagnostics.effective,
        acceptance: accepted as f64 / (ENSEMBLES * walkers * steps) as f64,
        runs: 0,
        predictions: Vec::new(),
    })
}

/// Returns the stream of random numbers of a walker in a round.
fn stream(round: u64, ensemble: usize, walker: usize) -> u64 {
    (round << 32) + ((ensemble as u64) << 16) + walker as u64
}

/// Logarithm of the posterior density. Its arguments are the unknown parameters, followed by the logarithms of the
/// unknown standard deviations of residuals.
struct PosteriorDensity<'a> {
    problem: &'a IdentificationProblem<'a>,
    /// Argument of the unknown standard deviation of each series.
    deviation: Vec<Option<usize>>,
    /// Initial values of the unknown standard deviations.
    scales: Vec<f64>,
    runs: AtomicUsize,
    look: &'a (dyn Fn(usize) + Sync),
    failure: Mutex<Option<StudyError>>,
}

impl<'a> PosteriorDensity<'a> {
    fn new(
        problem: &'a IdentificationProblem<'a>,
        fit: &ParameterFit,
        model_error: bool,
        look: &'a (dyn Fn(usize) + Sync),
    ) -> PosteriorDensity<'a> {
        let data = problem.data;
        let (mut deviation, mut scales) = (Vec::new(), Vec::new());
        for (series, has_deviations) in data.has_deviations.iter().enumerate() {
            let is_unknown = model_error || !has_deviations;
            deviation.push(is_unknown.then_some(problem.unknowns.len() + scales.len()));
            if is_unknown {
                let of_series = data.observations.iter().zip(&fit.residuals).filter(|o| o.0.series == series);
                let squares: Vec<f64> = of_series.map(|(o, r)| (r * o.deviation).powi(2)).collect();
                let mean = squares.iter().sum::<f64>() / squares.len().max(1) as f64;
                scales.push(if mean > 0.0 { mean.sqrt() } else { 1.0 });
            }
        }
        PosteriorDensity { problem, deviation, scales, runs: AtomicUsize::new(0), look, failure: Mutex::default() }
    }

    fn size(&self) -> usize {
        self.problem.unknowns.len() + self.scales.len()
    }

    fn names(&self) -> Vec<String> {
        let unknowns = self.problem.unknowns.iter().map(|unknown| unknown.name.clone());
        let data = self.problem.data;
        let series = data.series.iter().zip(&data.has_deviations).zip(&self.deviation);
        let errors = series.filter(|(_, at)| at.is_some()).map(|((name, has_deviations), _)| {
            let what = if *has_deviations { "model error" } else { "standard deviation" };
            format!("{what} of {name}")
        });
        unknowns.chain(errors).collect()
    }

    /// Draws an initial position that can be evaluated: normal with twice the standard deviations of the fit, or
    /// uniform within the bounds if the data do not determine all parameters.
    fn initial(&self, fit: &ParameterFit, draws: &mut ChaCha8Rng) -> Result<Vec<f64>, StudyError> {
        let factor = fit.covariance.as_ref().and_then(|c| CholeskyFactor::of(c, fit.values.len(), 0.0));
        let mut normal = || standard_normal(draws);
        let mut position = vec![0.0; self.size()];
        let (parameters, deviations) = position.split_at_mut(fit.values.len());
        for _ in 0..ATTEMPTS {
            parameters.iter_mut().for_each(|z| *z = 2.0 * normal());
            match &factor {
                Some(factor) => {
                    factor.multiply(parameters);
                    parameters.iter_mut().zip(&fit.values).for_each(|(x, value)| *x += value);
                }
                None => self.spread_over_bounds(parameters)?,
            }
            deviations.iter_mut().zip(&self.scales).for_each(|(ln, s)| *ln = libm::log(*s) + 0.2 * normal());
            let candidate = [&*parameters, &*deviations].concat();
            if self.log_prob(&candidate).is_finite() {
                return Ok(candidate);
            }
        }
        Err(StudyError::Comparison("the runs around the fitted parameters fail: give narrower bounds".into()))
    }

    /// Replaces standard normal numbers by numbers that are uniform within the bounds.
    fn spread_over_bounds(&self, parameters: &mut [f64]) -> Result<(), StudyError> {
        for (x, unknown) in parameters.iter_mut().zip(self.problem.unknowns) {
            let [low, high] = unknown.bounds.ok_or_else(|| {
                let name = &unknown.name;
                StudyError::Setting(format!(
                    "the data do not determine all parameters, therefore --posterior needs bounds: --unknown {name}=low..high"
                ))
            })?;
            *x = low + normal::cumulative(*x / 2.0) * (high - low);
        }
        Ok(())
    }

    /// Returns the variance of the residual of observation `i`.
    fn variance(&self, i: usize, state: &[f64]) -> f64 {
        let (data, series) = (self.problem.data, self.problem.data.observations[i].series);
        let known = if data.has_deviations[series] { data.observations[i].deviation.powi(2) } else { 0.0 };
        known + self.deviation[series].map_or(0.0, |at| libm::exp(2.0 * state[at]))
    }

    /// Returns the logarithm of the prior density of the unknown standard deviations.
    fn log_prior(&self, state: &[f64]) -> f64 {
        let width = self.problem.unknowns.len();
        let inside = |(ln, scale): (&f64, &f64)| (ln - libm::log(*scale)).abs() <= libm::log(DEVIATION_RANGE);
        if !state[width..].iter().zip(&self.scales).all(inside) {
            return f64::NEG_INFINITY;
        }
        let uniform = self.deviation.iter().zip(&self.problem.data.has_deviations).filter(|series| *series.1);
        uniform.filter_map(|(at, _)| at.map(|at| state[at])).sum()
    }

    /// Returns the limits of the central 95 % of a new measurement of each observation.
    fn predictions(&self, chain: &[Vec<f64>], seed: u64) -> Result<Vec<[f64; 2]>, StudyError> {
        let count = PREDICTIONS.min(chain.len());
        let states: Vec<&Vec<f64>> = (0..count).map(|i| &chain[i * chain.len() / count]).collect();
        let width = self.problem.unknowns.len();
        let points: Vec<Vec<f64>> = states.iter().map(|state| state[..width].to_vec()).collect();
        self.runs.fetch_add(count * self.problem.data.shots.len(), Ordering::Relaxed);
        let computed = self.problem.computed(&points, self.problem.threads)?;
        let mut draws = draws(seed, u64::MAX);
        let limits = |i: usize| {
            let mut values: Vec<f64> = computed
                .iter()
                .zip(&states)
                .map(|(values, state)| values[i] + self.variance(i, state).sqrt() * standard_normal(&mut draws))
                .filter(|value| value.is_finite())
                .collect();
            values.sort_by(f64::total_cmp);
            [TAIL, 1.0 - TAIL].map(|part| between(&values, part))
        };
        Ok((0..self.problem.data.observations.len()).map(limits).collect())
    }

    /// Returns the error that prevented runs, if any.
    fn check(&self) -> Result<(), StudyError> {
        let failure = self.failure.lock().unwrap_or_else(PoisonError::into_inner).take();
        failure.map_or(Ok(()), Err)
    }

    fn diagnose(&self, chains: &[Vec<Vec<f64>>], walkers: usize) -> ChainDiagnostics {
        let steps = chains[0].len() / walkers;
        let of_parameter = |i: usize| {
            let retained_half =
                |chain: &Vec<Vec<f64>>| chain[steps / 2 * walkers..].iter().map(|s| s[i]).collect::<Vec<f64>>();
            let retained_values: Vec<Vec<f64>> = chains.iter().map(retained_half).collect();
            (r_hat(&retained_values), retained_values.iter().map(|values| effective_size(values, walkers)).sum::<f64>())
        };
        let (r_hat, effective) = (0..self.size()).map(of_parameter).unzip();
        ChainDiagnostics { r_hat, effective }
    }
}

impl Model for PosteriorDensity<'_> {
    type Params = Vec<f64>;

    fn log_prob(&self, state: &Vec<f64>) -> f64 {
        let width = self.problem.unknowns.len();
        let prior = self.log_prior(state);
        if !prior.is_finite() || !self.problem.allows(&state[..width]) {
            return f64::NEG_INFINITY;
        }
        let shots = self.problem.data.shots.len();
        (self.look)(self.runs.fetch_add(shots, Ordering::Relaxed) + shots);
        let computed = match self.problem.computed(&[state[..width].to_vec()], 1) {
            Ok(computed) => computed,
            Err(failure) => {
                self.failure.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(failure);
                return f64::NEG_INFINITY;
            }
        };
        let term = |(i, value): (usize, &f64)| {
            let (residual, variance) = (value - self.problem.data.observations[i].value, self.variance(i, state));
            -0.5 * (residual * residual / variance + libm::log(variance))
        };
        let sum = prior + computed[0].iter().enumerate().map(term).sum::<f64>();
        if sum.is_finite() { sum } else { f64::NEG_INFINITY }
    }
}

/// Draws a number from the standard normal distribution.
fn standard_normal(draws: &mut ChaCha8Rng) -> f64 {
    normal::quantile(unit(draws.next_u64()))
}

/// Convergence diagnostics of each parameter.
#[derive(Default)]
struct ChainDiagnostics {
    r_hat: Vec<f64>,
    effective: Vec<f64>,
}

impl ChainDiagnostics {
    fn is_converged(&self, effective: f64) -> bool {
        self.r_hat.iter().all(|r| *r < CONVERGED) && self.effective.iter().all(|n| *n >= effective)
    }
}

/// Returns the potential scale reduction over the halves of independent chains (Gelman and others, Bayesian Data
/// Analysis, 3rd edition, section 11.4).
fn r_hat(chains: &[Vec<f64>]) -> f64 {
    let halves: Vec<&[f64]> = chains.iter().flat_map(|c| [&c[..c.len() / 2], &c[c.len() / 2..]]).collect();
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let variance = |values: &[f64]| {
        let centre = mean(values);
        values.iter().map(|v| (v - centre).powi(2)).sum::<f64>() / (values.len() as f64 - 1.0)
    };
    let means: Vec<f64> = halves.iter().map(|half| mean(half)).collect();
    let within = mean(&halves.iter().map(|half| variance(half)).collect::<Vec<_>>());
    let count = halves[0].len() as f64;
    ((count - 1.0) / count + variance(&means) / within).sqrt()
}

/// Returns the effective sample size of an ensemble from the autocorrelation time of its means (Goodman and Weare,
/// section 5).
fn effective_size(values: &[f64], walkers: usize) -> f64 {
    let means: Vec<f64> = values.chunks(walkers).map(|step| step.iter().sum::<f64>() / walkers as f64).collect();
    let time = auto_corr_time(means.iter().copied(), None, Some(0)).unwrap_or(f64::INFINITY);
    values.len() as f64 / time.max(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn normals(seed: u64, count: usize) -> Vec<f64> {
        let mut draws = draws(seed, 0);
        (0..count).map(|_| standard_normal(&mut draws)).collect()
    }

    /// An autoregressive process x' = a x + e has the autocorrelation time (1 + a)/(1 - a) = 9 for a = 0.8.
    #[test]
    fn effective_size_of_an_autoregressive_process_matches_the_closed_form() {
        let mut x = 0.0;
        let chain: Vec<f64> = normals(1, 100_000)
            .into_iter()
            .map(|e| {
                x = 0.8 * x + e;
                x
            })
            .collect();
        let effective = effective_size(&chain, 1);
        assert!((effective * 9.0 / 1e5 - 1.0).abs() < 0.1, "{effective}");
    }

    #[test]
    fn r_hat_detects_chains_with_different_means() {
        let chains: Vec<Vec<f64>> = (0..4).map(|seed| normals(seed, 4000)).collect();
        assert!(r_hat(&chains) < 1.002);
        let shifted: Vec<Vec<f64>> =
            chains.iter().zip([0.0, 0.5, 0.0, 0.0]).map(|(c, by)| c.iter().map(|v| v + by).collect()).collect();
        assert!(r_hat(&shifted) > 1.01);
    }
}
