//! `*TIE`: which nodes of a slave surface lie on a master surface, and where.
//! Never here: what keeps them there.

use std::collections::HashSet;

use crate::deck::{Diagnostic, Diagnostics};
use crate::model::{Model, SurfaceTie};
use crate::platform::PortableMath as _;

/// A node that follows the point of a master surface that is nearest to it (ABAQUS Analysis User's Guide, "Mesh tie
/// constraints", node-to-surface approach).
#[derive(Clone, Debug, PartialEq)]
pub(super) struct TiedNode {
    /// Index of its tie in the model.
    pub tie: usize,
    /// The node.
    pub node: usize,
    /// Element of the master surface behind it.
    pub element: usize,
    /// Nodes of the facet with their shares in the point; one where the point is a node.
    pub shares: Vec<(usize, f64)>,
    /// That point.
    pub place: [f64; 2],
}

/// A facet of a master surface.
struct MasterFacet {
    nodes: [usize; 2],
    element: usize,
}

/// How close to a node of a facet, as a fraction of it, a point counts as that node.
const ON_NODE: f64 = 1e-6;

/// The tied nodes of all ties; what is not tied is told.
pub(super) fn find(model: &Model, diagnostics: &mut Diagnostics) -> Vec<TiedNode> {
    let (mut tied, mut taken): (Vec<TiedNode>, HashSet<usize>) = Default::default();
    for (index, tie) in model.constraints.ties.iter().enumerate() {
        let facet = |&(element, side)| Some(MasterFacet { nodes: model.mesh.ends(element, side)?, element });
        let facets: Vec<MasterFacet> = tie.masters.iter().filter_map(facet).collect();
        let own: HashSet<usize> = facets.iter().flat_map(|f| f.nodes).collect();
        let tolerance = tie.tolerance.unwrap_or_else(|| 0.05 * mean_length(model, &facets));
        let before = tied.len();
        let mut left: Vec<(usize, f64)> = Vec::new();
        for &node in tie.slaves.iter().filter(|n| !own.contains(n)) {
            let Some((at, distance)) = nearest(model, &facets, index, node) else { continue };
            let chosen = match &tie.chosen {
                Some(list) => list.binary_search(&node).is_ok(),
                None => distance <= tolerance * (1.0 + 1e-9),
            };
            if !chosen {
                left.push((node, distance));
            } else if taken.insert(node) {
                tied.push(at);
            }
        }
        tell(model, tie, &left, tied.len() - before, tolerance, diagnostics);
    }
    tied
}

fn mean_length(model: &Model, facets: &[MasterFacet]) -> f64 {
    let length = |f: &MasterFacet| {
        let [a, b] = f.nodes.map(|n| model.mesh.points[n]);
        (b[0] - a[0]).portable_hypot(b[1] - a[1])
    };
    facets.iter().map(length).sum::<f64>() / facets.len().max(1) as f64
}

/// The point of a surface nearest to a node, and its distance.
fn nearest(model: &Model, facets: &[MasterFacet], tie: usize, node: usize) -> Option<(TiedNode, f64)> {
    let points = &model.mesh.points;
    let p = points[node];
    let on_facet = |f: &MasterFacet| {
        let [a, b] = f.nodes.map(|n| points[n]);
        let along = [b[0] - a[0], b[1] - a[1]];
        let length = along[0] * along[0] + along[1] * along[1];
        let part = ((p[0] - a[0]) * along[0] + (p[1] - a[1]) * along[1]) / length;
        let part = if part < ON_NODE { 0.0 } else { part };
        let part = if part > 1.0 - ON_NODE { 1.0 } else { part };
        let place = match part {
            0.0 => a,
            1.0 => b,
            _ => [a[0] + part * along[0], a[1] + part * along[1]],
        };
        (part, place, (p[0] - place[0]).portable_hypot(p[1] - place[1]))
    };
    let closest = facets.iter().map(|f| (f, on_facet(f))).min_by(|a, b| a.1.2.total_cmp(&b.1.2))?;
    let (facet, (part, place, distance)) = closest;
    let shares = [(facet.nodes[0], 1.0 - part), (facet.nodes[1], part)];
    let shares = shares.into_iter().filter(|s| s.1 > 0.0).collect();
    Some((TiedNode { tie, node, element: facet.element, shares, place }, distance))
}

/// Says which nodes of a slave surface are not tied.
fn tell(
    model: &Model,
    tie: &SurfaceTie,
    left: &[(usize, f64)],
    tied: usize,
    tolerance: f64,
    diagnostics: &mut Diagnostics,
) {
    if left.is_empty() || tie.chosen.is_some() && tied > 0 {
        return;
    }
    let named = left.iter().take(8).map(|l| model.mesh.node_names[l.0].as_str()).collect::<Vec<_>>().join(", ");
    let more = if left.len() > 8 { ", …" } else { "" };
    let (near, far) = left.iter().fold((f64::INFINITY, 0.0_f64), |(n, f), l| (n.min(l.1), f.max(l.1)));
    let (count, all) = (left.len(), left.len() + tied);
    let message =
        format!("{count} of {all} nodes of the slave surface of tie {} are not tied: {named}{more}", tie.name);
    let distances =
        format!("they lie {near:.4e} to {far:.4e} away from the master surface, the tolerance is {tolerance:.4e}");
    let (severity, code): (fn(&'static str, String) -> Diagnostic, _) = match tied {
        0 => (|code, text| Diagnostic::error(code, text), "P060"),
        _ => (|code, text| Diagnostic::warning(code, text), "P061"),
    };
    let help = format!("give POSITION TOLERANCE={far:.4e} to tie all of them, or ADJUST=NO and the nodes as TIED NSET");
    diagnostics.push(severity(code, message).at(tie.span, distances).help(help));
}

/// The model with tied nodes put on their master surfaces without strain, where some are to be (`ADJUST=YES`) and are not there.
pub(super) fn adjusted(model: &Model, tied: &[TiedNode]) -> Option<Model> {
    let moves = |t: &&TiedNode| model.constraints.ties[t.tie].adjust && model.mesh.points[t.node] != t.place;
    let moved: Vec<&TiedNode> = tied.iter().filter(moves).collect();
    if moved.is_empty() {
        return None;
    }
    let mut model = model.clone();
    moved.iter().for_each(|t| model.mesh.points[t.node] = t.place);
    Some(model)
}
