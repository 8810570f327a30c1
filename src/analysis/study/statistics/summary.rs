//! Sample statistics with confidence intervals: mean, standard deviation, quantiles.

use super::{IntervalEstimate, TAIL, normal};

/// Statistic that is estimated from a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SampleStatistic {
    /// Arithmetic mean of the sample.
    Mean,
    /// Standard deviation of the population (divisor n - 1).
    Deviation,
    /// Quantile for a probability.
    Quantile(f64),
}

/// Smallest sample size for an error estimate.
const FEWEST: usize = 2;

/// Estimates a statistic; values that are not finite are ignored. The values of one set are independent; with several
/// sets (ends as from [`super::design::SampleDesign::sets`]) only the sets are independent. `None` with fewer than two
/// finite values.
///
/// Errors with one set: mean s/sqrt(n), deviation by the fourth moment, quantiles by order statistics (Conover,
/// Practical Nonparametric Statistics, section 3.2). With several sets: mean and deviation by the jackknife over sets
/// (Efron and Tibshirani, An Introduction to the Bootstrap, section 11.5), quantiles by the fraction of each set below
/// the quantile (Woodruff, J. Am. Stat. Assoc. 47 (1952) 635).
pub fn estimate(values: &[f64], sets: &[usize], statistic: SampleStatistic) -> Option<IntervalEstimate> {
    estimate_sorted(values, &sorted(values), sets, statistic)
}

/// Estimates a statistic as [`estimate`] does, from values that are also given [`sorted`].
pub fn estimate_sorted(
    values: &[f64],
    sorted: &[f64],
    sets: &[usize],
    statistic: SampleStatistic,
) -> Option<IntervalEstimate> {
    if sorted.len() < FEWEST {
        return None;
    }
    let value = statistic.of(sorted);
    if sets.len() <= 2 {
        return Some(statistic.alone(sorted, value));
    }
    if let SampleStatistic::Quantile(part) = statistic {
        return Some(by_shares(values, sets, sorted, value, part));
    }
    let without = |ends: &[usize]| self::sorted(&[&values[..ends[0]], &values[ends[1]..]].concat());
    let leave_one_out: Vec<f64> =
        sets.windows(2).map(|ends| statistic.of(&without(ends))).filter(|v| v.is_finite()).collect();
    let count = leave_one_out.len() as f64;
    let error = ((count - 1.0) * moment(&leave_one_out, 2)).sqrt();
    Some(IntervalEstimate::around(value, error, count - 1.0))
}

/// Returns a quantile with an interval from the fraction of each set below it.
fn by_shares(values: &[f64], sets: &[usize], sorted: &[f64], value: f64, part: f64) -> IntervalEstimate {
    let share = |ends: &[usize]| {
        let set = || values[ends[0]..ends[1]].iter().filter(|v| v.is_finite());
        set().filter(|v| **v < value).count() as f64 / set().count() as f64
    };
    let shares: Vec<f64> = sets.windows(2).map(share).filter(|share| share.is_finite()).collect();
    let count = shares.len() as f64;
    // The resolution is half a rank.
    let error = (moment(&shares, 2) / (count - 1.0)).sqrt().max(0.5 / sorted.len() as f64);
    let shares = IntervalEstimate::around(part, error, count - 1.0);
    IntervalEstimate { value, low: between(sorted, shares.low), high: between(sorted, shares.high) }
}

/// Returns the finite values in ascending order.
pub fn sorted(values: &[f64]) -> Vec<f64> {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    sorted
}

/// Returns the quantile of a sorted list by interpolation (type 7 of Hyndman and Fan, Am. Stat. 50 (1996) 361).
pub fn between(sorted: &[f64], part: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else { return f64::NAN };
    let position = part.clamp(0.0, 1.0) * last as f64;
    let below = position as usize;
    let above = sorted[(below + 1).min(last)];
    sorted[below] + (position - below as f64) * (above - sorted[below])
}

/// Returns a central moment.
fn moment(values: &[f64], power: i32) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    values.iter().map(|v| (v - mean).powi(power)).sum::<f64>() / values.len() as f64
}

impl SampleStatistic {
    /// Computes the statistic; the values must be sorted for a quantile.
    fn of(self, sorted: &[f64]) -> f64 {
        let count = sorted.len() as f64;
        match self {
            SampleStatistic::Mean => sorted.iter().sum::<f64>() / count,
            SampleStatistic::Deviation => (moment(sorted, 2) * count / (count - 1.0)).sqrt(),
            SampleStatistic::Quantile(part) => between(sorted, part),
        }
    }

    /// Adds the confidence interval for independent values.
    fn alone(self, sorted: &[f64], value: f64) -> IntervalEstimate {
        let count = sorted.len() as f64;
        match self {
            SampleStatistic::Mean => {
                IntervalEstimate::around(value, SampleStatistic::Deviation.of(sorted) / count.sqrt(), count - 1.0)
            }
            SampleStatistic::Deviation => {
                let square = moment(sorted, 2);
                let error = ((moment(sorted, 4) - square * square) / count).max(0.0).sqrt() / (2.0 * square.sqrt());
                IntervalEstimate::around(value, if square > 0.0 { error } else { 0.0 }, f64::INFINITY)
            }
            SampleStatistic::Quantile(part) => {
                let half = normal::quantile(1.0 - TAIL) * (count * part * (1.0 - part)).sqrt();
                let rank = |place: f64| {
                    let inside = place >= 1.0 && place <= count;
                    if inside { sorted[place as usize - 1] } else { f64::INFINITY.copysign(place - 1.0) }
                };
                IntervalEstimate {
                    value,
                    low: rank((count * part - half).floor()),
                    high: rank((count * part + half).ceil() + 1.0),
                }
            }
        }
    }
}

/// Returns a histogram with cells of equal width: edges and counts; empty without values.
pub fn histogram(values: &[f64]) -> (Vec<f64>, Vec<usize>) {
    let sorted = sorted(values);
    let (Some(low), Some(high)) = (sorted.first(), sorted.last()) else { return (Vec::new(), Vec::new()) };
    // Cell width by Freedman and Diaconis (Z. Wahrscheinlichkeitstheorie 57 (1981) 453).
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
    use crate::study::statistics::design::{SampleDesign, SamplingScheme};
    use crate::study::statistics::distribution::ParameterDistribution;
    use crate::study::statistics::student;

    const KNOWN: [(SampleStatistic, f64); 5] = [
        (SampleStatistic::Mean, 800.0),
        (SampleStatistic::Deviation, 20.0),
        (SampleStatistic::Quantile(0.05), 800.0 - 20.0 * 1.644_853_627),
        (SampleStatistic::Quantile(0.5), 800.0),
        (SampleStatistic::Quantile(0.9), 800.0 + 20.0 * 1.281_551_566),
    ];

    /// With twenty seeds and five statistics, 95 of 100 intervals are expected to contain the exact value; stratified
    /// designs have smaller errors.
    #[test]
    fn intervals_have_their_nominal_coverage() {
        let distribution = ParameterDistribution::parse("normal(800, 20)").expect("a distribution");
        let mut errors = Vec::new();
        for sampling in [SamplingScheme::Random, SamplingScheme::Latin, SamplingScheme::Sobol] {
            let (mut inside, mut error) = (0, 0.0);
            for seed in 0..20 {
                let mut points = vec![0.0; 1024];
                SampleDesign::new(sampling, 1, 1024, seed).expect("a design").fill(&mut points);
                let values: Vec<f64> = points.into_iter().map(|u| distribution.quantile(u)).collect();
                for (statistic, known) in KNOWN {
                    let sets = SampleDesign::sets(sampling, 1024);
                    let interval = estimate(&values, &sets, statistic).expect("an estimate");
                    inside += usize::from(interval.holds(known));
                    error += (interval.value - known).abs();
                }
            }
            println!("{sampling:?}: {inside} of 100 inside, mean error {}", error / 100.0);
            assert!(inside >= 88, "{sampling:?}: {inside}");
            errors.push(error);
        }
        assert!(errors[1] < 0.3 * errors[0] && errors[2] < 0.3 * errors[0], "{errors:?}");
    }

    #[test]
    fn values_that_are_not_finite_are_ignored() {
        let values = [1.0, f64::NAN, 2.0, 3.0, f64::INFINITY];
        let mean = estimate(&values, &[0, 5], SampleStatistic::Mean).expect("a mean");
        assert!(mean.value == 2.0 && (mean.high - 2.0 - student(2.0) / 3_f64.sqrt()).abs() < 1e-12);
        assert_eq!(estimate(&[1.0, f64::NAN], &[0, 2], SampleStatistic::Mean), None);
        let few = estimate(&[1.0, 2.0, 3.0], &[0, 3], SampleStatistic::Quantile(0.01)).expect("a quantile");
        assert_eq!(few.low, f64::NEG_INFINITY);
        let (edges, counts) = histogram(&values);
        assert_eq!((edges.first(), edges.last(), counts.iter().sum::<usize>()), (Some(&1.0), Some(&3.0), 3));
        assert_eq!(histogram(&[5.0, 5.0]).1, [2]);
    }

    #[test]
    fn quantiles_are_interpolated() {
        assert_eq!(between(&[1.0, 2.0, 4.0], 0.75), 3.0);
        assert_eq!([between(&[1.0], 0.3), between(&[1.0, 2.0], 1.0)], [1.0, 2.0]);
        assert!(between(&[], 0.5).is_nan());
    }
}
