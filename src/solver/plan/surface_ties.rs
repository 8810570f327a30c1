//! `*TIE`: the nodes of slave surfaces and their points on the master surfaces.

use std::collections::HashSet;

use crate::deck::{Diagnostic, Diagnostics};
use crate::kernel::sorted_boxes::{SortedBoxes, bounding_box};
use crate::model::{Model, SurfaceTie};
use crate::platform::PortableMath as _;

/// A slave node, which follows the nearest point of the master surface (ABAQUS Analysis User's Guide, "Mesh tie
/// constraints", node-to-surface approach).
#[derive(Clone, Debug, PartialEq)]
pub(super) struct TiedNode {
    /// Index of the tie in the model.
    pub tie: usize,
    /// Index of the tied mesh node.
    pub node: usize,
    /// Element of the master facet.
    pub element: usize,
    /// Nodes of the master facet and their weights; one node if the point is a node.
    pub shares: Vec<(usize, f64)>,
    /// Coordinates (r, z) of the point on the master surface.
    pub place: [f64; 2],
}

/// A facet of a master surface.
#[derive(Clone, Copy)]
struct MasterFacet {
    nodes: [usize; 2],
    element: usize,
}

/// Distance from a node, as a fraction of the facet length, within which a point counts as the node.
const ON_NODE: f64 = 1e-6;

/// Returns the tied nodes of all ties. Untied nodes are reported.
pub(super) fn find_tied_nodes(model: &Model, diagnostics: &mut Diagnostics) -> Vec<TiedNode> {
    let (mut tied, mut taken): (Vec<TiedNode>, HashSet<usize>) = Default::default();
    for (index, tie) in model.constraints.ties.iter().enumerate() {
        let facet = |&(element, side)| Some(MasterFacet { nodes: model.mesh.side_nodes(element, side)?, element });
        let facets: Vec<MasterFacet> = tie.masters.iter().filter_map(facet).collect();
        let own: HashSet<usize> = facets.iter().flat_map(|f| f.nodes).collect();
        let length = mean_length(model, &facets);
        let tolerance = tie.tolerance.unwrap_or(0.05 * length);
        let mut boxes = SortedBoxes::default();
        boxes.sort(facets.iter().map(|f| bounding_box(f.nodes.map(|n| model.mesh.points[n]))).zip(0..));
        let facets = MasterSurface { model, facets, boxes, length };
        let before = tied.len();
        let mut left: Vec<(usize, f64)> = Vec::new();
        for &node in tie.slaves.iter().filter(|n| !own.contains(n)) {
            let Some((at, distance)) = facets.nearest(index, node) else { continue };
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
        report_untied_nodes(model, tie, &left, tied.len() - before, tolerance, diagnostics);
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

/// The facets of a master surface.
struct MasterSurface<'a> {
    model: &'a Model,
    facets: Vec<MasterFacet>,
    boxes: SortedBoxes,
    /// Mean length of the facets.
    length: f64,
}

impl MasterSurface<'_> {
    /// Returns the nearest point of the surface to a node, and its distance; `None` if there are no facets.
    fn nearest(&self, tie: usize, node: usize) -> Option<(TiedNode, f64)> {
        let p = self.model.mesh.points[node];
        let (mut margin, mut near) = (self.length, Vec::new());
        let (facet, (part, place, distance)) = loop {
            near.clear();
            self.boxes.near([p; 2], margin, |index| near.push(index as usize));
            // Of equally distant facets the first one is used.
            near.sort_unstable();
            let closest = near.iter().map(|&f| (f, self.point_on(f, p))).min_by(|a, b| a.1.2.total_cmp(&b.1.2));
            // Facets outside of the margin are at a larger distance than the margin.
            match closest {
                Some(closest) if closest.1.2 <= margin => break closest,
                _ if margin == f64::INFINITY => break closest?,
                _ => margin = if margin > 0.0 { 4.0 * margin } else { f64::INFINITY },
            }
        };
        let MasterFacet { nodes, element } = self.facets[facet];
        let shares = [(nodes[0], 1.0 - part), (nodes[1], part)];
        let shares = shares.into_iter().filter(|s| s.1 > 0.0).collect();
        Some((TiedNode { tie, node, element, shares, place }, distance))
    }

    /// Returns the nearest point of a facet to a position: its fraction of the facet, its coordinates and its distance.
    fn point_on(&self, facet: usize, p: [f64; 2]) -> (f64, [f64; 2], f64) {
        let [a, b] = self.facets[facet].nodes.map(|n| self.model.mesh.points[n]);
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
    }
}

/// Reports the untied nodes of a slave surface: a warning, or an error if no node is tied.
fn report_untied_nodes(
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
        format!("their distance from the master surface is {near:.4e} to {far:.4e}, the tolerance is {tolerance:.4e}");
    let (severity, code): (fn(&'static str, String) -> Diagnostic, _) = match tied {
        0 => (|code, text| Diagnostic::error(code, text), "P060"),
        _ => (|code, text| Diagnostic::warning(code, text), "P061"),
    };
    let help =
        format!("give POSITION TOLERANCE={far:.4e} to tie all nodes, or give the nodes as TIED NSET with ADJUST=NO");
    diagnostics.push(severity(code, message).at(tie.span, distances).help(help));
}

/// Returns a model in which tied nodes are moved onto their master surfaces without strain (`ADJUST=YES`); `None` if no
/// node moves.
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
