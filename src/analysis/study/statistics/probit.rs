//! Maximum-likelihood fit of a normal distribution to interval-censored data: bracketed limits, or single shots with or
//! without perforation (probit analysis).

use super::{IntervalEstimate, normal};

/// Fitted mean and standard deviation with confidence intervals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalFit {
    /// Mean, which is the median (V50).
    pub median: IntervalEstimate,
    /// Standard deviation of the members.
    pub deviation: IntervalEstimate,
}

const MOST_ITERATIONS: usize = 200;
/// Smallest width of an interval, in standard deviations; differences over narrower intervals would be dominated by
/// rounding.
const NARROWEST: f64 = 1e-4;

/// Fits a normal distribution by maximum likelihood to intervals that contain the members. An end may be infinite: a
/// shot at v with perforation gives the interval (-inf, v), one without gives (v, inf) (probit analysis; Finney, Probit
/// Analysis, 1971). `None` if the intervals do not determine a scatter: fewer than three members, or all intervals
/// overlap.
///
/// Confidence intervals follow from the second derivatives of the log-likelihood at its maximum; the interval of the
/// standard deviation is computed for its logarithm.
pub fn fit(members: &[(f64, f64)]) -> Option<NormalFit> {
    let mut current = LikelihoodPoint::of(members, start(members)?);
    for _ in 0..MOST_ITERATIONS {
        let Some(next) = current.uphill(members) else { break };
        let gained = next.likelihood - current.likelihood;
        current = next;
        if gained < 1e-12 * members.len() as f64 {
            break;
        }
    }
    let [uu, us, ss] = current.curvatures.map(|c| -c);
    let determinant = uu * ss - us * us;
    if !(uu > 0.0 && determinant > 0.0) {
        return None;
    }
    let deviation = libm::exp(current.at[1]);
    let freedom = members.len() as f64 - 1.0;
    let median = IntervalEstimate::around(current.at[0], deviation * (ss / determinant).sqrt(), freedom);
    let log = IntervalEstimate::around(current.at[1], (uu / determinant).sqrt(), freedom);
    let [value, low, high] = [log.value, log.low, log.high].map(libm::exp);
    Some(NormalFit { median, deviation: IntervalEstimate { value, low, high } })
}

/// Returns initial values: mean, and logarithm of the standard deviation, of all finite ends.
fn start(members: &[(f64, f64)]) -> Option<[f64; 2]> {
    let highest = members.iter().map(|m| m.0).fold(f64::NEG_INFINITY, f64::max);
    let lowest = members.iter().map(|m| m.1).fold(f64::INFINITY, f64::min);
    if members.len() < 3 || highest <= lowest {
        return None;
    }
    let ends: Vec<f64> = members.iter().flat_map(|m| [m.0, m.1]).filter(|end| end.is_finite()).collect();
    let count = ends.len() as f64;
    let mean = ends.iter().sum::<f64>() / count;
    let square = ends.iter().map(|e| (e - mean) * (e - mean)).sum::<f64>() / count;
    (square > 0.0).then(|| [mean, 0.5 * libm::log(square)])
}

/// Log-likelihood at a mean and a logarithm of the standard deviation, with its first and second derivatives.
/// Derivatives by the mean are in units of the standard deviation.
struct LikelihoodPoint {
    at: [f64; 2],
    likelihood: f64,
    slopes: [f64; 2],
    curvatures: [f64; 3],
}

impl LikelihoodPoint {
    fn of(members: &[(f64, f64)], at: [f64; 2]) -> LikelihoodPoint {
        let mut sum = LikelihoodPoint { at, likelihood: 0.0, slopes: [0.0; 2], curvatures: [0.0; 3] };
        let scale = libm::exp(at[1]);
        for (low, high) in members {
            let (mut a, mut b) = ((low - at[0]) / scale, (high - at[0]) / scale);
            if b - a < NARROWEST {
                let middle = 0.5 * (a + b);
                (a, b) = (middle - 0.5 * NARROWEST, middle + 0.5 * NARROWEST);
            }
            sum.add(a, b);
        }
        sum
    }

    /// Adds a member between two ends in units of the standard deviation.
    fn add(&mut self, a: f64, b: f64) {
        // The tail on the side of the interval avoids cancellation.
        let part = if a > 0.0 {
            normal::cumulative(-a) - normal::cumulative(-b)
        } else {
            normal::cumulative(b) - normal::cumulative(a)
        };
        let part = part.max(f64::MIN_POSITIVE);
        let powers = |x: f64| {
            let density = if x.is_finite() { normal::density(x) / part } else { 0.0 };
            let x = if x.is_finite() { x } else { 0.0 };
            [density, x * density, x * x * density, x * x * x * density]
        };
        let (low, high) = (powers(a), powers(b));
        let [d0, d1, d2, d3] = [0, 1, 2, 3].map(|i| high[i] - low[i]);
        self.likelihood += libm::log(part);
        self.slopes[0] -= d0;
        self.slopes[1] -= d1;
        self.curvatures[0] += -d1 - d0 * d0;
        self.curvatures[1] += d0 - d2 - d0 * d1;
        self.curvatures[2] += d1 - d3 - d1 * d1;
    }

    /// Returns a point of higher likelihood by a damped Newton step; `None` if there is none.
    fn uphill(&self, members: &[(f64, f64)]) -> Option<LikelihoodPoint> {
        let [u, s] = self.slopes;
        let mut damping = 0.0;
        for _ in 0..60 {
            let [uu, us, ss] = [damping - self.curvatures[0], -self.curvatures[1], damping - self.curvatures[2]];
            let determinant = uu * ss - us * us;
            if uu > 0.0 && determinant > 0.0 {
                let step = [(ss * u - us * s) / determinant, (uu * s - us * u) / determinant];
                let candidate = [self.at[0] + libm::exp(self.at[1]) * step[0], self.at[1] + step[1]];
                let next = LikelihoodPoint::of(members, candidate);
                if step[1].abs() < 2.0 && next.likelihood > self.likelihood {
                    return Some(next);
                }
            }
            damping = if damping == 0.0 { 1e-6 * members.len() as f64 } else { 4.0 * damping };
        }
        None
    }
}

/// Returns the cumulative probability at a value.
pub fn part_below(scatter: &NormalFit, value: f64) -> f64 {
    normal::cumulative((value - scatter.median.value) / scatter.deviation.value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::statistics::design::{draws, unit};
    use rand_chacha::rand_core::RngCore as _;

    /// Limits of 60 targets, normal with mean 412 and deviation 8.
    fn limits(seed: u64) -> Vec<f64> {
        let mut draws = draws(seed, 2);
        (0..60).map(|_| 412.0 + 8.0 * normal::quantile(unit(draws.next_u64()))).collect()
    }

    fn inside(of: &dyn Fn(usize, f64) -> (f64, f64)) -> [usize; 2] {
        let mut inside = [0; 2];
        for seed in 0..200 {
            let members: Vec<_> = limits(seed).into_iter().enumerate().map(|(i, limit)| of(i, limit)).collect();
            let Some(found) = fit(&members) else { continue };
            inside[0] += usize::from(found.median.holds(412.0));
            inside[1] += usize::from(found.deviation.holds(8.0));
        }
        println!("{inside:?} of 200 inside");
        inside
    }

    /// With 200 tables, 190 ± 3 intervals are expected to contain the exact value, for narrow brackets, wide brackets,
    /// and single shots.
    #[test]
    fn intervals_have_their_nominal_coverage() {
        for width in [1e-6, 10.0] {
            let bracket = |_: usize, limit: f64| {
                let low = (limit / width).floor() * width;
                (low, low + width)
            };
            assert!(inside(&bracket).iter().all(|n| (180..=198).contains(n)), "{width}");
        }
        let shot = |i: usize, limit: f64| {
            let v = 412.0 + 8.0 * 2.5 * (2.0 * (i as f64 + 0.5) / 60.0 - 1.0);
            if v > limit { (f64::NEG_INFINITY, v) } else { (v, f64::INFINITY) }
        };
        assert!(inside(&shot).iter().all(|n| (180..=198).contains(n)));
    }

    #[test]
    fn narrow_brackets_give_mean_and_deviation() {
        let limits = limits(1);
        let members: Vec<(f64, f64)> = limits.iter().map(|v| (v - 1e-7, v + 1e-7)).collect();
        let fitted = fit(&members).expect("a scatter");
        let mean = limits.iter().sum::<f64>() / 60.0;
        let deviation = (limits.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / 60.0).sqrt();
        assert!((fitted.median.value - mean).abs() < 1e-6 && (fitted.deviation.value / deviation - 1.0).abs() < 1e-6);
        assert!((part_below(&fitted, mean) - 0.5).abs() < 1e-6);
    }

    #[test]
    fn separable_members_have_no_fit() {
        let clean = [1.0, 2.0, 3.0].map(|v| (v, f64::INFINITY)).into_iter();
        let clean: Vec<_> = clean.chain([4.0, 5.0].map(|v| (f64::NEG_INFINITY, v))).collect();
        assert_eq!(fit(&clean), None);
        assert_eq!(fit(&[(1.0, 2.0), (1.0, 2.0), (1.0, 2.0)]), None);
    }
}
