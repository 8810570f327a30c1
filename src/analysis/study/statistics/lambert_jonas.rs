//! Lambert-Jonas curve of residual over striking velocity: v_r = a (v^p - v_l^p)^(1/p) above the limit velocity v_l,
//! zero below.
//!
//! Source: J. P. Lambert and G. H. Jonas, BRL Report 1852 (1976).

use super::IntervalEstimate;
use super::least_squares;

/// Fitted Lambert-Jonas curve.
#[derive(Clone, Debug, PartialEq)]
pub struct LambertJonasFit {
    /// a, p and the limit velocity, with confidence intervals.
    pub estimates: [IntervalEstimate; 3],
    /// Standard deviation of the residual velocities from the curve.
    pub deviation: f64,
    /// Whether the fit converged.
    pub converged: bool,
}

/// Returns the residual velocity at a striking velocity for a, p and the limit velocity. Equation (15.7).
pub fn residual([a, p, limit]: [f64; 3], velocity: f64) -> f64 {
    if velocity <= limit { 0.0 } else { a * velocity * libm::pow(1.0 - libm::pow(limit / velocity, p), 1.0 / p) }
}

/// Fits the curve to perforating shots, given as pairs of striking and residual velocity, from an approximate limit
/// velocity. `None` with fewer than four shots, if no curve fits, or if the shots do not determine it: an interval is
/// wider than its value.
pub fn fit(shots: &[(f64, f64)], limit: f64) -> Option<LambertJonasFit> {
    let slowest = shots.iter().map(|s| s.0).fold(f64::INFINITY, f64::min);
    if shots.len() < 4 || !(limit > 0.0 && limit < slowest) {
        return None;
    }
    let model = &mut |points: &[Vec<f64>]| -> Result<Vec<Vec<f64>>, std::convert::Infallible> {
        let residuals_at = |point: &Vec<f64>| {
            let [a, p, limit] = [point[0], point[1], point[2]];
            let sound = a > 0.0 && (0.3..50.0).contains(&p) && limit > 0.0 && limit < slowest;
            let value = |v: f64| if sound { residual([a, p, limit], v) } else { f64::NAN };
            shots.iter().map(|(v, known)| value(*v) - known).collect()
        };
        Ok(points.iter().map(residuals_at).collect())
    };
    let fit = match least_squares::fit(&[1.0, 2.0, limit], 1e-4, model) {
        Ok(fit) => fit?,
        Err(never) => match never {},
    };
    let intervals = fit.estimates();
    if !intervals.iter().all(|e| e.high - e.low < e.value.abs()) {
        return None;
    }
    Some(LambertJonasFit {
        estimates: [intervals[0], intervals[1], intervals[2]],
        deviation: fit.deviation(),
        converged: fit.converged,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::statistics::design::{draws, unit};
    use crate::study::statistics::normal;
    use rand_chacha::rand_core::RngCore as _;

    const TRUTH: [f64; 3] = [0.95, 2.3, 412.0];

    /// With 200 tables and three parameters, 570 ± 6 of 600 intervals are expected to contain the exact value.
    #[test]
    fn intervals_have_their_nominal_coverage() {
        let mut inside = 0;
        for seed in 0..200 {
            let mut draws = draws(seed, 1);
            let mut noise = || 2.0 * normal::quantile(unit(draws.next_u64()));
            let shots: Vec<(f64, f64)> =
                (1..=12).map(|i| 412.0 + 30.0 * f64::from(i)).map(|v| (v, residual(TRUTH, v) + noise())).collect();
            let curve = fit(&shots, 410.0).expect("a curve");
            assert!(curve.converged, "{seed}: {curve:?}");
            inside += curve.estimates.iter().zip(TRUTH).filter(|(e, truth)| e.holds(*truth)).count();
        }
        println!("{inside} of 600 inside");
        assert!((545..=590).contains(&inside), "{inside}");
    }

    #[test]
    fn exact_data_give_their_curve() {
        let shots: Vec<(f64, f64)> = [420.0, 450.0, 500.0, 600.0, 800.0].map(|v| (v, residual(TRUTH, v))).to_vec();
        let curve = fit(&shots, 400.0).expect("a curve");
        for (found, truth) in curve.estimates.iter().zip(TRUTH) {
            assert!((found.value / truth - 1.0).abs() < 1e-5, "{curve:?}");
        }
        assert_eq!(residual(TRUTH, 300.0), 0.0);
        assert_eq!(fit(&shots[..3], 400.0), None);
        assert_eq!(fit(&shots, 430.0), None);
    }
}
