//! Weighted least-squares fit of A, B, C in sigma/Y = A + B x + C x^2.

use nalgebra::{DMatrix, SVD};

use super::ResistanceError;
use crate::probability::students_t;

/// Bound on the iterations of the singular value decomposition, which takes some ten for three columns.
const MOST_SWEEPS: usize = 1000;

/// Free constants and weights of a fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitForm {
    /// Whether B is fitted; otherwise it is zero, as in much of the literature.
    pub linear: bool,
    /// Value of A if it is not fitted.
    pub pinned: Option<f64>,
    /// Weights of the squared differences.
    pub weight: FitWeight,
}

/// Weights of squared differences.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FitWeight {
    /// Equal weights.
    #[default]
    Even,
    /// Relative differences (weight 1/pressure²).
    Relative,
    /// Weight proportional to velocity: the depth is the integral of m V / F over V.
    Velocity,
}

/// Fitted constants with their confidence intervals.
#[derive(Clone, Debug, PartialEq)]
pub struct ResistanceFit {
    /// Constants A, B, C of sigma/Y = A + B x + C x^2.
    pub constants: [f64; 3],
    /// Half-width of the 95 % confidence interval of each constant by Student's t; `None` if not fitted. The residuals
    /// are misfit of the law and not noise, so the intervals show how well the range determines a constant.
    pub half_widths: [Option<f64>; 3],
    /// Weighted rms difference, divided by Y.
    pub residual: f64,
}

impl ResistanceFit {
    /// Returns sigma/Y at x = V sqrt(rho/Y).
    pub fn at(&self, x: f64) -> f64 {
        law(self.constants, x)
    }
}

/// Returns the fitted pressure A + B x + C x² at the dimensionless velocity `x`.
pub fn law([a, b, c]: [f64; 3], x: f64) -> f64 {
    a + x * (b + x * c)
}

/// Fits points `[x, sigma/Y]` with constants of at least zero: negative constants are set to zero and the others fitted
/// again.
///
/// # Errors
/// `C003` if there are fewer points than constants plus two, `C005` if A is negative or all constants are.
pub fn fit(points: &[[f64; 2]], form: FitForm) -> Result<ResistanceFit, ResistanceError> {
    let mut free = [form.pinned.is_none(), form.linear, true];
    loop {
        let fit = free_fit(points, form, free)?;
        let below = (0..3).filter(|i| free[*i] && fit.constants[*i] < 0.0);
        let Some(worst) = below.min_by(|i, k| fit.constants[*i].total_cmp(&fit.constants[*k])) else { return Ok(fit) };
        free[worst] = false;
        if worst == 0 || free == [false; 3] {
            return Err(ResistanceError::Negative(format!("A, B, C would be {:?}", fit.constants)));
        }
    }
}

fn free_fit(points: &[[f64; 2]], form: FitForm, free: [bool; 3]) -> Result<ResistanceFit, ResistanceError> {
    let columns: Vec<usize> = (0..3).filter(|i| free[*i]).collect();
    let (rows, count) = (points.len(), columns.len());
    if rows < count + 2 {
        return Err(ResistanceError::Range(format!(
            "{rows} points do not determine {count} constants: give at least {} points",
            count + 2
        )));
    }
    let weights = weights(points, form.weight);
    let fixed = [form.pinned.unwrap_or(0.0), 0.0, 0.0];
    let power = |x: f64, term: usize| [1.0, x, x * x][term];
    let matrix = DMatrix::from_fn(rows, count, |i, k| weights[i].sqrt() * power(points[i][0], columns[k]));
    let right = DMatrix::from_fn(rows, 1, |i, _| weights[i].sqrt() * (points[i][1] - law(fixed, points[i][0])));
    let svd = matrix.try_svd(true, true, f64::EPSILON, MOST_SWEEPS);
    let Some(SVD { u: Some(left), v_t: Some(right_transposed), singular_values: singular }) = svd else {
        return Err(ResistanceError::Range("the least-squares problem has no solution".into()));
    };
    if singular[count - 1] <= 1e-12 * singular[0] || singular[0].is_nan() {
        return Err(ResistanceError::Range("too few different velocities to determine the constants".into()));
    }
    let turned = left.transpose() * &right;
    let mut constants = fixed;
    let mut spread = [None; 3];
    for (row, &term) in columns.iter().enumerate() {
        let share = |k: usize| right_transposed[(k, row)] / singular[k];
        constants[term] = (0..count).map(|k| share(k) * turned[(k, 0)]).sum();
        spread[term] = Some((0..count).map(|k| share(k) * share(k)).sum::<f64>().sqrt());
    }
    let square = |(point, weight): (&[f64; 2], &f64)| weight * (point[1] - law(constants, point[0])).powi(2);
    let sum: f64 = points.iter().zip(&weights).map(square).sum();
    let freedom = (rows - count) as f64;
    let scale = students_t::quantile(0.975, freedom) * (sum / freedom).sqrt();
    let half_widths = spread.map(|s| s.map(|s| scale * s));
    Ok(ResistanceFit { constants, half_widths, residual: (sum / rows as f64).sqrt() })
}

/// Returns weights with a mean of one.
fn weights(points: &[[f64; 2]], weight: FitWeight) -> Vec<f64> {
    let weight_of = |p: &[f64; 2]| match weight {
        FitWeight::Even => 1.0,
        FitWeight::Relative => 1.0 / (p[1] * p[1]),
        FitWeight::Velocity => p[0],
    };
    let raw: Vec<f64> = points.iter().map(weight_of).collect();
    let mean = raw.iter().sum::<f64>() / raw.len() as f64;
    raw.iter().map(|w| w / mean).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const FREE: FitForm = FitForm { linear: true, pinned: None, weight: FitWeight::Even };

    fn parabola(constants: [f64; 3]) -> Vec<[f64; 2]> {
        (0..21).map(|i| 0.1 * f64::from(i)).map(|x| [x, law(constants, x)]).collect()
    }

    #[test]
    fn parabola_is_recovered_with_all_weights() {
        for weight in [FitWeight::Even, FitWeight::Relative, FitWeight::Velocity] {
            for pinned in [None, Some(4.0)] {
                let fit = fit(&parabola([4.0, 0.5, 1.1]), FitForm { pinned, weight, ..FREE }).expect("a fit");
                assert!(fit.constants.iter().zip([4.0, 0.5, 1.1]).all(|(a, b)| (a - b).abs() < 1e-12), "{fit:?}");
                assert!(fit.residual < 1e-13);
                assert_eq!(fit.half_widths[0].is_none(), pinned.is_some());
            }
        }
    }

    /// By hand: for the points (0, 1), (1, 0), (2, 3), (3, 2), (4, 7) and A + C x^2 the normal equations are 5 A + 30 C
    /// = 13 and 30 A + 354 C = 142.
    #[test]
    fn two_constants_match_hand_calculation() {
        let points = [[0.0, 1.0], [1.0, 0.0], [2.0, 3.0], [3.0, 2.0], [4.0, 7.0]];
        let fit = fit(&points, FitForm { linear: false, ..FREE }).expect("a fit");
        let c = (142.0 - 6.0 * 13.0) / (354.0 - 180.0);
        let a = (13.0 - 30.0 * c) / 5.0;
        assert!(
            (fit.constants[0] - a).abs() < 1e-13 && fit.constants[1] == 0.0 && (fit.constants[2] - c).abs() < 1e-13
        );
        let squares: f64 = points.iter().map(|p| (p[1] - a - c * p[0] * p[0]).powi(2)).sum();
        assert!((fit.residual - (squares / 5.0).sqrt()).abs() < 1e-14);
        // Three degrees of freedom: t = 3.182. The variance of C is s^2 divided by the sum of squared deviations of
        // x^2.
        let half = 3.182 * (squares / 3.0 / 174.0).sqrt();
        assert!((fit.half_widths[2].expect("fitted") / half - 1.0).abs() < 5e-3, "{fit:?} {half}");
    }

    #[test]
    fn negative_constants_are_set_to_zero() {
        let fitted = fit(&parabola([4.0, -0.3, 1.1]), FREE).expect("a fit");
        assert!(
            fitted.constants[1] == 0.0 && fitted.half_widths[1].is_none() && fitted.constants[2] > 0.0,
            "{fitted:?}"
        );
        assert_eq!(fit(&parabola([-4.0, 0.0, 1.0]), FREE).expect_err("below zero").code(), "C005");
        assert_eq!(fit(&parabola([4.0, 0.0, 1.0])[..4], FREE).expect_err("few").code(), "C003");
        assert_eq!(fit(&[[1.0, 2.0]; 9], FREE).expect_err("one place").code(), "C003");
    }
}
