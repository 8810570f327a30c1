//! What a sample says of where it was drawn from: mean, deviation, quantiles, with their errors.

use super::{Estimate, TAIL, normal};

/// What is estimated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Statistic {
    /// The mean.
    Mean,
    /// The standard deviation.
    Deviation,
    /// The value below which so much lies.
    Quantile(f64),
}

/// The smallest part of a sample that says anything of its error.
const FEWEST: usize = 2;

/// A statistic of values, of which those that are no numbers are left out. Of one set each value is drawn by itself; of several (ends as
/// [`super::design::Design::sets`] gives them) each set is spread by itself. `None` where too few are left.
///
/// Errors of independent values: mean s/sqrt(n), deviation by the fourth moment, quantiles by the ranks that hold them
/// (Conover, Practical Nonparametric Statistics, section 3.2). Of several sets: mean and deviation by the
/// jackknife, which leaves out one set after the other (Efron and Tibshirani, An Introduction to the Bootstrap, section 11.5), quantiles
/// by how much of each set lies below (Woodruff, J. Am. Stat. Assoc. 47 (1952) 635).
pub fn estimate(values: &[f64], sets: &[usize], statistic: Statistic) -> Option<Estimate> {
    let sorted = sorted(values);
    if sorted.len() < FEWEST {
        return None;
    }
    let value = statistic.of(&sorted);
    if sets.len() <= 2 {
        return Some(statistic.alone(&sorted, value));
    }
    if let Statistic::Quantile(part) = statistic {
        return Some(by_shares(values, sets, &sorted, value, part));
    }
    let without = |ends: &[usize]| self::sorted(&[&values[..ends[0]], &values[ends[1]..]].concat());
    let rest: Vec<f64> = sets.windows(2).map(|ends| statistic.of(&without(ends))).filter(|v| v.is_finite()).collect();
    let count = rest.len() as f64;
    let error = ((count - 1.0) * moment(&rest, 2)).sqrt();
    Some(Estimate::around(value, error, count - 1.0))
}

/// A quantile with the interval that the part of each set below it leaves.
fn by_shares(values: &[f64], sets: &[usize], sorted: &[f64], value: f64, part: f64) -> Estimate {
    let share = |ends: &[usize]| {
        let set = || values[ends[0]..ends[1]].iter().filter(|v| v.is_finite());
        set().filter(|v| **v < value).count() as f64 / set().count() as f64
    };
    let shares: Vec<f64> = sets.windows(2).map(share).filter(|share| share.is_finite()).collect();
    let count = shares.len() as f64;
    // No ranks are told apart more closely than half of one.
    let error = (moment(&shares, 2) / (count - 1.0)).sqrt().max(0.5 / sorted.len() as f64);
    let shares = Estimate::around(part, error, count - 1.0);
    Estimate { value, low: between(sorted, shares.low), high: between(sorted, shares.high) }
}

fn sorted(values: &[f64]) -> Vec<f64> {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    sorted
}

/// The value below which so much of a sorted list lies, between its members (type 7 of Hyndman and Fan, Am. Stat. 50 (1996) 361).
pub fn between(sorted: &[f64], part: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else { return f64::NAN };
    let place = part.clamp(0.0, 1.0) * last as f64;
    let below = place as usize;
    let above = sorted[(below + 1).min(last)];
    sorted[below] + (place - below as f64) * (above - sorted[below])
}

/// The mean of a power of the distance from the mean.
fn moment(values: &[f64], power: i32) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    values.iter().map(|v| (v - mean).powi(power)).sum::<f64>() / values.len() as f64
}

impl Statistic {
    /// Of values, which a quantile asks to be sorted.
    fn of(self, sorted: &[f64]) -> f64 {
        let count = sorted.len() as f64;
        match self {
            Statistic::Mean => sorted.iter().sum::<f64>() / count,
            Statistic::Deviation => (moment(sorted, 2) * count / (count - 1.0)).sqrt(),
            Statistic::Quantile(part) => between(sorted, part),
        }
    }

    /// With the interval of values each drawn by itself.
    fn alone(self, sorted: &[f64], value: f64) -> Estimate {
        let count = sorted.len() as f64;
        match self {
            Statistic::Mean => Estimate::around(value, Statistic::Deviation.of(sorted) / count.sqrt(), count - 1.0),
            Statistic::Deviation => {
                let square = moment(sorted, 2);
                let error = ((moment(sorted, 4) - square * square) / count).max(0.0).sqrt() / (2.0 * square.sqrt());
                Estimate::around(value, if square > 0.0 { error } else { 0.0 }, f64::INFINITY)
            }
            Statistic::Quantile(part) => {
                let half = normal::quantile(1.0 - TAIL) * (count * part * (1.0 - part)).sqrt();
                let rank = |place: f64| {
                    let inside = place >= 1.0 && place <= count;
                    if inside { sorted[place as usize - 1] } else { f64::INFINITY.copysign(place - 1.0) }
                };
                Estimate {
                    value,
                    low: rank((count * part - half).floor()),
                    high: rank((count * part + half).ceil() + 1.0),
                }
            }
        }
    }
}

/// Numbers of values in cells of equal width: edges, and how many lie between them. Empty without values.
pub fn histogram(values: &[f64]) -> (Vec<f64>, Vec<usize>) {
    let sorted = sorted(values);
    let (Some(low), Some(high)) = (sorted.first(), sorted.last()) else { return (Vec::new(), Vec::new()) };
    // Width by Freedman and Diaconis (Z. Wahrscheinlichkeitstheorie 57 (1981) 453).
    let width = 2.0 * (between(&sorted, 0.75) - between(&sorted, 0.25)) / libm::cbrt(sorted.len() as f64);
    let cells = ((high - low) / width).ceil().clamp(1.0, 80.0);
    let cells = if cells.is_finite() { cells as usize } else { 1 };
    let edges: Vec<f64> = (0..=cells).map(|i| low + (high - low) * i as f64 / cells as f64).collect();
    let mut counts = vec![0; cells];
    for value in &sorted {
        let cell = ((value - low) / (high - low) * cells as f64) as usize;
        counts[cell.min(cells - 1)] += 1;
    }
    (edges, counts)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::statistics::design::{Design, Sampling};
    use crate::study::statistics::distribution::Distribution;
    use crate::study::statistics::student;

    const KNOWN: [(Statistic, f64); 5] = [
        (Statistic::Mean, 800.0),
        (Statistic::Deviation, 20.0),
        (Statistic::Quantile(0.05), 800.0 - 20.0 * 1.644_853_627),
        (Statistic::Quantile(0.5), 800.0),
        (Statistic::Quantile(0.9), 800.0 + 20.0 * 1.281_551_566),
    ];

    /// Of twenty seeds and five statistics 95 of 100 are to be expected inside; designs that fill evenly come closer.
    #[test]
    fn intervals_hold_what_they_promise() {
        let of = Distribution::parse("normal(800, 20)").expect("a distribution");
        let mut errors = Vec::new();
        for sampling in [Sampling::Random, Sampling::Latin, Sampling::Sobol] {
            let (mut inside, mut error) = (0, 0.0);
            for seed in 0..20 {
                let mut points = vec![0.0; 1024];
                Design::new(sampling, 1, 1024, seed).expect("a design").fill(&mut points);
                let values: Vec<f64> = points.into_iter().map(|u| of.quantile(u)).collect();
                for (statistic, known) in KNOWN {
                    let sets = Design::sets(sampling, 1024);
                    let found = estimate(&values, &sets, statistic).expect("an estimate");
                    inside += usize::from(found.holds(known));
                    error += (found.value - known).abs();
                }
            }
            println!("{sampling:?}: {inside} of 100 inside, mean error {}", error / 100.0);
            assert!(inside >= 88, "{sampling:?}: {inside}");
            errors.push(error);
        }
        assert!(errors[1] < 0.3 * errors[0] && errors[2] < 0.3 * errors[0], "{errors:?}");
    }

    #[test]
    fn what_is_no_number_is_left_out() {
        let values = [1.0, f64::NAN, 2.0, 3.0, f64::INFINITY];
        let mean = estimate(&values, &[0, 5], Statistic::Mean).expect("a mean");
        assert!(mean.value == 2.0 && (mean.high - 2.0 - student(2.0) / 3_f64.sqrt()).abs() < 1e-12);
        assert_eq!(estimate(&[1.0, f64::NAN], &[0, 2], Statistic::Mean), None);
        let few = estimate(&[1.0, 2.0, 3.0], &[0, 3], Statistic::Quantile(0.01)).expect("a quantile");
        assert_eq!(few.low, f64::NEG_INFINITY);
        let (edges, counts) = histogram(&values);
        assert_eq!((edges.first(), edges.last(), counts.iter().sum::<usize>()), (Some(&1.0), Some(&3.0), 3));
        assert_eq!(histogram(&[5.0, 5.0]).1, [2]);
    }

    #[test]
    fn quantiles_lie_between_values() {
        assert_eq!(between(&[1.0, 2.0, 4.0], 0.75), 3.0);
        assert_eq!([between(&[1.0], 0.3), between(&[1.0, 2.0], 1.0)], [1.0, 2.0]);
        assert!(between(&[], 0.5).is_nan());
    }
}
