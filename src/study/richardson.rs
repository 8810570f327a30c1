//! What a series of refined values says of its limit: observed order, Richardson's value, grid convergence index.
//!
//! Sources: L. F. Richardson, Phil. Trans. R. Soc. A 210 (1911) 307; P. J. Roache, J. Fluids Eng. 116 (1994) 405: the grid
//! convergence index with the factor of safety 1.25 where the order is observed on three levels, 3 where it is assumed;
//! ASME V&V 20-2009, section 2; W. L. Oberkampf and C. J. Roy, Verification and Validation in Scientific Computing
//! (Cambridge 2010), section 8.7: factor 3 and a bounded order where the observed one is not credible.

use serde::Serialize;

/// Order that is assumed where two levels cannot show one, and the highest that is believed: central differences, mean
/// quadrature and straight facets are of second order.
pub const FORMAL_ORDER: f64 = 2.0;
/// Observed orders outside are not credible: the series is not yet, or no longer, governed by one power.
pub const CREDIBLE: [f64; 2] = [0.5, 2.5];
/// Factor of safety on three levels with a credible order.
const OBSERVED: f64 = 1.25;
/// Factor of safety otherwise.
const ASSUMED: f64 = 3.0;
/// Differences below this fraction of the values are rounding.
const ROUNDING: f64 = 1e-12;

/// One level of a series.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Level {
    /// Size of what is refined, in any unit; smaller is finer.
    pub size: f64,
    /// What was found.
    pub value: f64,
}

/// How a series behaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Behaviour {
    /// The observed order is credible.
    Asymptotic,
    /// Two levels show no order.
    TwoLevels,
    /// Differences change their sign.
    Oscillating,
    /// Differences fall slower than with order 0.5, or grow.
    Slow,
    /// Differences fall faster than with order 2.5.
    Fast,
    /// Differences are rounding.
    Settled,
}

impl Behaviour {
    /// In a word, for tables.
    pub fn word(self) -> &'static str {
        match self {
            Behaviour::Asymptotic => "",
            Behaviour::TwoLevels => "two levels",
            Behaviour::Oscillating => "oscillates",
            Behaviour::Slow => "slow",
            Behaviour::Fast => "fast",
            Behaviour::Settled => "settled",
        }
    }
}

/// What the finest levels of a series say.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LimitEstimate {
    /// Observed order; `None` where there is none to observe.
    pub order: Option<f64>,
    /// How the series behaves.
    pub behaviour: Behaviour,
    /// Richardson's value: the estimate of the limit.
    pub limit: f64,
    /// Grid convergence index in the units of the value: the limit is expected within this distance of the finest value.
    pub uncertainty: f64,
    /// Factor of safety in it.
    pub factor: f64,
}

/// Judges a series by its last three levels, or by two; `None` for fewer. Sizes fall along the series.
pub fn estimate(series: &[Level]) -> Option<LimitEstimate> {
    match series {
        [.., a, b, c] => Some(of_three(*a, *b, *c)),
        [a, b] => Some(of_two(*a, *b)),
        _ => None,
    }
}

fn of_two(coarse: Level, fine: Level) -> LimitEstimate {
    let change = fine.value - coarse.value;
    let error = change / gain(coarse, fine, FORMAL_ORDER);
    let behaviour = if is_rounding(&[coarse, fine]) { Behaviour::Settled } else { Behaviour::TwoLevels };
    let uncertainty = ASSUMED * error.abs() + floor(fine);
    LimitEstimate { order: None, behaviour, limit: fine.value + error, uncertainty, factor: ASSUMED }
}

fn of_three(coarse: Level, middle: Level, fine: Level) -> LimitEstimate {
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
        return unextrapolated(None, Behaviour::Settled, ASSUMED * widest);
    }
    if before * last < 0.0 {
        return unextrapolated(None, Behaviour::Oscillating, ASSUMED * widest);
    }
    let Some(order) = observed_order(coarse, middle, fine) else {
        let slow = last.abs() / gain(middle, fine, CREDIBLE[0]);
        return unextrapolated(None, Behaviour::Slow, ASSUMED * widest.max(slow));
    };
    if order < CREDIBLE[0] {
        let slow = last.abs() / gain(middle, fine, CREDIBLE[0]);
        return unextrapolated(Some(order), Behaviour::Slow, ASSUMED * widest.max(slow));
    }
    let error = last / gain(middle, fine, order.min(FORMAL_ORDER));
    let limit = fine.value + error;
    if order > CREDIBLE[1] {
        // The last difference may be small by chance: what the one before leaves with the formal order bounds it, too.
        let left = before / gain(coarse, middle, FORMAL_ORDER) / libm::pow(middle.size / fine.size, FORMAL_ORDER);
        let uncertainty = ASSUMED * error.abs().max(left.abs()) + floor(fine);
        return LimitEstimate { order: Some(order), behaviour: Behaviour::Fast, limit, uncertainty, factor: ASSUMED };
    }
    let uncertainty = OBSERVED * error.abs() + floor(fine);
    LimitEstimate { order: Some(order), behaviour: Behaviour::Asymptotic, limit, uncertainty, factor: OBSERVED }
}

/// r^p - 1: how much larger the coarser error's excess is than the finer error.
fn gain(coarse: Level, fine: Level, order: f64) -> f64 {
    libm::pow(coarse.size / fine.size, order) - 1.0
}

fn floor(fine: Level) -> f64 {
    ROUNDING * fine.value.abs()
}

fn is_rounding(levels: &[Level]) -> bool {
    let scale = levels.iter().fold(0.0_f64, |m, l| m.max(l.value.abs()));
    levels.windows(2).all(|w| (w[1].value - w[0].value).abs() <= ROUNDING * scale)
}

/// The order p that three levels show: (h1^p - h2^p) / (h2^p - h3^p) is the ratio of their differences. `None` where no
/// positive order gives that ratio. The left side grows with p, so halving finds it.
pub fn observed_order(coarse: Level, middle: Level, fine: Level) -> Option<f64> {
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

/// The order that two errors show; `None` where one of them is zero.
pub fn order_of_errors(coarse: Level, fine: Level) -> Option<f64> {
    let ratio = (coarse.value / fine.value).abs();
    let order = libm::log(ratio) / libm::log(coarse.size / fine.size);
    order.is_finite().then_some(order)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series(sizes: &[f64], law: impl Fn(f64) -> f64) -> Vec<Level> {
        sizes.iter().map(|&size| Level { size, value: law(size) }).collect()
    }

    #[test]
    fn a_power_is_found_for_any_ratio_of_levels() {
        for (sizes, order) in [([1.0, 0.5, 0.25], 2.0), ([1.0, 0.7, 0.3], 1.0), ([3.0, 2.0, 1.9], 1.5)] {
            let found = estimate(&series(&sizes, |h| 7.0 + 0.1 * h.powf(order))).expect("three levels");
            assert!((found.order.expect("an order") - order).abs() < 1e-6, "{found:?}");
            assert!((found.limit - 7.0).abs() < 1e-6 && found.behaviour == Behaviour::Asymptotic);
            let error = 0.1 * sizes[2].powf(order);
            assert!((found.uncertainty / (1.25 * error) - 1.0).abs() < 1e-5);
        }
    }

    #[test]
    fn what_is_not_a_power_is_said_and_bounded_widely() {
        let of = |values: [f64; 3]| {
            let levels = [1.0, 0.5, 0.25].iter().zip(values).map(|(&size, value)| Level { size, value });
            estimate(&levels.collect::<Vec<_>>()).expect("three levels")
        };
        for (values, behaviour, at_least) in [
            ([1.0, 1.2, 1.1], Behaviour::Oscillating, 0.6),
            ([1.0, 1.1, 1.2], Behaviour::Slow, 0.3),
            ([1.0, 1.1, 1.3], Behaviour::Slow, 0.6),
            ([1.0, 2.0, 2.01], Behaviour::Fast, 0.01),
            ([1.0, 1.0, 1.0], Behaviour::Settled, 0.0),
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
