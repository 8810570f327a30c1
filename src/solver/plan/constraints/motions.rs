//! Prescribed motions of a step: rigid bodies along z, nodes along r and z, rotations of shells, and the axis of
//! symmetry.

use std::collections::{HashMap, HashSet};

use crate::constraint::Constraint;
use crate::constraint::motion::{PrescribedMotion, PrescribedQuantity};
use crate::constraint::user_motion::{UserDof, UserMotion};
use crate::deck::{Diagnostic, Span};
use crate::model::{self, BoundaryCondition, Model, Step};
use crate::plan::bodies::rigid_bodies_3d::refuse_on_spatial_body;
use crate::plan::loads::magnitude;
use crate::plan::queries::number_of_node;
use crate::plan::steps::{ConstraintList, ConstraintOrigin};
use crate::plan::{Report, Scene, SolidPlaces};
use crate::state::dofs::Dof;
use crate::state::magnitude::{Magnitude, TimeFunction};

/// Degrees of freedom of rigid bodies whose motion is prescribed, with the kind of motion and its value.
type BodyMotions = HashMap<usize, (PrescribedQuantity, f64)>;

/// A line of `*BOUNDARY`.
#[derive(PartialEq, Eq, Hash)]
struct BoundaryLine<'a> {
    span: Span,
    set: &'a str,
    kind: model::MotionKind,
}

/// Names of the directions that each line of `*BOUNDARY` prescribes.
type LineDirections<'a> = HashMap<BoundaryLine<'a>, Vec<&'static str>>;

/// Adds the prescribed motions of a step and the condition r = 0 on the axis.
pub fn add_motions<'a>(scene: Scene, step: &'a Step, list: &mut ConstraintList<'a>, report: &mut Report) {
    let (mut taken, mut nodes) = (BodyMotions::new(), HashSet::new());
    let directions = directions_of_lines(scene.places, step);
    for boundary in step.boundaries.iter().filter(|b| !b.is_thermal()) {
        let dofs = prescribed_dofs(scene, boundary, &mut taken, &mut nodes, report);
        if dofs.is_empty() {
            continue;
        }
        let origin = ConstraintOrigin::Motion(boundary, dofs.iter().map(|d| d.0).collect());
        let Err(origin) = list.keep(origin) else { continue };
        let ways = directions.get(&line_of(boundary)).map_or_else(String::new, |ways| ways.join(" and "));
        if let Some(motion) = add_motion(scene, boundary, &ways, dofs, list, report) {
            list.add(origin, motion);
        }
    }
    hold_axis(scene, step, &nodes, list, report);
}

/// Returns the degrees of freedom that a boundary condition prescribes, with their mesh nodes.
fn prescribed_dofs(
    scene: Scene,
    boundary: &BoundaryCondition,
    taken: &mut BodyMotions,
    nodes: &mut HashSet<Dof>,
    report: &mut Report,
) -> Vec<(Dof, usize)> {
    let mut dofs = Vec::new();
    let (kind, value) = prescribed(boundary);
    let mut radial = false;
    for &node in &boundary.nodes {
        if let Some(&place) = scene.places.rotations.get(&node).filter(|_| boundary.dof == 6) {
            let dof = Dof::Node(place, 0);
            if nodes.insert(dof) {
                dofs.push((dof, node));
            }
            continue;
        }
        if let Some(place) = scene.places.free_node(node) {
            let dof = Dof::Node(place, usize::from(boundary.dof).wrapping_sub(1));
            if boundary.dof <= 2 && nodes.insert(dof) {
                dofs.push((dof, node));
            }
            continue;
        }
        let Some(&body) = scene.bodies.of_node.get(&node) else { continue };
        if scene.bodies.list[body].spatial {
            let what = "a prescribed motion (*BOUNDARY)";
            refuse_on_spatial_body(boundary.span, &scene.bodies.list[body].name, what, report);
            continue;
        }
        if boundary.dof != 2 {
            radial = true;
        } else if scene.bodies.list[body].reference != node {
            dependent_node(scene.model, boundary, node, report);
        } else if let Some(other) = taken.get(&body) {
            if *other != (kind, value) {
                let message =
                    format!("body `{}` has two different prescribed motions along z", scene.bodies.list[body].name);
                report.push(Diagnostic::error("P008", message).at(boundary.span, "second prescribed motion"));
            }
        } else {
            taken.insert(body, (kind, value));
            dofs.push((Dof::Body(body), node));
        }
    }
    if radial {
        radial_boundary(boundary, report);
    }
    dofs
}

/// Returns the names of all directions of each boundary line, which may be several (ENCASTRE).
fn directions_of_lines<'a>(places: &'a SolidPlaces, step: &'a Step) -> LineDirections<'a> {
    let turns = |b: &BoundaryCondition| b.dof == 6 && b.nodes.iter().any(|n| places.rotations.contains_key(n));
    let mut directions = LineDirections::new();
    for boundary in step.boundaries.iter().filter(|b| b.dof <= 2 || turns(b)) {
        directions.entry(line_of(boundary)).or_default().push(along(boundary));
    }
    directions.values_mut().for_each(Vec::dedup);
    directions
}

fn add_motion(
    scene: Scene,
    boundary: &BoundaryCondition,
    ways: &str,
    dofs: Vec<(Dof, usize)>,
    list: &mut ConstraintList,
    report: &mut Report,
) -> Option<Box<dyn Constraint>> {
    if boundary.user {
        return add_user_motion(scene, boundary, dofs, list, report);
    }
    let (kind, value) = prescribed(boundary);
    let detail = match (kind, value) {
        (PrescribedQuantity::Displacement, 0.0) => format!("{}: fixed along {ways}", boundary.set),
        _ => format!("{}: {} {value} along {ways}", boundary.set, format!("{kind:?}").to_lowercase()),
    };
    let id = report.ledger_row(boundary.span, "prescribed motion", dofs.len(), unit(&dofs), detail);
    let magnitude = magnitude(scene, value, boundary.amplitude, report);
    let dofs: Vec<Dof> = dofs.into_iter().map(|d| d.0).collect();
    Some(Box::new(PrescribedMotion::new(id, kind, vec![magnitude], &dofs)))
}

/// Creates the motion of `*BOUNDARY, USER`. VDISP is called once per increment for each degree of freedom.
fn add_user_motion(
    scene: Scene,
    boundary: &BoundaryCondition,
    dofs: Vec<(Dof, usize)>,
    list: &mut ConstraintList,
    report: &mut Report,
) -> Option<Box<dyn Constraint>> {
    if boundary.dof == 6 {
        let message = "rotations of shells cannot be prescribed by a user subroutine";
        return report.refuse(Diagnostic::error("P015", message).at(boundary.span, "here"));
    }
    let asks = format!("the motion of `{}` is user-defined (*BOUNDARY, USER)", boundary.set);
    report.require_routine(boundary.span, "motion", &asks, "vdisp")?;
    let (kind, _) = prescribed(boundary);
    let detail = format!("{}: {kind:?} along {} by vdisp", boundary.set, along(boundary)).to_lowercase();
    let id = report.ledger_row(boundary.span, "prescribed motion", dofs.len(), unit(&dofs), detail);
    let mesh = &scene.model.mesh;
    let user_dof = |&(dof, node): &(Dof, usize)| UserDof {
        dof,
        number: number_of_node(scene.model, node),
        reference: mesh.points[node],
        offset: 0.0,
    };
    let first = report.shared.amplitude_count;
    report.shared.amplitude_count += dofs.len();
    let (set, user_dofs) = (boundary.set.to_uppercase(), dofs.iter().map(user_dof).collect());
    let amplitude = magnitude(scene, 1.0, boundary.amplitude, report);
    list.add_user_motion(UserMotion {
        set,
        kind,
        amplitude,
        dofs: user_dofs,
        first,
        increment_before: 0.0,
        has_begun: false,
    });
    let dofs: Vec<Dof> = dofs.into_iter().map(|d| d.0).collect();
    let sampled = |i| Magnitude { value: 1.0, shape: TimeFunction::Sampled(first + i) };
    Some(Box::new(PrescribedMotion::new(id, kind, (0..dofs.len()).map(sampled).collect(), &dofs)))
}

fn hold_axis(scene: Scene, step: &Step, nodes: &HashSet<Dof>, list: &mut ConstraintList, report: &mut Report) {
    let mesh = &scene.model.mesh;
    let on_axis = |n: &usize| mesh.points[*n][0] == 0.0;
    let free = scene.places.nodes.keys().filter(|n| on_axis(n)).filter_map(|n| scene.places.free_node(n));
    // Rotations are zero on the axis, where a shell would have a kink otherwise, and on rigid bodies.
    let carried = |n: &usize| scene.places.tied.contains_key(n);
    let turning: Vec<usize> =
        scene.places.rotations.iter().filter(|(n, _)| on_axis(n) || carried(n)).map(|r| *r.1).collect();
    let detail = if turning.is_empty() { "r = 0" } else { "r = 0; rotations on the axis and on rigid bodies are zero" };
    let places = free.chain(turning);
    let dofs: Vec<Dof> = places.map(|place| Dof::Node(place, 0)).filter(|dof| !nodes.contains(dof)).collect();
    if dofs.is_empty() {
        return;
    }
    if let Err(origin) = list.keep(ConstraintOrigin::Axis(dofs.clone())) {
        let id = report.ledger_row(step.span, "axis of symmetry", dofs.len(), "nodes", detail.into());
        let motion = PrescribedMotion::new(id, PrescribedQuantity::Velocity, vec![Magnitude::constant(0.0)], &dofs);
        list.add(origin, Box::new(motion));
    }
}

fn radial_boundary(boundary: &BoundaryCondition, report: &mut Report) {
    if boundary.value == 0.0 {
        let what = format!("*BOUNDARY {}, {}", boundary.set, boundary.dof);
        report.add_unused_card(boundary.span, what, "a rigid body of revolution moves along z only");
    } else {
        let message = "radial motion or rotation of a rigid body of revolution cannot be prescribed";
        report.push(
            Diagnostic::error("P103", message).at(boundary.span, "only degree of freedom 2 (z) can be prescribed"),
        );
    }
}

fn dependent_node(model: &Model, boundary: &BoundaryCondition, node: usize, report: &mut Report) {
    let name = &model.mesh.node_names[node];
    let message = format!("node {name} follows its rigid body; its motion cannot be prescribed");
    let finding = Diagnostic::error("P007", message).at(boundary.span, "here");
    report.push(finding.help("prescribe the motion of the body's REF NODE"));
}

/// Returns the line of `*BOUNDARY` of a condition.
fn line_of(boundary: &BoundaryCondition) -> BoundaryLine<'_> {
    BoundaryLine { span: boundary.span, set: &boundary.set, kind: boundary.kind }
}

fn along(boundary: &BoundaryCondition) -> &'static str {
    if boundary.dof == 6 { "the rotation" } else { ["r", "z"][usize::from(boundary.dof) - 1] }
}

fn unit(dofs: &[(Dof, usize)]) -> &'static str {
    if dofs.iter().all(|d| matches!(d.0, Dof::Body(_))) { "bodies" } else { "nodes" }
}

/// Returns whether a boundary condition fixes its nodes.
pub fn holds(boundary: &BoundaryCondition) -> bool {
    let (kind, value) = prescribed(boundary);
    value == 0.0 && kind != PrescribedQuantity::Acceleration
}

/// Returns the kind of motion that a boundary condition prescribes, and its value for amplitude 1.
fn prescribed(boundary: &BoundaryCondition) -> (PrescribedQuantity, f64) {
    match boundary.kind {
        // ABAQUS/Explicit ignores displacements without amplitude, which would be jumps.
        model::MotionKind::Displacement if boundary.amplitude.is_none() => (PrescribedQuantity::Displacement, 0.0),
        model::MotionKind::Displacement => (PrescribedQuantity::Displacement, boundary.value),
        model::MotionKind::Velocity => (PrescribedQuantity::Velocity, boundary.value),
        model::MotionKind::Acceleration => (PrescribedQuantity::Acceleration, boundary.value),
        // A temperature prescribes no motion.
        model::MotionKind::Temperature => (PrescribedQuantity::Displacement, 0.0),
    }
}
