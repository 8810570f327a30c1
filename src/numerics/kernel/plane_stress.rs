//! Plane stress at a point of a shell: linear elasticity with isotropic von Mises plasticity and zero stress through
//! the thickness.
//!
//! There is no shear in the directions of meridian and hoop. With p = s1 + s2 and d = s1 - s2 the von Mises stress is
//! q² = (p² + 3 d²)/4, and the return scales both by one unknown x (Simo and Taylor 1986, Int. J. Numer. Meth. Eng. 22,
//! 649): p = p_trial / (1 + x E/(3 (1 - ν))), d = d_trial / (1 + 2 G x), with the plastic strain increment 2/3 x q.

use super::hardening::{YieldStress, bracketed_root};

/// Young's modulus and Poisson's ratio in plane stress.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaneElastic {
    /// Young's modulus.
    pub young: f64,
    /// Poisson's ratio.
    pub ratio: f64,
}

/// Result of a return to the yield surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlaneReturn {
    /// Stress along meridian and hoop.
    pub stress: [f64; 2],
    /// Von Mises stress; 0 for an elastic increment.
    pub mises: f64,
    /// Increment of equivalent plastic strain.
    pub flow: f64,
    /// Increment of plastic strain along meridian and hoop.
    pub plastic: [f64; 2],
}

impl PlaneElastic {
    /// Returns the modulus of one strain with the other fixed, E/(1 - ν²).
    #[inline(always)]
    pub fn modulus(&self) -> f64 {
        self.young / (1.0 - self.ratio * self.ratio)
    }

    /// Returns the shear modulus E/(2(1 + ν)).
    pub fn shear(&self) -> f64 {
        0.5 * self.young / (1.0 + self.ratio)
    }

    /// Returns the elastic trial stress for a strain increment, both along meridian and hoop.
    #[inline(always)]
    pub fn trial(&self, stress: [f64; 2], strain: [f64; 2]) -> [f64; 2] {
        let modulus = self.modulus();
        [
            stress[0] + modulus * (strain[0] + self.ratio * strain[1]),
            stress[1] + modulus * (strain[1] + self.ratio * strain[0]),
        ]
    }

    /// Returns a trial stress to the yield stress at the resulting plastic strain and rate: reference for the lanes.
    #[cfg(test)]
    pub(super) fn returned(
        &self,
        law: &dyn YieldStress,
        trial: [f64; 2],
        [strain, temperature]: [f64; 2],
        dt: f64,
    ) -> PlaneReturn {
        match self.unknown(law, trial, [strain, temperature], dt) {
            Some(x) => self.flowed(trial, x),
            None => PlaneReturn { stress: trial, ..PlaneReturn::default() },
        }
    }

    /// Returns the result of a return to the yield surface with the unknown x. Associated flow: dp_i = x (2 s_i - s_j)/3.
    /// Equation (8.4).
    #[inline(always)]
    pub(super) fn flowed(&self, trial: [f64; 2], x: f64) -> PlaneReturn {
        let stress = self.scaled(trial, x);
        let plastic = [x / 3.0 * (2.0 * stress[0] - stress[1]), x / 3.0 * (2.0 * stress[1] - stress[0])];
        let mises = mises(stress);
        PlaneReturn { stress, mises, flow: 2.0 / 3.0 * x * mises, plastic }
    }

    /// Returns the unknown x of the return to the yield surface; `None` for an elastic increment.
    pub(super) fn unknown(
        &self,
        law: &dyn YieldStress,
        trial: [f64; 2],
        [strain, temperature]: [f64; 2],
        dt: f64,
    ) -> Option<f64> {
        let per_dt = if dt > 0.0 { 1.0 / dt } else { 0.0 };
        let residual = |x: f64| {
            let mises = mises(self.scaled(trial, x));
            let flow = 2.0 / 3.0 * x * mises;
            mises - law.at(strain + flow, flow * per_dt, temperature)
        };
        let at_zero = residual(0.0);
        let flows = at_zero > 0.0;
        flows.then(|| self.root(residual, at_zero, mises(trial)))
    }

    /// Returns the coefficients of x in the denominators of p and d.
    #[inline(always)]
    pub(super) fn scaling_rates(&self) -> [f64; 2] {
        [self.young / (3.0 * (1.0 - self.ratio)), 2.0 * self.shear()]
    }

    /// Returns the trial stress with p and d scaled for the unknown x.
    #[inline(always)]
    pub(super) fn scaled(&self, trial: [f64; 2], x: f64) -> [f64; 2] {
        let [a, b] = self.scaling_rates();
        let p = (trial[0] + trial[1]) / (1.0 + a * x);
        let d = (trial[0] - trial[1]) / (1.0 + b * x);
        [0.5 * (p + d), 0.5 * (p - d)]
    }

    /// Returns the root of a residual that is positive at 0 and decreases: the upper limit is doubled until the sign
    /// changes, then bracketed secants. Returns NaN if no root is found.
    fn root(&self, residual: impl Fn(f64) -> f64, at_zero: f64, trial: f64) -> f64 {
        let (mut low, mut at_low) = (0.0, at_zero);
        let mut high = at_zero / (trial * self.shear());
        let mut at_high = residual(high);
        for _ in 0..200 {
            if at_high <= 0.0 {
                break;
            }
            (low, at_low) = (high, at_high);
            high *= 2.0;
            at_high = residual(high);
        }
        bracketed_root(residual, [low, at_low], [high, at_high], 1e-12 * trial)
    }
}

/// Returns the von Mises stress of two principal stresses.
#[inline(always)]
pub fn mises([a, b]: [f64; 2]) -> f64 {
    (a * a - a * b + b * b).sqrt()
}

#[cfg(test)]
mod tests {
    use super::{PlaneElastic, mises};
    use crate::kernel::hardening::{FlowStress, JohnsonCook, LinearTable, RateFactor, StaticYield, YieldStress};

    const STEEL: PlaneElastic = PlaneElastic { young: 200e3, ratio: 0.3 };

    /// Uniaxial tension: the strain is the sum of its elastic and plastic parts.
    #[test]
    fn uniaxial_tension_follows_the_hardening_curve() {
        let law = LinearTable { rows: vec![[200.0, 0.0], [400.0, 0.2]] };
        // Strains of a bar at the plastic strain 0.01: the stress is 210.
        let (stress, plastic) = (210.0, 0.01);
        let strain = [stress / STEEL.young + plastic, -0.3 * stress / STEEL.young - 0.5 * plastic];
        let returned = STEEL.returned(&law, STEEL.trial([0.0; 2], strain), [0.0; 2], 0.0);
        assert!((returned.stress[0] - stress).abs() < 1e-8 && returned.stress[1].abs() < 1e-8, "{returned:?}");
        assert!((returned.flow - plastic).abs() < 1e-13);
        assert!((returned.plastic[0] - plastic).abs() < 1e-13 && (returned.plastic[1] + 0.5 * plastic).abs() < 1e-13);
    }

    #[test]
    fn return_reaches_the_yield_surface() {
        let base = JohnsonCook { a: 806.0, b: 614.0, n: 0.168, m: 1.1, melt: 1540.0, transition: 20.0 };
        let factor = Some(RateFactor::JohnsonCook { c: 0.0089, reference: 1.0 });
        let law = FlowStress { base: StaticYield::JohnsonCook(base), factor };
        for trial in [[5000.0, -300.0], [2500.0, 2500.0], [-2000.0, 1.0], [0.0, 1e5]] {
            let returned = STEEL.returned(&law, trial, [0.02, 300.0], 1e-6);
            let yields = law.at(0.02 + returned.flow, returned.flow / 1e-6, 300.0);
            assert!((returned.mises / yields - 1.0).abs() < 1e-9, "{trial:?} {returned:?}");
            // The remaining elastic strain gives the same stress.
            let back = STEEL.trial(trial, returned.plastic.map(|p| -p));
            assert!((0..2).all(|i| (back[i] - returned.stress[i]).abs() < 1e-8 * mises(trial)), "{trial:?} {back:?}");
        }
        let melted = STEEL.returned(&law, [900.0, 0.0], [0.0, 1600.0], 1e-6);
        assert!(melted.mises < 1e-6);
    }
}
