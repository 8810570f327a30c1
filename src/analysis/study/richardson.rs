//! Estimate of the limit of a series of refined values: observed order, Richardson extrapolation, grid convergence
//! index.
//!
//! Sources: L. F. Richardson, Phil. Trans. R. Soc. A 210 (1911) 307; P. J. Roache, J. Fluids Eng. 116 (1994) 405: the
//! grid convergence index with the factor of safety 1.25 where the order is observed on three levels, 3 where it is
//! assumed; ASME V&V 20-2009, section 2; W. L. Oberkampf and C. J. Roy, Verification and Validation in Scientific
//! Computing (Cambridge 2010), section 8.7: factor 3 and a bounded order where the observed one is not credible.

use serde::Serialize;

/// Formal order of convergence: central differences, one-point quadrature and straight facets are of second order. It
/// is used with two levels, and as upper bound of the observed order in the extrapolation.
pub const FORMAL_ORDER: f64 = 2.0;
/// Range of credible observed orders; outside it the series is not in the asymptotic range.
pub const CREDIBLE: [f64; 2] = [0.5, 2.5];
/// Factor of safety for three levels with a credible order.
const OBSERVED: f64 = 1.25;
/// Factor of safety in all other cases.
const ASSUMED: f64 = 3.0;
/// Relative differences below this value are rounding errors.
const ROUNDING: f64 = 1e-12;

/// One level of a series of refinement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RefinementLevel {
    /// Size, for example of elements or increments, in any unit; smaller is finer.
    pub size: f64,
    /// Value computed at this size.
    pub value: f64,
}

/// Convergence behaviour of a series.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ConvergenceBehaviour {
    /// The observed order is credible.
    Asymptotic,
    /// Two levels: no order can be observed.
    TwoLevels,
    /// Differences alternate in sign.
    Oscillating,
    /// Differences decrease more slowly than with order 0.5, or increase.
    Slow,
    /// Differences decrease faster than with order 2.5.
    Fast,
    /// Differences are rounding errors.
    Settled,
}

impl ConvergenceBehaviour {
    /// Returns the word by which tables show the behaviour.
    pub fn word(self) -> &'static str {
        match self {
            ConvergenceBehaviour::Asymptotic => "",
            ConvergenceBehaviour::TwoLevels => "two levels",
            ConvergenceBehaviour::Oscillating => "oscillates",
            ConvergenceBehaviour::Slow => "slow",
            ConvergenceBehaviour::Fast => "fast",
            ConvergenceBehaviour::Settled => "settled",
        }
    }
}

/// Estimate of the limit of a series from its finest levels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LimitEstimate {
    /// Observed order; `None` if it cannot be determined.
    pub order: Option<f64>,
    /// Convergence behaviour of the series.
    pub behaviour: ConvergenceBehaviour,
    /// Estimated limit, by Richardson extrapolation if the behaviour allows it.
    pub limit: f64,
    /// Grid convergence index in the units of the value: expected distance of the limit from the finest value.
    pub uncertainty: f64,
    /// Factor of safety of the uncertainty.
    pub factor: f64,
}

/// Estimates the limit from the last three levels, or from two; `None` with fewer. Sizes must decrease along the
/// series.
pub fn estimate(series: &[RefinementLevel]) -> Option<LimitEstimate> {
    match series {
        [.., a, b, c] => Some(of_three(*a, *b, *c)),
        [a, b] => Some(of_two(*a, *b)),
        _ => None,
    }
}

fn of_two(coarse: RefinementLevel, fine: RefinementLevel) -> LimitEstimate {
    let change = fine.value - coarse.value;
    let error = change / gain(coarse, fine, FORMAL_ORDER);
    let behaviour =
        if is_rounding(&[coarse, fine]) { ConvergenceBehaviour::Settled } else { ConvergenceBehaviour::TwoLevels };
    let uncertainty = ASSUMED * error.abs() + floor(fine);
    LimitEstimate { order: None, behaviour, limit: fine.value + error, uncertainty, factor: ASSUMED }
}

fn of_three(coarse: RefinementLevel, middle: RefinementLevel, fine: RefinementLevel) -> LimitEstimate {
    let (before, last) = (middle.value - coarse.value, fine.value - middle.value);
    let widest = before.abs().max(last.abs());
    let unextrapolated = |order, behaviour, uncertainty: f64| LimitEstimate {
        order,
        behaviour,
        limit: fine.value,
        uncertainty: uncertainty + floor(fine),
        factor: ASSUMED,
    };
    if is_rounding(&[coarse, middle, fine]) {
        return unextrapolated(None, ConvergenceBehaviour::Settled, ASSUMED * widest);
    }
    if before * last < 0.0 {
        return unextrapolated(None, ConvergenceBehaviour::Oscillating, ASSUMED * widest);
    }
    let Some(order) = observed_order(coarse, middle, fine) else {
        let slow = last.abs() / gain(middle, fine, CREDIBLE[0]);
        return unextrapolated(None, ConvergenceBehaviour::Slow, ASSUMED * widest.max(slow));
    };
    if order < CREDIBLE[0] {
        let slow = last.abs() / gain(middle, fine, CREDIBLE[0]);
        return unextrapolated(Some(order), ConvergenceBehaviour::Slow, ASSUMED * widest.max(slow));
    }
    let error = last / gain(middle, fine, order.min(FORMAL_ORDER));
    let limit = fine.value + error;
    if order > CREDIBLE[1] {
        // The last difference may be small by chance; the previous one, reduced with the formal order, is also a bound.
        let left = before / gain(coarse, middle, FORMAL_ORDER) / libm::pow(middle.size / fine.size, FORMAL_ORDER);
        let uncertainty = ASSUMED * error.abs().max(left.abs()) + floor(fine);
        return LimitEstimate {
            order: Some(order),
            behaviour: ConvergenceBehaviour::Fast,
            limit,
            uncertainty,
            factor: ASSUMED,
        };
    }
    let uncertainty = OBSERVED * error.abs() + floor(fine);
    LimitEstimate {
        order: Some(order),
        behaviour: ConvergenceBehaviour::Asymptotic,
        limit,
        uncertainty,
        factor: OBSERVED,
    }
}

/// Returns r^p - 1 with the ratio r of the sizes: the ratio of the difference between two levels to the error of the
/// finer one.
fn gain(coarse: RefinementLevel, fine: RefinementLevel, order: f64) -> f64 {
    libm::pow(coarse.size / fine.size, order) - 1.0
}

fn floor(fine: RefinementLevel) -> f64 {
    ROUNDING * fine.value.abs()
}

fn is_rounding(levels: &[RefinementLevel]) -> bool {
    let scale = levels.iter().fold(0.0_f64, |m, l| m.max(l.value.abs()));
    levels.windows(2).all(|w| (w[1].value - w[0].value).abs() <= ROUNDING * scale)
}

/// Returns the order p observed on three levels: (h1^p - h2^p) / (h2^p - h3^p) equals the ratio of their differences.
/// `None` if no positive order gives that ratio. The left side increases with p, so bisection finds p.
pub fn observed_order(coarse: RefinementLevel, middle: RefinementLevel, fine: RefinementLevel) -> Option<f64> {
    let ratio = (middle.value - coarse.value) / (fine.value - middle.value);
    let of = |p: f64| {
        let [a, b, c] = [coarse, middle, fine].map(|l| libm::pow(l.size / coarse.size, p));
        (a - b) / (b - c)
    };
    let (mut low, mut high) = (1e-3, 16.0);
    if !ratio.is_finite() || ratio <= of(low) {
        return None;
    }
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        *(if of(middle) < ratio { &mut low } else { &mut high }) = middle;
    }
    Some(0.5 * (low + high))
}

/// Returns the order of convergence from two errors; `None` if an error is zero.
pub fn order_of_errors(coarse: RefinementLevel, fine: RefinementLevel) -> Option<f64> {
    let ratio = (coarse.value / fine.value).abs();
    let order = libm::log(ratio) / libm::log(coarse.size / fine.size);
    order.is_finite().then_some(order)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series(sizes: &[f64], law: impl Fn(f64) -> f64) -> Vec<RefinementLevel> {
        sizes.iter().map(|&size| RefinementLevel { size, value: law(size) }).collect()
    }

    #[test]
    fn order_is_found_for_any_ratio_of_sizes() {
        for (sizes, order) in [([1.0, 0.5, 0.25], 2.0), ([1.0, 0.7, 0.3], 1.0), ([3.0, 2.0, 1.9], 1.5)] {
            let found = estimate(&series(&sizes, |h| 7.0 + 0.1 * h.powf(order))).expect("three levels");
            assert!((found.order.expect("an order") - order).abs() < 1e-6, "{found:?}");
            assert!((found.limit - 7.0).abs() < 1e-6 && found.behaviour == ConvergenceBehaviour::Asymptotic);
            let error = 0.1 * sizes[2].powf(order);
            assert!((found.uncertainty / (1.25 * error) - 1.0).abs() < 1e-5);
        }
    }

    #[test]
    fn non_asymptotic_series_have_wide_bounds() {
        let of = |values: [f64; 3]| {
            let levels = [1.0, 0.5, 0.25].iter().zip(values).map(|(&size, value)| RefinementLevel { size, value });
            estimate(&levels.collect::<Vec<_>>()).expect("three levels")
        };
        for (values, behaviour, at_least) in [
            ([1.0, 1.2, 1.1], ConvergenceBehaviour::Oscillating, 0.6),
            ([1.0, 1.1, 1.2], ConvergenceBehaviour::Slow, 0.3),
            ([1.0, 1.1, 1.3], ConvergenceBehaviour::Slow, 0.6),
            ([1.0, 2.0, 2.01], ConvergenceBehaviour::Fast, 0.01),
            ([1.0, 1.0, 1.0], ConvergenceBehaviour::Settled, 0.0),
        ] {
            let found = of(values);
            assert_eq!(found.behaviour, behaviour, "{values:?}");
            assert!(found.uncertainty >= at_least * (1.0 - 1e-12), "{values:?}: {}", found.uncertainty);
        }
        assert_eq!(estimate(&series(&[1.0], |h| h)), None);
        let two = estimate(&series(&[1.0, 0.5], |h| h * h)).expect("two levels");
        assert!((two.uncertainty - 0.75).abs() < 1e-9 && two.limit.abs() < 1e-15, "{two:?}");
    }
}
