//! Stiffness of a shell section about its reference surface: uniform, or integrated over layers.

use super::laminate::PointElasticity;
use super::lanes::InlineMap;
use super::plane_stress::PlaneElastic;
use super::real::Real;
use super::shell::{SectionComponents, coupled, scaled};

/// Shear correction factor of a parabolic shear stress over the thickness.
const SHEAR_SHARE: f64 = 5.0 / 6.0;
/// Smallest value of E' h / K - 1 in the scaling of rotary inertias, that of an isotropic section with ν = -1.
const LEAST_SLACK: f64 = 0.2;

/// A layer of a section, in the initial configuration.
#[derive(Clone, Copy, Debug)]
pub struct Layer {
    /// Heights of bottom and top over the reference surface.
    pub heights: [f64; 2],
    /// Mass per volume.
    pub density: f64,
    pub elasticity: PointElasticity,
}

/// Elasticity of a section.
#[derive(Clone, Debug, PartialEq)]
pub enum SectionStiffness {
    /// One isotropic material, with the reference surface in the middle.
    Uniform {
        elastic: PlaneElastic,
        /// Transverse shear force per length and shear angle.
        shear: f64,
    },
    /// Layers, or one material whose reference surface is not in the middle.
    Layered(Box<LayeredStiffness>),
}

/// Stiffnesses of a layered section about its reference surface, for the initial thickness. Each of the three lists has the
/// components ss, sθ, θθ.
#[derive(Clone, Debug, PartialEq)]
pub struct LayeredStiffness {
    /// Forces per length and membrane strain.
    membrane: [f64; 3],
    /// Forces per length and curvature, and moments per length and membrane strain.
    coupling: [f64; 3],
    /// Moments per length and curvature.
    bending: [f64; 3],
    shear: f64,
    thickness: f64,
    /// Largest wave modulus in the plane: force per length and membrane strain over the thickness.
    modulus: f64,
    /// See [`SectionStiffness::viscous_divisor`].
    viscous_divisor: f64,
}

/// Rule for the rotary inertia of nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RotaryRule {
    /// Least rotary inertia per mass.
    pub least: f64,
    /// Membrane stiffness over transverse shear stiffness, less 1.
    pub slack: f64,
}

impl SectionStiffness {
    /// Creates the stiffness of one isotropic material with the reference surface in the middle.
    pub fn uniform(elastic: PlaneElastic, thickness: f64) -> Self {
        SectionStiffness::Uniform { elastic, shear: SHEAR_SHARE * elastic.shear() * thickness }
    }

    /// Creates the stiffness of layers, from the side SNEG to the side SPOS. Equation (8.10).
    pub fn layered(layers: &[Layer]) -> Self {
        let moment = |power: i32| {
            let mut sums = [0.0; 3];
            for layer in layers {
                let range = integral(layer.heights, power);
                sums.iter_mut().zip(layer.elasticity.stiffness()).for_each(|(sum, q)| *sum += q * range);
            }
            sums
        };
        let [membrane, coupling, bending] = [moment(0), moment(1), moment(2)];
        let thickness: f64 = layers.iter().map(|l| l.heights[1] - l.heights[0]).sum();
        let modulus = membrane[0].max(membrane[2]) / thickness;
        let shear = transverse_shear(layers, [membrane[0], coupling[0]]);
        let viscous_divisor = viscous_divisor([&membrane, &coupling, &bending], modulus * thickness, thickness);
        SectionStiffness::Layered(Box::new(LayeredStiffness {
            membrane,
            coupling,
            bending,
            shear,
            thickness,
            modulus,
            viscous_divisor,
        }))
    }

    /// Returns the modulus of plane waves in the section; of layers, the larger one of both directions.
    #[inline(always)]
    pub fn modulus(&self) -> f64 {
        match self {
            SectionStiffness::Uniform { elastic, .. } => elastic.modulus(),
            SectionStiffness::Layered(layered) => layered.modulus,
        }
    }

    /// Returns the transverse shear force per length and shear angle.
    #[inline(always)]
    pub fn shear(&self) -> f64 {
        match self {
            SectionStiffness::Uniform { shear, .. } => *shear,
            SectionStiffness::Layered(layered) => layered.shear,
        }
    }

    /// Returns the divisor of the bulk viscosity in the fraction of critical damping: 1 + ν of a uniform section. Viscosity
    /// acts on the sum of both membrane strains, and on the sum of both curvatures; relative to the stiffness it is at most
    /// 2 over this value times as much as on one membrane strain.
    #[inline(always)]
    pub fn viscous_divisor(&self) -> f64 {
        match self {
            SectionStiffness::Uniform { elastic, .. } => 1.0 + elastic.ratio,
            SectionStiffness::Layered(layered) => layered.viscous_divisor,
        }
    }

    /// Returns the rule of rotary inertias of a uniform section, or of layers with a radius of gyration about the reference
    /// surface; the radius is squared. Equation (8.12).
    pub fn rotary_rule(&self, thickness: f64, gyration: f64) -> RotaryRule {
        match self {
            SectionStiffness::Uniform { elastic, shear } => {
                RotaryRule { least: thickness * thickness / 12.0, slack: elastic.modulus() * thickness / shear - 1.0 }
            }
            SectionStiffness::Layered(layered) => {
                let [along, hoop] = [0, 2].inline_map(|i: usize| layered.bending[i] / layered.membrane[i]);
                let slack = (layered.membrane[0] / layered.shear - 1.0).max(LEAST_SLACK);
                RotaryRule { least: gyration.max(along).max(hoop), slack }
            }
        }
    }

    /// Returns the stiffness matrix times the area and times a symmetric matrix, for a current thickness.
    #[inline(always)]
    pub fn times<T: Real>(
        &self,
        area: T,
        thickness: T,
        [s, h, k, c, q]: &[SectionComponents<T>; 5],
    ) -> [SectionComponents<T>; 5] {
        let like = |value: f64| thickness.like(value);
        match self {
            SectionStiffness::Uniform { elastic, shear } => {
                let stretch = area * like(elastic.modulus()) * thickness;
                let bend = stretch * thickness * thickness / like(12.0);
                let ratio = like(elastic.ratio);
                [
                    coupled(stretch, ratio, s, h),
                    coupled(stretch, ratio, h, s),
                    coupled(bend, ratio, k, c),
                    coupled(bend, ratio, c, k),
                    scaled(q, area * like(*shear)),
                ]
            }
            SectionStiffness::Layered(layered) => layered.times(area, thickness, [s, h, k, c, q]),
        }
    }
}

impl LayeredStiffness {
    #[inline(always)]
    fn times<T: Real>(
        &self,
        area: T,
        thickness: T,
        [s, h, k, c, q]: [&SectionComponents<T>; 5],
    ) -> [SectionComponents<T>; 5] {
        let like = |value: f64| thickness.like(value);
        let ratio = thickness / like(self.thickness);
        let (first, second) = (area * ratio, area * ratio * ratio);
        let third = second * ratio;
        let (a, b, d) = (&self.membrane, &self.coupling, &self.bending);
        let row = |factors: [T; 4]| sum_of_rows(factors, [s, h, k, c]);
        [
            row([first * like(a[0]), first * like(a[1]), second * like(b[0]), second * like(b[1])]),
            row([first * like(a[1]), first * like(a[2]), second * like(b[1]), second * like(b[2])]),
            row([second * like(b[0]), second * like(b[1]), third * like(d[0]), third * like(d[1])]),
            row([second * like(b[1]), second * like(b[2]), third * like(d[1]), third * like(d[2])]),
            scaled(q, area * like(self.shear)),
        ]
    }
}

/// Returns the sum of four rows times factors.
#[inline(always)]
fn sum_of_rows<T: Real>(factors: [T; 4], rows: [&SectionComponents<T>; 4]) -> SectionComponents<T> {
    let [a, b, c, d] = factors;
    let [p, q, r, s] = rows;
    [
        a * p[0] + b * q[0] + c * r[0] + d * s[0],
        a * p[1] + b * q[1] + c * r[1] + d * s[1],
        a * p[2] + b * q[2] + c * r[2] + d * s[2],
        a * p[3] + b * q[3] + c * r[3] + d * s[3],
        a * p[4] + b * q[4] + c * r[4] + d * s[4],
    ]
}

/// Returns the integral of a power of the height over a range of heights.
fn integral([low, high]: [f64; 2], power: i32) -> f64 {
    let exponent = power + 1;
    (high.powi(exponent) - low.powi(exponent)) / f64::from(exponent)
}

/// Returns the squared radius of gyration of the mass of layers about the reference surface.
pub fn squared_gyration(layers: &[Layer]) -> f64 {
    let sum = |power: i32| layers.iter().map(|l| l.density * integral(l.heights, power)).sum::<f64>();
    sum(2) / sum(0)
}

/// Returns the transverse shear stiffness of layers: that with the strain energy of the shear stress which is in equilibrium
/// with the stress of cylindrical bending about the neutral surface. Equation (8.11).
fn transverse_shear(layers: &[Layer], [membrane, coupling]: [f64; 2]) -> f64 {
    let neutral = coupling / membrane;
    let (mut bending, mut below, mut compliance) = (0.0, 0.0, 0.0);
    for layer in layers {
        let [low, high] = layer.heights.inline_map(|height| height - neutral);
        let [modulus, ..] = layer.elasticity.stiffness();
        bending += modulus * integral([low, high], 2);
        // The static moment of the part of the section below a height u over the neutral surface is a + b u².
        let b = 0.5 * modulus;
        let a = below - b * low * low;
        let squared = a * a * (high - low) + 2.0 * a * b * integral([low, high], 2) + b * b * integral([low, high], 4);
        compliance += squared / layer.elasticity.transverse_shear();
        below = a + b * high * high;
    }
    bending * bending / compliance
}

/// Returns [`SectionStiffness::viscous_divisor`] of layers: 2 over the largest eigenvalue of the viscosity relative to the
/// stiffness, and over the membrane stiffness. The viscosity is (1, 1, 0, 0) (1, 1, 0, 0)ᵀ + (0, 0, g, g) (0, 0, g, g)ᵀ with
/// g² = h²/12.
fn viscous_divisor([a, b, d]: [&[f64; 3]; 3], membrane: f64, thickness: f64) -> f64 {
    let matrix =
        [[a[0], a[1], b[0], b[1]], [a[1], a[2], b[1], b[2]], [b[0], b[1], d[0], d[1]], [b[1], b[2], d[1], d[2]]];
    let arm = thickness / 12.0_f64.sqrt();
    let [along, turned] = [[1.0, 1.0, 0.0, 0.0], [0.0, 0.0, arm, arm]];
    let [from_along, from_turned] = [solved(matrix, along), solved(matrix, turned)];
    let product = |x: [f64; 4], y: [f64; 4]| x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>();
    let (p, q, r) = (product(along, from_along), product(turned, from_turned), product(along, from_turned));
    let largest = 0.5 * (p + q) + (0.25 * (p - q) * (p - q) + r * r).sqrt();
    2.0 / (largest * membrane)
}

/// Solves a positive definite system of four equations.
fn solved(mut matrix: [[f64; 4]; 4], mut right: [f64; 4]) -> [f64; 4] {
    for pivot in 0..4 {
        for row in pivot + 1..4 {
            let factor = matrix[row][pivot] / matrix[pivot][pivot];
            let above = matrix[pivot];
            matrix[row].iter_mut().zip(above).skip(pivot).for_each(|(value, above)| *value -= factor * above);
            right[row] -= factor * right[pivot];
        }
    }
    for row in (0..4).rev() {
        let known: f64 = (row + 1..4).map(|column| matrix[row][column] * right[column]).sum();
        right[row] = (right[row] - known) / matrix[row][row];
    }
    right
}

#[cfg(test)]
mod tests {
    use faer::Mat;

    use super::{Layer, SectionStiffness, squared_gyration};
    use crate::kernel::laminate::{Lamina, PointElasticity};
    use crate::kernel::plane_stress::PlaneElastic;
    use crate::kernel::shell::ShellFrame;

    const STEEL: PlaneElastic = PlaneElastic { young: 200e9, ratio: 0.3 };

    fn layers_of_steel(heights: &[f64]) -> Vec<Layer> {
        let layer =
            |w: &[f64]| Layer { heights: [w[0], w[1]], density: 7800.0, elasticity: PointElasticity::Isotropic(STEEL) };
        heights.windows(2).map(layer).collect()
    }

    /// Layers of one material are the uniform section, also about another reference surface.
    #[test]
    fn layers_of_one_material_are_the_uniform_section() {
        let uniform = SectionStiffness::uniform(STEEL, 2e-3);
        let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-12, "{a} {b}");
        for offset in [0.0, 1e-3, -0.4e-3] {
            let layers = layers_of_steel(&[-1e-3, -0.7e-3, 0.2e-3, 1e-3].map(|z| z - offset));
            let section = SectionStiffness::layered(&layers);
            close(section.shear(), uniform.shear());
            close(section.modulus(), uniform.modulus());
            close(squared_gyration(&layers), 4e-6 / 12.0 + offset * offset);
            let rule = section.rotary_rule(2e-3, squared_gyration(&layers));
            close(rule.least, 4e-6 / 12.0 + offset * offset);
            close(rule.slack, uniform.rotary_rule(2e-3, 0.0).slack);
            if offset == 0.0 {
                close(section.viscous_divisor(), uniform.viscous_divisor());
                let mut unit = [[0.0; 5]; 5];
                (0..5).for_each(|i| unit[i][i] = 1.0);
                let matrices = [&section, &uniform].map(|s| s.times(3.0, 1.9e-3, &unit));
                let largest = matrices[1].iter().flatten().fold(0.0_f64, |largest, value| largest.max(value.abs()));
                for (a, b) in matrices[0].iter().flatten().zip(matrices[1].iter().flatten()) {
                    assert!((a - b).abs() < 1e-14 * largest, "{a} {b}");
                }
            } else {
                assert!(section.viscous_divisor() < uniform.viscous_divisor());
            }
        }
    }

    /// Comparison of the frequency bound with the eigenvalues of the dense stiffness: laminates, sandwiches, offset nodes.
    #[test]
    fn frequency_bound_of_layers_is_close_to_the_highest_frequency() {
        let carbon = Lamina { young: [140e9, 10e9], ratio: 0.3, shear: [5e9, 5e9, 3e9] };
        let lamina = |angle: f64| PointElasticity::Orthotropic(carbon.turned(angle));
        for offset in [0.0, 0.5, -0.3] {
            let mut layers = layers_of_steel(&[-1e-3, -4e-4, 4e-4, 1e-3].map(|z| z - 2e-3 * offset));
            for elasticity in [lamina(0.0), lamina(90.0), lamina(30.0)] {
                layers[1] = Layer { density: 1600.0, elasticity, ..layers[1] };
                let section = SectionStiffness::layered(&layers);
                for places in [[[0.0, 0.0], [0.01, 0.0]], [[0.1, 0.0], [0.1, 0.005]], [[0.1, 0.0], [0.105, 0.003]]] {
                    let frame = ShellFrame::new(places);
                    let rule = section.rotary_rule(2e-3, squared_gyration(&layers));
                    let masses = frame.masses([places[0][0], places[1][0]], 11.0, rule);
                    let bound = frame.frequency(&masses, 2e-3, &section);
                    let largest = dense_frequency(&frame, &section, &masses);
                    assert!(bound >= largest * (1.0 - 1e-12) && bound < 1.07 * largest, "{bound} {largest}");
                }
            }
        }
    }

    fn dense_frequency(frame: &ShellFrame, section: &SectionStiffness, masses: &[f64; 4]) -> f64 {
        let mut unit = [[0.0; 5]; 5];
        (0..5).for_each(|i| unit[i][i] = 1.0);
        let stiffness = section.times(1.0, 2e-3, &unit);
        let mass = |i: usize| if i % 3 == 2 { masses[2 + i / 3] } else { masses[i / 3] };
        let matrix = Mat::from_fn(6, 6, |i, j| {
            let mut motion = [[0.0; 3]; 2];
            motion[j / 3][j % 3] = 1.0;
            let strains = frame.strains(motion);
            let resultants = stiffness.map(|row| row.iter().zip(strains).map(|(c, e)| c * e).sum::<f64>());
            -frame.forces(&resultants)[i / 3][i % 3] / (mass(i) * mass(j)).sqrt()
        });
        matrix.self_adjoint_eigenvalues(faer::Side::Lower).expect("eigenvalues")[5].sqrt()
    }

    /// Shear stiffness of a sandwich with thin stiff faces: G c² / (c - t) is approached for a soft core (Allen 1969,
    /// Analysis and Design of Structural Sandwich Panels, chapter 2: D_Q = G d²/c with the core c and the distance d of the
    /// middles of the faces).
    #[test]
    fn shear_stiffness_of_a_sandwich_is_that_of_its_core() {
        let (face, core) = (1e-4, 2e-2);
        let shear = 30e6;
        let soft = Lamina { young: [70e3; 2], ratio: 0.3, shear: [shear; 3] };
        let bounds = [-0.5 * core - face, -0.5 * core, 0.5 * core, 0.5 * core + face];
        let mut layers = layers_of_steel(&bounds);
        layers[1].elasticity = PointElasticity::Orthotropic(soft.turned(0.0));
        let expected = shear * (core + face) * (core + face) / core;
        let found = SectionStiffness::layered(&layers).shear();
        assert!((found / expected - 1.0).abs() < 1e-4, "{found} {expected}");
    }
}
