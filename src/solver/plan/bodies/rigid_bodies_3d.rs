//! Oblique rigid bodies, which have six degrees of freedom: selection, inertia, initial motion, and checks for
//! unsupported input.

use crate::deck::{Diagnostic, Span};
use crate::kernel::attitude::{Attitude, PrincipalInertia, SpatialVector, cross, norm, plus};
use crate::model::{self, ElementKind, InitialKind, LoadKind, Model, RigidBody, RotaryInertia, STATIONS};
use crate::plan::{Bodies, Links, PlannedRigidBody, Report, Scene};
use crate::platform::PortableMath as _;
use crate::state::BodyState;
use crate::state::rigid_body_3d::{Pose, RigidBody3d};

/// Points and weights of the three-point Gauss rule on [-1, 1], exact for polynomials up to degree 5.
const GAUSS: [[f64; 2]; 3] =
    [[-0.774_596_669_241_483_4, 5.0 / 9.0], [0.0, 8.0 / 9.0], [0.774_596_669_241_483_4, 5.0 / 9.0]];

/// Mass and moments of a mass distribution about the origin.
#[derive(Clone, Copy, Debug, Default)]
struct MassMoments {
    mass: f64,
    /// First moment along the axis: mass times z.
    first: f64,
    /// Moments of inertia about the axis of symmetry, and about a transverse axis at z = 0.
    axial: f64,
    transverse: f64,
}

impl MassMoments {
    /// Adds a mass that is evenly distributed over a circle of radius r at height z.
    fn add(&mut self, mass: f64, [r, z]: [f64; 2]) {
        self.mass += mass;
        self.first += mass * z;
        self.axial += mass * r * r;
        self.transverse += mass * (0.5 * r * r + z * z);
    }

    fn height(&self) -> f64 {
        self.first / self.mass
    }

    /// Returns the moments of inertia about the centre of mass.
    fn inertia(&self) -> PrincipalInertia {
        PrincipalInertia { axial: self.axial, transverse: self.transverse - self.first * self.height() }
    }
}

/// Returns the attitude of a body in the deck.
fn attitude<'a>(model: &'a Model, rigid: &RigidBody) -> Option<&'a model::InitialAttitude> {
    model.attitudes.iter().find(|attitude| attitude.reference == rigid.reference)
}

/// Returns whether a body is oblique: it is rotated, hits an inclined target, or has an attitude and a transverse or
/// angular initial velocity, a contact pair with an analytical surface, or general contact with one and only rigid bodies.
pub fn is_oblique(model: &Model, rigid: &RigidBody) -> bool {
    let attitude = attitude(model, rigid);
    let turned = attitude.is_some_and(|a| a.angles != [0.0; 2]);
    let steps = model.steps.iter();
    let tilted = steps.flat_map(|s| &s.loads).any(|load| match &load.kind {
        LoadKind::Cavity { sides, target, .. } => {
            model.targets[*target].obliquity != 0.0 && sides.faces.iter().any(|(e, _)| rigid.elements.contains(e))
        }
        _ => false,
    });
    let across = || initial_velocities_of(model, rigid.reference).iter().enumerate().any(|(i, v)| i != 1 && *v != 0.0);
    let pairs = || model.steps.iter().flat_map(|s| &s.surface_contacts).filter(|pair| pair.analytical.is_some());
    let faces = || pairs().flat_map(|pair| &pair.sides).flat_map(|side| &side.faces);
    let meets_wall = || faces().any(|(e, _)| rigid.elements.contains(e));
    turned || tilted || attitude.is_some() && (across() || meets_wall() || may_meet_wall(model, rigid))
}

/// Returns whether general contact of rigid bodies includes a body and an analytical surface of another one.
fn may_meet_wall(model: &Model, rigid: &RigidBody) -> bool {
    let is_of_body = |element: usize| model.rigid_bodies.iter().any(|body| body.elements.contains(&element));
    let mut elements = model.mesh.elements.iter().enumerate();
    let mut walls = model.surfaces.analytical.values().filter_map(|surface| surface.reference);
    model.steps.iter().any(|step| step.general_contact.is_some())
        && walls.any(|reference| reference != rigid.reference)
        && elements.all(|(index, element)| element.kind.topology().is_none() || is_of_body(index))
}

/// Returns the initial velocities of a reference node along and about directions 1, 2, 3.
fn initial_velocities_of(model: &Model, reference: usize) -> [f64; 6] {
    let mut starts = [0.0; 6];
    for condition in model.initial_conditions.iter().filter(|c| c.members.contains(&reference)) {
        if let InitialKind::Velocity(dof @ 1..=6, value) = condition.kind {
            starts[usize::from(dof) - 1] = value;
        }
    }
    starts
}

/// Returns whether an initial velocity is given for an oblique body, which may have any direction.
pub fn starts_in_space(bodies: &Bodies, members: &[usize]) -> bool {
    bodies.list.iter().any(|b| b.spatial && members.contains(&b.reference))
}

/// Returns the initial states of the bodies; `velocities` are those along z.
pub fn initial_states(scene: Scene, velocities: &[f64], report: &mut Report) -> Vec<BodyState> {
    check_attitudes(scene, report);
    let bodies = scene.bodies.list.iter().zip(velocities).enumerate();
    let initial_state = |(index, (body, velocity)): (usize, (&PlannedRigidBody, &f64))| match body.spatial {
        false => BodyState::new(body.mass(), *velocity),
        true => BodyState::in_space(oblique_body(scene, index, report)),
    };
    bodies.map(initial_state).collect()
}

fn check_attitudes(scene: Scene, report: &mut Report) {
    let mut seen: Vec<usize> = Vec::new();
    for attitude in &scene.model.attitudes {
        let message = if !scene.model.rigid_bodies.iter().any(|b| b.reference == attitude.reference) {
            "the attitude is given for a node that is not the REF NODE of a rigid body"
        } else if seen.contains(&attitude.reference) {
            "the body already has an attitude"
        } else {
            seen.push(attitude.reference);
            let moves_straight =
                scene.bodies.of_node.get(&attitude.reference).is_some_and(|&body| !scene.bodies.list[body].spatial);
            if moves_straight {
                report.add_unused_card(attitude.span, "*ATTITUDE", "the body moves along its axis, without rotation");
            }
            continue;
        };
        report.push(Diagnostic::error("P130", message).at(attitude.span, "here"));
    }
    for inertia in &scene.model.discrete.inertias {
        match scene.bodies.of_node.get(&inertia.node).map(|&b| &scene.bodies.list[b]) {
            None => {
                let message = "the rotary inertia is on a node that belongs to no rigid body";
                let finding = Diagnostic::error("P005", message).at(inertia.span, "here");
                report.push(finding.help("put it on the REF NODE of a *RIGID BODY, or delete the card"));
            }
            Some(body) if !body.spatial => {
                let why = "a rigid body that moves along z only does not rotate";
                report.add_unused_card(inertia.span, "*ROTARY INERTIA", why);
            }
            Some(_) => check_revolution(inertia, report),
        }
    }
}

/// Reports transverse moments of inertia that differ, which a body of revolution cannot have.
fn check_revolution(inertia: &RotaryInertia, report: &mut Report) {
    let [first, _, third] = inertia.moments;
    if first != third {
        let message = format!("I11 and I33 of a body of revolution must be equal, found {first} and {third}");
        report.push(Diagnostic::error("P131", message).at(inertia.span, "here"));
    }
}

fn oblique_body(scene: Scene, index: usize, report: &mut Report) -> RigidBody3d {
    let rigid = &scene.model.rigid_bodies[index];
    let body = &scene.bodies.list[index];
    let (mass, mesh) = (body.mass(), &scene.model.mesh);
    let initial_attitude = attitude(scene.model, rigid);
    let uniform = initial_attitude.is_some_and(|a| a.uniform);
    let moments =
        if uniform { moments_of_volume(scene.model, rigid, mass) } else { moments_of_nodes(scene.model, rigid, body) };
    let mut inertia = moments.inertia();
    let on_body = scene.model.discrete.inertias.iter().filter(|i| body.nodes.contains(&i.node));
    for [transverse, axial, _] in on_body.map(|i| i.moments) {
        inertia = PrincipalInertia { axial: inertia.axial + axial, transverse: inertia.transverse + transverse };
    }
    let height = if moments.mass > 0.0 { moments.height() } else { mesh.points[rigid.reference][1] };
    let angles = initial_attitude.map_or([0.0; 2], |a| a.angles).map(f64::to_radians);
    let attitude = Attitude::turned([angles[1], 0.0, 0.0]).after(Attitude::turned([0.0, 0.0, angles[0]]));
    let [r, z] = mesh.points[rigid.reference];
    let arm = attitude.to_world([-r, height - z, 0.0]);
    let starts = initial_velocities_of(scene.model, rigid.reference);
    let (translation, turning): (SpatialVector, SpatialVector) =
        ([starts[0], starts[1], starts[2]], [starts[3], starts[4], starts[5]]);
    let far = |n: &usize| mesh.points[*n][0].portable_hypot(mesh.points[*n][1] - height);
    let mut spatial = RigidBody3d {
        mass,
        inertia,
        heights: [height, z],
        stations: stations(scene.model, index),
        size: body.nodes.iter().map(far).fold(0.0, f64::max),
        centre: plus([r, z, 0.0], 1.0, arm),
        attitude,
        velocity: plus(translation, 1.0, cross(turning, arm)),
        momentum: inertia.momentum(attitude.axis(), turning),
        ..RigidBody3d::default()
    };
    spatial.start = Pose { centre: spatial.centre, attitude, moving: [spatial.velocity, spatial.momentum] };
    spatial.previous = spatial.start;
    spatial.rests = norm(spatial.velocity) == 0.0 && norm(spatial.momentum) == 0.0;
    spatial.show_own_motion();
    let detail = format!(
        "{}: centre of mass at z = {height:.6}, axial inertia {:.6e}, transverse inertia {:.6e}",
        mesh.node_names[rigid.reference], inertia.axial, inertia.transverse
    );
    let span = initial_attitude.map_or(rigid.span, |a| a.span);
    if !(inertia.axial > 0.0 && inertia.transverse > 0.0 && inertia.axial <= 2.0 * inertia.transverse * (1.0 + 1e-12)) {
        no_inertia(scene.bodies, span, index, inertia, report);
    }
    report.ledger_row(span, "six degrees of freedom", 1, "body", detail);
    spatial
}

fn no_inertia(bodies: &Bodies, span: Span, body: usize, inertia: PrincipalInertia, report: &mut Report) {
    let name = &bodies.list[body].name;
    let message = if inertia.axial > 0.0 && inertia.transverse > 0.0 {
        format!(
            "invalid inertia of `{name}`: the axial moment {:e} exceeds twice the transverse moment {:e}",
            inertia.axial, inertia.transverse
        )
    } else {
        format!("oblique rigid body `{name}` has no rotary inertia: its mass is on the axis or at one point")
    };
    let help = "give *ROTARY INERTIA for an element of TYPE=ROTARYI on its reference node, distribute its mass with *ATTITUDE, \
                INERTIA=UNIFORM, or give its elements a density";
    report.push(Diagnostic::error("P131", message).at(span, "this body").help(help));
}

/// Returns the moments of the solid and RAX2 elements of a body as bodies of revolution, and of its point masses.
fn moments_of_nodes(model: &Model, rigid: &RigidBody, body: &PlannedRigidBody) -> MassMoments {
    let (mesh, mut moments) = (&model.mesh, MassMoments::default());
    for section in &model.sections {
        let density = model.materials[section.material].density.unwrap_or(0.0);
        for &e in section.elements.iter().filter(|e| rigid.elements.contains(e)) {
            for cell in mesh.initial_cells(e) {
                in_solid(cell, |place, volume| moments.add(density * volume, place));
            }
        }
    }
    let shells = rigid.elements.iter().filter(|&&e| mesh.elements[e].kind == ElementKind::Rax2);
    for &e in shells {
        let [a, b] = [0, 1].map(|i| mesh.points[mesh.elements[e].nodes[i]]);
        let per_area = rigid.density * rigid.thickness;
        let length = (b[0] - a[0]).portable_hypot(b[1] - a[1]);
        along(a, b, |place, share| {
            moments.add(per_area * 2.0 * std::f64::consts::PI * place[0] * length * share, place);
        });
    }
    for point in model.discrete.masses.iter().filter(|p| body.nodes.contains(&p.node)) {
        moments.add(point.mass, mesh.points[point.node]);
    }
    moments
}

/// Returns the moments of a mass that is evenly distributed over the volume enclosed by the RAX2 elements of a
/// body; plane end faces may be missing. By the divergence theorem each moment is an integral over the meridian;
/// the volume is ∫ π r² dz.
fn moments_of_volume(model: &Model, rigid: &RigidBody, mass: f64) -> MassMoments {
    let (mesh, mut moments) = (&model.mesh, MassMoments::default());
    for &e in rigid.elements.iter().filter(|&&e| mesh.elements[e].kind == ElementKind::Rax2) {
        let [a, b] = [0, 1].map(|i| mesh.points[mesh.elements[e].nodes[i]]);
        along(a, b, |[r, z], share| {
            let volume = std::f64::consts::PI * r * r * (b[1] - a[1]) * share;
            moments.mass += volume;
            moments.first += volume * z;
            moments.axial += 0.5 * volume * r * r;
            moments.transverse += volume * (0.25 * r * r + z * z);
        });
    }
    for &e in rigid.elements.iter().filter(|&&e| mesh.elements[e].kind.is_solid()) {
        mesh.initial_cells(e).for_each(|cell| in_solid(cell, |place, volume| moments.add(volume, place)));
    }
    let factor = mass / moments.mass;
    MassMoments {
        mass,
        first: factor * moments.first,
        axial: factor * moments.axial,
        transverse: factor * moments.transverse,
    }
}

pub fn stations(model: &Model, body: usize) -> usize {
    attitude(model, &model.rigid_bodies[body]).map_or(STATIONS, |a| a.stations)
}

/// Reports input that is unsupported on oblique bodies.
pub fn refuse_on_spatial_bodies(scene: Scene, links: &Links, report: &mut Report) {
    let Some(name) = scene.bodies.list.iter().find(|b| b.spatial).map(|b| b.name.clone()) else { return };
    let in_space = |node: &usize| scene.bodies.of_node.get(node).is_some_and(|&b| scene.bodies.list[b].spatial);
    let model = scene.model;
    let on_nodes = |list: &[usize]| list.iter().any(&in_space);
    let tie = links.rigid_ties.iter().find(|tie| scene.bodies.list[tie.body].spatial);
    let tied = tie.map(|tie| (scene.bodies.list[tie.body].span, "a deformable body with shared nodes"));
    let spring =
        model.discrete.connectors.iter().find(|c| c.elements.iter().any(|&e| on_nodes(&model.mesh.elements[e].nodes)));
    let spring = spring.map(|c| (c.span, "a spring or a dashpot"));
    let equation = model.constraints.equations.iter().find(|e| e.terms.iter().any(|t| in_space(&t.0)));
    let equation = equation.map(|e| (e.span, "an *EQUATION"));
    let unsupported = [tied, spring, equation];
    let findings: Vec<_> = unsupported.into_iter().flatten().collect();
    for (span, what) in findings {
        refuse_on_spatial_body(span, &name, what, report);
    }
}

/// Reports that `what` is unsupported on an oblique body.
pub fn refuse_on_spatial_body(span: Span, body: &str, what: &str, report: &mut Report) {
    let message = format!("rigid body `{body}` is oblique: {what} is not supported on it");
    let help = "an oblique body supports the resistance of targets (CAVITY), pressures (P, PNU), gravity, *CLOAD, and \
                contact with analytical surfaces";
    report.push(Diagnostic::error("P132", message).at(span, "here").help(help));
}

/// Calls `each` with the Gauss points of a line and their weights, which sum to 1.
fn along(a: [f64; 2], b: [f64; 2], mut each: impl FnMut([f64; 2], f64)) {
    for [at, weight] in GAUSS {
        let s = 0.5 * (1.0 + at);
        each([a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1])], 0.5 * weight);
    }
}

/// Calls `each` with the Gauss points of a quadrilateral of revolution and their volumes; exact for moments up to
/// second order.
fn in_solid(corners: [[f64; 2]; 4], mut each: impl FnMut([f64; 2], f64)) {
    for [x, wx] in GAUSS {
        for [y, wy] in GAUSS {
            let shape = [(1.0 - x) * (1.0 - y), (1.0 + x) * (1.0 - y), (1.0 + x) * (1.0 + y), (1.0 - x) * (1.0 + y)];
            let by_x = [-(1.0 - y), 1.0 - y, 1.0 + y, -(1.0 + y)];
            let by_y = [-(1.0 - x), -(1.0 + x), 1.0 + x, 1.0 - x];
            let sum =
                |weights: [f64; 4], axis: usize| 0.25 * (0..4).map(|i| weights[i] * corners[i][axis]).sum::<f64>();
            let point = [sum(shape, 0), sum(shape, 1)];
            let area = sum(by_x, 0) * sum(by_y, 1) - sum(by_x, 1) * sum(by_y, 0);
            each(point, 2.0 * std::f64::consts::PI * point[0] * area * wx * wy);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{MassMoments, in_solid};

    /// A cylinder of radius 2 from height 1 to 4 in one element: m r^2/2 and m (3 r^2 + h^2)/12.
    #[test]
    fn cylinder_of_one_element_has_exact_inertia() {
        let mut moments = MassMoments::default();
        in_solid([[0.0, 1.0], [2.0, 1.0], [2.0, 4.0], [0.0, 4.0]], |place, volume| moments.add(3.0 * volume, place));
        let mass = 3.0 * std::f64::consts::PI * 4.0 * 3.0;
        let inertia = moments.inertia();
        assert!((moments.mass / mass - 1.0).abs() < 1e-14 && (moments.height() - 2.5).abs() < 1e-14);
        assert!((inertia.axial / (mass * 2.0) - 1.0).abs() < 1e-14);
        assert!((inertia.transverse / (mass * (12.0 + 9.0) / 12.0) - 1.0).abs() < 1e-14);
    }
}
