//! Nodes that rigid and deformable bodies share.
//! Never here: rigid bodies without such nodes.

use std::collections::BTreeMap;

use super::Compiler;
use crate::constraint::tie::Tie;

impl Compiler<'_> {
    /// Ties of shared nodes; the mass that elements put on them goes over to the bodies.
    pub(super) fn tie(&mut self, mass: &mut [f64]) {
        let mut by_body: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (node, &body) in self.places.tied.iter() {
            by_body.entry(body).or_default().push(self.places.nodes[node]);
        }
        for (body, mut nodes) in by_body {
            nodes.sort_unstable();
            let tied: f64 = nodes.iter().map(|&n| mass[n]).sum();
            nodes.iter().for_each(|&n| mass[n] = 0.0);
            self.bodies[body].tied_mass += tied;
            let detail = format!("shared with deformable elements, whose mass there, {tied}, the body carries");
            let id = self.cause(self.bodies[body].span, "tied nodes", nodes.len(), "nodes", detail);
            self.ties.push(Tie { id, body, nodes });
        }
    }
}
