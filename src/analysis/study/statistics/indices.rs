//! Sobol indices: the fraction of the variance due to each input, alone and in interaction with others.

use rand_chacha::rand_core::RngCore as _;

use super::design::{draws, whole};
use super::summary::between;
use super::{IntervalEstimate, TAIL};

/// Sobol indices of all inputs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SobolIndices {
    /// First-order indices: fraction of the variance due to the input alone.
    pub first: Vec<IntervalEstimate>,
    /// Total indices: fraction of the variance that remains if all other inputs are fixed.
    pub total: Vec<IntervalEstimate>,
}

/// Number of bootstrap samples.
const RESAMPLED: usize = 1000;

/// Sums over rows: mean and mean square, and for each input the numerators of both indices.
struct IndexSums(Vec<f64>);

/// Computes the indices from rows f(A), f(B), f(A with input 1 of B), f(A with input 2 of B), …; rows with values that
/// are not finite are ignored. `None` if the variance is zero or there are fewer than two rows. Equation (15.8).
///
/// First order by Saltelli et al. (Comput. Phys. Commun. 181 (2010) 259, equation (b) of table 2), total by Jansen
/// (Comput. Phys. Commun. 117 (1999) 35). Confidence intervals: percentile bootstrap over rows.
pub fn indices(rows: &[f64], inputs: usize, seed: u64) -> Option<SobolIndices> {
    let width = inputs + 2;
    let finite_rows = || rows.chunks_exact(width).filter(|row| row.iter().all(|f| f.is_finite()));
    let count = finite_rows().count();
    if count < 2 {
        return None;
    }
    // Subtracting the mean reduces the variance of the numerators.
    let mean = finite_rows().map(|row| 0.5 * (row[0] + row[1])).sum::<f64>() / count as f64;
    let terms: Vec<f64> = finite_rows().flat_map(|row| terms(row, mean)).collect();
    let sums = |rows: &mut dyn Iterator<Item = usize>| {
        let mut sums = vec![0.0; 2 * inputs + 2];
        for row in rows {
            let row_terms = &terms[row * sums.len()..(row + 1) * sums.len()];
            sums.iter_mut().zip(row_terms).for_each(|(sum, term)| *sum += term);
        }
        IndexSums(sums)
    };
    let index_values = sums(&mut (0..count)).indices(count)?;
    let mut resampled = vec![Vec::with_capacity(RESAMPLED); 2 * inputs];
    for again in 0..RESAMPLED {
        let mut draws = draws(seed, again as u64);
        let mut drawn = (0..count).map(|_| whole(draws.next_u64(), count));
        if let Some(values) = sums(&mut drawn).indices(count) {
            resampled.iter_mut().zip(values).for_each(|(list, value)| list.push(value));
        }
    }
    let estimate = |(value, list): (f64, &mut Vec<f64>)| {
        list.sort_by(f64::total_cmp);
        IntervalEstimate { value, low: between(list, TAIL), high: between(list, 1.0 - TAIL) }
    };
    let mut intervals: Vec<IntervalEstimate> = index_values.into_iter().zip(&mut resampled).map(estimate).collect();
    let total = intervals.split_off(inputs);
    Some(SobolIndices { first: intervals, total })
}

fn terms(row: &[f64], mean: f64) -> impl Iterator<Item = f64> {
    let [a, b] = [row[0] - mean, row[1] - mean];
    let mixed = row[2..].iter().map(move |f| f - mean);
    let first = mixed.clone().map(move |m| b * (m - a));
    let total = mixed.map(move |m| 0.5 * (a - m) * (a - m));
    [a + b, a * a + b * b].into_iter().chain(first).chain(total)
}

impl IndexSums {
    /// Returns the first-order, then the total indices; `None` if the variance is zero.
    fn indices(&self, count: usize) -> Option<Vec<f64>> {
        let [mean, square] = [0, 1].map(|i| self.0[i] / (2 * count) as f64);
        let variance = square - mean * mean;
        let some = variance > 1e-24 * square && variance.is_finite();
        some.then(|| self.0[2..].iter().map(|sum| sum / count as f64 / variance).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::statistics::design::{SampleDesign, SamplingScheme};
    use std::f64::consts::PI;

    fn ishigami(x: &[f64]) -> f64 {
        let [x1, x2, x3] = [x[0], x[1], x[2]].map(|u| PI * (2.0 * u - 1.0));
        libm::sin(x1) + 7.0 * libm::sin(x2).powi(2) + 0.1 * x3.powi(4) * libm::sin(x1)
    }

    fn of_ishigami(sampling: SamplingScheme, count: usize, seed: u64) -> SobolIndices {
        let mut points = vec![0.0; 6 * count];
        SampleDesign::new(sampling, 6, count, seed).expect("a design").fill(&mut points);
        let row = |point: &[f64]| {
            let mixed = (0..3).map(|i| {
                let mut x = [point[0], point[1], point[2]];
                x[i] = point[3 + i];
                ishigami(&x)
            });
            [ishigami(&point[..3]), ishigami(&point[3..])].into_iter().chain(mixed).collect::<Vec<_>>()
        };
        indices(&points.chunks(6).flat_map(row).collect::<Vec<_>>(), 3, seed).expect("indices")
    }

    /// Returns the closed form of Ishigami and Homma (1990) with a = 7, b = 0.1.
    fn exact() -> [f64; 6] {
        let (a, b) = (7.0, 0.1);
        let v1 = 0.5 * (1.0 + b * PI.powi(4) / 5.0).powi(2);
        let (v2, v13) = (a * a / 8.0, b * b * PI.powi(8) * 8.0 / 225.0);
        [v1, v2, 0.0, v1 + v13, v2, v13].map(|v| v / (v1 + v2 + v13))
    }

    #[test]
    fn intervals_contain_the_indices_of_the_ishigami_function() {
        let exact = exact();
        assert!((exact[0] - 0.3139).abs() < 1e-4 && (exact[3] - 0.5576).abs() < 1e-4);
        // Twenty seeds and six indices: 114 of 120 intervals are expected to contain the exact value.
        let mut inside = 0;
        for seed in 0..20 {
            let sobol = of_ishigami(SamplingScheme::Random, 1024, seed);
            let intervals: Vec<IntervalEstimate> = sobol.first.into_iter().chain(sobol.total).collect();
            inside += intervals.iter().zip(exact).filter(|(sobol, exact)| sobol.holds(*exact)).count();
        }
        println!("{inside} of 120 inside");
        assert!((108..=120).contains(&inside), "{inside}");
        // With the Sobol sequence the errors are a few thousandths, and the intervals contain the exact values.
        let sobol = of_ishigami(SamplingScheme::Sobol, 1 << 14, 1);
        for (sobol, exact) in sobol.first.iter().chain(&sobol.total).zip(exact) {
            println!("{sobol:?} {exact}");
            assert!(sobol.holds(exact) && (sobol.value - exact).abs() < 5e-3 && sobol.high - sobol.low < 0.08);
        }
    }

    #[test]
    fn rows_with_nan_are_ignored() {
        let rows = [1.0, 2.0, 3.0, f64::NAN, 1.0, 1.0, 2.0, 1.0, 5.0, 4.0, 0.0, 1.0];
        let without: Vec<f64> = rows.chunks(3).filter(|r| r[0].is_finite()).flatten().copied().collect();
        assert_eq!(indices(&rows, 1, 3), indices(&without, 1, 3));
        assert_eq!(indices(&[1.0; 9], 1, 0), None);
        assert_eq!(indices(&[f64::NAN; 9], 1, 0), None);
    }
}
