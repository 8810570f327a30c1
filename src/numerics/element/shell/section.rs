//! Properties that all shells of a group share: initial thickness, layers, integration points, stiffness, viscosity.

use crate::element::constants::damped;
use crate::kernel::bulk_viscosity::{BulkViscosity, slow_rate};
use crate::kernel::hardening::FlowStress;
use crate::kernel::heating::PlasticHeating;
use crate::kernel::laminate::PointElasticity;
use crate::kernel::lanes::InlineMap;
use crate::kernel::real::Real;
use crate::kernel::section_stiffness::{RotaryRule, SectionStiffness};
use crate::kernel::shell::ShellFrame;

/// Rule for the thickness change from the membrane strains (`POISSON` of `*SHELL SECTION`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ThicknessRule {
    /// From the material at the points through the thickness.
    Material,
    /// From a Poisson's ratio: -ν/(1 - ν) times the sum of the membrane strains.
    Ratio(f64),
}

/// Plasticity of the section points.
pub struct SectionPlasticity {
    pub law: FlowStress,
    /// Temperature rise by plastic work.
    pub heating: PlasticHeating,
}

/// Material of a layer of a section.
pub struct LayerProperties {
    pub elasticity: PointElasticity,
    /// Plasticity, of isotropic layers only; `None` for an elastic layer.
    pub flowing: Option<SectionPlasticity>,
    /// Angle from the meridian to direction 1 of the layer, degrees. Output is in the directions of the layer.
    pub angle: f64,
}

/// Integration point of a section.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThicknessPoint {
    /// Height over the reference surface, relative to half the thickness.
    pub place: f64,
    /// Weight; the weights of all points have the sum 1.
    pub weight: f64,
    /// Index of the layer.
    pub layer: usize,
}

/// Properties of a shell section.
pub struct ShellProperties {
    pub layers: Vec<LayerProperties>,
    pub stiffness: SectionStiffness,
    pub rotary: RotaryRule,
    /// Initial thickness, length.
    pub thickness: f64,
    /// Initial mass per area.
    pub per_area: f64,
    /// Integration points, from the side SNEG to the side SPOS.
    pub points: Vec<ThicknessPoint>,
    pub thinning: ThicknessRule,
    /// Bulk viscosity.
    pub bulk_viscosity: BulkViscosity,
}

impl ShellProperties {
    /// Returns one over the stable time increment of an element of this thickness, with linear bulk viscosity and, for
    /// a shrinking area, the quadratic one.
    ///
    /// A fraction ξ of critical damping reduces the increment to 2/ω (sqrt(1 + ξ²) - ξ) (ABAQUS Theory Guide 2.4.5).
    /// Viscosity acts on the sum of both membrane strains: relative to elasticity at most 2/(1 + ν) times as much as on
    /// one strain ([`SectionStiffness::viscous_divisor`]).
    #[inline(always)]
    pub fn rate<T: Real>(&self, frame: &ShellFrame<T>, masses: &[T; 4], thickness: T, area_rate: T) -> T {
        let like = |value: f64| thickness.like(value);
        let frequency = frame.frequency(masses, thickness, &self.stiffness);
        let speed = self.wave_speed(frame, masses, thickness);
        let BulkViscosity { linear, quadratic, .. } = self.bulk_viscosity;
        let closing = area_rate.if_less(like(0.0), -area_rate, like(0.0)) * frame.length / speed;
        let viscosity = (like(linear) + like(quadratic * quadratic) * closing) / like(self.stiffness.viscous_divisor());
        let xi = viscosity * frame.length * frequency / speed;
        like(0.5) * frequency * damped(xi)
    }

    /// Returns whether a layer has plasticity.
    pub fn flows(&self) -> bool {
        self.layers.iter().any(|layer| layer.flowing.is_some())
    }

    /// Returns the wave speed in the plane of the shell.
    #[inline(always)]
    pub fn wave_speed<T: Real>(&self, frame: &ShellFrame<T>, masses: &[T; 4], thickness: T) -> T {
        (thickness.like(self.stiffness.modulus()) * frame.area() * thickness / (masses[0] + masses[1])).root()
    }

    /// Returns the slow parts of the rates of area and curvature after an increment `dt`.
    #[inline(always)]
    pub fn slow_rates<T: Real>(
        &self,
        frame: &ShellFrame<T>,
        masses: &[T; 4],
        (before, thickness): ([T; 2], T),
        rates: [T; 2],
        dt: f64,
    ) -> [T; 2] {
        let turn = thickness.like(2.0 * dt) * self.wave_speed(frame, masses, thickness) / frame.length;
        let filter = turn.like(self.bulk_viscosity.filter());
        [0, 1].inline_map(|i: usize| slow_rate(before[i], rates[i], turn, filter))
    }

    /// Returns force and moment per length of the bulk viscosity, equal in both directions, for the rates of area and
    /// of curvature (sums over both directions) and their slow parts. The force is linear, and also quadratic if the
    /// area shrinks (ABAQUS Theory Guide 2.4.5); the moment is linear only (ABAQUS Theory Guide 3.6.5, "Rotational bulk
    /// viscosity for explicit dynamics"). Equation (8.8).
    #[inline(always)]
    pub fn viscosity<T: Real>(
        &self,
        frame: &ShellFrame<T>,
        masses: &[T; 4],
        thickness: T,
        [area, curvature]: [T; 2],
        slow: [T; 2],
    ) -> [T; 2] {
        let BulkViscosity { linear, quadratic, .. } = self.bulk_viscosity;
        let like = |value: f64| thickness.like(value);
        // Density times thickness.
        let per_area = (masses[0] + masses[1]) / frame.area();
        let (l, speed) = (frame.length, self.wave_speed(frame, masses, thickness));
        let closing = area.if_less(like(0.0), area, like(0.0)) * l * like(quadratic);
        let viscous = per_area * like(linear) * speed * l;
        let force = viscous * (area - slow[0]) - per_area * closing * closing;
        let moment = like(self.thickness * self.thickness / 12.0) * viscous * (curvature - slow[1]);
        [force, moment]
    }
}
