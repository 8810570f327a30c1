//! Contact of oblique rigid bodies (six degrees of freedom) with analytical surfaces.

use crate::constraint::contact::stations::{StationContact, StationPair};
use crate::constraint::contact::wall_stations::{WallRing, WallSurfaces};
use crate::kernel::interaction::InteractionLaw;
use crate::kernel::lists::sorted_unique;
use crate::kernel::profile::SurfaceProfile;
use crate::load::stations::divided_facets;
use crate::mesh::surface::RigidFacets;
use crate::model::{ElementSide, RigidSurface, SurfaceContact};
use crate::plan::bodies::rigid_bodies_3d::refuse_on_spatial_body;
use crate::plan::contact::analytical::{friction_of, warn_of_front};
use crate::plan::contact::cohesion::{cohesion_of, refuse_analytical};
use crate::plan::contact::curves::ContactGeometry;
use crate::plan::contact::general::body_of_analytical;
use crate::plan::contact::penalty::rigid_spring_law;
use crate::plan::contact::{check_damping, has_springs, kind_of, pair_number, place_of};
use crate::plan::meshes::surfaces::rigid_facet;
use crate::plan::{Bodies, Report, StepInput};
use crate::platform::PortableMath as _;
use crate::state::rigid_body_3d::RigidBody3d;

/// Largest number of stations of a ring in hard contact, which are checked in addition to its deepest point, so that a
/// flat contact on a plane is stable.
const MOST_STATIONS: usize = 16;

/// Returns the oblique rigid body of a pair and its side (0 or 1).
pub fn spatial_side(bodies: &Bodies, pair: &SurfaceContact) -> Option<(usize, usize)> {
    if !bodies.list.iter().any(|body| body.spatial) {
        return None;
    }
    let spatial = |body: &usize| bodies.list[*body].spatial;
    let of_side = |side: usize| {
        let faces = pair.sides[side].faces.iter();
        let of_faces = faces.filter_map(|f| bodies.of_element.get(&f.0)).find(|b| spatial(b)).copied();
        let nodes = pair.analytical.iter().filter(|a| a.side != side).flat_map(|a| &a.nodes);
        of_faces.or_else(|| nodes.filter_map(|n| bodies.of_node.get(n)).find(|b| spatial(b)).copied())
    };
    (0..2).find_map(|side| Some((of_side(side)?, side)))
}

/// Creates the contact of an oblique rigid body, given with its side of the pair, and a wall. Unsupported pairs are
/// reported.
pub fn station_contact(
    input: StepInput,
    pair: &SurfaceContact,
    (body, side): (usize, usize),
    geometry: &mut ContactGeometry,
    report: &mut Report,
) -> Option<StationContact> {
    let StepInput { scene, pairs, state, index, .. } = input;
    if let Some(cohesion) = cohesion_of(scene.model, pair) {
        return refuse_analytical(pair, cohesion, report);
    }
    let is_soft = (pair.law.is_soft() || pair.penalty.is_some()) && !pair.sides[side].faces.is_empty();
    let (wall, surface) = match wall_of(input, pair, is_soft) {
        Ok(wall) => wall,
        Err(what) => {
            refuse_on_spatial_body(pair.span, &scene.bodies.list[body].name, what, report);
            return None;
        }
    };
    let spatial = state.dofs.bodies[body].spatial.as_ref()?;
    let (rings, laws) = if is_soft {
        soft_rings(input, pair, (body, side), spatial, report)?
    } else {
        (hard_rings(input, pair, (body, side), spatial), vec![pair.law.clone()])
    };
    let profile = facing_wall(pair, side, (surface, spatial), report);
    let stations = if is_soft { spatial.stations } else { spatial.stations.min(MOST_STATIONS) };
    let names = [side, 1 - side].map(|side| pair.sides[side].name.as_str());
    let kind = if is_soft { kind_of(pair) } else { "kinematic".into() };
    let detail = format!("{} on {}, {kind}{}", names[0], names[1], friction_of(pair));
    check_damping(pair, report);
    let station_pair = StationPair {
        id: report.ledger_row(pair.span, "contact with a wall", rings.len(), "rings", detail),
        number: pair_number(pairs, pair),
        first: side == 0,
        bodies: [body, wall],
        wall: geometry.add_carried(wall),
        laws,
        travel: scene.model.steps[index].increment.travel(),
    };
    Some(StationContact::new(station_pair, WallSurfaces::new(profile, rings, stations)))
}

/// Returns the body of the wall of a pair and its surface.
///
/// # Errors
/// What is unsupported on an oblique body.
fn wall_of<'a>(
    input: StepInput<'a, '_>,
    pair: &SurfaceContact,
    is_soft: bool,
) -> Result<(usize, &'a RigidSurface), &'static str> {
    let scene = input.scene;
    let analytical = pair.analytical.as_ref().ok_or("contact with a surface of elements")?;
    let wall = body_of_analytical(scene, analytical.surface).filter(|&wall| !scene.bodies.list[wall].spatial);
    let wall = wall.ok_or("contact with an analytical surface that belongs to no rigid body, or to an oblique one")?;
    if pair.law.friction_routine.is_some() {
        return Err("*FRICTION, USER");
    }
    if !is_soft && pair.law.friction.largest.is_finite() {
        return Err("TAUMAX in hard contact, whose pressures are not unique between rigid bodies,");
    }
    if pair.clearance.is_some() {
        return Err("an initial clearance of a contact pair");
    }
    let heat = &pair.law.heat;
    if scene.model.solves_for_temperatures() && !(heat.over_clearance.is_empty() && heat.over_pressure.is_empty()) {
        return Err("heat conduction through contact");
    }
    Ok((wall, &scene.model.surfaces.analytical[analytical.surface]))
}

/// Returns the profile of the wall with its front towards the centre of mass. Warns if it was reversed.
fn facing_wall(
    pair: &SurfaceContact,
    side: usize,
    (surface, body): (&RigidSurface, &RigidBody3d),
    report: &mut Report,
) -> SurfaceProfile {
    let [centre_r, centre_z, third] = body.centre;
    if surface.profile.nearest([centre_r.portable_hypot(third), centre_z], 0.0).gap >= 0.0 {
        return surface.profile.clone();
    }
    let [wall, body] = [1 - side, side].map(|side| &pair.sides[side].name);
    let message = format!("`{wall}` faces away from `{body}`: the analytical surface is reversed");
    warn_of_front(message, surface, "; ABAQUS does not reverse it", Some(pair), report);
    surface.profile.reversed()
}

/// Returns a ring for each node of the surface of a body.
fn hard_rings(
    input: StepInput,
    pair: &SurfaceContact,
    (body, side): (usize, usize),
    spatial: &RigidBody3d,
) -> Vec<WallRing> {
    let (scene, mesh) = (input.scene, &input.scene.model.mesh);
    let faces = pair.sides[side].faces.iter().filter_map(|&(e, s)| mesh.side_nodes(e, s)).flatten();
    let of_analytical = pair.analytical.iter().flat_map(|analytical| &analytical.nodes);
    let mut nodes: Vec<usize> = sorted_unique(faces.chain(of_analytical.copied()));
    nodes.retain(|n| scene.bodies.of_node.get(n) == Some(&body));
    let ring = |&n: &usize| {
        let place = [mesh.points[n][0], mesh.points[n][1] - spatial.heights[0]];
        WallRing { place, normal: [0.0; 2], area: 1.0, law: 0 }
    };
    nodes.iter().map(ring).collect()
}

/// Returns two rings for each part of the facets of a body, with the areas of their hat functions on it, and the laws.
/// Unknown penalty stiffnesses are reported.
fn soft_rings(
    input: StepInput,
    pair: &SurfaceContact,
    (body, side): (usize, usize),
    spatial: &RigidBody3d,
    report: &mut Report,
) -> Option<(Vec<WallRing>, Vec<InteractionLaw>)> {
    let model = input.scene.model;
    let of_body = |&&(element, _): &&(usize, ElementSide)| input.scene.bodies.of_element.get(&element) == Some(&body);
    let faces: Vec<(usize, ElementSide)> = pair.sides[side].faces.iter().filter(of_body).copied().collect();
    let mut laws: Vec<InteractionLaw> = Vec::new();
    let law_of_face = |face: &(usize, ElementSide)| match pair.penalty.filter(|_| has_springs(pair)) {
        None => Some(place_of(&mut laws, pair.law.clone())),
        Some(factor) => Some(place_of(&mut laws, rigid_spring_law(model, pair, factor, *face, report)?)),
    };
    let law_of_faces = faces.iter().map(law_of_face).collect::<Option<Vec<usize>>>()?;
    let facets = faces.iter().enumerate().filter_map(|(i, &(e, s))| Some((i, rigid_facet(model, e, s)?))).collect();
    let mut rings: Vec<WallRing> = Vec::new();
    for (face, facet) in divided_facets(&RigidFacets { body, facets }, spatial, f64::INFINITY) {
        for [place, far] in [[facet.low, facet.high], [facet.high, facet.low]] {
            let area = std::f64::consts::TAU * facet.length() * (2.0 * place[0] + far[0]) / 6.0;
            let place = [place[0], place[1] - spatial.heights[0]];
            rings.push(WallRing { place, normal: facet.normal, area, law: law_of_faces[face] });
        }
    }
    rings.retain(|ring| ring.area > 0.0);
    Some((rings, laws))
}
