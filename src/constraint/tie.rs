//! Nodes of deformable bodies that belong to a rigid body as well: they move with it, and it takes their forces.
//! Never here: the motion of rigid bodies.

use crate::element::body::Solid;
use crate::state::BodyState;

/// The nodes that one rigid body carries. Their mass is the body's, in the solver they have none.
#[derive(Clone, Debug, PartialEq)]
pub struct Tie {
    /// Body.
    pub body: usize,
    /// Nodes, ascending.
    pub nodes: Vec<usize>,
}

impl Solid {
    /// Forces along z of elements and loads on tied nodes, one sum a tie. Forces along r meet themselves around the ring.
    pub fn tie_forces(&self, out: &mut [f64]) {
        for (tie, out) in self.ties.iter().zip(out) {
            let force = |&n: &usize| {
                let more = self.external[0].get(n).map_or(0.0, |f| f[1]);
                self.gather.one(n, &self.corners)[1] + more
            };
            *out = tie.nodes.iter().map(force).sum();
        }
    }

    /// Tied nodes show the acceleration of their bodies.
    pub fn accelerate_ties(&mut self, bodies: &[BodyState]) {
        for tie in &self.ties {
            let acceleration = bodies[tie.body].acceleration;
            tie.nodes.iter().for_each(|&n| self.acceleration[n] = [0.0, acceleration]);
        }
    }

    /// Puts tied nodes where their bodies are; `velocity` is what they move with.
    pub fn follow(&mut self, bodies: &[BodyState], velocity: impl Fn(&BodyState) -> f64) {
        for tie in &self.ties {
            let body = &bodies[tie.body];
            for &n in &tie.nodes {
                let [r, z] = self.start[n];
                let node = &mut self.nodes[n];
                (node.r, node.z) = (r, z + body.displacement);
                (node.v_r, node.v_z) = (0.0, velocity(body));
            }
        }
    }
}
