//! Derivatives from companion runs: a smooth curve is fitted to the results over several changes of a parameter, and its
//! slope has the uncertainty of the fit.

use crate::study::StudyError;
use crate::study::statistics::student;

/// Changes of a parameter relative to the largest one: one side, then the other.
pub const CHANGES: [f64; 8] = [0.25, 0.5, 0.75, 1.0, -0.25, -0.5, -0.75, -1.0];
/// Number of changes on one side.
const SIDE: usize = CHANGES.len() / 2;
/// Degrees of freedom of a fit of two terms.
const FREEDOM: f64 = (SIDE - 2) as f64;

/// Results of companion runs over the changes of one parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct StepSeries {
    /// Largest change of the parameter, in its unit.
    pub step: f64,
    side: UsedSide,
    /// For each quantity, half the difference of both sides, or the difference from the result without a change, for the
    /// changes of one side.
    differences: Vec<[f64; SIDE]>,
    /// For each quantity its results; NaN for a run without one.
    results: Vec<[f64; CHANGES.len()]>,
}

/// Side of the value on which companion runs have results.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum UsedSide {
    Both,
    Above,
    Below,
}

/// Too few companion runs with results.
#[derive(Debug)]
pub struct MissingRuns {
    failed: usize,
    reason: StudyError,
}

impl MissingRuns {
    /// Returns the error for the name of the parameter.
    pub fn error(self, name: &str) -> StudyError {
        let MissingRuns { failed, reason } = self;
        StudyError::Setting(format!(
            "--to {name}: {failed} of {} runs with changes of {name} gave no result, on both sides of its value; decrease \
             the changes with --step; the first error:\n{reason}",
            CHANGES.len()
        ))
    }
}

impl StepSeries {
    /// Collects the results of the runs over [`CHANGES`]; `values` are those without a change.
    pub fn new(values: &[f64], step: f64, rows: &[Result<Vec<f64>, StudyError>]) -> Result<StepSeries, MissingRuns> {
        let [above, below] = [&rows[..SIDE], &rows[SIDE..]];
        let is_complete = |side: &[Result<Vec<f64>, StudyError>]| side.iter().all(Result::is_ok);
        let side = match [above, below].map(is_complete) {
            [true, true] => UsedSide::Both,
            [true, false] => UsedSide::Above,
            [false, true] => UsedSide::Below,
            [false, false] => {
                let mut reasons = rows.iter().filter_map(|row| row.as_ref().err());
                let reason = reasons.next().cloned().unwrap_or_else(|| StudyError::Comparison("no run".into()));
                return Err(MissingRuns { failed: 1 + reasons.count(), reason });
            }
        };
        let number = |row: &Result<Vec<f64>, StudyError>, quantity: usize| {
            row.as_ref().map_or(f64::NAN, |values| values[quantity])
        };
        let difference = |quantity: usize, at: usize| match side {
            UsedSide::Both => 0.5 * (number(&above[at], quantity) - number(&below[at], quantity)),
            UsedSide::Above => number(&above[at], quantity) - values[quantity],
            UsedSide::Below => number(&below[at], quantity) - values[quantity],
        };
        let quantities = 0..values.len();
        let differences = quantities.clone().map(|quantity| std::array::from_fn(|at| difference(quantity, at)));
        let results = quantities.map(|quantity| std::array::from_fn(|at| number(&rows[at], quantity)));
        Ok(StepSeries { step, side, differences: differences.collect(), results: results.collect() })
    }

    /// Returns parameter and result of each run with a result; `at` is the value of the parameter.
    pub fn points(&self, at: f64, quantity: usize) -> Vec<[f64; 2]> {
        let runs = CHANGES.iter().zip(self.results[quantity]);
        let point = |(change, result): (&f64, f64)| [at + change * self.step, result];
        runs.map(point).filter(|point| point[1].is_finite()).collect()
    }
}

/// Slope of a fit to companion runs, by the parameter in its unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DifferenceFit {
    /// Slope at the value of the parameter.
    pub slope: f64,
    /// Half-width of its 95 % interval from the noise of perturbed runs.
    pub noise: f64,
    /// Half-width of its 95 % interval from the deviations of the runs from the fit.
    pub deviation: f64,
    /// Largest change of the parameter.
    pub step: f64,
    /// Whether changes have one sign only.
    pub one_sided: bool,
}

impl DifferenceFit {
    /// Creates a fit without uncertainty.
    pub fn of_slope(slope: f64) -> DifferenceFit {
        DifferenceFit { slope, noise: 0.0, deviation: 0.0, step: 0.0, one_sided: false }
    }

    /// Returns the half-width of the 95 % interval.
    pub fn uncertainty(&self) -> f64 {
        self.noise.max(self.deviation)
    }

    /// Returns the fit with the smaller uncertainty. If the intervals of both have no common point, it is widened up to the
    /// other slope.
    pub fn best(self, other: DifferenceFit) -> DifferenceFit {
        let (best, rest) = if other.uncertainty() < self.uncertainty() { (other, self) } else { (self, other) };
        let distance = (best.slope - rest.slope).abs();
        if distance <= best.uncertainty() + rest.uncertainty() {
            return best;
        }
        DifferenceFit { deviation: distance, ..best }
    }
}

/// Fit of two terms to results of companion runs.
struct TwoTerms {
    /// Factor of the linear term, with changes relative to the largest one.
    slope: f64,
    /// Weights of the results in this factor.
    weights: [f64; SIDE],
    /// Standard deviation of the results from the fit.
    scatter: f64,
}

impl StepSeries {
    /// Returns the standard deviation of half the difference of two runs from a smooth curve.
    pub fn scatter(&self, quantity: usize) -> f64 {
        self.fit(quantity).scatter
    }

    /// Returns the slope of a quantity. `noise` is the half-width of the 95 % interval of a run from perturbations, `least`
    /// a lower bound of the scatter of the runs.
    pub fn fitted(&self, quantity: usize, noise: f64, least: f64) -> DifferenceFit {
        let TwoTerms { slope, weights, scatter } = self.fit(quantity);
        let (squares, sum) = (weights.iter().map(|weight| weight * weight).sum::<f64>(), weights.iter().sum::<f64>());
        let both = self.side == UsedSide::Both;
        // A difference of two runs, halved; or a difference from one and the same run.
        let of_noise = if both { 0.5 * squares } else { squares + sum * sum };
        DifferenceFit {
            slope: slope / self.step,
            noise: noise * of_noise.sqrt() / self.step,
            deviation: student(FREEDOM) * scatter.max(least) * squares.sqrt() / self.step,
            step: self.step,
            one_sided: !both,
        }
    }

    /// Fits `a x + b x³` to differences of both sides, `a x + b x²` to those of one side. Equation (15.9).
    fn fit(&self, quantity: usize) -> TwoTerms {
        let power = if self.side == UsedSide::Both { 3 } else { 2 };
        let x: [f64; SIDE] = if self.side == UsedSide::Below { side(SIDE) } else { side(0) };
        let y = &self.differences[quantity];
        let weights = slope_weights(&x, power);
        let slope: f64 = weights.iter().zip(y).map(|(weight, y)| weight * y).sum();
        let curved = x.map(|x| x.powi(power));
        let rest: [f64; SIDE] = std::array::from_fn(|at| y[at] - slope * x[at]);
        let product = |a: &[f64; SIDE], b: &[f64; SIDE]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let curvature = product(&curved, &rest) / product(&curved, &curved);
        let residuals: [f64; SIDE] = std::array::from_fn(|at| rest[at] - curvature * curved[at]);
        TwoTerms { slope, weights, scatter: (product(&residuals, &residuals) / FREEDOM).sqrt() }
    }
}

/// Returns the changes of one side, from an index of [`CHANGES`] on.
fn side(first: usize) -> [f64; SIDE] {
    std::array::from_fn(|at| CHANGES[first + at])
}

/// Returns the weights of values at `x` in the factor of x of the least-squares fit of x and a power of x.
fn slope_weights(x: &[f64; SIDE], power: i32) -> [f64; SIDE] {
    let curved = x.map(|x| x.powi(power));
    let sum = |a: &[f64; SIDE], b: &[f64; SIDE]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let [linear, mixed, square] = [sum(x, x), sum(x, &curved), sum(&curved, &curved)];
    let determinant = linear * square - mixed * mixed;
    std::array::from_fn(|at| (square * x[at] - mixed * curved[at]) / determinant)
}
