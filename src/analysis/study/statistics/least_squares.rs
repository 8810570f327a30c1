//! Nonlinear least squares by the Levenberg-Marquardt method with finite-difference derivatives, and confidence
//! intervals.

use super::IntervalEstimate;
use super::cholesky::CholeskyFactor;

/// Relative change of all parameters below which the iteration has converged.
const SETTLED: f64 = 1e-7;
const MOST_ITERATIONS: usize = 100;
/// Smallest relative pivot of the normal equations; below it the parameters are linearly dependent.
const LEAST_PIVOT: f64 = 1e-9;

/// Function that returns the residuals of several points at once, each divided by its standard deviation. Values that
/// are not finite mean that the model cannot be evaluated there.
pub type ResidualFunction<'a, E> = dyn FnMut(&[Vec<f64>]) -> Result<Vec<Vec<f64>>, E> + 'a;

/// Result of a least-squares fit.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterFit {
    /// Fitted parameters, in the order of the start values.
    pub values: Vec<f64>,
    /// Residuals at the fitted parameters.
    pub residuals: Vec<f64>,
    /// Degrees of freedom: number of residuals minus number of parameters.
    pub freedom: usize,
    /// Covariance matrix of the parameters by rows; `None` if the residuals do not determine all parameters.
    pub covariance: Option<Vec<f64>>,
    /// Indices of parameters that no residual depends on.
    pub insensitive: Vec<usize>,
    /// Indices of parameters at the edge of their valid range: the model cannot be evaluated on one side.
    pub edges: Vec<usize>,
    /// Whether the iteration converged.
    pub converged: bool,
}

impl ParameterFit {
    /// Returns the sum of the squared residuals.
    pub fn sum_of_squares(&self) -> f64 {
        square(&self.residuals)
    }

    /// Returns the standard deviation of a residual: sqrt(sum r^2/(n - p)) with n residuals r and p parameters.
    pub fn deviation(&self) -> f64 {
        (self.sum_of_squares() / self.freedom.max(1) as f64).sqrt()
    }

    /// Returns the parameters with confidence intervals by Student's t and the covariance of the linearised model
    /// (Seber and Wild, Nonlinear Regression, section 5.1); intervals are infinite if the residuals do not determine
    /// the parameters. Equation (15.6).
    pub fn estimates(&self) -> Vec<IntervalEstimate> {
        let size = self.values.len();
        let error = |i: usize| match &self.covariance {
            Some(covariance) if self.freedom > 0 => covariance[i * size + i].sqrt(),
            _ => f64::INFINITY,
        };
        self.values
            .iter()
            .enumerate()
            .map(|(i, v)| IntervalEstimate::around(*v, error(i), self.freedom as f64))
            .collect()
    }

    /// Returns the correlation of two parameters.
    pub fn correlation(&self, one: usize, other: usize) -> Option<f64> {
        let (covariance, size) = (self.covariance.as_ref()?, self.values.len());
        let [a, b, ab] = [(one, one), (other, other), (one, other)].map(|(i, j)| covariance[i * size + j]);
        Some(ab / (a * b).sqrt())
    }
}

/// Parameter values with their residuals.
struct EvaluatedPoint {
    at: Vec<f64>,
    residuals: Vec<f64>,
}

impl EvaluatedPoint {
    fn cost(&self) -> f64 {
        square(&self.residuals)
    }
}

/// Fits parameters, starting at `start`. `part` is the relative step of the difference quotients. `None` if the model
/// cannot be evaluated at `start`, or if there are fewer residuals than parameters.
pub fn fit<E>(start: &[f64], part: f64, model: &mut ResidualFunction<'_, E>) -> Result<Option<ParameterFit>, E> {
    let scale: Vec<f64> = start.iter().map(|x| if *x == 0.0 { 1.0 } else { x.abs() }).collect();
    let Some(mut here) = best(model, vec![start.to_vec()])? else { return Ok(None) };
    if here.residuals.len() < start.len() {
        return Ok(None);
    }
    let steps: Vec<f64> = scale.iter().map(|s| part * s).collect();
    let (mut damping, mut settled) = (1e-3, false);
    let mut slopes = jacobian(&here, &steps, part, model)?;
    for _ in 0..MOST_ITERATIONS {
        let Some(next) = step(&here, &slopes.columns, &mut damping, &steps, model)? else {
            settled = true;
            break;
        };
        let moved = |i: usize| (next.at[i] - here.at[i]).abs() / here.at[i].abs().max(steps[i]);
        let small = (0..start.len()).all(|i| moved(i) < SETTLED);
        here = next;
        slopes = jacobian(&here, &steps, part, model)?;
        if small {
            settled = true;
            break;
        }
    }
    let freedom = here.residuals.len() - start.len();
    let (normal, norms) = normal(&slopes.columns);
    let idle: Vec<usize> = (0..start.len()).filter(|i| norms[*i] == 0.0).collect();
    let mut fit = ParameterFit {
        values: here.at,
        residuals: here.residuals,
        freedom,
        covariance: None,
        insensitive: idle,
        edges: slopes.edges,
        converged: settled,
    };
    let variance = fit.deviation().powi(2);
    let factor = CholeskyFactor::of(&normal, start.len(), LEAST_PIVOT).filter(|_| fit.insensitive.is_empty());
    fit.covariance = factor.map(|factor| {
        let mut inverse = factor.inverse();
        for (i, row) in inverse.chunks_exact_mut(norms.len()).enumerate() {
            row.iter_mut().zip(&norms).for_each(|(c, norm)| *c *= variance / (norms[i] * norm));
        }
        inverse
    });
    Ok(Some(fit))
}

fn square(residuals: &[f64]) -> f64 {
    residuals.iter().map(|r| r * r).sum()
}

/// Returns the point with the smallest sum of squares; `None` if the model cannot be evaluated at any point.
fn best<E>(model: &mut ResidualFunction<'_, E>, points: Vec<Vec<f64>>) -> Result<Option<EvaluatedPoint>, E> {
    let residuals = model(&points)?;
    let evaluated = points.into_iter().zip(residuals).map(|(at, residuals)| EvaluatedPoint { at, residuals });
    Ok(evaluated.filter(|p| p.cost().is_finite()).min_by(|a, b| a.cost().total_cmp(&b.cost())))
}

/// Jacobian of the residuals, and the parameters whose difference quotients are one-sided.
struct ResidualJacobian {
    columns: Vec<Vec<f64>>,
    edges: Vec<usize>,
}

/// Computes the Jacobian by central differences, or one-sided differences if the model cannot be evaluated on one side.
fn jacobian<E>(
    here: &EvaluatedPoint,
    steps: &[f64],
    part: f64,
    model: &mut ResidualFunction<'_, E>,
) -> Result<ResidualJacobian, E> {
    let step = |i: usize| steps[i].max(part * here.at[i].abs());
    let shifted = |i: usize, side: f64| {
        let mut point = here.at.clone();
        point[i] += side * step(i);
        point
    };
    let points: Vec<Vec<f64>> = (0..steps.len()).flat_map(|i| [1.0, -1.0].map(|side| shifted(i, side))).collect();
    let values = model(&points)?;
    let mut edges = Vec::new();
    let mut column = |i: usize| -> Vec<f64> {
        let finite_residuals = |side: usize| Some(&values[2 * i + side]).filter(|r| r.iter().all(|v| v.is_finite()));
        let (above, below) = (finite_residuals(0), finite_residuals(1));
        let width = step(i) * f64::from(u8::from(above.is_some()) + u8::from(below.is_some()));
        if above.is_none() || below.is_none() {
            edges.push(i);
        }
        let (above, below) = (above.unwrap_or(&here.residuals), below.unwrap_or(&here.residuals));
        let slope = |(a, b): (&f64, &f64)| if width > 0.0 { (a - b) / width } else { 0.0 };
        above.iter().zip(below).map(slope).collect()
    };
    let columns = (0..steps.len()).map(&mut column).collect();
    Ok(ResidualJacobian { columns, edges })
}

/// Returns the matrix of the normal equations with columns scaled to length 1, and the column lengths.
fn normal(columns: &[Vec<f64>]) -> (Vec<f64>, Vec<f64>) {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let norms: Vec<f64> = columns.iter().map(|c| dot(c, c).sqrt()).collect();
    let cell = |i: usize, j: usize| {
        let norm = norms[i] * norms[j];
        if i == j {
            1.0
        } else if norm > 0.0 {
            dot(&columns[i], &columns[j]) / norm
        } else {
            0.0
        }
    };
    let size = columns.len();
    ((0..size * size).map(|k| cell(k / size, k % size)).collect(), norms)
}

/// Returns the next point, with a smaller sum of squares; `None` if there is none.
fn step<E>(
    here: &EvaluatedPoint,
    columns: &[Vec<f64>],
    damping: &mut f64,
    steps: &[f64],
    model: &mut ResidualFunction<'_, E>,
) -> Result<Option<EvaluatedPoint>, E> {
    let (normal, norms) = normal(columns);
    let size = steps.len();
    let downhill: Vec<f64> = columns
        .iter()
        .zip(&norms)
        .map(|(c, norm)| {
            let dot: f64 = c.iter().zip(&here.residuals).map(|(c, r)| c * r).sum();
            if *norm > 0.0 { -dot / norm } else { 0.0 }
        })
        .collect();
    // Any further reduction is below rounding error.
    if downhill.iter().all(|d| d.abs() <= 1e-12 * here.cost().sqrt()) {
        return Ok(None);
    }
    while *damping < 1e12 {
        let mut damped = normal.clone();
        (0..size).for_each(|i| damped[i * size + i] += *damping);
        let Some(factor) = CholeskyFactor::of(&damped, size, 0.0) else {
            *damping *= 10.0;
            continue;
        };
        let mut change = downhill.clone();
        factor.solve(&mut change);
        let candidate: Vec<f64> =
            (0..size).map(|i| here.at[i] + if norms[i] > 0.0 { change[i] / norms[i] } else { 0.0 }).collect();
        let small = (0..size).all(|i| (candidate[i] - here.at[i]).abs() < SETTLED * here.at[i].abs().max(steps[i]));
        if let Some(next) = best(model, vec![candidate])?.filter(|next| next.cost() < here.cost()) {
            *damping = (*damping * 0.1).max(1e-12);
            return Ok(Some(next));
        }
        if small {
            return Ok(None);
        }
        *damping *= 10.0;
    }
    Ok(None)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::statistics::design::{draws, unit};
    use crate::study::statistics::normal;
    use rand_chacha::rand_core::RngCore as _;

    /// Returns points of y = a exp(-b x) with normal errors of deviation 0.05.
    fn table(seed: u64) -> Vec<(f64, f64)> {
        let mut draws = draws(seed, 0);
        let x = (0..20).map(|i| 0.2 * f64::from(i));
        x.map(|x| (x, 2.0 * libm::exp(-0.7 * x) + 0.05 * normal::quantile(unit(draws.next_u64())))).collect()
    }

    fn decay(table: &[(f64, f64)]) -> ParameterFit {
        let model = &mut |points: &[Vec<f64>]| -> Result<Vec<Vec<f64>>, ()> {
            let residuals = |p: &Vec<f64>| table.iter().map(|(x, y)| p[0] * libm::exp(-p[1] * x) - y).collect();
            Ok(points.iter().map(residuals).collect())
        };
        fit(&[1.0, 0.1], 1e-3, model).expect("a model").expect("a fit")
    }

    /// With 500 tables and two parameters, 950 ± 7 of 1000 intervals are expected to contain the exact value.
    #[test]
    fn intervals_have_their_nominal_coverage() {
        let mut inside = 0;
        for seed in 0..500 {
            let fit = decay(&table(seed));
            assert!(fit.converged && fit.freedom == 18);
            inside += fit.estimates().iter().zip([2.0, 0.7]).filter(|(e, truth)| e.holds(*truth)).count();
        }
        println!("{inside} of 1000 inside");
        assert!((925..=975).contains(&inside), "{inside}");
        let fit = decay(&table(3));
        let correlation = fit.correlation(0, 1).expect("a covariance");
        assert!((0.02..0.08).contains(&fit.deviation()) && (0.3..0.9).contains(&correlation), "{correlation}");
    }

    /// Dependent and insensitive parameters have no interval; the fit does not enter regions where the model is
    /// undefined.
    #[test]
    fn undetermined_parameters_are_reported() {
        let table = table(1);
        let residuals = |of: &dyn Fn(&[f64], f64) -> f64, start: &[f64]| {
            let model = &mut |points: &[Vec<f64>]| -> Result<Vec<Vec<f64>>, ()> {
                Ok(points.iter().map(|p| table.iter().map(|(x, y)| of(p, *x) - y).collect()).collect())
            };
            fit(start, 1e-3, model).expect("a model")
        };
        let product = residuals(&|p, x| p[0] * p[1] * libm::exp(-0.7 * x), &[1.0, 1.0]).expect("a fit");
        assert!(product.covariance.is_none() && product.insensitive.is_empty());
        assert!((product.values[0] * product.values[1] - 2.0).abs() < 0.1);
        let idle = residuals(&|p, x| p[0] * libm::exp(-0.7 * x), &[1.0, 5.0]).expect("a fit");
        assert_eq!((idle.insensitive, idle.values[1]), (vec![1], 5.0));
        let walled = |p: &[f64], x: f64| if p[0] > 1.5 { f64::NAN } else { p[0] * libm::exp(-0.7 * x) };
        let fit = residuals(&walled, &[1.0]).expect("a fit");
        assert!((1.4..=1.5).contains(&fit.values[0]) && fit.edges == [0], "{fit:?}");
        assert!(residuals(&|_, _| f64::NAN, &[1.0]).is_none());
    }
}
