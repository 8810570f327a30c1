//! Contact of oblique rigid bodies (six degrees of freedom) with fixed analytical surfaces.

use crate::constraint::Constraint;
use crate::constraint::rigid_wall_contact::{RigidWallContact, WallPair};
use crate::kernel::lists::sorted_unique;
use crate::model::SurfaceContact;
use crate::plan::bodies::rigid_bodies_3d::refuse_on_spatial_body;
use crate::plan::contact::analytical::{friction_of, warn_of_front};
use crate::plan::contact::general::pair_name;
use crate::plan::{Bodies, Report, StepInput};
use crate::platform::PortableMath as _;

/// Returns the oblique rigid body of a pair and its side (0 or 1).
pub fn spatial_side(bodies: &Bodies, pair: &SurfaceContact) -> Option<(usize, usize)> {
    let spatial = |body: &usize| bodies.list[*body].spatial;
    let of_side = |side: usize| {
        let faces = pair.sides[side].faces.iter();
        let of_faces = faces.filter_map(|f| bodies.of_element.get(&f.0)).find(|b| spatial(b)).copied();
        let nodes = pair.analytical.iter().filter(|a| a.side != side).flat_map(|a| &a.nodes);
        of_faces.or_else(|| nodes.filter_map(|n| bodies.of_node.get(n)).find(|b| spatial(b)).copied())
    };
    (0..2).find_map(|side| Some((of_side(side)?, side)))
}

/// Creates the contact of oblique rigid bodies in a step. Unsupported pairs are reported.
pub fn wall_contacts(input: StepInput, report: &mut Report) -> Vec<Box<dyn Constraint>> {
    let StepInput { scene, pairs, index: step, .. } = input;
    let walls = pairs.by_step[step].iter().filter_map(|pair| Some((pair, spatial_side(scene.bodies, pair)?)));
    let mut contacts: Vec<Box<dyn Constraint>> = Vec::new();
    for (pair, (body, side)) in walls {
        match wall_contact(input, pair, (body, side), report) {
            Ok(contact) => contacts.push(Box::new(contact)),
            Err(what) => {
                refuse_on_spatial_body(pair.span, &scene.bodies.list[body].name, what, report);
            }
        }
    }
    contacts
}

fn wall_contact(
    input: StepInput,
    pair: &SurfaceContact,
    (body, side): (usize, usize),
    report: &mut Report,
) -> Result<RigidWallContact, &'static str> {
    let StepInput { scene, pairs, state, index, .. } = input;
    let step = &scene.model.steps[index];
    let Some(analytical) = &pair.analytical else {
        return Err("contact with a surface of elements");
    };
    if pair.penalty.is_some() || pair.law.is_soft() || pair.law.friction.largest.is_finite() {
        return Err("soft contact or TAUMAX");
    }
    let surface = &scene.model.surfaces.analytical[analytical.surface];
    let wall = surface.reference.and_then(|node| scene.bodies.of_node.get(&node).copied());
    let is_fixed = |reference: usize| {
        let fixed = |b: &&crate::model::BoundaryCondition| b.dof == 2 && b.nodes.contains(&reference);
        step.boundaries.iter().find(fixed).is_some_and(|b| b.value == 0.0 && !b.user)
    };
    let Some(wall) = wall.filter(|&wall| is_fixed(scene.bodies.list[wall].reference)) else {
        return Err("contact with an analytical surface whose rigid body is not fixed (*BOUNDARY along 2)");
    };
    let spatial = state.dofs.bodies[body].spatial.as_ref().ok_or("contact")?;
    let [centre_r, centre_z, third] = spatial.centre;
    let mut profile = surface.profile.clone();
    let mesh = &scene.model.mesh;
    if profile.nearest([centre_r.portable_hypot(third), centre_z], 0.0).gap < 0.0 {
        let message = format!(
            "`{}` faces away from `{}`: the analytical surface is reversed",
            pair.sides[1 - side].name,
            pair.sides[side].name
        );
        warn_of_front(message, surface, "; ABAQUS does not reverse it", Some(pair), report);
        profile = profile.reversed();
    }
    let faces = pair.sides[side].faces.iter().filter_map(|&(e, s)| mesh.side_nodes(e, s)).flatten();
    let mut nodes: Vec<usize> = sorted_unique(faces.chain(analytical.nodes.iter().copied()));
    nodes.retain(|n| scene.bodies.of_node.get(n) == Some(&body));
    let rings: Vec<[f64; 2]> =
        nodes.iter().map(|&n| [mesh.points[n][0], mesh.points[n][1] - spatial.heights[0]]).collect();
    let travel = step.increment.travel();
    let detail = format!("{} on {}, kinematic{}", pair.sides[side].name, pair.sides[1 - side].name, friction_of(pair));
    let number = pairs.names.get_index_of(&pair_name(pair)).unwrap_or_default();
    let id = report.ledger_row(pair.span, "contact with a wall", rings.len(), "rings", detail);
    let pair = WallPair { id, number, first: side == 0, bodies: [body, wall], friction: pair.law.friction };
    Ok(RigidWallContact::new(pair, profile, rings, spatial.stations, travel))
}
