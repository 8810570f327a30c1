//! Forces on nodes of deformable bodies: pressures on faces, the user's load, resistance of a target, gravity, forces.
//! Never here: rigid bodies.

use std::f64::consts::PI;

use crate::element::body::{Behind, NodeForce};
use crate::kernel::facet::Facet;
use crate::load::cavity::Stack;
use crate::load::user_load::{Shown, UserLoad};
use crate::state::Instant;
use crate::state::archive::{Archive, Persist, persist_fields};
use crate::state::halt::Halt;
use crate::state::magnitude::Magnitude;
use crate::state::nodes::Node;
use crate::user::{LoadFailure, MAX_BLOCK};

/// A face: its two nodes, so that the body lies to the left of the way from the first to the second.
pub type Face = [usize; 2];

/// Whether a face belongs to one of these elements: its nodes follow each other there, and in no neighbour.
fn is_of(face: Face, elements: &[[u32; 4]]) -> bool {
    let [a, b] = face.map(|n| n as u32);
    elements.iter().any(|corners| (0..4).any(|i| corners[i] == a && corners[(i + 1) % 4] == b))
}

/// Forces on the nodes of a face by a pressure, positive against the outward normal: the consistent forces of a uniform
/// pressure, -p n 2 pi L (2 r1 + r2)/6 on the first node.
#[inline]
fn pushes(face: Face, pressure: f64, nodes: &[Node]) -> [[f64; 2]; 2] {
    let [a, b] = face.map(|n| &nodes[n]);
    let third = PI / 3.0 * pressure;
    // The outward normal times the length is (dz, -dr).
    let (n_r, n_z) = (third * (b.z - a.z), -third * (b.r - a.r));
    [2.0 * a.r + b.r, a.r + 2.0 * b.r].map(|weight| [-n_r * weight, -n_z * weight])
}

/// Adds a pressure on a face.
#[inline]
fn push(face: Face, pressure: f64, nodes: &[Node], forces: &mut [[f64; 2]]) {
    for (node, force) in face.into_iter().zip(pushes(face, pressure, nodes)) {
        forces[node] = [forces[node][0] + force[0], forces[node][1] + force[1]];
    }
}

/// A prescribed pressure on faces.
#[derive(Debug)]
pub struct FacePressure {
    /// Faces.
    pub faces: Vec<Face>,
    /// Pressure.
    pub magnitude: Magnitude,
}

impl NodeForce for FacePressure {
    fn add(&mut self, now: &Instant, nodes: &[Node], forces: &mut [[f64; 2]]) -> Result<(), Halt> {
        let pressure = self.magnitude.at(now);
        self.faces.iter().for_each(|&face| push(face, pressure, nodes, forces));
        Ok(())
    }

    fn release(&mut self, gone: &[[u32; 4]]) {
        self.faces.retain(|face| !is_of(*face, gone));
    }
}

/// Concentrated forces along one axis.
#[derive(Debug)]
pub struct NodeConcentrated {
    /// Nodes.
    pub nodes: Vec<usize>,
    /// 0 along r, 1 along z.
    pub axis: usize,
    /// Force on each node.
    pub magnitude: Magnitude,
}

impl NodeForce for NodeConcentrated {
    fn add(&mut self, now: &Instant, _nodes: &[Node], forces: &mut [[f64; 2]]) -> Result<(), Halt> {
        let force = self.magnitude.at(now);
        self.nodes.iter().for_each(|&n| forces[n][self.axis] += force);
        Ok(())
    }
}

/// Gravity along z.
#[derive(Debug)]
pub struct NodeGravity {
    /// Nodes and the mass that feels it.
    pub masses: Vec<(usize, f64)>,
    /// Whether it is all of their mass.
    pub whole: bool,
    /// Acceleration along z.
    pub acceleration: Magnitude,
}

impl NodeForce for NodeGravity {
    fn add(&mut self, now: &Instant, _nodes: &[Node], forces: &mut [[f64; 2]]) -> Result<(), Halt> {
        let acceleration = self.acceleration.at(now);
        self.masses.iter().for_each(|&(n, mass)| forces[n][1] += mass * acceleration);
        Ok(())
    }

    fn weigh(&mut self, mass: &[f64]) {
        if self.whole {
            self.masses.iter_mut().for_each(|m| m.1 = mass[m.0]);
        }
    }
}

/// What a routine or a resistance is shown of a face.
struct Seen {
    place: [f64; 2],
    velocity: [f64; 2],
    /// Outward.
    normal: [f64; 2],
}

fn see(face: Face, nodes: &[Node]) -> Seen {
    let [a, b] = face.map(|n| &nodes[n]);
    let (dr, dz) = (b.r - a.r, b.z - a.z);
    let length = dr.hypot(dz);
    Seen {
        place: [0.5 * (a.r + b.r), 0.5 * (a.z + b.z)],
        velocity: [0.5 * (a.v_r + b.v_r), 0.5 * (a.v_z + b.v_z)],
        normal: [dz / length, -dr / length],
    }
}

/// The user's pressure on faces. The routine is shown the velocity of the middle of the increment behind, as ABAQUS shows
/// it: with deformable bodies increments are short.
pub struct FaceUser {
    load: UserLoad,
    blocks: Vec<FaceBlock>,
}

/// At most [`MAX_BLOCK`] faces with the places of their middles at the start.
struct FaceBlock {
    faces: Vec<Face>,
    start: Vec<[f64; 2]>,
    /// Whether the element behind a face still carries.
    carries: Vec<bool>,
    shown: Shown,
}

impl FaceUser {
    /// The load on faces whose nodes are at these places at the start.
    pub fn new(load: UserLoad, faces: &[Face], nodes: &[Node]) -> Self {
        let block = |faces: &[Face]| FaceBlock {
            faces: faces.to_vec(),
            start: faces.iter().map(|&f| see(f, nodes).place).collect(),
            carries: vec![true; faces.len()],
            shown: Shown::new(faces.len()),
        };
        FaceUser { load, blocks: faces.chunks(MAX_BLOCK).map(block).collect() }
    }
}

impl FaceBlock {
    /// Brings the arrays to this instant and empties the answer.
    fn show(&mut self, nodes: &[Node], inward: bool) {
        let n = self.faces.len();
        self.shown.forget();
        for (i, (&face, start)) in self.faces.iter().zip(&self.start).enumerate() {
            let Seen { place, velocity, normal } = see(face, nodes);
            for axis in 0..2 {
                self.shown.coordinates[axis * n + i] = place[axis];
                self.shown.motion[axis * n + i] = velocity[axis];
                self.shown.motion[(2 + axis) * n + i] = place[axis] - start[axis];
            }
            self.shown.set_normal(i, normal, inward);
        }
    }

    fn evaluate(&mut self, load: &UserLoad, now: &Instant, amplitude: f64) -> Result<(), LoadFailure> {
        self.shown.call(load, now, amplitude)?;
        let finite = self.shown.pressure().iter().all(|p| p.is_finite());
        self.shown.accept(finite)
    }
}

impl NodeForce for FaceUser {
    fn see_accelerations(&mut self, acceleration: &[[f64; 2]]) {
        for block in &mut self.blocks {
            let n = block.faces.len();
            for (i, [a, b]) in block.faces.iter().map(|face| face.map(|n| acceleration[n])).enumerate() {
                block.shown.motion[4 * n + i] = 0.5 * (a[0] + b[0]);
                block.shown.motion[5 * n + i] = 0.5 * (a[1] + b[1]);
            }
        }
    }

    fn add(&mut self, now: &Instant, nodes: &[Node], forces: &mut [[f64; 2]]) -> Result<(), Halt> {
        let amplitude = self.load.magnitude.amplitude(now);
        for (i, block) in self.blocks.iter_mut().enumerate() {
            block.show(nodes, self.load.inward);
            let called = block.evaluate(&self.load, now, amplitude);
            called.map_err(|failure| block.shown.failure(&self.load, i * MAX_BLOCK, now, &failure))?;
            let loaded = block.faces.iter().zip(block.shown.pressure()).zip(&block.carries);
            for ((&face, &pressure), _) in loaded.filter(|face| *face.1) {
                push(face, pressure, nodes, forces);
            }
        }
        Ok(())
    }

    /// The routine goes on to be shown the face; its answer no longer counts.
    fn release(&mut self, gone: &[[u32; 4]]) {
        for block in &mut self.blocks {
            for (face, carries) in block.faces.iter().zip(&mut block.carries) {
                *carries &= !is_of(*face, gone);
            }
        }
    }
}

/// Resistance of a target that is not meshed, on faces that move into it.
pub struct FaceCavity {
    faces: Vec<Resisted>,
    /// Layers.
    stack: Stack,
    /// Coulomb coefficient.
    friction: f64,
}

/// A face and the forces on its two nodes, of pressure and of friction, now and an instant before.
struct Resisted {
    face: Face,
    /// Whether the element behind it still carries.
    carries: bool,
    now: Pair,
    before: Pair,
}

/// Forces on the two nodes of a face: of pressure, of friction.
type Pair = [[[f64; 2]; 2]; 2];

impl FaceCavity {
    /// The resistance of `stack` on faces, with a Coulomb coefficient.
    pub fn new(faces: &[Face], stack: Stack, friction: f64) -> Self {
        let resisted = |&face: &Face| Resisted { face, carries: true, now: Pair::default(), before: Pair::default() };
        FaceCavity { faces: faces.iter().map(resisted).collect(), stack, friction }
    }

    /// Pressure by the normal velocity of the face's middle, times the share of the face's area in each layer; friction
    /// against the tangential velocity.
    fn forces(&self, face: Face, nodes: &[Node]) -> Pair {
        let mut pair = Pair::default();
        let [a, b] = face.map(|n| [nodes[n].r, nodes[n].z]);
        let Seen { velocity, normal, .. } = see(face, nodes);
        let into = velocity[0] * normal[0] + velocity[1] * normal[1];
        let Some(facet) = Facet::new(a, b, false).filter(|_| into > 0.0) else { return pair };
        let pressure = self.stack.mean_stress(&facet, into);
        if pressure == 0.0 {
            return pair;
        }
        pair[0] = pushes(face, pressure, nodes);
        let along = velocity[1] * normal[0] - velocity[0] * normal[1];
        if self.friction > 0.0 && along != 0.0 {
            // Half of the face's friction on each node, against the motion along the tangent (-n_z, n_r).
            let force = 0.5 * self.friction * pressure * facet.area * -along.signum();
            pair[1] = [[-force * normal[1], force * normal[0]]; 2];
        }
        pair
    }
}

impl NodeForce for FaceCavity {
    fn add(&mut self, _now: &Instant, nodes: &[Node], forces: &mut [[f64; 2]]) -> Result<(), Halt> {
        for i in 0..self.faces.len() {
            let Resisted { face, carries, .. } = self.faces[i];
            let pair = if carries { self.forces(face, nodes) } else { Pair::default() };
            for (&n, force) in pair.iter().flat_map(|part| face.iter().zip(part)) {
                forces[n] = [forces[n][0] + force[0], forces[n][1] + force[1]];
            }
            let resisted = &mut self.faces[i];
            (resisted.before, resisted.now) = (resisted.now, pair);
        }
        Ok(())
    }

    fn dissipated(&self, behind: &Behind<'_>) -> [f64; 2] {
        let mut against = [0.0; 2];
        for Resisted { face, now, before, .. } in &self.faces {
            for (sum, (now, before)) in against.iter_mut().zip(now.iter().zip(before)) {
                for (&n, (now, before)) in face.iter().zip(now.iter().zip(before)) {
                    *sum -= behind.work(n, *now, *before);
                }
            }
        }
        against
    }

    fn release(&mut self, gone: &[[u32; 4]]) {
        self.faces.iter_mut().for_each(|f| f.carries &= !is_of(f.face, gone));
    }
}

impl Persist for FacePressure {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let FacePressure { faces, magnitude: _ } = self;
        faces.persist(archive);
    }
}

impl Persist for NodeConcentrated {
    fn persist(&mut self, _archive: &mut Archive<'_>) {
        let NodeConcentrated { nodes: _, axis: _, magnitude: _ } = self;
    }
}

impl Persist for NodeGravity {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let NodeGravity { masses, whole: _, acceleration: _ } = self;
        masses.as_mut_slice().persist(archive);
    }
}

impl Persist for FaceBlock {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let FaceBlock { faces: _, start: _, carries, shown } = self;
        persist_fields!(archive; carries.as_mut_slice(), shown);
    }
}

impl Persist for FaceUser {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let FaceUser { load: _, blocks } = self;
        blocks.as_mut_slice().persist(archive);
    }
}

impl Persist for FaceCavity {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let FaceCavity { faces, stack: _, friction: _ } = self;
        faces.as_mut_slice().persist(archive);
    }
}

impl Persist for Resisted {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let Resisted { face: _, carries, now, before } = self;
        persist_fields!(archive; carries, now, before);
    }
}
