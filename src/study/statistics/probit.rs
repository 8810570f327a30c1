//! A normal distribution by intervals that hold its members: limits that were bracketed, and shots that perforated or did not.

use super::{Estimate, normal};

/// Mean and deviation with their intervals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalFit {
    /// The value that half of the members lie below: V50.
    pub median: Estimate,
    /// The standard deviation.
    pub deviation: Estimate,
}

const MOST_ITERATIONS: usize = 200;
/// Intervals are taken no narrower than this part of the deviation, where differences would be rounding.
const NARROWEST: f64 = 1e-4;

/// By maximum likelihood. An end may be infinite: a shot at v that perforates says that its limit lies in (-inf, v), one that does
/// not in (v, inf), which is probit analysis (Finney, Probit Analysis, 1971). `None` where the members tell no scatter: fewer than
/// three, or none that stops above another that perforates.
///
/// Intervals by the matrix of second derivatives at the most likely values; that of the deviation in its logarithm.
pub fn fit(members: &[(f64, f64)]) -> Option<NormalFit> {
    let mut here = LikelihoodPoint::of(members, start(members)?);
    for _ in 0..MOST_ITERATIONS {
        let Some(next) = here.uphill(members) else { break };
        let gained = next.likelihood - here.likelihood;
        here = next;
        if gained < 1e-12 * members.len() as f64 {
            break;
        }
    }
    let [uu, us, ss] = here.curvatures.map(|c| -c);
    let determinant = uu * ss - us * us;
    if !(uu > 0.0 && determinant > 0.0) {
        return None;
    }
    let deviation = libm::exp(here.at[1]);
    let freedom = members.len() as f64 - 1.0;
    let median = Estimate::around(here.at[0], deviation * (ss / determinant).sqrt(), freedom);
    let log = Estimate::around(here.at[1], (uu / determinant).sqrt(), freedom);
    let [value, low, high] = [log.value, log.low, log.high].map(libm::exp);
    Some(NormalFit { median, deviation: Estimate { value, low, high } })
}

/// Mean and logarithm of the deviation of all ends that there are.
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

/// Mean and logarithm of the deviation, how likely the members are with them, and derivatives of that: by the mean in units of the
/// deviation, and by the logarithm.
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

    /// A member between two ends in units of the deviation.
    fn add(&mut self, a: f64, b: f64) {
        // The tail on whose side it lies loses no digits.
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

    /// A point that is more likely, by Newton's method, damped where that overshoots; `None` where there is none.
    fn uphill(&self, members: &[(f64, f64)]) -> Option<LikelihoodPoint> {
        let [u, s] = self.slopes;
        let mut damping = 0.0;
        for _ in 0..60 {
            let [uu, us, ss] = [damping - self.curvatures[0], -self.curvatures[1], damping - self.curvatures[2]];
            let determinant = uu * ss - us * us;
            if uu > 0.0 && determinant > 0.0 {
                let step = [(ss * u - us * s) / determinant, (uu * s - us * u) / determinant];
                let at = [self.at[0] + libm::exp(self.at[1]) * step[0], self.at[1] + step[1]];
                let next = LikelihoodPoint::of(members, at);
                if step[1].abs() < 2.0 && next.likelihood > self.likelihood {
                    return Some(next);
                }
            }
            damping = if damping == 0.0 { 1e-6 * members.len() as f64 } else { 4.0 * damping };
        }
        None
    }
}

/// The part of members below a value.
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

    /// Of 200 tables 190 intervals are to be expected to hold the truth, give or take 3, whether limits were bracketed closely, widely,
    /// or each target was shot at once.
    #[test]
    fn intervals_hold_what_made_the_members() {
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
        let found = fit(&members).expect("a scatter");
        let mean = limits.iter().sum::<f64>() / 60.0;
        let deviation = (limits.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / 60.0).sqrt();
        assert!((found.median.value - mean).abs() < 1e-6 && (found.deviation.value / deviation - 1.0).abs() < 1e-6);
        assert!((part_below(&found, mean) - 0.5).abs() < 1e-6);
    }

    #[test]
    fn members_that_tell_no_scatter_have_none() {
        let clean = [1.0, 2.0, 3.0].map(|v| (v, f64::INFINITY)).into_iter();
        let clean: Vec<_> = clean.chain([4.0, 5.0].map(|v| (f64::NEG_INFINITY, v))).collect();
        assert_eq!(fit(&clean), None);
        assert_eq!(fit(&[(1.0, 2.0), (1.0, 2.0), (1.0, 2.0)]), None);
    }
}
