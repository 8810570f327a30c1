//! Warnings for implausible input: inconsistent units, unstable fixed increments, very long steps, bodies without
//! loads. Surfaces that face away are checked in `contact/analytical.rs`, overlapping bodies in `overlaps.rs`.

use std::collections::HashSet;

use crate::deck::Diagnostic;
use crate::model::{
    DeckUnits, Element, IncrementControl, InitialCondition, InitialKind, MaterialDefinition, Model, SYSTEMS,
    SolidSection, Step, UnitSystem, is_without_units,
};
use crate::plan::checks::amplitudes::check_amplitudes;
use crate::plan::checks::blasts::check_blasts;
use crate::plan::checks::equations_of_state::check_detonation_times;
use crate::plan::checks::methods::check_methods;
use crate::plan::checks::targets::{check_shots, check_targets};
use crate::plan::checks::unit_systems::check_unit_systems;
use crate::plan::checks::values::check_values;
use crate::plan::{Report, Scene, State};

/// Ratio of an initial velocity to the speed of sound above which inconsistent units are assumed.
const TOO_FAST: f64 = 3.0;
/// Number of element updates of a step above which a mistake is assumed; they take hours on any machine.
const TOO_MANY: f64 = 1e12;

/// Returns a warning (P119) if density and Young's modulus of a material are not plausible for a solid in any usual unit
/// system, or in that of `*UNITS`.
pub fn unit_warning(material: &MaterialDefinition, units: Option<&DeckUnits>) -> Option<Diagnostic> {
    let unit_system = units.and_then(DeckUnits::system);
    let ([modulus, _], density) = (material.elastic?, material.density?);
    let fits = |system: &UnitSystem| system.fits(density, modulus);
    if unit_system.is_none() && is_without_units(density) || unit_system.map_or_else(|| SYSTEMS.iter().any(fits), fits)
    {
        return None;
    }
    let speed = (modulus / density).sqrt();
    let whose = unit_system.map_or_else(|| "any usual unit system".into(), |s| format!("the units {}", s.words()));
    let message = format!(
        "density {density:e} and Young's modulus {modulus:e} of `{}` (wave speed {speed:.3e}) are \
         not plausible for a solid in {whose}",
        material.name
    );
    let finding = Diagnostic::warning("P119", message).at(material.span, "this material");
    Some(finding.help(suggested_units(density, modulus)))
}

pub fn check_plausibility(scene: Scene, state: &State, report: &mut Report) {
    check_targets(scene, report);
    check_shots(scene, report);
    check_blasts(scene.model, report);
    check_amplitudes(scene.model, report);
    if state.elements.is_empty() {
        let stable = state.elements.stable_increment();
        check_increments_of_springs(scene.model, stable, report);
        check_period_of_springs(scene.model, stable, report);
        return;
    }
    check_units(scene.model, report);
    check_unit_systems(scene.model, report);
    check_detonation_times(scene.model, report);
    check_methods(scene.model, report);
    check_values(scene.model, report);
    check_initial_speed(scene.model, report);
    if let Some((time, element)) = shortest_wave_transit(scene.model) {
        check_given_increments(scene.model, time, element, report);
        check_step_length(scene.model, time, element, report);
    }
    check_free_motion(scene, report);
}

/// Returns the longitudinal wave speed of an elastic material.
fn wave_speed(model: &Model, section: &SolidSection) -> Option<f64> {
    let material = model.materials.get(section.material.index())?;
    let ([e, nu], density) = (material.elastic?, material.density?);
    Some((e * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu) * density)).sqrt())
}

/// Warns once of each material of a section whose density and Young's modulus are not plausible together.
fn check_units(model: &Model, report: &mut Report) {
    let units = model.settings.units.as_ref();
    let mut checked = HashSet::new();
    let sections = model.sections.iter().filter(|section| checked.insert(section.material));
    let materials = sections.filter_map(|section| model.materials.get(section.material.index()));
    materials.filter_map(|material| unit_warning(material, units)).for_each(|finding| report.push(finding));
}

/// An initial velocity along a degree of freedom.
pub struct InitialVelocity<'m> {
    pub condition: &'m InitialCondition,
    pub dof: u8,
    pub value: f64,
}

/// Iterates over the initial velocities along the axes.
pub fn initial_velocities(model: &Model) -> impl Iterator<Item = InitialVelocity<'_>> {
    model.initial_conditions.iter().filter_map(|condition| match condition.kind {
        InitialKind::Velocity(dof, value) if dof <= 2 => Some(InitialVelocity { condition, dof, value }),
        _ => None,
    })
}

fn check_initial_speed(model: &Model, report: &mut Report) {
    let mut too_fast = None;
    for section in &model.sections {
        let Some(sound) = wave_speed(model, section) else { continue };
        let mut fast = initial_velocities(model).filter(|v| v.value.abs() > TOO_FAST * sound).peekable();
        if fast.peek().is_none() {
            continue;
        }
        let mut nodes: Vec<usize> = nodes_of(model, &section.elements);
        nodes.sort_unstable();
        nodes.dedup();
        let meets = |c: &InitialCondition| c.members.iter().any(|n| nodes.binary_search(n).is_ok());
        if let Some(InitialVelocity { condition, value, .. }) = fast.find(|velocity| meets(velocity.condition)) {
            too_fast = Some((condition.span, value, sound, &model.materials[section.material]));
            break;
        }
    }
    let Some((span, velocity, sound, material)) = too_fast else { return };
    let message = format!(
        "the initial velocity {velocity:e} is {:.0} times the speed of sound in `{}`, {sound:.3e}: check the units of density, \
         moduli, lengths and time",
        velocity.abs() / sound,
        material.name
    );
    let finding = Diagnostic::warning("P105", message).at(span, "this velocity");
    let finding = finding.at(material.span, "this material");
    report.push(finding.help("use m, kg, s and Pa, or mm, t, s and MPa (steel: 7.85e-9 t/mm3, 210e3 MPa)"));
}

fn nodes_of(model: &Model, elements: &[usize]) -> Vec<usize> {
    elements.iter().flat_map(|&e| model.mesh.elements[e].nodes.iter().copied()).collect()
}

/// Returns the shortest time in which a wave crosses an element, and the element.
fn shortest_wave_transit(model: &Model) -> Option<(f64, &Element)> {
    let mut smallest: Option<(f64, &Element)> = None;
    for section in &model.sections {
        let Some(sound) = wave_speed(model, section) else { continue };
        for &element in &section.elements {
            let time = model.mesh.side_lengths(element)[0] / sound;
            if smallest.is_none_or(|s| time < s.0) {
                smallest = Some((time, &model.mesh.elements[element]));
            }
        }
    }
    smallest
}

/// Warns if a fixed time increment is longer than the shortest time in which a wave crosses an element.
fn check_given_increments(model: &Model, time: f64, element: &Element, report: &mut Report) {
    if !model.scales_masses() {
        warn_of_long_increment(model, time, format!("a wave crosses element {} in {time:.2e}", element.name), report);
    }
}

/// Warns of fixed increments above the stable time increment of springs and dashpots, in a model without elements.
fn check_increments_of_springs(model: &Model, stable: f64, report: &mut Report) {
    let reason = format!("the stable time increment of the springs and dashpots is {stable:.4e}");
    warn_of_long_increment(model, stable, reason, report);
}

/// Warns if a model of springs without elements runs for less than a quarter of its shortest period, π/2 of the stable time
/// increment over 2.
fn check_period_of_springs(model: &Model, stable: f64, report: &mut Report) {
    let quarter = 0.25 * std::f64::consts::PI * stable;
    let end: f64 = model.steps.iter().map(|step| step.duration).sum();
    let Some(step) =
        model.steps.first().filter(|_| !model.discrete.connectors.is_empty() && quarter.is_finite() && end < quarter)
    else {
        return;
    };
    let message = format!(
        "the analysis ends at {end:.4e}, before a quarter of the shortest natural period of the springs and masses, {quarter:.4e}"
    );
    let finding = Diagnostic::warning("P157", message).at(step.span, "this step");
    report.push(finding.help("check the units of stiffness and mass, and the length of the step"));
}

/// Warns of the first fixed increment above `stable`.
fn warn_of_long_increment(model: &Model, stable: f64, reason: String, report: &mut Report) {
    let mut fixed_increments = model.steps.iter().filter_map(|s| match s.increment {
        IncrementControl::Fixed(dt) => Some((s.span, dt)),
        IncrementControl::Automatic { .. } => None,
    });
    let Some((span, dt)) = fixed_increments.find(|(_, dt)| *dt > stable) else { return };
    let message = format!("the fixed time increment {dt:e} is not stable: {reason}");
    let finding = Diagnostic::warning("P106", message).at(span, "DIRECT USER CONTROL");
    report.push(finding.help("remove DIRECT USER CONTROL, or give a smaller increment"));
}

/// Warns of a step with more element updates than [`TOO_MANY`].
fn check_step_length(model: &Model, time: f64, element: &Element, report: &mut Report) {
    let count = model.sections.iter().map(|s| s.elements.len()).sum::<usize>();
    let increments = |s: &Step| match s.increment {
        IncrementControl::Fixed(dt) => s.duration / dt,
        IncrementControl::Automatic { .. } => s.duration / time,
    };
    let endless = |s: &&Step| s.mass_scalings.is_empty() && increments(s) * count as f64 > TOO_MANY;
    let Some(step) = model.steps.iter().find(endless) else { return };
    let message = format!(
        "step `{}` of duration {:e} is very long: a wave crosses element {} in {time:.1e}, about {:.0e} increments of {count} elements",
        step.name,
        step.duration,
        element.name,
        increments(step)
    );
    let finding = Diagnostic::warning("P113", message).at(step.span, "this step");
    let help = "check that its time is in the units of density and moduli; use a shorter step, a coarser mesh or *FIXED MASS SCALING";
    report.push(finding.help(help));
}

/// Warns if deformable bodies have a uniform initial velocity, and no boundary condition, load or contact.
fn check_free_motion(scene: Scene, report: &mut Report) {
    let model = scene.model;
    let free = model.rigid_bodies.is_empty()
        && model.targets.is_empty()
        && model.constraints.equations.is_empty()
        && !model.has_equation_of_state()
        && model.mesh.elements.iter().all(|e| e.kind.is_solid() && !e.kind.is_thermal())
        && model.steps.iter().all(|s| s.boundaries.is_empty() && s.loads.is_empty() && !s.has_contact());
    let is_simple = |c: &InitialCondition| matches!(c.kind, InitialKind::Velocity(..) | InitialKind::Temperature(_));
    let everywhere = |c: &InitialCondition| {
        let members: HashSet<usize> = c.members.iter().copied().collect();
        scene.places.nodes.keys().all(|n| members.contains(&n))
    };
    if !free || !model.initial_conditions.iter().all(is_simple) {
        return;
    }
    let (mut moving, mut whole) = (None, true);
    for InitialVelocity { condition, dof, .. } in initial_velocities(scene.model).filter(|v| v.value != 0.0) {
        whole &= dof == 2 && condition.members.len() >= scene.places.nodes.len() && everywhere(condition);
        moving = Some(condition.span);
    }
    let Some(span) = moving.filter(|_| whole) else { return };
    let message =
        "no boundary condition, load or contact acts on the deformable body: it will move at constant velocity";
    let finding = Diagnostic::warning("P109", message).at(span, "this velocity remains constant");
    report.push(finding.help("add a *BOUNDARY, a load or a *CONTACT PAIR"));
}

/// Suggests units: the density and modulus of steel in the unit systems that fit the density or the modulus.
fn suggested_units(density: f64, modulus: f64) -> String {
    const STEEL: [f64; 2] = [7850.0, 2.1e11];
    let like = |system: &UnitSystem| {
        let [length, mass, time] = system.factors;
        [STEEL[0] * length.powi(3) / mass, STEEL[1] * length * time * time / mass]
    };
    let near = |a: f64, b: f64| (0.05..20.0).contains(&(a / b));
    let systems = SYSTEMS.iter().filter(|s| near(density, like(s)[0]) || near(modulus, like(s)[1]));
    let suggestions: Vec<String> =
        systems.map(|s| format!("{}: steel has {:.3e} and {:.3e}", s.words(), like(s)[0], like(s)[1])).collect();
    if suggestions.is_empty() { "check the units of density and modulus".into() } else { suggestions.join("; ") }
}
