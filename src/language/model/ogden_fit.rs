//! Constants of the Ogden form fitted to measured stresses of rubber.
//!
//! The sum of the squared relative errors of the nominal stresses is least. The stresses are linear in the moduli mu_i and
//! nonlinear in the exponents alpha_i: the moduli are eliminated by linear least squares, and the exponents follow from
//! the Levenberg-Marquardt method with the derivatives of the reduced problem (Kaufman 1975, BIT 15, 49), started from
//! the best points of a grid (Twizell and Ogden 1983, J. Austral. Math. Soc. B 24, 424, use the same method for all
//! constants together).

use nalgebra::{DMatrix, DVector};

use super::types::{RubberMeasurement, RubberTest};

/// Exponents of the grid of starting points.
const GRID: [f64; 14] = [-10.0, -7.0, -5.0, -3.5, -2.0, -1.0, 0.5, 1.3, 2.0, 3.0, 4.0, 5.5, 8.0, 12.0];
/// Number of starting points from which the exponents are improved.
const STARTS: usize = 20;
/// Range of the absolute value of an exponent.
const EXPONENTS: [f64; 2] = [1e-3, 40.0];
/// Most iterations from a starting point.
const ITERATIONS: usize = 400;
/// Step of the exponents, relative to them, that ends the iteration.
const SHORT: f64 = 1e-13;
/// Ratio of the sizes of independent columns below which moduli are not determined.
const DEPENDENT: f64 = 1e-5;

/// Result of a fit.
pub struct OgdenFit {
    /// Pairs mu_i, alpha_i, in ascending order of alpha_i.
    pub terms: Vec<[f64; 2]>,
    /// Root mean square of the relative errors.
    pub error: f64,
}

/// The linear problem for given exponents.
struct Reduced {
    moduli: DVector<f64>,
    errors: DVector<f64>,
    /// Orthonormal basis of the stresses of all terms.
    basis: DMatrix<f64>,
}

/// Returns the exponent of the stretch across the tension, relative to that of the stretch along it.
fn lateral(test: RubberTest) -> f64 {
    match test {
        RubberTest::Uniaxial => 0.5,
        RubberTest::Equibiaxial => 2.0,
        RubberTest::Planar | RubberTest::Volumetric => 1.0,
    }
}

/// Returns the nominal stress by a term with mu = 1, and its derivative with respect to alpha (ABAQUS Theory Guide 4.6.2).
pub fn term_stress(test: RubberTest, stretch: f64, alpha: f64) -> [f64; 2] {
    let (logarithm, ratio) = (stretch.ln(), lateral(test));
    let [along, across] = [alpha * logarithm, -ratio * alpha * logarithm].map(f64::exp);
    let stress = 2.0 / alpha * (along - across) / stretch;
    let growth = 2.0 / alpha * logarithm * (along + ratio * across) / stretch;
    [stress, growth - stress / alpha]
}

/// Returns the constants of `order` terms with the least sum of squared relative errors.
///
/// # Errors
/// The reason if there are fewer values than constants, or the values do not determine them.
pub fn fit(data: &[RubberMeasurement], order: usize) -> Result<OgdenFit, String> {
    let unknowns = 2 * order;
    if data.len() < unknowns {
        return Err(format!(
            "{} measured values do not determine {unknowns} constants: give more test data",
            data.len()
        ));
    }
    let mut starts = starting_points(order);
    starts.retain_mut(|start| match reduced(data, &start.exponents) {
        Some(problem) => {
            start.error = problem.errors.norm();
            start.error.is_finite()
        }
        None => false,
    });
    starts.sort_by(|a, b| a.error.total_cmp(&b.error));
    let mut best: Option<Start> = None;
    for start in starts.into_iter().take(STARTS) {
        let improved = improve(data, start);
        if best.as_ref().is_none_or(|best| improved.error < best.error) {
            best = Some(improved);
        }
    }
    let undetermined = "the test data do not determine all constants: give a lower order, or tests of another kind";
    let mut exponents = best.ok_or(undetermined)?.exponents;
    exponents.sort_by(f64::total_cmp);
    let problem = reduced(data, &exponents).ok_or(undetermined)?;
    if !determines_exponents(data, &exponents, &problem) {
        return Err(undetermined.into());
    }
    let terms = problem.moduli.iter().zip(&exponents).map(|(modulus, alpha)| [*modulus, *alpha]).collect();
    Ok(OgdenFit { terms, error: problem.errors.norm() / (data.len() as f64).sqrt() })
}

/// Exponents with the norm of the relative errors.
struct Start {
    exponents: Vec<f64>,
    error: f64,
}

/// Returns all ascending combinations of the exponents of the grid.
fn starting_points(order: usize) -> Vec<Start> {
    let mut lists: Vec<Vec<usize>> = vec![Vec::new()];
    for _ in 0..order {
        let longer = |list: &Vec<usize>| {
            let first = list.last().map_or(0, |last| last + 1);
            (first..GRID.len()).map(|next| [&list[..], &[next]].concat()).collect::<Vec<_>>()
        };
        lists = lists.iter().flat_map(longer).collect();
    }
    let start = |list: Vec<usize>| Start { exponents: list.into_iter().map(|i| GRID[i]).collect(), error: 0.0 };
    lists.into_iter().map(start).collect()
}

/// Solves the linear problem for given exponents; `None` if the terms are not independent.
fn reduced(data: &[RubberMeasurement], exponents: &[f64]) -> Option<Reduced> {
    let matrix = DMatrix::from_fn(data.len(), exponents.len(), |i, j| {
        let RubberMeasurement { test, stress, stretch } = data[i];
        term_stress(test, stretch, exponents[j])[0] / stress
    });
    let scales: Vec<f64> = matrix.column_iter().map(|column| column.norm().max(f64::MIN_POSITIVE)).collect();
    let scaled = DMatrix::from_fn(data.len(), exponents.len(), |i, j| matrix[(i, j)] / scales[j]);
    let (basis, triangle) = scaled.qr().unpack();
    if (0..exponents.len()).any(|j| triangle[(j, j)].abs() < DEPENDENT || !triangle[(j, j)].is_finite()) {
        return None;
    }
    let ones = DVector::from_element(data.len(), 1.0);
    let solution = triangle.solve_upper_triangular(&(basis.transpose() * &ones))?;
    let moduli = DVector::from_fn(exponents.len(), |j, _| solution[j] / scales[j]);
    let errors = ones - &matrix * &moduli;
    Some(Reduced { moduli, errors, basis })
}

/// Returns the derivatives of the errors with respect to the exponents, with the moduli eliminated.
fn derivatives(data: &[RubberMeasurement], exponents: &[f64], problem: &Reduced) -> DMatrix<f64> {
    let direct = DMatrix::from_fn(data.len(), exponents.len(), |i, j| {
        let RubberMeasurement { test, stress, stretch } = data[i];
        -problem.moduli[j] * term_stress(test, stretch, exponents[j])[1] / stress
    });
    let within = &problem.basis * (problem.basis.transpose() * &direct);
    direct - within
}

/// Returns whether the data determine the exponents.
fn determines_exponents(data: &[RubberMeasurement], exponents: &[f64], problem: &Reduced) -> bool {
    let jacobian = derivatives(data, exponents, problem);
    // A relative change of an exponent must change the stresses more than rounding does.
    let changes = DMatrix::from_fn(data.len(), exponents.len(), |i, j| jacobian[(i, j)] * exponents[j]);
    changes.svd(false, false).singular_values.iter().all(|value| *value > 1e-9)
}

/// Improves exponents by the Levenberg-Marquardt method.
fn improve(data: &[RubberMeasurement], start: Start) -> Start {
    let mut best = start;
    let Some(mut problem) = reduced(data, &best.exponents) else { return best };
    let mut damping = 1e-2;
    for _ in 0..ITERATIONS {
        let jacobian = derivatives(data, &best.exponents, &problem);
        let (mut normal, gradient) = (jacobian.transpose() * &jacobian, jacobian.transpose() * &problem.errors);
        for j in 0..best.exponents.len() {
            normal[(j, j)] += damping * normal[(j, j)].max(f64::MIN_POSITIVE);
        }
        let Some(step) = normal.lu().solve(&-gradient) else { break };
        let exponents: Vec<f64> =
            best.exponents.iter().zip(step.iter()).map(|(alpha, change)| alpha + change).collect();
        let is_short = step.iter().zip(&exponents).all(|(change, alpha)| change.abs() < SHORT * alpha.abs());
        let in_range = exponents.iter().all(|alpha| (EXPONENTS[0]..=EXPONENTS[1]).contains(&alpha.abs()));
        let next = in_range.then(|| reduced(data, &exponents)).flatten();
        match next.filter(|next| next.errors.norm() < best.error) {
            Some(next) => {
                best = Start { error: next.errors.norm(), exponents };
                problem = next;
                damping = (0.2 * damping).max(1e-15);
            }
            None if is_short || damping > 1e12 => break,
            None => damping *= 4.0,
        }
    }
    best
}
