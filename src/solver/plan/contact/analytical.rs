//! Contact pairs with analytical surfaces: their nodes, the side of the surface, and checks of the initial position.

use crate::constraint::contact::analytical::AnalyticalSurface;
use crate::constraint::contact::curve::FacetCurve;
use crate::deck::Diagnostic;
use crate::kernel::profile::SurfaceProfile;
use crate::model::{AnalyticalFront, AnalyticalSide, Element, Model, RigidSurface, SideSelection, SurfaceContact};
use crate::plan::contact::curves::{ContactGeometry, CurveContext, add_curve, point_of};
use crate::plan::contact::general::{general_row, pair_name};
use crate::plan::{Report, StepInput};

/// Accepted initial penetration of nodes, as a fraction of the size of the smaller surface: rounded coordinates,
/// straight edges of a curved mesh.
const OVERLAP: f64 = 1e-3;

/// Initial positions of nodes relative to an analytical surface.
#[derive(Debug, Default)]
struct InitialGaps {
    /// Maximum penetration, and maximum gap, length.
    penetration: f64,
    front: f64,
    /// Number of penetrating nodes.
    count: usize,
}

impl InitialGaps {
    fn new(profile: &SurfaceProfile, places: &[[f64; 2]], rounding: f64) -> InitialGaps {
        InitialGaps::of(places.iter().map(|&place| profile.nearest(place, 0.0).gap), rounding)
    }

    /// Returns the gaps of the points that are not beyond the ends of the profile.
    fn between_ends(profile: &SurfaceProfile, places: &[[f64; 2]], rounding: f64) -> InitialGaps {
        let near = places.iter().map(|&place| profile.nearest(place, 0.0));
        InitialGaps::of(near.filter(|near| !near.beyond).map(|near| near.gap), rounding)
    }

    fn of(gaps: impl Iterator<Item = f64>, rounding: f64) -> InitialGaps {
        let mut start = InitialGaps::default();
        for gap in gaps {
            (start.penetration, start.front) = (start.penetration.max(-gap), start.front.max(gap));
            start.count += usize::from(gap < -rounding);
        }
        start
    }
}

/// Returns the larger side of the bounding box of points.
fn extent(points: &[[f64; 2]]) -> f64 {
    let along = |axis: usize| {
        let coordinates = points.iter().map(|p| p[axis]);
        coordinates.clone().fold(f64::NEG_INFINITY, f64::max) - coordinates.fold(f64::INFINITY, f64::min)
    };
    along(0).max(along(1))
}

/// Describes the friction of a pair for the ledger.
pub fn friction_of(pair: &SurfaceContact) -> String {
    match pair.law.friction.at_rest {
        _ if pair.law.friction_routine.is_some() => ", friction by vfriction".into(),
        _ if !pair.law.friction.is_active() => String::new(),
        f64::INFINITY => ", rough".into(),
        coefficient => format!(", friction {coefficient}"),
    }
}

/// Returns the name of a pair in [`AnalyticalFront`]: all pairs of general contact have the same front.
fn name_of_front(pair: &SurfaceContact) -> Option<String> {
    (!pair.general).then(|| pair_name(pair))
}

/// The surface of a pair that is opposite to the analytical one.
#[derive(Clone, Copy)]
struct OpposingSurface<'a> {
    sides: &'a SideSelection,
    nodes: &'a [usize],
    pair: &'a SurfaceContact,
}

/// Returns the indices of the curve and of the analytical surface of a pair, and the ledger row. Unsupported pairs
/// are reported as errors.
pub fn analytical_contact(
    (pair, analytical): (&SurfaceContact, &AnalyticalSide),
    context: &CurveContext,
    geometry: &mut ContactGeometry,
    report: &mut Report,
) -> Option<([usize; 2], usize)> {
    let sides = &pair.sides[1 - analytical.side];
    let curve = if sides.faces.is_empty() {
        curve_of_nodes(pair, &analytical.nodes, context, geometry, report)?
    } else {
        add_curve(pair, 1 - analytical.side, context, geometry, report)?
    };
    let opposite = OpposingSurface { sides, nodes: &analytical.nodes, pair };
    match analytical_surface(opposite, analytical, context, geometry, report) {
        Ok((mut surface, count)) => {
            let gives_way = (pair.penalty.is_some() || pair.law.is_soft()) && !sides.faces.is_empty();
            if gives_way {
                surface.overlap = surface.overlap.max(geometry.deepest(curve));
            }
            if let Some(general) = context.general.filter(|_| pair.general) {
                let id = general_row(general, context, report);
                geometry.analyticals.push(surface);
                return Some(([curve, geometry.analyticals.len() - 1], id));
            }
            let friction = friction_of(pair);
            let (set, name) = (&sides.name, &pair.sides[analytical.side].name);
            let kind = if gives_way { "soft contact" } else { "kinematic" };
            let (effect, detail) = match surface.profile.height() {
                Some(z) => {
                    let front = if surface.profile.nearest([0.0, z + 1.0], 0.0).gap > 0.0 { "+z" } else { "-z" };
                    let detail = format!("{set} on {name}, z = {z}, normal {front}, {kind}{friction}");
                    ("contact with a plane", detail)
                }
                None => {
                    let segments = surface.profile.segments.len();
                    ("contact with a surface", format!("{set} on {name}, {segments} segments, {kind}{friction}"))
                }
            };
            let id = report.ledger_row(pair.span, effect, count, "nodes", detail);
            geometry.analyticals.push(surface);
            Some(([curve, geometry.analyticals.len() - 1], id))
        }
        Err(why) => {
            let finding = Diagnostic::error("P021", why).at(pair.span, "this pair");
            report.refuse(finding)
        }
    }
}

/// Adds a curve of nodes without facets.
fn curve_of_nodes(
    pair: &SurfaceContact,
    nodes: &[usize],
    context: &CurveContext,
    geometry: &mut ContactGeometry,
    report: &mut Report,
) -> Option<usize> {
    let mut points = Vec::new();
    for &node in nodes {
        match point_of(node, context, geometry) {
            Ok(point) => points.push(point),
            Err(why) => {
                let finding = Diagnostic::error("P021", why.message(&context.input.scene.model.mesh));
                return report.refuse(finding.at(pair.span, "this pair"));
            }
        }
    }
    points.sort_unstable();
    Some(geometry.add_points(FacetCurve::of_points(points)))
}

/// Returns the analytical surface with its front towards the nodes, and the number of contact nodes. The point of its
/// rigid body and the front are added to the geometry.
fn analytical_surface(
    opposite: OpposingSurface,
    side: &AnalyticalSide,
    context: &CurveContext,
    geometry: &mut ContactGeometry,
    report: &mut Report,
) -> Result<(AnalyticalSurface, usize), String> {
    let StepInput { scene, state, .. } = context.input;
    let surface: &RigidSurface = &scene.model.surfaces.analytical[side.surface];
    let reference = surface
        .reference
        .ok_or("the analytical surface belongs to no rigid body (*RIGID BODY, ANALYTICAL SURFACE=)")?;
    let body = *scene.bodies.of_node.get(&reference).ok_or("the rigid body of the analytical surface is missing")?;
    let mut nodes = Vec::new();
    for &node in opposite.nodes {
        let name = &scene.model.mesh.node_names[node];
        let free_node = scene
            .places
            .free_node(node)
            .ok_or(format!("node {name} does not belong to a deformable body, or is tied to a rigid body"))?;
        nodes.push(free_node);
    }
    if surface.profile.height().is_some() {
        nodes.retain(|n| !context.prescribed.contains(&(*n, 1)));
    }
    if nodes.is_empty() && !opposite.pair.general {
        return Err("this surface has no node of a deformable body that is free to move".into());
    }
    let places: Vec<[f64; 2]> = nodes.iter().map(|n| state.dofs.nodes.start[*n]).collect();
    let mut analytical = AnalyticalSurface::new(surface.profile.clone(), 0);
    let ends = surface.profile.bounds();
    let overlap = OVERLAP * [extent(&ends), extent(&places)].into_iter().filter(|e| *e > 0.0).fold(f64::MAX, f64::min);
    let tolerances = [analytical.rounding, overlap];
    let profile = match (known_front(scene.model, opposite.pair, side), opposite.pair.general) {
        (Some(true), _) => surface.profile.reversed(),
        (Some(false), _) => surface.profile.clone(),
        (None, true) => profile_facing_all(context, opposite, (surface, side), &places, tolerances, report),
        (None, false) => facing_profile(scene.model, opposite, surface, &places, tolerances, report)?,
    };
    let is_reversed = profile != surface.profile;
    let front = AnalyticalFront { surface: side.surface, pair: name_of_front(opposite.pair), is_reversed };
    if !geometry.fronts.contains(&front) {
        geometry.fronts.push(front);
    }
    analytical = AnalyticalSurface::new(profile, geometry.add_carried(body));
    analytical.overlap = overlap.max(analytical.rounding);
    Ok((analytical, nodes.len()))
}

/// Returns whether the surface of a pair is reversed, if this was determined at the start of the run: on a new mesh, places of
/// nodes are current ones, while a surface is where it was at the start, and soft contact may have deep overlaps.
fn known_front(model: &Model, pair: &SurfaceContact, side: &AnalyticalSide) -> Option<bool> {
    let pair = name_of_front(pair);
    let mut fronts = model.surfaces.fronts.iter().flatten();
    fronts.find(|front| (front.surface, &front.pair) == (side.surface, &pair)).map(|front| front.is_reversed)
}

/// Warns of an analytical surface whose front is not towards the other surface; `comparison` is what ABAQUS does.
pub fn warn_of_front(
    message: String,
    surface: &RigidSurface,
    comparison: &str,
    pair: Option<&SurfaceContact>,
    report: &mut Report,
) {
    let way = format!("its front is to the left of the direction from START{comparison}");
    let finding = Diagnostic::warning("P110", message).at(surface.span, way);
    let finding = pair.into_iter().fold(finding, |finding, pair| finding.at(pair.span, "this pair"));
    report.push(finding.help("give the points of the surface in the opposite order"));
}

/// Returns the profile with its front towards the nodes. Warns if it was reversed, if nodes penetrate it, or if
/// there will be no contact; an error if nodes are on both sides.
fn facing_profile(
    model: &Model,
    opposite: OpposingSurface,
    surface: &RigidSurface,
    places: &[[f64; 2]],
    [rounding, overlap]: [f64; 2],
    report: &mut Report,
) -> Result<SurfaceProfile, String> {
    let OpposingSurface { sides, pair, .. } = opposite;
    let side = usize::from(pair.sides[0].name == sides.name);
    let (profile, name, set) = (surface.profile.clone(), &pair.sides[side].name, &sides.name);
    let start = InitialGaps::new(&profile, places, rounding);
    if start.penetration <= rounding {
        if start.front <= rounding && looks_away(model, opposite, &profile) {
            let message =
                format!("`{name}` faces away from `{}`, which is on the surface: there will be no contact", set);
            warn_of_front(message, surface, ", as in ABAQUS", Some(pair), report);
        }
        return Ok(profile);
    }
    let away = match sides.faces.is_empty() {
        true => start.penetration > overlap,
        false => looks_away(model, opposite, &profile),
    };
    if away && start.front <= rounding.max(overlap) {
        let message = format!("`{name}` faces away from `{}`: the analytical surface is reversed", set);
        warn_of_front(message, surface, "; ABAQUS does not reverse it", Some(pair), report);
        return Ok(profile.reversed());
    }
    if start.penetration <= overlap {
        let (count, penetration) = (start.count, start.penetration);
        let message = format!("{count} nodes of `{}` penetrate `{name}` by up to {penetration:.3e} at the start", set);
        let finding = Diagnostic::warning("P111", message)
            .at(pair.span, "this penetration is kept, further penetration is prevented");
        report.push(finding.help("move the nodes onto the surface"));
        return Ok(profile);
    }
    if start.front <= overlap {
        return Err(format!(
            "nodes of this surface penetrate the analytical surface by up to {:.3e} at the start",
            start.penetration
        ));
    }
    Err("nodes of this surface are on both sides of the analytical surface".into())
}

/// Returns the profile in general contact, with its front to the left of its direction. If all surfaces of the
/// contact domain are on its back, it is reversed. Warns if it was reversed, or if nodes penetrate it.
fn profile_facing_all(
    context: &CurveContext,
    OpposingSurface { sides, pair, .. }: OpposingSurface,
    (surface, side): (&RigidSurface, &AnalyticalSide),
    places: &[[f64; 2]],
    [rounding, overlap]: [f64; 2],
    report: &mut Report,
) -> SurfaceProfile {
    let mesh = &context.input.scene.model.mesh;
    let is_same = |c: &&SurfaceContact| c.analytical.as_ref().is_some_and(|a| a.surface == side.surface);
    let pairs = || context.pairs.iter().filter(|c| c.general).filter(is_same);
    let (name, set) = (&pair.sides[side.side].name, &sides.name);
    let all_nodes = pairs().flat_map(|contact| &contact.analytical).flat_map(|side| &side.nodes);
    let all_places: Vec<[f64; 2]> = all_nodes.map(|&n| mesh.points[n]).collect();
    let start = InitialGaps::between_ends(&surface.profile, &all_places, rounding);
    let mut profile = surface.profile.clone();
    if start.front <= rounding.max(overlap) && start.penetration > overlap {
        profile = profile.reversed();
        if pairs().next().is_some_and(|first| first.sides == pair.sides) {
            let message = format!("`{name}` faces away from all surfaces in contact with it: it is reversed");
            warn_of_front(message, surface, "; ABAQUS does not reverse it", None, report);
        }
    }
    let start = InitialGaps::between_ends(&profile, places, rounding);
    let count = start.count;
    if start.penetration > rounding && start.front > rounding.max(overlap)
        || (count > 0 && start.penetration <= overlap)
    {
        let depth = start.penetration;
        let message = format!("{count} nodes of `{set}` penetrate `{name}` by up to {depth:.3e} at the start");
        let label = format!("nodes deeper than {overlap:.1e} do not contact it; the others keep their penetration");
        let finding = Diagnostic::warning("P111", message).at(pair.span, label);
        report.push(finding.at(surface.span, "this surface").help("move the nodes, or use *CONTACT EXCLUSIONS"));
    }
    profile
}

/// Returns whether the elements at the nodes are, on average, on the back side of the analytical surface.
fn body_of_nodes_is_behind(model: &Model, nodes: &[usize], profile: &SurfaceProfile) -> bool {
    let mesh = &model.mesh;
    let touches = |e: &&Element| e.nodes.len() > 2 && e.nodes.iter().any(|n| nodes.binary_search(n).is_ok());
    let body = mesh.elements.iter().filter(touches).flat_map(|e| &e.nodes);
    body.map(|&n| profile.nearest(mesh.points[n], 0.0).gap).sum::<f64>() < 0.0
}

/// Returns whether the faces nearest to the analytical surface have normals in its direction, so that they cannot
/// touch it.
fn looks_away(model: &Model, opposite: OpposingSurface, profile: &SurfaceProfile) -> bool {
    let OpposingSurface { sides, nodes, .. } = opposite;
    let mesh = &model.mesh;
    let points = &mesh.points;
    if sides.faces.is_empty() {
        return body_of_nodes_is_behind(model, nodes, profile);
    }
    let face = |f: &[usize; 2]| {
        let [a, b] = f.map(|n| points[n]);
        let middle = [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
        let near = profile.nearest(middle, 0.0);
        let n = profile.segments[near.segment].normal(middle, 0.0);
        (near.gap.abs(), n[0] * (b[1] - a[1]) - n[1] * (b[0] - a[0]), libm::hypot(b[0] - a[0], b[1] - a[1]))
    };
    let faces: Vec<[usize; 2]> = sides.faces.iter().filter_map(|&(e, side)| mesh.side_nodes(e, side)).collect();
    let least = faces.iter().map(|f| face(f).0).fold(f64::INFINITY, f64::min);
    let near = faces.iter().map(face).filter(|(gap, _, length)| *gap <= least + 0.5 * length);
    near.map(|f| f.1).sum::<f64>() > 0.0
}
