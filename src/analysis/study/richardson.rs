//! Estimate of the limit of a series of refined values: observed order, Richardson extrapolation, grid convergence
//! index.
//!
//! Sources: L. F. Richardson, Phil. Trans. R. Soc. A 210 (1911) 307; P. J. Roache, J. Fluids Eng. 116 (1994) 405: the
//! grid convergence index with the factor of safety 1.25 where the order is observed on three levels, 3 where it is
//! assumed; ASME V&V 20-2009, section 2; W. L. Oberkampf and C. J. Roy, Verification and Validation in Scientific
//! Computing (Cambridge 2010), section 8.7: factor 3 and a bounded order where the observed one is not credible or not
//! confirmed, that is, neither within 10 % of the formal order nor equal to the order of the previous levels. With two
//! levels the order is taken as the smallest credible one: with the formal order, the band of impact problems contains the
//! limit in three of four cases only (docs/theory/errors.md).

use serde::Serialize;

/// Formal order of convergence: central differences, one-point quadrature and straight facets are of second order. It
/// is the order of the extrapolation with two levels, and its upper bound with more.
pub const FORMAL_ORDER: f64 = 2.0;
/// Range of credible observed orders; outside it the series is not in the asymptotic range.
pub const CREDIBLE: [f64; 2] = [0.5, 2.5];
/// Smallest ratio of the sizes of two levels at which an order is reliable.
const SMALLEST_RATIO: f64 = 1.5;
/// Smallest ratio of the sizes of two levels whose order is above the credible range.
const FAST_RATIO: f64 = 2.0;
/// Order below which a series is singular: a point load, a corner, a shock or linear bulk viscosity limits it.
const SINGULAR: f64 = 0.9;
/// Largest difference of two agreeing orders, and of an agreeing order from the formal one (10 %).
const AGREEMENT: f64 = 0.2;
/// Factor of safety for a credible order that is confirmed.
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
    /// The observed order is credible and confirmed by that of the previous levels or by the formal order.
    Asymptotic,
    /// The observed order is credible but not confirmed.
    Unconfirmed,
    /// The observed order is credible but below 1.
    Singular,
    /// The ratio of two sizes is below 1.5, or below 2 with an order above 2.5; such levels agree by chance.
    Close,
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
            ConvergenceBehaviour::Unconfirmed => "one order",
            ConvergenceBehaviour::Singular => "order below 1",
            ConvergenceBehaviour::Close => "close levels",
            ConvergenceBehaviour::TwoLevels => "two levels",
            ConvergenceBehaviour::Oscillating => "oscillates",
            ConvergenceBehaviour::Slow => "slow",
            ConvergenceBehaviour::Fast => "fast",
            ConvergenceBehaviour::Settled => "settled",
        }
    }

    /// Returns whether properties of the model can be the cause, and not only the choice of levels.
    pub fn concerns_model(self) -> bool {
        !matches!(self, ConvergenceBehaviour::TwoLevels | ConvergenceBehaviour::Close)
    }

    /// Returns why the estimate is wide; `None` if it is not.
    pub fn reason(self) -> Option<&'static str> {
        Some(match self {
            ConvergenceBehaviour::Asymptotic | ConvergenceBehaviour::Settled => return None,
            ConvergenceBehaviour::Unconfirmed => {
                "the order is observed once only, or differs from that of the previous levels; add a finer level"
            }
            ConvergenceBehaviour::Singular => "the order is below 1, as at singular points and shocks",
            ConvergenceBehaviour::Close => "sizes of levels are too close; use ratios of at least 1.5, better 2",
            ConvergenceBehaviour::TwoLevels => "two levels give no order; add a level",
            ConvergenceBehaviour::Oscillating => "differences between levels change sign",
            ConvergenceBehaviour::Slow => "differences between levels do not decrease, or with an order below 0.5",
            ConvergenceBehaviour::Fast => "the last difference may be small by chance; add a finer level",
        })
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

/// Estimates the limit from the last three levels, or from two; `None` with fewer. The level before these confirms
/// their order. Sizes must decrease along the series.
pub fn estimate(series: &[RefinementLevel]) -> Option<LimitEstimate> {
    match series {
        [.., z, a, b, c] => Some(of_three(*a, *b, *c, Some(*z))),
        [a, b, c] => Some(of_three(*a, *b, *c, None)),
        [a, b] => Some(of_two(*a, *b)),
        _ => None,
    }
}

fn of_two(coarse: RefinementLevel, fine: RefinementLevel) -> LimitEstimate {
    let change = fine.value - coarse.value;
    let error = change / gain(coarse, fine, FORMAL_ORDER);
    let behaviour =
        if is_rounding(&[coarse, fine]) { ConvergenceBehaviour::Settled } else { ConvergenceBehaviour::TwoLevels };
    let uncertainty = ASSUMED * (change / gain(coarse, fine, CREDIBLE[0])).abs() + floor(fine);
    LimitEstimate { order: None, behaviour, limit: fine.value + error, uncertainty, factor: ASSUMED }
}

fn of_three(
    coarse: RefinementLevel,
    middle: RefinementLevel,
    fine: RefinementLevel,
    previous: Option<RefinementLevel>,
) -> LimitEstimate {
    let (previous_change, last) = (middle.value - coarse.value, fine.value - middle.value);
    let widest = previous_change.abs().max(last.abs());
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
    if previous_change * last < 0.0 {
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
    extrapolated([coarse, middle, fine], order, behaviour_of([coarse, middle, fine], order, previous))
}

/// Returns the behaviour of three levels with an order of at least 0.5.
fn behaviour_of(
    [coarse, middle, fine]: [RefinementLevel; 3],
    order: f64,
    previous: Option<RefinementLevel>,
) -> ConvergenceBehaviour {
    let ratio = (coarse.size / middle.size).min(middle.size / fine.size);
    let confirmed = match previous {
        Some(previous) => {
            observed_order(previous, coarse, middle).is_some_and(|p| p >= SINGULAR && (p - order).abs() <= AGREEMENT)
        }
        None => (order - FORMAL_ORDER).abs() <= AGREEMENT,
    };
    let fast = order > CREDIBLE[1];
    if ratio < (1.0 - 1e-9) * if fast { FAST_RATIO } else { SMALLEST_RATIO } {
        ConvergenceBehaviour::Close
    } else if fast {
        ConvergenceBehaviour::Fast
    } else if order < SINGULAR {
        ConvergenceBehaviour::Singular
    } else if confirmed {
        ConvergenceBehaviour::Asymptotic
    } else {
        ConvergenceBehaviour::Unconfirmed
    }
}

/// Returns the estimate by Richardson extrapolation. Unless the order is confirmed, the previous difference, reduced
/// with the formal order, is also a bound, because the last one may be small by chance. The order of close levels
/// is taken as at most 1. Equations (15.3), (15.4).
fn extrapolated(
    [coarse, middle, fine]: [RefinementLevel; 3],
    order: f64,
    behaviour: ConvergenceBehaviour,
) -> LimitEstimate {
    let (previous_change, last) = (middle.value - coarse.value, fine.value - middle.value);
    let error = last / gain(middle, fine, order.min(FORMAL_ORDER));
    let (factor, bound) = if behaviour == ConvergenceBehaviour::Asymptotic {
        (OBSERVED, error.abs())
    } else {
        let assumed = if behaviour == ConvergenceBehaviour::Close { 1.0 } else { FORMAL_ORDER };
        let remaining_error =
            previous_change / gain(coarse, middle, assumed) / libm::pow(middle.size / fine.size, assumed);
        (ASSUMED, (last / gain(middle, fine, order.min(assumed))).abs().max(remaining_error.abs()))
    };
    LimitEstimate {
        order: Some(order),
        behaviour,
        limit: fine.value + error,
        uncertainty: factor * bound + floor(fine),
        factor,
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
/// `None` if no positive order gives that ratio. The left side increases with p, so bisection finds p. Equation (15.2).
pub fn observed_order(coarse: RefinementLevel, middle: RefinementLevel, fine: RefinementLevel) -> Option<f64> {
    let ratio = (middle.value - coarse.value) / (fine.value - middle.value);
    let ratio_of_order = |p: f64| {
        let [a, b, c] = [coarse, middle, fine].map(|l| libm::pow(l.size / coarse.size, p));
        (a - b) / (b - c)
    };
    let (mut low, mut high) = (1e-3, 16.0);
    if !ratio.is_finite() || ratio <= ratio_of_order(low) {
        return None;
    }
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        *(if ratio_of_order(middle) < ratio { &mut low } else { &mut high }) = middle;
    }
    Some(0.5 * (low + high))
}

/// Returns the order of convergence from two errors; `None` if an error is zero. Equation (15.1).
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
        for (sizes, order, behaviour, factor) in [
            (&[1.0, 0.5, 0.25][..], 2.0, ConvergenceBehaviour::Asymptotic, 1.25),
            (&[2.0, 1.0, 0.5, 0.25], 1.0, ConvergenceBehaviour::Asymptotic, 1.25),
            (&[1.0, 0.5, 0.25], 1.0, ConvergenceBehaviour::Unconfirmed, 3.0),
            (&[2.0, 1.0, 0.5, 0.25], 0.8, ConvergenceBehaviour::Singular, 3.0),
        ] {
            let limit_estimate = estimate(&series(sizes, |h| 7.0 + 0.1 * h.powf(order))).expect("three levels");
            assert!((limit_estimate.order.expect("an order") - order).abs() < 1e-6, "{limit_estimate:?}");
            assert!(
                (limit_estimate.limit - 7.0).abs() < 1e-6 && limit_estimate.behaviour == behaviour,
                "{limit_estimate:?}"
            );
            let error = 0.1 * sizes[sizes.len() - 1].powf(order);
            assert!((limit_estimate.uncertainty / (factor * error) - 1.0).abs() < 1e-5, "{limit_estimate:?}");
        }
    }

    #[test]
    fn close_levels_and_a_jump_in_order_keep_the_wide_factor() {
        let close = estimate(&series(&[1.0 / 3.0, 0.25, 1.0 / 6.0], |h| h * h)).expect("three levels");
        assert_eq!((close.behaviour, close.factor), (ConvergenceBehaviour::Close, 3.0));
        assert!((close.order.expect("an order") - 2.0).abs() < 1e-6);
        // Slow between the first three levels, then order 2: by chance, or the first credible level.
        let jump = [(1.0, 1.0), (0.5, 1.5), (0.25, 2.0), (0.125, 2.125)];
        let jump = jump.map(|(size, value)| RefinementLevel { size, value });
        let limit_estimate = estimate(&jump).expect("four levels");
        assert_eq!((limit_estimate.behaviour, limit_estimate.factor), (ConvergenceBehaviour::Unconfirmed, 3.0));
    }

    #[test]
    fn non_asymptotic_series_have_wide_bounds() {
        let estimate_of = |values: [f64; 3]| {
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
            let limit_estimate = estimate_of(values);
            assert_eq!(limit_estimate.behaviour, behaviour, "{values:?}");
            assert!(
                limit_estimate.uncertainty >= at_least * (1.0 - 1e-12),
                "{values:?}: {}",
                limit_estimate.uncertainty
            );
        }
        assert_eq!(estimate(&series(&[1.0], |h| h)), None);
        let two = estimate(&series(&[1.0, 0.5], |h| h * h)).expect("two levels");
        let expected = 3.0 * 0.75 / (2.0_f64.sqrt() - 1.0);
        assert!((two.uncertainty - expected).abs() < 1e-9 && two.limit.abs() < 1e-15, "{two:?}");
    }

    /// The band of two levels contains the limit for every order from 0.5 to 4.
    #[test]
    fn band_of_two_levels_contains_the_limit_for_any_credible_order() {
        for ratio in [2.0, 3.0, 4.0] {
            for order in [0.5, 1.0, 1.5, 2.0, 4.0] {
                let levels = series(&[1.0, 1.0 / ratio], |h| 7.0 + 0.3 * h.powf(order));
                let limit_estimate = estimate(&levels).expect("two levels");
                assert!(
                    (levels[1].value - 7.0).abs() <= limit_estimate.uncertainty,
                    "{ratio} {order}: {limit_estimate:?}"
                );
            }
        }
    }

    /// Radius of the foot of an aluminium Taylor bar on a mesh of 3 x 18 elements and on its third: 6.562 on a mesh with
    /// eight times as many elements along each edge. The order 2 would give 6.492 ± 0.026.
    #[test]
    fn band_of_a_coarse_taylor_bar_contains_the_value_of_a_fine_mesh() {
        let levels = [(3.0, 6.422), (1.0, 6.492)].map(|(size, value)| RefinementLevel { size, value });
        let limit_estimate = estimate(&levels).expect("two levels");
        assert!(
            (6.562 - 6.492_f64).abs() < limit_estimate.uncertainty && limit_estimate.uncertainty < 0.3,
            "{limit_estimate:?}"
        );
    }
}
