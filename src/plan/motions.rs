//! Prescribed motions of a step: of rigid bodies along z, of nodes along r and z, and of the axis of symmetry.
//! Never here: what they do in an increment.

use std::collections::HashSet;

use super::Compiler;
use super::steps::{ConstraintList, Origin};
use crate::constraint::Constraint;
use crate::constraint::motion::{Prescribed, PrescribedMotion};
use crate::constraint::user_motion::{UserDof, UserMotion};
use crate::deck::Diagnostic;
use crate::model::{self, Boundary, Step};
use crate::state::dofs::Dof;
use crate::state::magnitude::Magnitude;

/// Degrees of freedom whose motion is prescribed already, with what prescribes it.
type Taken = Vec<(Dof, Prescribed, f64)>;

impl<'a> Compiler<'a> {
    /// Adds what is prescribed in a step, and the axis, which holds r by itself.
    pub(super) fn motions(&mut self, step: &'a Step, list: &mut ConstraintList<'a>) {
        let (mut taken, mut nodes) = (Taken::new(), HashSet::new());
        for boundary in step.boundaries.iter().filter(|b| b.kind != model::Motion::Temperature) {
            let dofs = self.dofs(boundary, &mut taken, &mut nodes);
            if dofs.is_empty() {
                continue;
            }
            let origin = Origin::Motion(boundary, dofs.iter().map(|d| d.0).collect());
            let Err(origin) = list.keep(origin) else { continue };
            if let Some(motion) = self.motion(boundary, &self.ways(boundary, step), dofs, list) {
                list.add(origin, motion);
            }
        }
        self.axis(step, &nodes, list);
    }

    /// Degrees of freedom that a boundary prescribes, with their nodes of the mesh.
    fn dofs(&mut self, boundary: &Boundary, taken: &mut Taken, nodes: &mut HashSet<Dof>) -> Vec<(Dof, usize)> {
        let mut dofs = Vec::new();
        let (kind, value) = prescribed(boundary);
        let mut radial = false;
        for &node in &boundary.nodes {
            if let Some(&place) = self.places.rotations.get(&node).filter(|_| boundary.dof == 6) {
                let dof = Dof::Node(place, 0);
                if nodes.insert(dof) {
                    dofs.push((dof, node));
                }
                continue;
            }
            if let Some(place) = self.places.free_node(node) {
                let dof = Dof::Node(place, usize::from(boundary.dof).wrapping_sub(1));
                if boundary.dof <= 2 && nodes.insert(dof) {
                    dofs.push((dof, node));
                }
                continue;
            }
            let Some(&body) = self.body_of_node.get(&node) else { continue };
            if self.bodies[body].spatial {
                let name = self.bodies[body].name.clone();
                self.refuse_on_spatial_body(boundary.span, &name, "a prescribed motion (*BOUNDARY)");
                continue;
            }
            if boundary.dof != 2 {
                radial = true;
            } else if self.bodies[body].reference != node {
                self.dependent_node(boundary, node);
            } else if let Some(other) = taken.iter().find(|t| t.0 == Dof::Body(body)) {
                if (other.1, other.2) != (kind, value) {
                    let message = format!("body `{}` is given two motions along z", self.bodies[body].name);
                    self.diagnostics.push(Diagnostic::error("P008", message).at(boundary.span, "the second of them"));
                }
            } else {
                taken.push((Dof::Body(body), kind, value));
                dofs.push((Dof::Body(body), node));
            }
        }
        if radial {
            self.radial_boundary(boundary);
        }
        dofs
    }

    /// All ways along which the line of a boundary prescribes the same: ENCASTRE is more than one.
    fn ways(&self, boundary: &Boundary, step: &Step) -> String {
        let turns = |b: &Boundary| b.dof == 6 && b.nodes.iter().any(|n| self.places.rotations.contains_key(n));
        let of_line = |b: &&Boundary| b.span == boundary.span && b.set == boundary.set && b.kind == boundary.kind;
        let all = step.boundaries.iter().filter(of_line).filter(|b| b.dof <= 2 || turns(b));
        let mut ways: Vec<&str> = all.map(along).collect();
        ways.dedup();
        ways.join(" and ")
    }

    fn motion(
        &mut self,
        boundary: &Boundary,
        ways: &str,
        dofs: Vec<(Dof, usize)>,
        list: &mut ConstraintList<'a>,
    ) -> Option<Box<dyn Constraint>> {
        if boundary.user {
            return self.user_motion(boundary, dofs, list);
        }
        let (kind, value) = prescribed(boundary);
        let detail = match (kind, value) {
            (Prescribed::Displacement, 0.0) => format!("{}: held along {ways}", boundary.set),
            _ => format!("{}: {} {value} along {ways}", boundary.set, format!("{kind:?}").to_lowercase()),
        };
        let id = self.cause(boundary.span, "prescribed motion", dofs.len(), unit(&dofs), detail);
        let magnitude = self.magnitude(value, boundary.amplitude);
        let dofs: Vec<Dof> = dofs.into_iter().map(|d| d.0).collect();
        Some(Box::new(PrescribedMotion::new(id, kind, magnitude, &dofs)))
    }

    /// `*BOUNDARY, USER`: each degree of freedom follows what the routine is asked for once an increment.
    fn user_motion(
        &mut self,
        boundary: &Boundary,
        dofs: Vec<(Dof, usize)>,
        list: &mut ConstraintList<'a>,
    ) -> Option<Box<dyn Constraint>> {
        if boundary.dof == 6 {
            let message = "rotations of shells that a user's routine gives are not supported";
            return self.diagnostics.refuse(Diagnostic::error("P015", message).at(boundary.span, "here"));
        }
        if self.routines.motion.is_none() {
            let asks = format!("the motion of `{}` is the user's (*BOUNDARY, USER)", boundary.set);
            self.no_routine(boundary.span, "motion", &asks, "vdisp");
            return None;
        }
        self.called.push("vdisp");
        let (kind, _) = prescribed(boundary);
        let detail = format!("{}: {kind:?} along {} by the user", boundary.set, along(boundary)).to_lowercase();
        let id = self.cause(boundary.span, "prescribed motion", dofs.len(), unit(&dofs), detail);
        let mesh = &self.model.mesh;
        let asked = |&(dof, node): &(Dof, usize)| UserDof {
            dof,
            number: mesh.node_names[node].parse().unwrap_or(node as i32 + 1),
            reference: mesh.points[node],
            offset: 0.0,
        };
        let first = self.user_amplitude_count;
        self.user_amplitude_count += dofs.len();
        let (set, asked) = (boundary.set.to_uppercase(), dofs.iter().map(asked).collect());
        let amplitude = self.magnitude(1.0, boundary.amplitude);
        list.ask(UserMotion { set, kind, amplitude, asked, first, increment_before: 0.0, has_begun: false });
        let dofs: Vec<Dof> = dofs.into_iter().map(|d| d.0).collect();
        Some(Box::new(PrescribedMotion::told(id, kind, first, &dofs)))
    }

    fn axis(&mut self, step: &Step, nodes: &HashSet<Dof>, list: &mut ConstraintList<'a>) {
        let mesh = &self.model.mesh;
        let on_axis = |n: &usize| mesh.points[*n][0] == 0.0;
        let free = self.places.nodes.keys().filter(|n| on_axis(n)).filter_map(|n| self.places.free_node(*n));
        // A shell that turned on the axis would have a kink there; one that a rigid body carries does not turn.
        let carried = |n: &usize| self.places.tied.contains_key(n);
        let turning: Vec<usize> =
            self.places.rotations.iter().filter(|(n, _)| on_axis(n) || carried(n)).map(|r| *r.1).collect();
        let detail =
            if turning.is_empty() { "r = 0 held" } else { "r = 0 held; rotations there and on rigid bodies held" };
        let all = free.chain(turning);
        let dofs: Vec<Dof> = all.map(|place| Dof::Node(place, 0)).filter(|dof| !nodes.contains(dof)).collect();
        if dofs.is_empty() {
            return;
        }
        if let Err(origin) = list.keep(Origin::Axis(dofs.clone())) {
            let id = self.cause(step.span, "axis of symmetry", dofs.len(), "nodes", detail.into());
            let held = PrescribedMotion::new(id, Prescribed::Velocity, Magnitude::constant(0.0), &dofs);
            list.add(origin, Box::new(held));
        }
    }

    fn radial_boundary(&mut self, boundary: &Boundary) {
        if boundary.value == 0.0 {
            let what = format!("*BOUNDARY {}, {}", boundary.set, boundary.dof);
            self.unused(boundary.span, what, "a rigid body of revolution moves along z only");
        } else {
            let message = "radial motion or rotation of a rigid body of revolution cannot be prescribed";
            self.diagnostics.push(Diagnostic::error("P103", message).at(boundary.span, "only 2 (z) can move"));
        }
    }

    fn dependent_node(&mut self, boundary: &Boundary, node: usize) {
        let name = &self.model.mesh.node_names[node];
        let message = format!("node {name} follows its rigid body; its motion cannot be prescribed");
        let finding = Diagnostic::error("P007", message).at(boundary.span, "here");
        self.diagnostics.push(finding.help("prescribe the motion of the body's REF NODE"));
    }
}

fn along(boundary: &Boundary) -> &'static str {
    if boundary.dof == 6 { "the rotation" } else { ["r", "z"][usize::from(boundary.dof) - 1] }
}

fn unit(dofs: &[(Dof, usize)]) -> &'static str {
    if dofs.iter().all(|d| matches!(d.0, Dof::Body(_))) { "bodies" } else { "nodes" }
}

/// Whether a boundary holds its nodes where they are.
pub(super) fn holds(boundary: &Boundary) -> bool {
    let (kind, value) = prescribed(boundary);
    value == 0.0 && kind != Prescribed::Acceleration
}

/// What a boundary prescribes, and its value at amplitude 1.
fn prescribed(boundary: &Boundary) -> (Prescribed, f64) {
    match boundary.kind {
        // ABAQUS/Explicit ignores a displacement without amplitude: it would be a jump.
        model::Motion::Displacement if boundary.amplitude.is_none() => (Prescribed::Displacement, 0.0),
        model::Motion::Displacement => (Prescribed::Displacement, boundary.value),
        model::Motion::Velocity => (Prescribed::Velocity, boundary.value),
        model::Motion::Acceleration => (Prescribed::Acceleration, boundary.value),
        // It moves nothing.
        model::Motion::Temperature => (Prescribed::Displacement, 0.0),
    }
}
