//! `identify`: fit of deck parameters to measured shots and curves, with confidence intervals and correlations.

pub mod data;
#[cfg(feature = "cli")]
pub mod figures;
#[cfg(feature = "cli")]
pub mod posterior;

use std::sync::Mutex;

use super::StudyError;
use super::evaluate::SampleEvaluator;
use super::statistics::design::{draws, unit};
use super::statistics::least_squares::{ParameterFit, fit};
use data::MeasuredData;
use rand_chacha::rand_core::RngCore as _;

/// Correlations above this size are reported.
const CLOSE: f64 = 0.95;
/// Relative step of the difference quotients; smaller steps would resolve single time increments.
const STEP: f64 = 1e-2;
/// Relative difference of the sums of squares below which two fits are the same minimum.
const SAME_MINIMUM: f64 = 1e-3;

/// Parameter to identify.
#[derive(Clone, Debug, PartialEq)]
pub struct UnknownParameter {
    /// Name of the deck parameter.
    pub name: String,
    /// Initial value of the fit.
    pub start: f64,
    /// Smallest and largest allowed value.
    pub bounds: Option<[f64; 2]>,
}

/// Measured data, unknown parameters and the evaluator of the deck.
pub struct IdentificationProblem<'a> {
    evaluator: SampleEvaluator,
    data: &'a MeasuredData,
    unknowns: &'a [UnknownParameter],
    threads: usize,
    failure: Mutex<Option<StudyError>>,
}

impl<'a> IdentificationProblem<'a> {
    /// Creates the problem. The parameters of the evaluator must be the known parameters of the shots, followed by the
    /// unknown ones; its quantities must be those of the data.
    pub fn new(
        evaluator: SampleEvaluator,
        data: &'a MeasuredData,
        unknowns: &'a [UnknownParameter],
        threads: usize,
    ) -> IdentificationProblem<'a> {
        let evaluator = evaluator.with_selections(data.selections());
        IdentificationProblem { evaluator, data, unknowns, threads, failure: Mutex::default() }
    }

    /// Returns the evaluator.
    pub fn evaluator(&self) -> &SampleEvaluator {
        &self.evaluator
    }

    /// Returns whether a point is within all bounds.
    fn allows(&self, point: &[f64]) -> bool {
        let inside = |(value, unknown): (&f64, &UnknownParameter)| {
            unknown.bounds.is_none_or(|[low, high]| (low..=high).contains(value))
        };
        point.iter().zip(self.unknowns).all(inside)
    }

    /// Computes the counterparts of all observations at several points of the unknown parameters; NaN if a run fails or
    /// a point is out of bounds.
    ///
    /// # Errors
    /// If the threads cannot be started.
    pub fn computed(&self, points: &[Vec<f64>], threads: usize) -> Result<Vec<Vec<f64>>, StudyError> {
        let shots = &self.data.shots;
        let allowed: Vec<bool> = points.iter().map(|point| self.allows(point)).collect();
        let runs = points.iter().zip(&allowed).filter(|run| *run.1).map(|run| run.0);
        let samples: Vec<f64> =
            runs.flat_map(|point| shots.iter().flat_map(move |row| row.iter().chain(point))).copied().collect();
        let (table, failures) = self.evaluator.table(&samples, threads)?;
        if let Some(first) = failures.into_iter().next() {
            let mut known = self.failure.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
            known.get_or_insert(first.reason);
        }
        let width = self.data.quantities.len();
        let mut rows = table.chunks(shots.len() * width);
        let values = |is_allowed: &bool| match rows.next().filter(|_| *is_allowed) {
            Some(row) => self.data.observations.iter().map(|o| row[o.shot * width + o.quantity]).collect(),
            None => vec![f64::NAN; self.data.observations.len()],
        };
        Ok(allowed.iter().map(values).collect())
    }

    /// Fits the unknown parameters from their initial values, and from `starts - 1` random points within their bounds.
    ///
    /// # Errors
    /// If there are too few observations, if further starts have no bounds, or if no initial point can be evaluated.
    pub fn fit(&self, starts: usize) -> Result<FitResults, StudyError> {
        let (count, unknown) = (self.data.observations.len(), self.unknowns.len());
        if count <= unknown {
            let why = format!(
                "{count} measured values do not determine {unknown} parameters and their errors; at least {} are needed",
                unknown + 1
            );
            return Err(StudyError::Comparison(why));
        }
        let mut fits = Vec::new();
        for start in self.starts(starts)? {
            fits.extend(fit(&start, STEP, &mut |points| self.residuals(points))?);
        }
        fits.sort_by(|a, b| a.sum_of_squares().total_cmp(&b.sum_of_squares()));
        let mut sums = fits.iter().map(ParameterFit::sum_of_squares).collect::<Vec<_>>().into_iter();
        let Some(best) = fits.into_iter().next() else {
            let failure = self.failure.lock().unwrap_or_else(std::sync::PoisonError::into_inner).take();
            let unknown =
                || StudyError::Comparison("the quantity cannot be computed with the initial parameters".into());
            return Err(failure.unwrap_or_else(unknown));
        };
        let smallest = sums.next().unwrap_or(0.0);
        let is_same = |sum: &f64| *sum <= smallest * (1.0 + SAME_MINIMUM);
        let others: Vec<f64> = sums.collect();
        let same = 1 + others.iter().filter(|sum| is_same(sum)).count();
        let next = others.iter().copied().find(|sum| !is_same(sum)).map(|sum| sum / smallest);
        Ok(FitResults { best, starts, same, next })
    }

    fn residuals(&self, points: &[Vec<f64>]) -> Result<Vec<Vec<f64>>, StudyError> {
        let weigh = |values: Vec<f64>| {
            let known = values.iter().zip(&self.data.observations);
            known.map(|(value, o)| (value - o.value) / o.deviation).collect()
        };
        Ok(self.computed(points, self.threads)?.into_iter().map(weigh).collect())
    }

    /// Returns the initial points of the fits.
    fn starts(&self, count: usize) -> Result<Vec<Vec<f64>>, StudyError> {
        let mut points = vec![self.unknowns.iter().map(|u| u.start).collect::<Vec<f64>>()];
        for i in 1..count {
            let mut draws = draws(0, i as u64);
            let value = |unknown: &UnknownParameter| {
                let wrong =
                    || StudyError::Setting(format!("--starts needs bounds: --unknown {}=low..high", unknown.name));
                let [low, high] = unknown.bounds.ok_or_else(wrong)?;
                Ok(low + unit(draws.next_u64()) * (high - low))
            };
            points.push(self.unknowns.iter().map(value).collect::<Result<_, StudyError>>()?);
        }
        Ok(points)
    }
}

/// Results of fits from several initial points.
#[derive(Clone, Debug, PartialEq)]
pub struct FitResults {
    /// Fit with the smallest sum of squares.
    pub best: ParameterFit,
    /// Number of initial points.
    pub starts: usize,
    /// Number of fits with the smallest sum of squares.
    pub same: usize,
    /// Sum of squares of the next minimum divided by the smallest one.
    pub next: Option<f64>,
}

/// Returns remarks on a fit: convergence, insensitive parameters, bounds and correlations.
pub fn sentences(found: &ParameterFit, names: &[String]) -> Vec<String> {
    let mut said: Vec<String> = Vec::new();
    if !found.converged {
        said.push("the fit did not converge: choose initial values closer to the solution".into());
    }
    said.extend(found.insensitive.iter().map(|i| format!("no shot depends on {}: it cannot be identified", names[*i])));
    let edge =
        |i: &usize| format!("{} is at the edge of its valid range: its interval extends beyond that edge", names[*i]);
    said.extend(found.edges.iter().map(edge));
    for one in 0..names.len() {
        for other in one + 1..names.len() {
            match found.correlation(one, other) {
                Some(r) if r.abs() > CLOSE => {
                    let (how, what) = if r > 0.0 {
                        ("increasing or decreasing both", "difference")
                    } else {
                        ("increasing one and decreasing the other", "sum")
                    };
                    said.push(format!(
                        "{} and {} are hardly distinguishable (correlation {r:.3}): {how} fits nearly as well; the shots determine a weighted \
                         {what} of the two",
                        names[one], names[other]
                    ));
                }
                _ => {}
            }
        }
    }
    if found.covariance.is_none() && found.insensitive.is_empty() {
        said.push(format!(
            "the shots do not determine {}: changing the parameters together leaves all computed values unchanged",
            names.join(" and ")
        ));
    }
    said
}

#[cfg(test)]
mod tests {
    use super::sentences;
    use crate::study::statistics::least_squares::ParameterFit;

    #[test]
    fn indistinguishable_parameters_are_reported() {
        let names = ["A".to_owned(), "mu".to_owned()];
        let with = |covariance: Option<[f64; 4]>, idle: &[usize]| {
            let covariance = covariance.map(|c| c.to_vec());
            sentences(
                &ParameterFit {
                    values: vec![1.0; 2],
                    residuals: vec![0.0; 4],
                    freedom: 2,
                    covariance,
                    insensitive: idle.to_vec(),
                    edges: Vec::new(),
                    converged: true,
                },
                &names,
            )
        };
        assert!(with(Some([1.0, 0.5, 0.5, 1.0]), &[]).is_empty());
        assert!(
            with(Some([1.0, -0.99, -0.99, 1.0]), &[])[0]
                .contains("A and mu are hardly distinguishable (correlation -0.990)")
        );
        assert!(with(None, &[])[0].contains("do not determine"));
        assert_eq!(with(None, &[1]), ["no shot depends on mu: it cannot be identified"]);
    }
}
