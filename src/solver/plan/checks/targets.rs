//! Warnings for implausible shots at targets without a mesh: density and yield stress of the target, velocity and mean density
//! of the projectile, in the usual unit systems.

use std::f64::consts::PI;

use super::plausibility::{InitialVelocity, initial_velocities};
use super::values::warn_about;
use crate::model::{DeckUnits, MaterialDefinition, Model, RigidBody, SYSTEMS, UnitSystem, is_without_units};
use crate::plan::{PlannedRigidBody, Report, Scene};

/// Largest plausible initial speed, m/s: that of meteorites.
const LARGEST_SPEED: f64 = 20e3;
/// Range of the mass of a projectile over the volume that its surface encloses, kg/m3: thin shells, and tungsten rods of which
/// only the nose has facets.
const MEAN_DENSITIES: [f64; 2] = [10.0, 1e6];

/// Warns of values that are plausible in none of the usual unit systems, or not in that of `*UNITS`.
pub fn check_targets(scene: Scene<'_>, report: &mut Report) {
    let model = scene.model;
    let materials = || model.materials.iter().filter_map(|material| Some((material, strength(material)?)));
    let units = model.settings.units.as_ref().and_then(DeckUnits::system);
    if materials().next().is_none() || units.is_none() && materials().any(|(_, [density, _])| is_without_units(density))
    {
        return;
    }
    let mut systems: Vec<&UnitSystem> =
        SYSTEMS.iter().filter(|system| units.is_none_or(|known| known == *system)).collect();
    for (material, [density, stress]) in materials() {
        systems.retain(|system| system.fits_target(density, stress));
        if systems.is_empty() {
            let message = format!(
                "density {density:e} and yield stress {stress:e} of the target material `{}` are not plausible in one unit \
                 system",
                material.name
            );
            let help = "steel has 7850 and 1e9 in m, kg, s, and 7.85e-9 and 1000 in mm, t, s";
            return warn_about("P140", message, (material.span, "this material"), help, report);
        }
    }
    let is_too_fast = |speed: f64| systems.iter().all(|system| system.speed(speed.abs()) > LARGEST_SPEED);
    if let Some(InitialVelocity { condition, value, .. }) = initial_velocities(model).find(|v| is_too_fast(v.value)) {
        let message = format!("the initial velocity {value:e} is above 20 km/s in the units of the target material");
        let help = "check the units of the velocity: m/s in m, kg, s, and mm/s in mm, t, s";
        warn_about("P105", message, (condition.span, "this velocity"), help, report);
    }
    let [least, most] = MEAN_DENSITIES;
    for (rigid, body) in model.rigid_bodies.iter().zip(&scene.bodies.list) {
        let Some(mean) = mean_density(model, rigid, body) else { continue };
        if !systems.iter().any(|system| (least..=most).contains(&system.density(mean))) {
            let message = format!(
                "the mass {:e} of rigid body `{}` is {mean:.2e} per volume enclosed by its facets, which no projectile has",
                body.mass(),
                body.name
            );
            let help = "check the units of mass and lengths: kg and m, or t and mm";
            warn_about("P140", message, (body.span, "this body"), help, report);
        }
    }
}

/// Returns density and yield stress of a material with a resistance.
fn strength(material: &MaterialDefinition) -> Option<[f64; 2]> {
    Some([material.density?, material.cavity?.yield_stress])
}

/// Returns the mass of a body over the volume ∫ π r² dz below its RAX2 elements; `None` without mass or volume, or with
/// deformable elements.
fn mean_density(model: &Model, rigid: &RigidBody, body: &PlannedRigidBody) -> Option<f64> {
    let cone = |&element: &usize| {
        let &[a, b] = &model.mesh.elements[element].nodes[..] else { return 0.0 };
        let ([ra, za], [rb, zb]) = (model.mesh.points[a], model.mesh.points[b]);
        PI / 3.0 * (zb - za) * (ra * ra + ra * rb + rb * rb)
    };
    let volume = rigid.elements.iter().map(cone).sum::<f64>().abs();
    let mass = body.mass();
    (volume > 0.0 && mass > 0.0 && body.tied_mass == 0.0).then(|| mass / volume)
}
