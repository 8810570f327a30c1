//! Loads of a step, on rigid and on deformable bodies.

pub mod amplitudes;
pub mod targets;

use std::collections::HashSet;

use indexmap::IndexMap;

use crate::deck::Diagnostic;
use crate::kernel::amplitude::AmplitudeCurve;
use crate::kernel::blast_wave::BurstShape;
use crate::kernel::lists::sorted_unique;
use crate::kernel::quad::corner_masses;
use crate::kernel::solid;
use crate::load::blast::{BlastLoad, BlastSource};
use crate::load::body_force::{BodyForceField, CentrifugalField};
use crate::load::concentrated::ConcentratedForces;
use crate::load::gravity::GravityField;
use crate::load::prescribed::{LoadDistribution, PrescribedLoad};
use crate::load::pressure::PressureField;
use crate::load::traction::{ReferenceMotion, TractionField, TractionLaw};
use crate::load::user_load::{LoadedVolume, RigidSolid, SubroutineLoad, UserLoadData};
use crate::load::{EnergyAccount, GeneralizedForce, Load as Effect};
use crate::model::{
    AmplitudeDefinition, AmplitudeId, BlastCharge, BodyForce, ElementKind, Load, LoadKind, Model, SideSelection, Step,
    SurfaceTraction,
};
use crate::plan::bodies::rigid_bodies_3d::refuse_on_spatial_body;
use crate::plan::loads::amplitudes::user_amplitude;
use crate::plan::loads::targets::cavity_load;
use crate::plan::meshes::surfaces::load_surface;
use crate::plan::solids::cohesive::add_masses_of_cohesive_elements;
use crate::plan::solids::shells::add_masses_of_shells;
use crate::plan::{Links, PlannedRigidBody, Report, Scene, State};
use crate::state::EffectId;
use crate::state::magnitude::{Magnitude, TimeFunction};
use crate::user::LoadProperties;

/// Names of the components of forces and moments on oblique bodies.
const COMPONENTS: [&str; 6] = ["F_1", "F_2", "F_3", "M_1", "M_2", "M_3"];

/// The effect of a load; `None` if it has none, or after an error.
pub type LoadEffect = Option<Box<dyn Effect>>;

/// A load of a step, and the products on which its effect depends.
pub struct LoadInput<'a> {
    pub scene: Scene<'a>,
    pub links: &'a Links,
    pub load: &'a Load,
    pub step: &'a Step,
    pub state: &'a State,
}

/// Returns whether a load has an effect. A load of zero magnitude is listed as unused.
pub fn has_effect(load: &Load, report: &mut Report) -> bool {
    let varies = load.kind.is_user() || matches!(load.kind, LoadKind::Cavity { .. } | LoadKind::Film { .. });
    let zero = !varies && load.magnitude == 0.0;
    if zero {
        report.add_unused_card(load.span, kind_name(&load.kind), "its magnitude is zero");
    }
    !zero
}

/// Creates the effect of a load; `None` if it has no effect or is unsupported, which is reported.
pub fn create_load(input: &LoadInput, report: &mut Report) -> LoadEffect {
    let load = input.load;
    if !has_effect(load, report) {
        return None;
    }
    match &load.kind {
        LoadKind::Concentrated { nodes, dof, set } => concentrated_load(input, nodes, *dof, set, report),
        LoadKind::Gravity { elements, direction } => gravity_load(input, elements.as_deref(), *direction, report),
        LoadKind::Pressure(sides) => pressure_load(input, sides, report),
        LoadKind::Traction { sides, law } => traction_load(input, sides, law, report),
        LoadKind::Blast { sides, charge, height, detonation } => {
            blast_load(input, sides, charge, [*height, *detonation], report)
        }
        LoadKind::Body { elements, set, law } => body_force_load(input, elements, set, *law, report),
        LoadKind::User { sides, load_type } => user_load(input, sides, *load_type, report),
        LoadKind::UserBody { elements, set, load_type } => user_body_force(input, elements, set, *load_type, report),
        LoadKind::Cavity { sides, target, friction } => cavity_load(input, sides, *target, *friction, report),
        // Heat loads are created in `heat/mod.rs`.
        LoadKind::NodalHeat { .. } | LoadKind::SurfaceHeat(_) | LoadKind::BodyHeat { .. } | LoadKind::Film { .. } => {
            None
        }
    }
}

pub fn magnitude(scene: Scene, value: f64, amplitude: Option<AmplitudeId>, report: &mut Report) -> Magnitude {
    let Some(id) = amplitude else { return Magnitude::constant(value) };
    let shape = match &scene.model.amplitudes[id].definition {
        AmplitudeDefinition::Curve { points, smooth, total_time } => {
            TimeFunction::Curve(AmplitudeCurve::new(points.clone(), *smooth, *total_time))
        }
        AmplitudeDefinition::User { .. } => TimeFunction::Sampled(user_amplitude(scene, id, report)),
    };
    Magnitude { value, shape }
}

/// Creates a load from its distribution.
fn prescribed_load(
    input: &LoadInput,
    id: EffectId,
    distribution: impl LoadDistribution,
    report: &mut Report,
) -> LoadEffect {
    let LoadInput { scene, load, .. } = *input;
    let magnitude = magnitude(scene, load.magnitude, load.amplitude, report);
    Some(Box::new(PrescribedLoad { id, magnitude, distribution }))
}

fn concentrated_load(input: &LoadInput, nodes: &[usize], dof: u8, set: &str, report: &mut Report) -> LoadEffect {
    let LoadInput { scene, links, load, .. } = *input;
    let turning: Vec<usize> = nodes.iter().filter_map(|n| scene.places.rotations.get(n).copied()).collect();
    if dof == 6 && !turning.is_empty() {
        let detail = format!("M = {}{}", load.magnitude, amplitude_name(scene.model, load));
        let id = report.ledger_row(load.span, "concentrated moment", turning.len(), "nodes", detail);
        let moments = ConcentratedForces { bodies: Vec::new(), spatial: Vec::new(), nodes: turning, dof: 0 };
        return prescribed_load(input, id, moments, report);
    }
    let (mut bodies, mut deforming, mut stray) = (Vec::new(), Vec::new(), false);
    let mut spatial = Vec::new();
    for node in nodes {
        match (scene.places.free_node(*node), scene.bodies.of_node.get(node)) {
            (Some(solver_node), _) => deforming.push(solver_node),
            (_, Some(&body)) if scene.bodies.list[body].spatial => {
                spatial.push((body, scene.model.mesh.points[*node][1]))
            }
            (_, Some(&body)) => bodies.push(body),
            _ => stray = true,
        }
    }
    if stray {
        let message = format!("a force acts on nodes of `{set}` that belong to no body");
        report.push(Diagnostic::error("P003", message).at(load.span, "here"));
    }
    if dof != 2 && !bodies.is_empty() {
        report.add_unused_card(load.span, "*CLOAD", "a rigid body of revolution moves along z only");
        bodies.clear();
    }
    if dof > 2 && !deforming.is_empty() {
        report.add_unused_card(load.span, "*CLOAD", "nodes of a body of revolution move along r and z only");
        deforming.clear();
    }
    let count = bodies.len() + spatial.len() + deforming.len();
    if count == 0 {
        return None;
    }
    let axis = usize::from(dof) - 1;
    let along =
        if spatial.is_empty() { ["F_r", "F_z"].get(axis).copied().unwrap_or_default() } else { COMPONENTS[axis] };
    if deforming.iter().any(|&n| links.unresisted_dofs.contains(&(n, axis))) {
        let message = format!(
            "a force acts on `{set}`, which has no mass and to which no mass is coupled along {}",
            ["r", "z"][axis]
        );
        let finding = Diagnostic::error("P062", message).at(load.span, "here");
        report.push(finding.help("couple this degree of freedom, or put a *MASS on the node"));
    }
    let detail = format!("{along} = {}{}", load.magnitude, amplitude_name(scene.model, load));
    let id = report.ledger_row(load.span, "concentrated force", count, "nodes", detail);
    let forces = ConcentratedForces { bodies, spatial, nodes: deforming, dof: axis };
    prescribed_load(input, id, forces, report)
}

fn gravity_load(input: &LoadInput, elements: Option<&[usize]>, direction: [f64; 3], report: &mut Report) -> LoadEffect {
    let LoadInput { scene, load, state, .. } = *input;
    let axial = load.magnitude * direction[1];
    let in_space = scene.bodies.list.iter().any(|b| b.spatial);
    if axial == 0.0 && !in_space {
        let why = "it has no component along z, and bodies of revolution move along z only";
        report.add_unused_card(load.span, "GRAV", why);
        return None;
    }
    let (bodies, count) = forces_of_gravity(input, elements, direction, report);
    let nodes: Vec<(usize, f64)> = match elements {
        None => {
            let masses = state.dofs.nodes.mass.iter().copied().enumerate().filter(|m| m.1 > 0.0);
            // Rotations follow all nodes in the list; their mass is a rotary inertia.
            masses.take_while(|(n, _)| *n < scene.places.nodes.len()).collect()
        }
        Some(list) => masses_of(scene, list),
    };
    if count == 0 && nodes.is_empty() {
        report.push(Diagnostic::error("P003", "gravity acts on elements that belong to no body").at(load.span, "here"));
    }
    let detail = match (in_space, direction) {
        (true, [a, b, c]) => {
            let [a, b, c] = [a, b, c].map(|d| load.magnitude * d + 0.0);
            format!("a = ({a}, {b}, {c}){}", amplitude_name(scene.model, load))
        }
        (false, _) => format!("a_z = {axial}{}", amplitude_name(scene.model, load)),
    };
    let (count, unit) = if nodes.is_empty() { (count, "bodies") } else { (count + nodes.len(), "nodes") };
    let id = report.ledger_row(load.span, "gravity", count, unit, detail);
    let field = GravityField { bodies, nodes, whole: elements.is_none(), along_z: direction[1] };
    prescribed_load(input, id, field, report)
}

/// Returns the generalised forces of gravity on rigid bodies, each with its mass times the direction component, and
/// the number of bodies.
fn forces_of_gravity(
    input: &LoadInput,
    elements: Option<&[usize]>,
    direction: [f64; 3],
    report: &mut Report,
) -> (Vec<(GeneralizedForce, f64)>, usize) {
    let LoadInput { scene, load, .. } = *input;
    let (mut forces, mut count) = (Vec::new(), 0);
    for index in 0..scene.bodies.list.len() {
        let body = &scene.bodies.list[index];
        let Some(mass) = gravity_mass(scene.model, body, elements) else { continue };
        count += 1;
        if !body.spatial {
            forces.push((GeneralizedForce::along_z(index, EnergyAccount::Work), mass * direction[1]));
        } else if mass == body.mass() {
            let along = GeneralizedForce::in_space(index, EnergyAccount::Work).zip(direction);
            forces.extend(along.map(|(force, component)| (force, mass * component)));
        } else {
            refuse_on_spatial_body(load.span, &body.name, "gravity on a part of its mass", report);
        }
    }
    (forces, count)
}

/// Returns the mass of a rigid body on which gravity acts: the total mass without an element set, the own mass if
/// one of its elements is in the set, or the point masses in the set.
fn gravity_mass(model: &Model, body: &PlannedRigidBody, elements: Option<&[usize]>) -> Option<f64> {
    let Some(list) = elements else { return Some(body.mass()) };
    // The mass of tied elements is added at their nodes.
    if body.elements.iter().any(|e| list.contains(e)) {
        return Some(body.own_mass());
    }
    let mesh = &model.mesh;
    let points = list.iter().filter(|&&e| mesh.elements[e].kind == ElementKind::Mass);
    let on: Vec<usize> = sorted_unique(points.map(|&e| mesh.elements[e].nodes[0]).filter(|n| body.nodes.contains(n)));
    let mass: f64 = model.discrete.masses.iter().filter(|p| on.contains(&p.node)).map(|p| p.mass).sum();
    (mass > 0.0).then_some(mass)
}

fn masses_of(scene: Scene, elements: &[usize]) -> Vec<(usize, f64)> {
    let mesh = &scene.model.mesh;
    let mut masses: IndexMap<usize, f64> = IndexMap::new();
    for section in &scene.model.sections {
        let density = scene.model.materials[section.material].density.unwrap_or(0.0);
        let section_elements: HashSet<usize> = section.elements.iter().copied().collect();
        for &e in elements.iter().filter(|e| section_elements.contains(*e) && scene.places.elements.contains_key(e)) {
            for cell in mesh.cells(e) {
                for (n, mass) in cell.iter().zip(corner_masses(cell.map(|n| mesh.points[n]), density)) {
                    *masses.entry(scene.places.nodes[n]).or_default() += mass;
                }
            }
        }
    }
    add_masses_of_shells(scene, elements, &mut masses);
    add_masses_of_cohesive_elements(scene, elements, &mut masses);
    masses.into_iter().collect()
}

fn pressure_load(input: &LoadInput, sides: &SideSelection, report: &mut Report) -> LoadEffect {
    let LoadInput { scene, load, state, .. } = *input;
    let surface = load_surface(scene, sides, load.span, report);
    let detail = format!("on {}, p = {}{}", sides.name, load.magnitude, amplitude_name(scene.model, load));
    let id = report.ledger_row(load.span, "pressure", surface.count(), "facets", detail);
    prescribed_load(input, id, PressureField::new(surface, &state.dofs), report)
}

fn traction_load(input: &LoadInput, sides: &SideSelection, law: &SurfaceTraction, report: &mut Report) -> LoadEffect {
    let LoadInput { scene, load, .. } = *input;
    let surface = load_surface(scene, sides, load.span, report);
    let oblique = surface.patches.iter().find(|patch| scene.bodies.list[patch.body].spatial);
    if let Some(patch) = oblique {
        let what = "a surface traction or viscous pressure";
        refuse_on_spatial_body(load.span, &scene.bodies.list[patch.body].name, what, report);
        return None;
    }
    let (law, how) = match *law {
        SurfaceTraction::Vector { direction, follows: true } => (
            TractionLaw::Following(direction),
            format!("along ({}, {}), rotates with the surface", direction[0], direction[1]),
        ),
        SurfaceTraction::Vector { direction, follows: false } => {
            (TractionLaw::Fixed(direction), format!("along ({}, {})", direction[0], direction[1]))
        }
        SurfaceTraction::Shear { direction } => (TractionLaw::Shear(direction), "along the surface".into()),
        SurfaceTraction::Viscous { reference } => {
            (TractionLaw::Viscous(reference_motion(input, reference, report)?), "against the normal velocity".into())
        }
        SurfaceTraction::Absorbing { shear_ratio } => (
            TractionLaw::Absorbing { shear_ratio },
            format!("against the normal velocity, {} along the face", load.magnitude * shear_ratio),
        ),
    };
    let detail = format!("on {}, {} {how}{}", sides.name, load.magnitude, amplitude_name(scene.model, load));
    let effect = if matches!(law, TractionLaw::Absorbing { .. }) { "infinite elements" } else { "surface traction" };
    let id = report.ledger_row(load.span, effect, surface.count(), "facets", detail);
    prescribed_load(input, id, TractionField::new(surface, law), report)
}

fn blast_load(
    input: &LoadInput,
    sides: &SideSelection,
    charge: &BlastCharge,
    [height, detonation]: [f64; 2],
    report: &mut Report,
) -> LoadEffect {
    let LoadInput { scene, load, state, .. } = *input;
    let surface = load_surface(scene, sides, load.span, report);
    let oblique = surface.patches.iter().find(|patch| scene.bodies.list[patch.body].spatial);
    if let Some(patch) = oblique {
        refuse_on_spatial_body(load.span, &scene.bodies.list[patch.body].name, "a blast", report);
        return None;
    }
    let (shape, scale) = (charge.shape, load.magnitude);
    let source = BlastSource { shape, mass: charge.mass, height, detonation, units: charge.units, scale };
    let middle = |face: &[usize; 2]| {
        let [a, b] = face.map(|n| state.dofs.nodes.start[n]);
        [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])]
    };
    let facets = surface.patches.iter().flat_map(|patch| &patch.facets).map(|(_, facet)| facet.middle());
    let scaled = surface.skin.faces.iter().map(middle).chain(facets).map(|place| source.scaled_distance(place));
    let [nearest, farthest] = scaled.fold([f64::INFINITY, 0.0_f64], |[a, b], z| [a.min(z), b.max(z)]);
    let [from, to] = shape.range();
    if nearest < from || farthest > to {
        let message = format!(
            "the scaled distances of `{}`, {nearest:.3} to {farthest:.3} m/kg^(1/3), are not within {from} to {to}",
            sides.name
        );
        let help = "the measurements of Kingery and Bulmash cover this range; check the second line of *CONWEP CHARGE \
                    PROPERTY, which converts the units of the model to metres, seconds and pascals";
        report.push(Diagnostic::error("P025", message).at(load.span, "this surface").help(help));
        return None;
    }
    let how = if shape == BurstShape::Spherical { "in free air" } else { "on the ground" };
    let detail =
        format!("on {}, {} kg of TNT {how}, {nearest:.3} to {farthest:.3} m/kg^(1/3)", sides.name, charge.mass);
    let id = report.ledger_row(load.span, "blast", surface.count(), "facets", detail);
    Some(Box::new(BlastLoad::new(id, surface, source, &state.dofs.nodes)))
}

fn reference_motion(input: &LoadInput, node: Option<usize>, report: &mut Report) -> Option<ReferenceMotion> {
    let LoadInput { scene, load, .. } = *input;
    let Some(node) = node else { return Some(ReferenceMotion::AtRest) };
    if let Some(&body) = scene.bodies.of_node.get(&node) {
        return Some(ReferenceMotion::Body(body));
    }
    let motion = scene.places.free_node(node).map(ReferenceMotion::Node);
    if motion.is_none() {
        let message = format!("REF NODE {} belongs to no body", scene.model.mesh.node_names[node]);
        report.push(Diagnostic::error("P003", message).at(load.span, "this load"));
    }
    motion
}

/// Creates `BR`, `BZ` and `CENTRIF` loads.
fn body_force_load(
    input: &LoadInput,
    elements: &[usize],
    set: &str,
    law: BodyForce,
    report: &mut Report,
) -> LoadEffect {
    let LoadInput { scene, load, .. } = *input;
    let magnitude = magnitude(scene, load.magnitude, load.amplitude, report);
    if law == BodyForce::Centrifugal {
        let nodes = masses_of(scene, elements);
        if nodes.is_empty() {
            report.add_unused_card(load.span, "CENTRIF", "none of its elements is deformable");
            return None;
        }
        let detail = format!("on {set}, omega^2 = {}{}", load.magnitude, amplitude_name(scene.model, load));
        let id = report.ledger_row(load.span, "centrifugal force", nodes.len(), "nodes", detail);
        return Some(Box::new(PrescribedLoad { id, magnitude, distribution: CentrifugalField { nodes } }));
    }
    let axis = usize::from(law == BodyForce::Axial);
    let volume = loaded_volume(input, elements, set, axis, report)?;
    let along = ["r", "z"][axis];
    let detail = format!("on {set}, {} per volume along {along}{}", load.magnitude, amplitude_name(scene.model, load));
    let count = volume.rigid.len() + volume.cells.len();
    let id = report.ledger_row(load.span, "body force", count, "elements", detail);
    let whole = |part: &[RigidSolid]| (part[0].body, part.iter().map(|solid| solid.volume).sum());
    let bodies = volume.rigid.chunk_by(|a, b| a.body == b.body).map(whole).collect();
    let distribution = BodyForceField { axis, cells: volume.cells, bodies };
    Some(Box::new(PrescribedLoad { id, magnitude, distribution }))
}

/// Creates `PNU` and `P1NU` to `P4NU` loads.
fn user_load(input: &LoadInput, sides: &SideSelection, load_type: i32, report: &mut Report) -> LoadEffect {
    let LoadInput { scene, load, state, .. } = *input;
    let surface = load_surface(scene, sides, load.span, report);
    // ABAQUS manual: normals point outwards on the loaded side of a surface element, and into a solid.
    let inward = sides.faces.first().is_some_and(|f| !scene.model.mesh.elements[f.0].kind.is_line());
    let load = user_load_description(input, ("user load", surface.count()), &sides.name, load_type, inward, report)?;
    Some(Box::new(SubroutineLoad::on_surface(load, &surface, &state.dofs)))
}

/// Creates `BRNU` and `BZNU` loads.
fn user_body_force(
    input: &LoadInput,
    elements: &[usize],
    set: &str,
    load_type: i32,
    report: &mut Report,
) -> LoadEffect {
    let volume = loaded_volume(input, elements, set, if load_type == 1 { 0 } else { 1 }, report)?;
    let count = volume.rigid.len() + volume.cells.len();
    let load = user_load_description(input, ("user body force", count), set, load_type, false, report)?;
    Some(Box::new(SubroutineLoad::on_volume(load, &volume)))
}

/// Returns the volume on which a body force along an axis acts. The point of a rigid solid is its centre, its weight
/// the volume. `None` if the force acts on nothing.
fn loaded_volume(
    input: &LoadInput,
    elements: &[usize],
    set: &str,
    axis: usize,
    report: &mut Report,
) -> Option<LoadedVolume> {
    let LoadInput { scene, load, .. } = *input;
    let mesh = &scene.model.mesh;
    let (mut volume, mut stray) = (LoadedVolume::default(), None);
    for &element in elements {
        if scene.places.elements.contains_key(&element) {
            volume.cells.extend(mesh.cells(element).map(|cell| cell.map(|n| scene.places.nodes[&n] as u32)));
            continue;
        }
        let corners: Vec<[f64; 2]> = mesh.elements[element].nodes.iter().map(|&n| mesh.points[n]).collect();
        match scene.bodies.of_element.get(&element) {
            Some(&body) if scene.bodies.list[body].spatial => {
                refuse_on_spatial_body(load.span, &scene.bodies.list[body].name, "a body force", report);
                return None;
            }
            Some(&body) if corners.len() > 2 => {
                let (centre, solid_volume) = (solid::centre(&corners), solid::volume(&corners));
                volume.rigid.push(RigidSolid { body, element, centre, volume: solid_volume });
            }
            _ => stray = stray.or(Some(element)),
        }
    }
    if let Some(element) = stray {
        let message =
            format!("`{set}` contains element {}, which is not a solid element of a body", mesh.elements[element].name);
        report.push(Diagnostic::error("P003", message).at(load.span, "a body force needs solid elements"));
    }
    if axis == 0 && !volume.rigid.is_empty() {
        report.add_unused_card(load.span, kind_name(&load.kind), "a rigid body of revolution moves along z only");
        volume.rigid.clear();
    }
    volume.rigid.sort_by_key(|solid| solid.body);
    let acts = !volume.rigid.is_empty() || !volume.cells.is_empty();
    acts.then_some(volume)
}

fn user_load_description(
    input: &LoadInput,
    (effect, count): (&'static str, usize),
    name: &str,
    load_type: i32,
    inward: bool,
    report: &mut Report,
) -> Option<UserLoadData> {
    let LoadInput { scene, load, .. } = *input;
    let asks = format!("the load on `{name}` is user-defined (PNU)");
    report.require_routine(load.span, "load", &asks, "vdload")?;
    let properties = load_properties(report)?;
    if load.magnitude != 1.0 && !properties.reads_magnitude {
        let what = format!("magnitude {} of {}", load.magnitude, kind_name(&load.kind));
        report.add_unused_card(load.span, what, "VDLOAD defines the load; it is not multiplied by the magnitude");
    }
    let detail = format!("on {name}{}", amplitude_name(scene.model, load));
    let id = report.ledger_row(load.span, effect, count, "points", detail);
    let magnitude = magnitude(scene, load.magnitude, load.amplitude, report);
    let LoadProperties { reads_motion, memory, .. } = properties;
    Some(UserLoadData { id, name: name.to_uppercase(), load_type, inward, magnitude, reads_motion, memory })
}

/// Returns the properties of the user load; a load that a run has locked is not asked again.
fn load_properties(report: &mut Report) -> Option<LoadProperties> {
    let ask = || report.routines.load.as_ref()?.lock().as_deref_mut().map(|load| LoadProperties::of(load));
    let properties = report.routines.load_properties.or(report.shared.load_properties).or_else(ask);
    report.shared.load_properties = properties;
    properties
}

pub fn amplitude_name(model: &Model, load: &Load) -> String {
    load.amplitude.map_or(String::new(), |a| format!(" x {}", model.amplitudes[a].name))
}

pub fn kind_name(kind: &LoadKind) -> &'static str {
    match kind {
        LoadKind::Concentrated { .. } => "*CLOAD",
        LoadKind::Gravity { .. } => "GRAV",
        LoadKind::Pressure(_) => "P",
        LoadKind::Traction { law, .. } => match law {
            SurfaceTraction::Vector { .. } => "TRVEC",
            SurfaceTraction::Shear { .. } => "TRSHR",
            SurfaceTraction::Viscous { .. } => "VP",
            SurfaceTraction::Absorbing { .. } => "infinite elements",
        },
        LoadKind::Blast { .. } => "CONWEP",
        LoadKind::Body { law, .. } => match law {
            BodyForce::Radial => "BR",
            BodyForce::Axial => "BZ",
            BodyForce::Centrifugal => "CENTRIF",
        },
        LoadKind::User { .. } => "PNU",
        LoadKind::UserBody { .. } => "BRNU or BZNU",
        LoadKind::Cavity { .. } => "CAVITY",
        LoadKind::NodalHeat { .. } => "*CFLUX",
        LoadKind::SurfaceHeat(_) | LoadKind::BodyHeat { .. } => "*DFLUX",
        LoadKind::Film { .. } => "*FILM",
    }
}
