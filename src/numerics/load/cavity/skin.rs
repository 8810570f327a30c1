//! Resistance on the faces of deformable bodies; each face has its own velocity.

use super::stack::{LayerStack, is_level};
use super::tunnel::TunnelWall;
use crate::kernel::facet::Facet;
use crate::kernel::lanes::InlineMap;
use crate::kernel::lists::heap_bytes;
use crate::kernel::topology::ElementNodes;
use crate::load::fields::FacetFields;
use crate::load::pressure::solid_face_forces;
use crate::load::{LastIncrement, SceneView, TargetDissipation};
use crate::mesh::surface::{CurrentFace, DeformableFaces};
use crate::platform::PortableMath as _;
use crate::state::archive::persist_struct;
use crate::state::direction;
use crate::state::dofs::Dofs;
use crate::state::limit::IncrementLimit;
use crate::state::nodes::Nodes;

/// Forces on the two nodes of a face, first of pressure, then of friction.
type FaceForces = [[[f64; 2]; 2]; 2];

/// Motion of a node at the previous instant, from which the effect of constraints follows.
#[derive(Clone, Copy, Debug, Default)]
struct PreviousMotion {
    /// Velocity in the middle of the increment before that instant.
    velocity: [f64; 2],
    /// Sum of the forces of elements and loads.
    force: [f64; 2],
}

/// Faces with their current and previous forces.
#[derive(Clone, Debug)]
pub(super) struct SkinResistance {
    skin: DeformableFaces,
    forces: Vec<[FaceForces; 2]>,
    /// Previous motion of the nodes of each face.
    previous: Vec<[PreviousMotion; 2]>,
    /// The tunnel wall, if faces that separate from it are ignored.
    tunnel: Option<TunnelWall>,
}

impl SkinResistance {
    pub(super) fn new(skin: DeformableFaces) -> Self {
        let count = skin.max_faces();
        let (forces, previous) = (vec![[FaceForces::default(); 2]; count], vec![Default::default(); count]);
        SkinResistance { forces, previous, skin, tunnel: None }
    }

    /// Ignores faces inside the tunnel from now on.
    pub(super) fn ignore_opened_tunnel(&mut self, nodes: &Nodes) {
        let faces = || self.skin.faces.iter().map(|face| CurrentFace::new(*face, nodes).ends);
        let shortest = faces().map(|[a, b]| (b[0] - a[0]).portable_hypot(b[1] - a[1])).fold(f64::INFINITY, f64::min);
        let heights = || faces().flatten().map(|end| end[1]);
        let length = heights().fold(f64::NEG_INFINITY, f64::max) - heights().fold(f64::INFINITY, f64::min);
        if shortest.is_finite() {
            self.tunnel = Some(TunnelWall::new(shortest, length));
        }
    }

    /// Copies the tunnel of the resistance that this one replaces, if they share faces.
    pub(super) fn continue_from(&mut self, previous: &SkinResistance) {
        let shared = || self.skin.faces.iter().any(|face| previous.skin.faces.contains(face));
        if self.tunnel.is_some() && previous.tunnel.is_some() && shared() {
            self.tunnel.clone_from(&previous.tunnel);
        }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.skin.max_faces() == 0
    }

    /// Adds the nodal forces.
    ///
    /// # Errors
    /// The normal velocity of the face, if its resistance is not finite.
    pub(super) fn resist(
        &mut self,
        stack: &LayerStack,
        friction: f64,
        view: &SceneView<'_>,
        forces: &mut [[f64; 2]],
    ) -> Result<(), f64> {
        let faces = self.skin.faces.iter().zip(&self.skin.is_active);
        for (((&nodes, &carries), [now, before]), previous) in faces.zip(&mut self.forces).zip(&self.previous) {
            *before = *now;
            let touches = carries && self.tunnel.as_ref().is_none_or(|tunnel| touches_wall(tunnel, nodes, view));
            *now = if touches {
                on_face(stack, friction, view, nodes, (previous, forces))?
            } else {
                FaceForces::default()
            };
            for (n, force) in now.iter().flat_map(|part| nodes.into_iter().zip(part)) {
                forces[n] = [forces[n][0] + force[0], forces[n][1] + force[1]];
            }
        }
        for (face, previous) in self.skin.faces.iter().zip(&mut self.previous) {
            *previous = face.inline_map(|n| PreviousMotion {
                velocity: view.dofs.nodes.velocity_after(n, 0.0),
                force: known_force(view, forces, n),
            });
        }
        if let Some(tunnel) = &mut self.tunnel {
            self.skin.active_faces().for_each(|face| tunnel.widen(&CurrentFace::new(face, &view.dofs.nodes)));
        }
        Ok(())
    }

    /// Returns the work over the previous increment against pressure and friction.
    pub(super) fn dissipated(&self, dofs: &Dofs) -> TargetDissipation {
        let last = LastIncrement::new(dofs);
        let mut against = [0.0; 2];
        for (nodes, [now, before]) in self.skin.faces.iter().zip(&self.forces) {
            for (sum, (now, before)) in against.iter_mut().zip(now.iter().zip(before)) {
                for (&n, (now, before)) in nodes.iter().zip(now.iter().zip(before)) {
                    *sum -= last.work(n, *now, *before);
                }
            }
        }
        let [cavity, friction] = against;
        TargetDissipation { cavity, friction }
    }

    pub(super) fn remove_elements(&mut self, deleted: &[ElementNodes]) {
        self.skin.remove_elements(deleted);
    }

    /// Returns the limit on the next time increment. A face normal to the axis enters a layer as a whole, so its force
    /// jumps there; another face may pass a plane by at most its own extent.
    pub(super) fn limit(&self, stack: &LayerStack, nodes: &Nodes) -> IncrementLimit {
        let limits = self.skin.active_faces().map(|face| face_limit(stack, &CurrentFace::new(face, nodes), nodes));
        limits.fold(IncrementLimit::NONE, IncrementLimit::earlier)
    }

    pub(super) fn show(&self, stack: &LayerStack, nodes: &Nodes, fields: &mut FacetFields) {
        for ((&face, &element), &carries) in self.skin.faces.iter().zip(&self.skin.elements).zip(&self.skin.is_active) {
            let face = CurrentFace::new(face, nodes);
            let into = face.normal_velocity(nodes);
            let facet = Facet::new(face.ends[0], face.ends[1], false);
            let sign = direction(face.mean(|n| nodes.velocity_now(n))[1]);
            let touches = carries && self.tunnel.as_ref().is_none_or(|tunnel| tunnel.is_touched_by(&face, sign));
            let loaded = facet.filter(|_| touches && into > 0.0);
            fields.push(element, loaded.map_or(0.0, |f| stack.mean_stress(&f, into)), into);
            if let Some(layer) = fields.layer.last_mut() {
                *layer = facet.map_or(0.0, |f| stack.number_of(&f) as f64);
            }
        }
    }

    pub(super) fn bytes(&self) -> usize {
        let tunnel = self.tunnel.as_ref().map_or(0, TunnelWall::bytes);
        self.skin.bytes() + heap_bytes(&self.forces) + heap_bytes(&self.previous) + tunnel
    }
}

fn touches_wall(tunnel: &TunnelWall, nodes: [usize; 2], view: &SceneView<'_>) -> bool {
    let face = CurrentFace::new(nodes, &view.dofs.nodes);
    tunnel.is_touched_by(&face, direction(face.mean(|n| view.velocity(n))[1]))
}

/// Returns the nodal forces of a face: the pressure at the normal velocity of its midpoint, weighted by area over the
/// layers, and friction against the tangential velocity. Both are limited to what stops the face, given the previous
/// motion of its nodes and the forces of other loads.
fn on_face(
    stack: &LayerStack,
    friction: f64,
    view: &SceneView<'_>,
    nodes: [usize; 2],
    others: (&[PreviousMotion; 2], &[[f64; 2]]),
) -> Result<FaceForces, f64> {
    let mut pair = FaceForces::default();
    let face = CurrentFace::new(nodes, &view.dofs.nodes);
    let (velocity, normal) = (face.mean(|n| view.velocity(n)), face.normal);
    let into = velocity[0] * normal[0] + velocity[1] * normal[1];
    let Some(facet) = Facet::new(face.ends[0], face.ends[1], false).filter(|_| into > 0.0) else { return Ok(pair) };
    let pressure = stack.mean_stress(&facet, into);
    if pressure == 0.0 {
        return Ok(pair);
    }
    if !pressure.is_finite() {
        return Err(into);
    }
    pair[0] = solid_face_forces(&face, pressure, view.rings);
    let share = share_to_rest(view, &face, normal, &pair[0], others);
    pair[0] = pair[0].inline_map(|force| force.inline_map(|f| share * f));
    let along = velocity[1] * normal[0] - velocity[0] * normal[1];
    if friction > 0.0 && along != 0.0 {
        // Half of the friction on each node, against the motion along the tangent (-n_z, n_r).
        let traction = friction * share * pressure * -along.signum();
        let area = |node: usize| view.rings.map_or(facet.area, |rings| rings[node] * facet.length());
        let force = nodes.inline_map(|node| 0.5 * traction * area(node));
        pair[1] = force.inline_map(|f| [-f * normal[1], f * normal[0]]);
        let motion = [-normal[1], normal[0]].inline_map(|tangent| along.signum() * tangent);
        let share = share_to_rest(view, &face, motion, &pair[1], others);
        pair[1] = pair[1].inline_map(|force| force.inline_map(|f| share * f));
    }
    Ok(pair)
}

/// Returns the sum of the forces of elements and loads on a node.
fn known_force(view: &SceneView<'_>, loads: &[[f64; 2]], node: usize) -> [f64; 2] {
    let ([r, z], [more_r, more_z]) = (view.element_force.map_or([0.0; 2], |force| force(node)), loads[node]);
    [r + more_r, z + more_z]
}

/// Returns the share of nodal forces against the motion of a face along `direction` that stops this motion within the
/// next increment; 1 if all forces do not stop it. More would reverse the motion and do work on the body: the force of
/// an increment acts with the mean of the velocities in the middle of the increments before and after it. Constraints
/// are taken to change the velocity of a node as over the previous increment.
fn share_to_rest(
    view: &SceneView<'_>,
    face: &CurrentFace,
    direction: [f64; 2],
    resistance: &[[f64; 2]; 2],
    (previous, loads): (&[PreviousMotion; 2], &[[f64; 2]]),
) -> f64 {
    let nodes = &view.dofs.nodes;
    let (mut before, mut after, mut lost) = (0.0, 0.0, 0.0);
    for ((&n, resistance), previous) in face.nodes.iter().zip(resistance).zip(previous) {
        let (velocity, force) = (nodes.velocity_after(n, 0.0), known_force(view, loads, n));
        let [dt, half] = [nodes.previous_dt, nodes.half].inline_map(|time| time * nodes.inverse_mass[n]);
        let change = |i: usize| dt * force[i] + (velocity[i] - previous.velocity[i] - half * previous.force[i]);
        // A node on the axis does not move along r.
        let along = [if nodes[n].r == 0.0 { 0.0 } else { direction[0] }, direction[1]];
        let part = |vector: [f64; 2]| along[0] * vector[0] + along[1] * vector[1];
        before += part(velocity);
        after += part(velocity) + part([change(0), change(1)]);
        lost -= dt * part(*resistance);
    }
    let most = after.min(after + before).max(0.0);
    if lost > most { most / lost } else { 1.0 }
}

fn face_limit(stack: &LayerStack, face: &CurrentFace, nodes: &Nodes) -> IncrementLimit {
    let velocity = face.mean(|n| nodes.velocity_now(n))[1];
    let into = face.normal_velocity(nodes);
    if into.is_nan() || into <= 0.0 || velocity == 0.0 {
        return IncrementLimit::NONE;
    }
    let sign = velocity.signum();
    let [a, b] = face.ends.inline_map(|end| sign * end[1]);
    let leading = sign * a.max(b);
    let rounding = 1e-12 * leading.abs().max((face.ends[1][0] - face.ends[0][0]).abs());
    let ahead = stack.distance_ahead(leading, sign, rounding);
    let jump = is_level(face.normal);
    let distance = if jump { ahead } else { ahead + (a - b).abs() };
    IncrementLimit { time: distance / velocity.abs(), jump }
}

persist_struct!(PreviousMotion { velocity, force });

persist_struct!(SkinResistance { skin, forces: fixed, previous: fixed, tunnel: present });
