//! A rigid plane z = const that nodes cannot pass.
//! Never here: deck words, contact of deformable surfaces with each other.
//!
//! Kinematic contact: where a node would be behind the plane at the end of an increment, an impulse puts it on the plane
//! (ABAQUS Analysis User's Guide, "Contact constraint enforcement methods in Abaqus/Explicit"). Nothing holds a node that
//! moves away. Friction takes of the velocity along the plane what Coulomb's law allows, and never turns it.

use super::Constraint;
use crate::state::EffectId;
use crate::state::archive::{Archive, Persist};
use crate::state::dofs::Dofs;
use crate::state::magnitude::Clock;

/// A plane and the nodes that may meet it.
#[derive(Clone, Debug)]
pub struct Wall {
    /// Its row of the ledger.
    pub id: EffectId,
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

impl Constraint for Wall {
    fn id(&self) -> EffectId {
        self.id
    }

    /// The body that carries the plane holds against what nodes do to it.
    fn accelerations(&mut self, dofs: &mut Dofs, _clock: &Clock<'_>) {
        dofs.bodies[self.body].reaction -= self.force;
    }

    /// Puts nodes that passed the plane in the increment back on it. What the impulse J does on a node is J times the mean of
    /// its velocities before and after; the plane's share J v is work of its motion, the rest is lost, as in the impact of a
    /// mass that does not rebound.
    fn motion(&mut self, dofs: &mut Dofs, _clock: &Clock<'_>, dt: f64) {
        let Dofs { bodies, nodes, energies } = dofs;
        let half = nodes.half;
        let body = &bodies[self.body];
        let (place, before) = (self.height + body.displacement, self.height + body.before.displacement);
        let tolerance = self.tolerance();
        self.force = 0.0;
        for &(n, slides) in &self.nodes {
            let mass = nodes.mass[n];
            let mut acceleration = nodes.acceleration[n];
            let node = &mut nodes[n];
            let came = self.side * (node.z - dt * node.v_z - before);
            let inside = node.r >= self.reach[0] && node.r <= self.reach[1];
            if self.side * (node.z - place) >= 0.0 || !inside || came < -tolerance {
                continue;
            }
            let started = node.v_z - half * acceleration[1];
            let change = (place - node.z) / dt;
            let impulse = mass * change;
            node.v_z += change;
            node.z = place;
            acceleration[1] += change / half;
            self.force -= impulse / half;
            let by_plane = impulse * body.velocity_half;
            energies.external += by_plane;
            energies.contact += by_plane - 0.5 * impulse * (started + node.v_z);
            if self.friction > 0.0 && slides {
                let most = self.friction * change.abs();
                let started = node.v_r - half * acceleration[0];
                let slowed = (-node.v_r).clamp(-most, most);
                node.v_r += slowed;
                node.r += dt * slowed;
                acceleration[0] += slowed / half;
                energies.friction -= 0.5 * mass * slowed * (started + node.v_r);
            }
            nodes.acceleration[n] = acceleration;
        }
    }

    fn moves_nodes(&self) -> bool {
        true
    }

    fn bytes(&self) -> usize {
        size_of::<(usize, bool)>() * self.nodes.capacity()
    }

    fn copy(&self) -> Box<dyn Constraint> {
        Box::new(self.clone())
    }
}

impl Persist for Wall {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let Wall { id: _, body: _, height: _, reach: _, side: _, friction: _, nodes: _, force } = self;
        force.persist(archive);
    }
}
