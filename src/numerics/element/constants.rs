//! Constants that all elements of a group share, and derived quantities of one linear elastic element.

use crate::kernel::bulk_viscosity::BulkViscosity;
use crate::kernel::lanes::InlineMap;
use crate::kernel::moduli::ElasticModuli;
use crate::kernel::real::Real;
use crate::kernel::{assumed, quad};

/// Largest relative volume change of an element per increment at its current rate. It prevents element inversion and
/// resolves the work of rapid expansion.
pub const CHANGE: f64 = 0.2;

/// Increase of the squared highest frequency by assumed strains, per ratio of their modulus to the longitudinal
/// modulus. Determined from skewed elements of all aspect ratios (test below).
const SKEWED: f64 = 0.25;
/// Linear bulk viscosity below which the highest modes of the mesh count as undamped.
const DAMPED: f64 = 0.05;

/// Elastic moduli, hourglass control and bulk viscosity of a group.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ElementConstants {
    /// Bulk modulus, stress.
    pub bulk: f64,
    /// Shear modulus, stress.
    pub shear: f64,
    /// Form and coefficients of the hourglass control.
    pub hourglass: HourglassControl,
    /// Bulk viscosity.
    pub bulk_viscosity: BulkViscosity,
    /// Dynamic shear viscosity of a fluid with an equation of state, stress times time; 0 for other materials.
    pub shear_viscosity: f64,
    /// Whether the equations of motion are weighted by area (`WEIGHTING=AREA`); only for quadrilaterals of materials with
    /// constant moduli.
    pub by_area: bool,
}

/// Hourglass control of elements with one integration point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HourglassControl {
    /// Stiffness over the shear modulus.
    pub stiffness: f64,
    /// Viscosity as a fraction of critical damping.
    pub viscosity: f64,
    /// Whether the hourglass stress is scaled back with the stress in plastic flow.
    pub relaxes: bool,
    /// Factor on the stresses of assumed strains that vary across the element; 0 without assumed strains.
    pub enhanced: f64,
}

/// Returns the factor by which a fraction ξ of critical damping divides the stable time increment: 1 + ξ + ξ²/2, never
/// below sqrt(1 + ξ²) + ξ (ABAQUS Analysis User's Guide, "Explicit dynamic analysis"). Equation (4.6).
#[inline(always)]
pub(super) fn damped<T: Real>(xi: T) -> T {
    let unity = xi.like(1.0);
    unity + xi * (unity + unity.like(0.5) * xi)
}

impl HourglassControl {
    /// No hourglass control, for elements without hourglass modes.
    pub const NONE: HourglassControl =
        HourglassControl { stiffness: 0.0, viscosity: 0.0, relaxes: false, enhanced: 0.0 };
}

impl ElementConstants {
    /// Returns the elastic energy per volume of a stress rr, zz, hoop, rz.
    pub(super) fn elastic_energy(&self, stress: [f64; 4]) -> f64 {
        ElasticModuli { bulk: self.bulk, shear: self.shear }.energy(stress)
    }

    /// Returns one over the stable time increment of an element with these corners `[r, z]` and corner masses. Uses the
    /// frequency bound of the inner loop, with linear bulk viscosity only. Equation (4.7).
    pub(super) fn own_rate(&self, corners: [[f64; 2]; 4], masses: &[f64; 4]) -> f64 {
        let g = quad::gradient(corners.inline_map(|c| c[0]), corners.inline_map(|c| c[1]));
        let corner = |i: usize| (g.r[i] * g.r[i] + g.z[i] * g.z[i] + g.hoop[i] * g.hoop[i]) / masses[i];
        let modulus = self.bulk + 4.0 / 3.0 * self.shear;
        let sum = modulus * quad::UNIT * ((corner(0) + corner(1)) + (corner(2) + corner(3)));
        0.5 * (sum / g.volume).sqrt() * damped(self.bulk_viscosity.linear) * self.raises()
    }

    /// Returns the elastic stiffness of an element, rows and columns `[r, z]` of each corner in turn.
    pub(super) fn stiffness(&self, corners: [[f64; 2]; 4]) -> [[f64; 8]; 8] {
        let moduli = [self.bulk, self.shear];
        let mut matrix = quad::stiffness(corners, moduli, self.hourglass.stiffness);
        let factor = self.hourglass.enhanced;
        if factor > 0.0 && corners[2] != corners[3] {
            let bent = assumed::stiffness(corners, moduli);
            let pairs = matrix.as_flattened_mut().iter_mut().zip(bent.as_flattened());
            pairs.for_each(|(entry, bent)| *entry += factor * bent);
        }
        matrix
    }

    /// Returns the largest factor by which assumed strains raise the highest frequency of a skewed element above the
    /// bound of the uniform strains. The factor is 1 for rectangles, whose patterns are orthogonal to the uniform
    /// strains, and tends to 1 for a nearly incompressible material. Equation (5.13).
    fn raises(&self) -> f64 {
        if self.hourglass.enhanced == 0.0 {
            return 1.0;
        }
        let share = assumed::moduli(self.bulk, self.shear)[0] / (self.bulk + 4.0 / 3.0 * self.shear);
        (1.0 + SKEWED * share).sqrt()
    }

    /// Returns the rate of a pass (one over its stable time increment) increased by the assumed strains, but not above
    /// what the highest frequency `cap` of the model requires.
    pub(super) fn with_assumed(&self, rate: f64, cap: f64) -> f64 {
        if self.hourglass.enhanced == 0.0 {
            return rate;
        }
        let (raised, bound) = (rate * self.raises(), 0.5 * cap * damped(self.bulk_viscosity.linear));
        if raised > bound { bound.max(rate) } else { raised }
    }

    /// Returns whether bulk viscosity damps the highest modes.
    pub(super) fn damps(&self) -> bool {
        self.bulk_viscosity.linear >= DAMPED
    }

    /// Returns the highest frequency of the model increased by hourglass viscosity, which also damps the highest modes.
    pub(super) fn cap(&self, frequency: f64) -> f64 {
        frequency * damped(self.hourglass.viscosity)
    }
}

#[cfg(test)]
mod tests {
    use faer::{Mat, Side};

    use super::{ElementConstants, HourglassControl};
    use crate::kernel::bulk_viscosity::BulkViscosity;
    use crate::kernel::quad;

    /// Returns the highest frequency of one element from its stiffness (dense eigenvalues, faer).
    fn highest(matrix: &[[f64; 8]; 8], masses: &[f64; 4]) -> f64 {
        let entry = |a: usize, b: usize| matrix[a][b] / (masses[a / 2] * masses[b / 2]).sqrt();
        let dense = Mat::<f64>::from_fn(8, 8, |a, b| 0.5 * (entry(a, b) + entry(b, a)));
        dense.self_adjoint_eigenvalues(Side::Lower).expect("eigenvalues")[7].sqrt()
    }

    /// Slender, skewed and tapered elements on the axis, near it and far from it: the bound of single elements without
    /// damping holds with assumed strains.
    #[test]
    fn element_frequency_bound_holds_with_assumed_strains() {
        let mut largest: f64 = 0.0;
        for (bulk, shear) in [(1.0, 1.5), (2.0, 0.9), (100.0, 1.0)] {
            let hourglass = HourglassControl { stiffness: 0.0, viscosity: 0.0, relaxes: true, enhanced: 1.0 };
            let constants = ElementConstants {
                bulk,
                shear,
                hourglass,
                bulk_viscosity: BulkViscosity::NONE,
                shear_viscosity: 0.0,
                by_area: false,
            };
            for shape in 0..20_000_usize {
                let noise = |i: usize| ((shape * 7919 + i * 104_729) % 9973) as f64 / 9973.0 - 0.5;
                let inner = [0.0, 0.3, 2.0, 50.0][shape % 4];
                let high = [0.05, 0.3, 1.0, 4.0, 20.0][shape % 5];
                let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
                let mut corners = square.map(|[r, z]| [r, high * z]);
                for (i, corner) in corners.iter_mut().enumerate() {
                    corner[0] += inner + if corner[0] > 0.0 { 0.5 * noise(i) } else { 0.25 * (noise(i) + 0.5) };
                    corner[1] += 0.5 * high * noise(i + 4);
                    // An edge on the axis.
                    corner[0] = if inner == 0.0 && corner[0] < 0.5 { 0.0 } else { corner[0] };
                }
                let masses = quad::corner_masses(corners, 1.0);
                let exact = highest(&constants.stiffness(corners), &masses);
                largest = largest.max(0.5 * exact / constants.own_rate(corners, &masses));
            }
        }
        println!("highest frequency over its bound: {largest:.4}");
        assert!(largest <= 1.0, "{largest}");
    }
}
