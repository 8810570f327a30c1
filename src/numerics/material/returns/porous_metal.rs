//! Porous metal plasticity (Gurson 1977, J. Eng. Mater. Technol. 99, 2; Tvergaard and Needleman 1984, Acta Metall. 32,
//! 157; ABAQUS Analysis User's Guide, "Porous metal plasticity").

use super::law::{ReturnPoint, StressReturn};
use super::porous_return::{PorousConstants, PorousIncrement, TOLERANCE};
use crate::kernel::hardening::LinearTable;
use crate::kernel::moduli::ElasticModuli;
use crate::kernel::transcendental::exp_of;
use crate::variables::{Variable, VariableComponent};

/// Voids that nucleate around a mean plastic strain of the matrix, with a normal distribution, only while the mean
/// stress is tensile (ABAQUS Theory Guide, "Porous metal plasticity").
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VoidNucleation {
    /// Mean of the plastic strain of nucleation.
    pub mean: f64,
    /// Standard deviation of that strain.
    pub deviation: f64,
    /// Volume fraction of all nucleating voids.
    pub fraction: f64,
}

impl VoidNucleation {
    /// Returns the nucleating volume fraction per plastic strain. Equation (20.31).
    #[inline(always)] // Into the return of each point.
    pub(super) fn density(&self, strain: f64) -> f64 {
        let distance = (strain - self.mean) / self.deviation;
        let scale = self.fraction / ((2.0 * std::f64::consts::PI).sqrt() * self.deviation);
        scale * exp_of(-0.5 * distance * distance)
    }
}

/// Void volume fractions at which the material loses its strength.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VoidFailure {
    /// Fraction at which voids begin to coalesce.
    pub critical: f64,
    /// Fraction at which the element is deleted.
    pub failure: f64,
}

/// Metal with voids, which dilates and softens under tension.
#[derive(Clone, Debug)]
pub struct PorousMetal {
    /// Constants q1, q2, q3 of the yield surface.
    pub constants: [f64; 3],
    /// Void volume fraction at the start: 1 less the relative density.
    pub voids: f64,
    /// Yield stress of the matrix over its plastic strain.
    pub hardening: LinearTable,
    /// Nucleation of voids; none without the card.
    pub nucleation: Option<VoidNucleation>,
    /// Coalescence of voids and deletion; none without the card.
    pub failure: Option<VoidFailure>,
    /// Elastic moduli of the matrix, also those of the porous metal.
    pub moduli: ElasticModuli,
}

/// States: equivalent plastic strain of the matrix, void volume fraction, relative density.
pub(super) const STRAIN: usize = 0;
pub(super) const VOIDS: usize = 1;
pub(super) const DENSITY: usize = 2;

impl PorousMetal {
    /// Returns the constants of returns.
    pub(super) fn constants(&self) -> PorousConstants {
        let [q1, _, q3] = self.constants;
        // The yield surface vanishes at the smaller root of 1 + q3 f² = 2 q1 f; coalescence leads to the larger one.
        let sum = q1 + (q1 * q1 - q3).max(0.0).sqrt();
        let [critical, coalescence] = match self.failure {
            Some(VoidFailure { critical, failure }) if failure > critical => {
                [critical, (sum / q3 - critical) / (failure - critical)]
            }
            _ => [f64::INFINITY, 1.0],
        };
        let &PorousMetal { constants, moduli, nucleation, .. } = self;
        let [per_bulk, per_shear3] = [1.0 / moduli.bulk, 1.0 / (3.0 * moduli.shear)];
        let most = 0.999 / sum;
        PorousConstants { constants, moduli, per_bulk, per_shear3, nucleation, critical, coalescence, most }
    }
}

impl StressReturn for PorousMetal {
    fn describe(&self) -> String {
        "porous metal (Gurson)".to_owned()
    }

    fn moduli(&self) -> ElasticModuli {
        self.moduli
    }

    fn initial_state(&self) -> Vec<f64> {
        vec![0.0, self.voids, 1.0 - self.voids]
    }

    fn hardening_state(&self) -> Option<usize> {
        Some(STRAIN)
    }

    fn output(&self, part: VariableComponent) -> Option<usize> {
        match part.variable {
            Variable::PlasticStrain => Some(STRAIN),
            Variable::VoidVolumeFraction => Some(VOIDS),
            Variable::RelativeDensity => Some(DENSITY),
            _ => None,
        }
    }

    fn deletes(&self) -> bool {
        self.failure.is_some()
    }

    fn update(&self, point: &mut ReturnPoint<'_>) {
        let trial = point.trial;
        let strain = point.state[STRAIN];
        let before = PorousIncrement {
            strain,
            voids: point.state[VOIDS],
            hardening: self.hardening.line(strain),
            mises: trial.mises,
            mean: -trial.pressure,
        };
        let law = self.constants();
        let first = law.trial(&before);
        // A NaN is not returned, so that the run halts.
        if first.excess.is_nan() || first.excess <= TOLERANCE {
            return point.stay_elastic();
        }
        let end = law.newton(&before, first).unwrap_or_else(|| law.bracketed(&before));
        point.state[STRAIN] = end.strain;
        point.state[VOIDS] = end.voids;
        point.state[DENSITY] = 1.0 - end.voids;
        point.deleted |= self.failure.is_some_and(|failure| end.voids >= failure.failure);
        point.return_to(-end.mean, end.mises, (before.mean - end.mean) / self.moduli.bulk);
    }
}

#[cfg(test)]
mod tests {
    use super::super::law::TrialStress;
    use super::*;

    fn metal(rows: Vec<[f64; 2]>) -> PorousMetal {
        let moduli = ElasticModuli::from_young(70_000.0, 0.33);
        let hardening = LinearTable { rows };
        PorousMetal { constants: [1.4, 0.9, 1.8], voids: 0.02, hardening, nucleation: None, failure: None, moduli }
    }

    fn strained(law: &PorousMetal, state: &mut [f64], carried: [f64; 4], strain: [f64; 4]) -> ([f64; 4], bool) {
        let mut point = ReturnPoint::new(strain, carried, state, law.moduli);
        law.update(&mut point);
        (point.stress, point.deleted)
    }

    /// Hydrostatic stress and voids in closed form: 2/(3 q2) y acosh((1 + q3 f²)/(2 q1 f)), f = 1 - (1 - f0) exp(-ev).
    #[test]
    fn hydrostatic_tension_and_compression_are_exact() {
        let law = metal(vec![[300.0, 0.0]]);
        let [q1, q2, q3] = law.constants;
        for (steps, size) in [(400, 0.04), (1, 0.1), (400, -0.006), (1, -0.006)] {
            let (mut state, mut stress) = (law.initial_state(), [0.0; 4]);
            let step = size / f64::from(steps);
            for _ in 0..steps {
                stress = strained(&law, &mut state, stress, [step, step, step, 0.0]).0;
            }
            let voids = state[VOIDS];
            let ratio = libm::acosh((1.0 + q3 * voids * voids) / (2.0 * q1 * voids)) / (1.5 * q2);
            assert!((stress[0].abs() / (300.0 * ratio) - 1.0).abs() < 1e-7, "{size}: {stress:?}");
            let plastic = 3.0 * size - stress[0] / law.moduli.bulk;
            assert!((voids - 1.0 + 0.98 * libm::exp(-plastic)).abs() < 1e-12);
        }
    }

    /// Increments of all sizes end on the yield surface; the element is deleted once the voids suffice.
    #[test]
    fn large_increments_end_on_the_surface() {
        let mut law = metal(vec![[300.0, 0.0], [400.0, 0.1], [450.0, 0.6]]);
        law.nucleation = Some(VoidNucleation { mean: 0.2, deviation: 0.1, fraction: 0.04 });
        law.failure = Some(VoidFailure { critical: 0.1, failure: 0.25 });
        for [volume, shear] in [[0.01, 0.01], [0.0, 0.3], [0.3, 0.0], [-0.2, 2.0], [-0.5, 0.0], [1e-9, 0.1], [3.0, 9.0]]
        {
            let mut state = law.initial_state();
            let (stress, deleted) = strained(&law, &mut state, [0.0; 4], [volume, volume, volume, shear]);
            let end = TrialStress::of(stress);
            let (strain, voids) = (state[STRAIN], state[VOIDS]);
            let hardening = law.hardening.line(strain);
            let before = PorousIncrement { strain, hardening, voids, mises: end.mises, mean: -end.pressure };
            let excess = law.constants().trial(&before).excess;
            assert!(excess.abs() < 1e-6 && state[STRAIN] > 0.0, "{volume} {shear}: {excess}");
            assert_eq!(deleted, voids >= 0.25);
        }
    }
}
