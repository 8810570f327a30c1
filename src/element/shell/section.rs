//! What all shells of a group share: thickness and points at the start, elasticity, what flows, viscosity.
//! Never here: state.

use crate::element::constants::damped;
use crate::kernel::hardening::FlowStress;
use crate::kernel::heating::Heating;
use crate::kernel::plane_stress::PlaneElastic;
use crate::kernel::shell::Frame;

/// How the thickness follows from the strains in the plane (`POISSON` of `*SHELL SECTION`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Thinning {
    /// By the material at the points through the thickness.
    Material,
    /// By a ratio: -nu/(1 - nu) times the sum of the membrane strains.
    Ratio(f64),
}

/// What flows at points.
pub struct Flowing {
    pub law: FlowStress,
    /// Rise of temperature by plastic work.
    pub heating: Heating,
}

pub struct Section {
    pub elastic: PlaneElastic,
    /// Thickness at the start.
    pub thickness: f64,
    /// Mass per area at the start.
    pub per_area: f64,
    /// Place (-1 to 1) and weight of the points through the thickness.
    pub points: Vec<[f64; 2]>,
    /// What flows; `None` where nothing does.
    pub flowing: Option<Flowing>,
    pub thinning: Thinning,
    /// Linear and quadratic bulk viscosity.
    pub bulk_viscosity: [f64; 2],
}

impl Section {
    /// One over the stable increment of an element of a thickness, with linear bulk viscosity and what the rate of area adds.
    ///
    /// A fraction xi of critical damping makes it 2/w (sqrt(1 + xi^2) - xi) (ABAQUS Theory Guide 2.4.5). Viscosity acts on the
    /// sum of both strains: over elasticity at most by 2/(1 + nu) as much as along one of them.
    pub fn rate(&self, frame: &Frame, masses: &[f64; 4], thickness: f64, area_rate: f64) -> f64 {
        let frequency = frame.frequency(masses, thickness, self.shear_stiffness(), &self.elastic);
        let speed = self.wave_speed(frame, masses, thickness);
        let [linear, quadratic] = self.bulk_viscosity;
        let closing = (-area_rate).max(0.0) * frame.length / speed;
        let viscosity = (linear + quadratic * quadratic * closing) / (1.0 + self.elastic.ratio);
        let xi = viscosity * frame.length * frequency / speed;
        0.5 * frequency * damped(xi)
    }

    /// Force a length over the angle of transverse shear.
    pub fn shear_stiffness(&self) -> f64 {
        Frame::shear_stiffness(self.thickness, &self.elastic)
    }

    /// Speed of waves in the plane of the shell.
    pub fn wave_speed(&self, frame: &Frame, masses: &[f64; 4], thickness: f64) -> f64 {
        (self.elastic.modulus() * frame.area() * thickness / (masses[0] + masses[1])).sqrt()
    }

    /// Force and moment a length of the bulk viscosity, which act along both directions, at rates of area and of curvature
    /// (sums of both directions): linear, and quadratic where the area shrinks (ABAQUS Theory Guide 2.4.5); on rotations
    /// linear alone (ABAQUS Theory Guide 3.6.5, "Rotational bulk viscosity for explicit dynamics").
    pub fn viscosity(&self, frame: &Frame, masses: &[f64; 4], thickness: f64, [area, curvature]: [f64; 2]) -> [f64; 2] {
        let [linear, quadratic] = self.bulk_viscosity;
        // Density times thickness.
        let per_area = (masses[0] + masses[1]) / frame.area();
        let (l, speed) = (frame.length, self.wave_speed(frame, masses, thickness));
        let closing = area.min(0.0) * l * quadratic;
        let force = per_area * (linear * speed * l * area - closing * closing);
        let moment = self.thickness * self.thickness / 12.0 * per_area * linear * speed * l * curvature;
        [force, moment]
    }
}
