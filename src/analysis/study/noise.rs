//! Noise of a quantity: its scatter over runs whose initial velocities and nodal coordinates differ by relative
//! perturbations without physical meaning.

use serde::Serialize;

use super::settings::ModelEdit;
use super::statistics::design::{mix, unit};
use super::statistics::student;
use super::statistics::summary::{self, SampleStatistic};
use super::table::short;
use crate::model::InitialKind;

/// Relative sizes of the perturbations. With two sizes, fast and slow divergence are distinguished.
pub const SIZES: [f64; 2] = [1e-9, 1e-6];
/// Relative deviation above which another quantity is recommended.
pub(super) const NOISY: f64 = 1e-3;
/// Ratio of the relative deviation to the size of the perturbation below which perturbations are not amplified.
const AMPLIFIED: f64 = 100.0;
/// Fraction of the deviation of the larger perturbations that the smaller ones reach if divergence is fast.
const FAST: f64 = 0.2;

/// Growth of small perturbations during a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Divergence {
    /// The scatter is proportional to the perturbation.
    Absent,
    /// The scatter increases with the perturbation.
    Slow,
    /// The smallest perturbations give about as much scatter as the larger ones.
    Fast,
}

impl Divergence {
    fn of(deviations: [f64; 2], scale: f64) -> Divergence {
        if deviations.iter().zip(SIZES).all(|(deviation, size)| *deviation <= AMPLIFIED * size * scale) {
            Divergence::Absent
        } else if deviations[0] >= FAST * deviations[1] {
            Divergence::Fast
        } else {
            Divergence::Slow
        }
    }

    fn sentence(self) -> &'static str {
        match self {
            Divergence::Absent => "perturbations are not amplified",
            Divergence::Slow => "slow divergence: smaller perturbations give less scatter",
            Divergence::Fast => "fast divergence: the smallest perturbations give as much scatter",
        }
    }
}

/// Scatter of a quantity over perturbed runs of one level.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NoiseEstimate {
    /// Index of the perturbed level.
    pub row: usize,
    /// Setting of the perturbed level.
    pub setting: String,
    /// Number of perturbed runs with a result.
    pub runs: usize,
    /// Number of perturbed runs without a result.
    pub failed: usize,
    /// Standard deviation of a run: the largest of three standard deviations, over all runs and over the runs of each
    /// size, each with the unperturbed run.
    pub deviation: f64,
    /// `deviation` divided by the magnitude of the value; `None` if the value is zero.
    pub relative: Option<f64>,
    /// Standard deviation over runs with perturbations of 1e-9, and of 1e-6, with the unperturbed run.
    pub deviations: [f64; 2],
    /// Half-width of the 95 % interval of a run, from `deviation` and Student's t.
    pub uncertainty: f64,
    /// Growth of the perturbations.
    pub divergence: Divergence,
    /// Quantity with a smaller scatter, if one was found.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub better: Option<BetterQuantity>,
}

/// Quantity that is recommended in place of a noisy one.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BetterQuantity {
    /// Expression of the quantity.
    pub quantity: String,
    /// Relative standard deviation over the same perturbed runs.
    pub relative: f64,
}

/// Returns a change of the model that multiplies each initial velocity and each nodal coordinate by a factor within
/// 1 ± `size`. The factors depend on the values and the seed only: coincident nodes remain coincident, nodes on the
/// axis and on the planes through the origin remain there, and nodes of equal velocity keep equal velocities.
pub fn perturbation(size: f64, seed: u64) -> ModelEdit {
    let factor = move |values: [f64; 2], salt: u64| {
        let bits = values.into_iter().fold(mix(seed ^ salt), |bits, value| mix(bits ^ value.to_bits()));
        1.0 + size * (2.0 * unit(bits) - 1.0)
    };
    Box::new(move |model| {
        for point in &mut model.mesh.points {
            *point = [point[0] * factor(*point, 1), point[1] * factor(*point, 2)];
        }
        for condition in &mut model.initial_conditions {
            if let InitialKind::Velocity(dof, velocity) = &mut condition.kind {
                *velocity *= factor([*velocity, f64::from(*dof)], 3);
            }
        }
        Ok(())
    })
}

/// Returns the changes of perturbed runs: the sizes alternate, and each run has its own seed.
pub fn perturbations(runs: usize) -> Vec<ModelEdit> {
    (0..runs).map(|run| perturbation(SIZES[run % SIZES.len()], run as u64)).collect()
}

/// Estimates the noise from the unperturbed value and the values of [`perturbations`]. Equation (15.5).
pub fn of_runs(plain: f64, perturbed: impl Iterator<Item = Option<f64>>) -> NoiseEstimate {
    let perturbed: Vec<Option<f64>> = perturbed.collect();
    let of_size = |k: usize| perturbed.iter().copied().skip(k).step_by(SIZES.len()).flatten().chain([plain]);
    let deviations = [0, 1].map(|k| deviation(of_size(k)));
    let deviation_of_all = deviation(perturbed.iter().copied().flatten().chain([plain]));
    let deviation = deviations.into_iter().fold(deviation_of_all, f64::max);
    let runs = perturbed.iter().flatten().count();
    NoiseEstimate {
        row: 0,
        setting: String::new(),
        runs,
        failed: perturbed.len() - runs,
        deviation,
        relative: (plain != 0.0).then(|| deviation / plain.abs()),
        deviations,
        uncertainty: if deviation > 0.0 { student(runs as f64) * deviation } else { 0.0 },
        divergence: Divergence::of(deviations, plain.abs()),
        better: None,
    }
}

/// Returns the standard deviation of a sample; zero with fewer than two values.
pub(super) fn deviation(values: impl Iterator<Item = f64>) -> f64 {
    let values: Vec<f64> = values.collect();
    summary::estimate(&values, &[], SampleStatistic::Deviation).map_or(0.0, |found| found.value)
}

impl NoiseEstimate {
    /// Returns the scatter and its growth, and the recommendation if the quantity is noisy.
    pub fn conclusions(&self, quantity: &str) -> Vec<String> {
        let size = |deviation: f64| match self.relative.filter(|_| self.deviation > 0.0) {
            Some(relative) => format!("{} %", short(100.0 * deviation * relative / self.deviation)),
            None => short(deviation),
        };
        let failed = if self.failed > 0 { format!(", {} runs without a result", self.failed) } else { String::new() };
        let mut lines = vec![format!(
            "noise of {}: standard deviation {} over {} perturbed runs ({} at 1e-9, {} at 1e-6{failed}); {}",
            self.setting,
            size(self.deviation),
            self.runs,
            size(self.deviations[0]),
            size(self.deviations[1]),
            self.divergence.sentence()
        )];
        match &self.better {
            Some(better) => lines.push(format!(
                "{quantity} scatters by {}, {} by {} %: use the latter",
                size(self.deviation),
                better.quantity,
                short(100.0 * better.relative)
            )),
            None if self.relative.is_some_and(|r| r > NOISY) => lines.push(format!(
                "{quantity} scatters by {}: use an average over time, mean(COLUMN, t1, t2), or over a set \
                 (*NODE OUTPUT, STATISTICS=MEAN)",
                size(self.deviation)
            )),
            None => {}
        }
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Model;

    #[test]
    fn perturbations_keep_coincident_nodes_and_the_axis() {
        let mut model = Model::default();
        model.mesh.points = vec![[0.0, 2.0], [1.0, 2.0], [1.0, 2.0], [1.0, 0.0]];
        let mut other = model.clone();
        perturbation(1e-6, 3)(&mut model).expect("a change");
        perturbation(1e-6, 4)(&mut other).expect("a change");
        let points = &model.mesh.points;
        assert_eq!((points[0][0], points[3][1], points[1]), (0.0, 0.0, points[2]));
        assert!(points[1] != [1.0, 2.0] && points[1].iter().zip([1.0, 2.0]).all(|(x, y)| (x / y - 1.0).abs() <= 1e-6));
        assert_ne!(points, &other.mesh.points);
    }

    #[test]
    fn divergence_is_fast_if_small_perturbations_scatter_as_much_as_large_ones() {
        let estimate_of = |values: [f64; 4]| of_runs(1.0, values.into_iter().map(Some));
        assert_eq!(estimate_of([1.0, 1.000_001, 1.0, 0.999_999]).divergence, Divergence::Absent);
        assert_eq!(estimate_of([1.000_1, 1.02, 1.0, 0.98]).divergence, Divergence::Slow);
        let fast = estimate_of([1.02, 1.03, 0.98, 0.99]);
        assert_eq!(fast.divergence, Divergence::Fast);
        // 0.02, -0.02 and 0: the variance is 0.0008 / 2. Student's t with 4 degrees of freedom is 2.776.
        assert!((fast.deviations[0] - 0.02).abs() < 1e-12, "{fast:?}");
        assert!((fast.uncertainty / fast.deviation - 2.776).abs() < 1e-3, "{fast:?}");
        assert!(of_runs(1.0, [None, Some(1.0)].into_iter()).failed == 1);
    }
}
