//! Solver nodes that belong to rigid bodies: nodes shared with deformable elements, ends of springs and dashpots.

use std::collections::BTreeMap;

use crate::constraint::tie::TiedNodes;
use crate::plan::{Bodies, Report, SolidPlaces};

/// Creates the ties of nodes to rigid bodies. The mass of deformable elements at tied nodes is moved to the rigid bodies.
pub fn tie_to_bodies(
    bodies: &mut Bodies,
    places: &SolidPlaces,
    mass: &mut [f64],
    report: &mut Report,
) -> Vec<TiedNodes> {
    let mut ties = Vec::new();
    let mut by_body: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (node, &body) in places.tied.iter() {
        by_body.entry(body).or_default().push(places.nodes[&node]);
    }
    for (body, mut nodes) in by_body {
        nodes.sort_unstable();
        let tied: f64 = nodes.iter().map(|&n| mass[n]).sum();
        nodes.iter().for_each(|&n| mass[n] = 0.0);
        bodies.list[body].tied_mass += tied;
        let detail = if tied > 0.0 {
            format!("shared with deformable elements, whose nodal mass {tied} is added to the rigid body")
        } else {
            "forces on them act on the rigid body".into()
        };
        let id = report.ledger_row(bodies.list[body].span, "tied nodes", nodes.len(), "nodes", detail);
        ties.push(TiedNodes { id, body, nodes });
    }
    ties
}
