//! A rigid plane z = const that nodes cannot pass.
//! Never here: deck words, contact of deformable surfaces with each other.
//!
//! Kinematic contact: where a node would be behind the plane at the end of an increment, an impulse puts it on the plane
//! (ABAQUS Analysis User's Guide, "Contact constraint enforcement methods in Abaqus/Explicit"). Nothing holds a node that
//! moves away. Friction takes of the velocity along the plane what Coulomb's law allows, and never turns it.

use crate::element::body::Solid;
use crate::state::BodyState;
use crate::state::archive::{Archive, Persist};

/// A plane and the nodes that may meet it.
#[derive(Clone, Debug)]
pub struct Wall {
    /// The body that carries it; its motion is given.
    pub body: usize,
    /// z of the plane at the start.
    pub height: f64,
    /// From which to which radius it reaches.
    pub reach: [f64; 2],
    /// 1 if nodes are above it, -1 if below.
    pub side: f64,
    /// Coulomb coefficient.
    pub friction: f64,
    /// Nodes that move freely along z, and whether they do along r.
    pub nodes: Vec<(usize, bool)>,
    /// Force along z on the plane over the increment behind.
    pub force: f64,
}

/// How far behind the plane a node counts as on it, as a fraction of its height and reach: rounding.
const ON_IT: f64 = 1e-9;

impl Wall {
    fn tolerance(&self) -> f64 {
        ON_IT * self.height.abs().max(self.reach[1] - self.reach[0])
    }
}

impl Solid {
    /// Puts nodes that passed a plane in the increment behind, of the length `dt`, back on it. What the impulse J does on a
    /// node is J times the mean of its velocities before and after; the plane's share J v is work of its motion, the rest
    /// is lost, as in the impact of a mass that does not rebound.
    pub fn meet_walls(&mut self, bodies: &[BodyState], dt: f64) {
        let half = self.half;
        for wall in &mut self.walls {
            let body = &bodies[wall.body];
            let (place, before) = (wall.height + body.displacement, wall.height + body.before.displacement);
            let tolerance = wall.tolerance();
            wall.force = 0.0;
            for &(n, slides) in &wall.nodes {
                let node = &mut self.nodes[n];
                let came = wall.side * (node.z - dt * node.v_z - before);
                let inside = node.r >= wall.reach[0] && node.r <= wall.reach[1];
                if wall.side * (node.z - place) >= 0.0 || !inside || came < -tolerance {
                    continue;
                }
                let (mass, acceleration) = (self.mass[n], &mut self.acceleration[n]);
                let started = node.v_z - half * acceleration[1];
                let change = (place - node.z) / dt;
                let impulse = mass * change;
                node.v_z += change;
                node.z = place;
                acceleration[1] += change / half;
                wall.force -= impulse / half;
                let by_plane = impulse * body.velocity_half;
                self.energies.external += by_plane;
                self.energies.contact += by_plane - 0.5 * impulse * (started + node.v_z);
                if wall.friction > 0.0 && slides {
                    let most = wall.friction * change.abs();
                    let started = node.v_r - half * acceleration[0];
                    let slowed = (-node.v_r).clamp(-most, most);
                    node.v_r += slowed;
                    node.r += dt * slowed;
                    acceleration[0] += slowed / half;
                    self.energies.friction -= 0.5 * mass * slowed * (started + node.v_r);
                }
            }
        }
    }
}

impl Persist for Wall {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let Wall { body: _, height: _, reach: _, side: _, friction: _, nodes: _, force } = self;
        force.persist(archive);
    }
}
