//! Forces on nodes of deformable bodies: pressures on faces, the user's load, resistance of a target, gravity, forces.
//! Never here: rigid bodies.

use std::f64::consts::PI;

use super::body::NodeForce;
use crate::effect::cavity::Stack;
use crate::effect::user_load::UserLoad;
use crate::effect::{Cause, Halt, Magnitude};
use crate::kernel::facet::Facet;
use crate::state::Instant;
use crate::state::nodes::Node;
use crate::user::{LoadFailure, LoadPoints, MAX_BLOCK};

/// A face: its two nodes, so that the body lies to the left of the way from the first to the second.
pub type Face = [usize; 2];

/// Adds a pressure on a face, positive against the outward normal: the consistent forces of a uniform pressure,
/// -p n 2 pi L (2 r1 + r2)/6 on the first node.
#[inline]
fn push(face: Face, pressure: f64, nodes: &[Node], forces: &mut [[f64; 2]]) {
    let [a, b] = face.map(|n| &nodes[n]);
    let third = PI / 3.0 * pressure;
    // The outward normal times the length is (dz, -dr).
    let (n_r, n_z) = (third * (b.z - a.z), -third * (b.r - a.r));
    for (node, weight) in [(face[0], 2.0 * a.r + b.r), (face[1], a.r + 2.0 * b.r)] {
        forces[node][0] -= n_r * weight;
        forces[node][1] -= n_z * weight;
    }
}

/// A prescribed pressure on faces.
#[derive(Debug)]
pub struct FacePressure {
    /// What asked for it.
    pub cause: Cause,
    /// Faces.
    pub faces: Vec<Face>,
    /// Pressure.
    pub magnitude: Magnitude,
}

impl NodeForce for FacePressure {
    fn cause(&self) -> Cause {
        self.cause
    }

    fn add(&mut self, now: &Instant, nodes: &[Node], forces: &mut [[f64; 2]]) -> Result<(), Halt> {
        let pressure = self.magnitude.at(now);
        self.faces.iter().for_each(|&face| push(face, pressure, nodes, forces));
        Ok(())
    }
}

/// Concentrated forces along one axis.
#[derive(Debug)]
pub struct NodeConcentrated {
    /// What asked for it.
    pub cause: Cause,
    /// Nodes.
    pub nodes: Vec<usize>,
    /// 0 along r, 1 along z.
    pub axis: usize,
    /// Force on each node.
    pub magnitude: Magnitude,
}

impl NodeForce for NodeConcentrated {
    fn cause(&self) -> Cause {
        self.cause
    }

    fn add(&mut self, now: &Instant, _nodes: &[Node], forces: &mut [[f64; 2]]) -> Result<(), Halt> {
        let force = self.magnitude.at(now);
        self.nodes.iter().for_each(|&n| forces[n][self.axis] += force);
        Ok(())
    }
}

/// Gravity along z.
#[derive(Debug)]
pub struct NodeGravity {
    /// What asked for it.
    pub cause: Cause,
    /// Nodes and the mass that feels it.
    pub masses: Vec<(usize, f64)>,
    /// Acceleration along z.
    pub acceleration: Magnitude,
}

impl NodeForce for NodeGravity {
    fn cause(&self) -> Cause {
        self.cause
    }

    fn add(&mut self, now: &Instant, _nodes: &[Node], forces: &mut [[f64; 2]]) -> Result<(), Halt> {
        let acceleration = self.acceleration.at(now);
        self.masses.iter().for_each(|&(n, mass)| forces[n][1] += mass * acceleration);
        Ok(())
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
    faces: Vec<Face>,
    start: Vec<[f64; 2]>,
    coordinates: Vec<f64>,
    motion: Vec<f64>,
    directions: Vec<f64>,
    pressure: Vec<f64>,
}

impl FaceUser {
    /// The load on faces whose nodes are at these places at the start.
    pub fn new(load: UserLoad, faces: Vec<Face>, nodes: &[Node]) -> Self {
        let n = faces.len().min(MAX_BLOCK);
        FaceUser {
            start: faces.iter().map(|&f| see(f, nodes).place).collect(),
            load,
            faces,
            coordinates: vec![f64::NAN; 3 * n],
            motion: vec![0.0; 6 * n],
            directions: vec![f64::NAN; 9 * n],
            pressure: vec![f64::NAN; MAX_BLOCK + 1],
        }
    }

    /// Fills the arrays for a block of faces, `n` of them; their layout is said at [`LoadPoints`].
    fn show(&mut self, first: usize, n: usize, nodes: &[Node]) {
        for i in 0..n {
            let Seen { place, velocity, normal } = see(self.faces[first + i], nodes);
            let start = self.start[first + i];
            for axis in 0..2 {
                self.coordinates[axis * n + i] = place[axis];
                self.motion[axis * n + i] = velocity[axis];
                self.motion[(2 + axis) * n + i] = place[axis] - start[axis];
            }
            // A solid's normal is shown pointing inward; the second direction is the first turned counter-clockwise.
            for (slab, value) in [-normal[0], normal[1], -normal[1], -normal[0]].into_iter().enumerate() {
                self.directions[slab * n + i] = value;
            }
            self.pressure[i] = f64::NAN;
        }
        self.coordinates[2 * n..].fill(f64::NAN);
        self.directions[4 * n..].fill(f64::NAN);
        self.pressure[n..].fill(f64::NAN);
    }

    fn block(&mut self, first: usize, n: usize, now: &Instant) -> Result<(), LoadFailure> {
        let (normal_r, normal_z): (Vec<f64>, Vec<f64>) =
            (0..n).map(|i| (-self.directions[i], -self.directions[2 * n + i])).unzip();
        let points = LoadPoints {
            surface: &self.load.name,
            load_type: self.load.load_type,
            now: *now,
            amplitude: self.load.magnitude.amplitude(now),
            magnitude: self.load.magnitude.value,
            r: &self.coordinates[..n],
            z: &self.coordinates[n..2 * n],
            velocity_r: &self.motion[..n],
            velocity_z: &self.motion[n..2 * n],
            normal_r: &normal_r,
            normal_z: &normal_z,
            coordinates: &self.coordinates,
            motion: &self.motion,
            directions: &self.directions,
        };
        let pressure = &mut self.pressure[..n];
        self.load.routine.with(|r| r.pressure(&points, pressure))?;
        if let Some(i) = pressure.iter().position(|p| !p.is_finite()) {
            let reason = format!("it gave the pressure {} at face {}", pressure[i], first + i + 1);
            return Err(LoadFailure { point: Some(i), reason });
        }
        if self.pressure[n].is_nan() && self.pressure[MAX_BLOCK].is_nan() {
            return Ok(());
        }
        Err(LoadFailure::new(format!("it wrote past the nblock = {n} points of its argument value")))
    }
}

impl NodeForce for FaceUser {
    fn cause(&self) -> Cause {
        self.load.cause
    }

    fn add(&mut self, now: &Instant, nodes: &[Node], forces: &mut [[f64; 2]]) -> Result<(), Halt> {
        for first in (0..self.faces.len()).step_by(MAX_BLOCK) {
            let n = (self.faces.len() - first).min(MAX_BLOCK);
            self.show(first, n, nodes);
            let called = self.block(first, n, now);
            let what = || format!("the user load on `{}`", self.load.name);
            called.map_err(|failure| Halt::of_routine(&what(), now, &failure))?;
            for i in 0..n {
                push(self.faces[first + i], self.pressure[i], nodes, forces);
            }
        }
        Ok(())
    }
}

/// Resistance of a target that is not meshed, on faces that move into it.
pub struct FaceCavity {
    /// What asked for it.
    pub cause: Cause,
    /// Faces.
    pub faces: Vec<Face>,
    /// Layers.
    pub stack: Stack,
    /// Coulomb coefficient.
    pub friction: f64,
}

impl NodeForce for FaceCavity {
    fn cause(&self) -> Cause {
        self.cause
    }

    /// Pressure by the normal velocity of the face's middle, times the share of the face's area in each layer; friction
    /// against the tangential velocity.
    fn add(&mut self, _now: &Instant, nodes: &[Node], forces: &mut [[f64; 2]]) -> Result<(), Halt> {
        for &face in &self.faces {
            let [a, b] = face.map(|n| [nodes[n].r, nodes[n].z]);
            let Seen { velocity, normal, .. } = see(face, nodes);
            let into = velocity[0] * normal[0] + velocity[1] * normal[1];
            let Some(facet) = Facet::new(a, b, false).filter(|_| into > 0.0) else { continue };
            let pressure = self.stack.mean_stress(&facet, into);
            if pressure == 0.0 {
                continue;
            }
            push(face, pressure, nodes, forces);
            let along = velocity[1] * normal[0] - velocity[0] * normal[1];
            if self.friction > 0.0 && along != 0.0 {
                // Half of the face's friction on each node, against the motion along the tangent (-n_z, n_r).
                let force = 0.5 * self.friction * pressure * facet.area * -along.signum();
                for n in face {
                    forces[n][0] -= force * normal[1];
                    forces[n][1] += force * normal[0];
                }
            }
        }
        Ok(())
    }
}
