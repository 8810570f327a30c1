//! Resistance on the faces of deformable bodies; each face has its own velocity.

use super::face_motion::{FaceMotion, PreviousMotion, velocity_lost};
use super::stack::{LayerStack, is_level};
use super::tunnel::TunnelWall;
use crate::kernel::facet::Facet;
use crate::kernel::lanes::InlineMap;
use crate::kernel::lists::Memory;
use crate::kernel::topology::ElementNodes;
use crate::load::fields::FacetFields;
use crate::load::pressure::solid_face_forces;
use crate::load::{LastIncrement, SceneView, TargetDissipation};
use crate::mesh::surface::{CurrentFace, DeformableFaces};
use crate::platform::PortableMath as _;
use crate::state::archive::Persist;
use crate::state::direction;
use crate::state::dofs::Dofs;
use crate::state::limit::IncrementLimit;
use crate::state::nodes::Nodes;

/// Forces on the two nodes of a face, first of pressure, then of friction.
type FaceForces = [[[f64; 2]; 2]; 2];

/// Largest number of sweeps over faces that the resistance can stop within an increment.
const SWEEPS: usize = 8;
/// Change of all pressures in a sweep, as a fraction of the pressures of the law, below which sweeps end.
const SETTLED: f64 = 1e-4;

/// Resistance of a face, and whether it can stop the face.
#[derive(Clone, Copy, Debug, Default, Persist)]
struct FaceResistance {
    forces: FaceForces,
    /// Pressure as a fraction of that of the law.
    share: f64,
    /// Whether the face is at rest along its normal, or can be with other forces of its neighbours.
    near_rest: bool,
}

/// Faces with their current and previous forces.
#[derive(Clone, Debug, Persist, Memory)]
#[persist(fixed: current, before, previous; present: tunnel)]
pub(super) struct SkinResistance {
    skin: DeformableFaces,
    /// Resistance at the current instant.
    current: Vec<FaceResistance>,
    /// Forces at the previous instant.
    before: Vec<FaceForces>,
    /// Previous motion of the nodes of each face.
    previous: Vec<[PreviousMotion; 2]>,
    /// The tunnel wall, if faces that separate from it are ignored.
    tunnel: Option<TunnelWall>,
}

impl SkinResistance {
    pub(super) fn new(skin: DeformableFaces) -> Self {
        let count = skin.max_faces();
        let (current, preceding) = (vec![FaceResistance::default(); count], vec![FaceForces::default(); count]);
        SkinResistance { current, before: preceding, previous: vec![Default::default(); count], skin, tunnel: None }
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

    /// Adds the nodal forces. Pressures of faces at rest along their normals are reactions that depend on each other:
    /// sweeps over these faces begin with the forces of the previous instant and end when the pressures do not change.
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
        self.begin(view, forces);
        for _ in 0..SWEEPS {
            if self.sweep(stack, friction, view, forces)? <= SETTLED {
                break;
            }
        }
        for (face, previous) in self.skin.faces.iter().zip(&mut self.previous) {
            *previous = face.inline_map(|n| PreviousMotion::now(view, forces, n));
        }
        if let Some(tunnel) = &mut self.tunnel {
            self.skin.active_faces().for_each(|face| tunnel.widen(&CurrentFace::new(face, &view.dofs.nodes)));
        }
        Ok(())
    }

    /// Moves the forces to the previous instant, keeps those of faces at rest, and adds these to the nodal forces.
    /// The share of other faces is NaN: the first sweep evaluates these.
    fn begin(&mut self, view: &SceneView<'_>, forces: &mut [[f64; 2]]) {
        let faces = self.skin.faces.iter().zip(&self.skin.is_active);
        for (((&nodes, &carries), current), before) in faces.zip(&mut self.current).zip(&mut self.before) {
            *before = current.forces;
            let touches = carries && self.tunnel.as_ref().is_none_or(|tunnel| touches_wall(tunnel, nodes, view));
            if !(touches && current.near_rest) {
                *current = FaceResistance { share: if touches { f64::NAN } else { 0.0 }, ..FaceResistance::default() };
                continue;
            }
            add_forces(nodes, &current.forces, 1.0, forces);
        }
    }

    /// Evaluates the faces near rest and those not evaluated yet. Returns the largest change of a share.
    ///
    /// # Errors
    /// The normal velocity of the face, if its resistance is not finite.
    fn sweep(
        &mut self,
        stack: &LayerStack,
        friction: f64,
        view: &SceneView<'_>,
        forces: &mut [[f64; 2]],
    ) -> Result<f64, f64> {
        let mut change: f64 = 0.0;
        for ((&nodes, current), previous) in self.skin.faces.iter().zip(&mut self.current).zip(&self.previous) {
            let is_new = current.share.is_nan();
            if !(is_new || current.near_rest) {
                continue;
            }
            if !is_new {
                add_forces(nodes, &current.forces, -1.0, forces);
            }
            let share = current.share;
            *current = on_face(stack, friction, view, nodes, (previous, forces))?;
            add_forces(nodes, &current.forces, 1.0, forces);
            if current.near_rest {
                change = change.max(if is_new { 1.0 } else { (current.share - share).abs() });
            }
        }
        Ok(change)
    }

    /// Returns the work over the previous increment against pressure and friction.
    pub(super) fn dissipated(&self, dofs: &Dofs) -> TargetDissipation {
        let last = LastIncrement::new(dofs);
        let mut against = [0.0; 2];
        for (nodes, (now, before)) in self.skin.faces.iter().zip(self.current.iter().zip(&self.before)) {
            for (sum, (now, before)) in against.iter_mut().zip(now.forces.iter().zip(before)) {
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
}

fn touches_wall(tunnel: &TunnelWall, nodes: [usize; 2], view: &SceneView<'_>) -> bool {
    let face = CurrentFace::new(nodes, &view.dofs.nodes);
    tunnel.is_touched_by(&face, direction(face.mean(|n| view.velocity(n))[1]))
}

fn add_forces(nodes: [usize; 2], parts: &FaceForces, sign: f64, forces: &mut [[f64; 2]]) {
    for (n, force) in parts.iter().flat_map(|part| nodes.into_iter().zip(part)) {
        forces[n] = [forces[n][0] + sign * force[0], forces[n][1] + sign * force[1]];
    }
}

/// Returns the resistance of a face: the pressure at the normal velocity of its midpoint, weighted by area over the
/// layers, and friction against the tangential velocity. Both are limited to what stops the face, given the previous
/// motion of its nodes and the forces of other loads and faces. A face at rest has the pressure that keeps it at rest,
/// at most that of the law for vanishing velocity. Equations (2.16), (2.17).
fn on_face(
    stack: &LayerStack,
    friction: f64,
    view: &SceneView<'_>,
    nodes: [usize; 2],
    others: (&[PreviousMotion; 2], &[[f64; 2]]),
) -> Result<FaceResistance, f64> {
    let mut result = FaceResistance::default();
    let face = CurrentFace::new(nodes, &view.dofs.nodes);
    let (velocity, normal) = (face.mean(|n| view.velocity(n)), face.normal);
    let into = velocity[0] * normal[0] + velocity[1] * normal[1];
    // A face on the axis has no area.
    let facet = Facet::new(face.ends[0], face.ends[1], false).filter(|facet| facet.area > 0.0);
    let Some(facet) = facet else { return Ok(result) };
    let law = stack.mean_stress(&facet, into.max(0.0));
    if law == 0.0 {
        return Ok(result);
    }
    if !law.is_finite() {
        return Err(into);
    }
    let forces = solid_face_forces(&face, law, view.rings);
    let (loaded, lost) = (into > 0.0, velocity_lost(view, &face, normal, &forces));
    // The law cannot stop a face that moves away this fast, if other forces turn its motion.
    if !loaded && (into.is_nan() || into <= -lost) {
        return Ok(result);
    }
    let motion = FaceMotion::new(view, &face, normal, others);
    if !loaded && motion.is_constrained {
        return Ok(result);
    }
    let velocity_bound = motion.velocity_to_rest();
    result.near_rest = velocity_bound > -lost && velocity_bound < 2.0 * lost;
    let taken = velocity_bound.max(0.0);
    result.share = if lost > taken { taken / lost } else { 1.0 };
    let share = result.share;
    if share == 0.0 {
        return Ok(result);
    }
    result.forces[0] = forces.inline_map(|force| force.inline_map(|f| share * f));
    let along = velocity[1] * normal[0] - velocity[0] * normal[1];
    if friction > 0.0 && along != 0.0 {
        result.forces[1] = friction_forces(view, &face, (&facet, friction * share * law), along, others);
    }
    Ok(result)
}

/// Returns the nodal forces of a friction traction against the tangential velocity `along`, at most those that stop the
/// face along its tangent (-n_z, n_r). Half of the friction acts on each node.
fn friction_forces(
    view: &SceneView<'_>,
    face: &CurrentFace,
    (facet, traction): (&Facet, f64),
    along: f64,
    others: (&[PreviousMotion; 2], &[[f64; 2]]),
) -> [[f64; 2]; 2] {
    let normal = face.normal;
    let area = |node: usize| view.rings.map_or(facet.area, |rings| rings[node] * facet.length());
    let force = face.nodes.inline_map(|node| 0.5 * traction * -along.signum() * area(node));
    let forces = force.inline_map(|f| [-f * normal[1], f * normal[0]]);
    let direction = [-normal[1], normal[0]].inline_map(|tangent| along.signum() * tangent);
    let velocity_bound = FaceMotion::new(view, face, direction, others).velocity_to_rest().max(0.0);
    let lost = velocity_lost(view, face, direction, &forces);
    let share = if lost > velocity_bound { velocity_bound / lost } else { 1.0 };
    forces.inline_map(|force| force.inline_map(|f| share * f))
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
