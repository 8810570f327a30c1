//! Warnings for implausible shots at targets without a mesh: density and yield stress of the target, velocity and mean density
//! of the projectile, in the usual unit systems.

use std::collections::HashSet;
use std::f64::consts::PI;

use super::finding::warn_about;
use super::methods::{LARGEST_FRICTION, report_friction};
use super::plausibility::{InitialVelocity, initial_velocities};
use crate::model::{
    DeckUnits, LoadKind, MaterialDefinition, Model, RigidBody, SYSTEMS, TargetStack, UnitSystem, is_without_units,
};
use crate::plan::{PlannedRigidBody, Report, Scene};

/// Largest plausible initial speed, m/s: that of meteorites.
const LARGEST_SPEED: f64 = 20e3;
/// Extrapolation of a derived law that is accepted, as a fraction of its highest velocity.
const EXTRAPOLATION: f64 = 0.05;
/// Stress above which no projectile is rigid, Pa: the Hugoniot elastic limit of tungsten carbide is 4 to 7 GPa, and rods of
/// hard steel stay rigid in aluminium up to 1.7 km/s, 9 GPa (Piekutowski et al., Int. J. Impact Eng. 23, 1999, 723).
const LARGEST_STRESS: f64 = 12e9;
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

/// Warns of shots for which the resistance law, or a rigid projectile, does not hold: a velocity away from the target, above
/// the range of a derived law, or one whose resistance no projectile withstands.
pub fn check_shots(scene: Scene<'_>, report: &mut Report) {
    let model = scene.model;
    let loads = model.steps.iter().flat_map(|step| &step.loads);
    let (mut checked, mut checked_friction) = (HashSet::new(), HashSet::new());
    for load in loads {
        let LoadKind::Cavity { sides, target, friction } = &load.kind else { continue };
        if *friction > LARGEST_FRICTION && checked_friction.insert(load.span) {
            report_friction(*friction, (load.span, "this load"), report);
        }
        let Some(target) = model.targets.get(target.index()) else { continue };
        let elements: HashSet<usize> = sides.faces.iter().map(|face| face.0).collect();
        for body in model.rigid_bodies.iter().filter(|body| body.elements.iter().any(|e| elements.contains(e))) {
            let mut along =
                initial_velocities(model).filter(|v| v.dof == 2 && v.condition.members.contains(&body.reference));
            if let Some(velocity) = along.next().filter(|_| checked.insert((body.reference, target.span))) {
                let normal = largest_normal(model, &body.elements);
                check_shot(model, &velocity, normal, target, report);
            }
        }
    }
}

/// Returns the largest component along z of the normals of facets: the resistance depends on the normal velocity.
fn largest_normal(model: &Model, elements: &[usize]) -> f64 {
    let component = |&e: &usize| {
        let &[a, b] = &model.mesh.elements[e].nodes[..] else { return 1.0 };
        let [dr, dz] = [0, 1].map(|i| model.mesh.points[b][i] - model.mesh.points[a][i]);
        dr.abs() / libm::hypot(dr, dz)
    };
    elements.iter().map(component).fold(0.0, f64::max)
}

/// Checks the velocity of a projectile; `normal` is the largest normal velocity of its facets over its velocity.
fn check_shot(model: &Model, velocity: &InitialVelocity<'_>, normal: f64, target: &TargetStack, report: &mut Report) {
    let (place, value) = ((velocity.condition.span, "this velocity"), velocity.value);
    let largest = value.abs() * normal;
    if value * target.direction < 0.0 {
        let message = format!(
            "the initial velocity {value:e} leads away from the target `{}`, whose layers follow each other along {}z",
            target.name,
            if target.direction > 0.0 { "+" } else { "-" }
        );
        let help = "check the sign of the velocity, and DIRECTION and FRONT of *TARGET";
        return warn_about("P155", message, place, help, report);
    }
    let materials = target.layers.iter().filter_map(|layer| model.materials.get(layer.material?.index()));
    for material in materials {
        let (Some(cavity), Some(density)) = (&material.cavity, material.density) else { continue };
        let highest = cavity.derived.as_ref().map_or(f64::INFINITY, |derived| derived.range[1]);
        if largest > (1.0 + EXTRAPOLATION) * highest {
            let message = format!(
                "the initial velocity {value:e} has a component {largest:e} normal to the surface, above the range of the resistance of `{}`, which is derived up to {highest:e}",
                material.name
            );
            return warn_about("P155", message, place, "give a higher velocity on *CAVITY EXPANSION, DERIVE", report);
        }
        let x = largest * (density / cavity.yield_stress).sqrt();
        let resistance = cavity.yield_stress * (cavity.a + cavity.b * x + cavity.c * x * x);
        let units = model.settings.units.as_ref().and_then(DeckUnits::system);
        let mut systems = SYSTEMS.iter().filter(|system| {
            units.is_none_or(|known| known == *system) && system.fits_target(density, cavity.yield_stress)
        });
        let pascals = |system: &UnitSystem| system.stress(resistance);
        if let Some(least) = systems.by_ref().map(pascals).reduce(f64::min).filter(|least| *least > LARGEST_STRESS) {
            let message = format!(
                "at the initial velocity the resistance of `{}` is {:.1} GPa, which no projectile withstands without yielding",
                material.name,
                1e-9 * least
            );
            let help = "check velocity and constants; a rigid projectile holds below the velocity at which it erodes (1 to 2 km/s): mesh it";
            return warn_about("P155", message, place, help, report);
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
