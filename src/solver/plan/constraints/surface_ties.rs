//! `*TIE`: the nodes of slave surfaces and their points on the master surfaces.

use std::collections::HashSet;

use crate::deck::{Diagnostic, Diagnostics};
use crate::kernel::lists::sorted_pair;
use crate::kernel::sorted_boxes::{SortedBoxes, bounding_box};
use crate::model::{ElementSide, Model, SurfaceTie};
use crate::plan::queries::largest_distances;
use crate::platform::PortableMath as _;

/// A slave node within the tolerance of the master surface, and the nearest point of this surface.
#[derive(Clone, Debug, PartialEq)]
pub struct AttachedNode {
    /// Index of the mesh node.
    pub node: usize,
    /// Element of the master facet.
    pub element: usize,
    /// Nodes of the master facet and their weights; one node if the point is a node.
    pub shares: Vec<(usize, f64)>,
    /// Coordinates (r, z) of the point on the master surface.
    pub place: [f64; 2],
    /// Whether the node belongs to the master surface, too.
    pub is_shared: bool,
}

/// A facet of a surface.
#[derive(Clone, Copy, Debug)]
pub struct Facet {
    pub nodes: [usize; 2],
    pub element: usize,
}

/// Returns the facets of faces; a facet of two faces, such as both sides of a shell, is listed once.
pub fn facets_of(model: &Model, faces: &[(usize, ElementSide)]) -> Vec<Facet> {
    let mut known = HashSet::new();
    let facet = |&(element, side)| Some(Facet { nodes: model.mesh.side_nodes(element, side)?, element });
    let is_new = |facet: &Facet| known.insert(sorted_pair(facet.nodes));
    faces.iter().filter_map(facet).filter(is_new).collect()
}

/// Distance from a node, as a fraction of the facet length, within which a point counts as the node.
const ON_NODE: f64 = 1e-6;

/// Returns the attached nodes of each tie. Untied nodes are reported.
pub fn find_attached_nodes(model: &Model, diagnostics: &mut Diagnostics) -> Vec<Vec<AttachedNode>> {
    let attached = |tie: &SurfaceTie| attached_nodes(model, tie, diagnostics);
    model.constraints.ties.iter().map(attached).collect()
}

fn attached_nodes(model: &Model, tie: &SurfaceTie, diagnostics: &mut Diagnostics) -> Vec<AttachedNode> {
    let surface = MasterSurface::new(model, tie);
    let master_nodes: HashSet<usize> = surface.facets.iter().flat_map(|f| f.nodes).collect();
    let tolerance = surface.tolerance(tie);
    let (mut attached, mut untied): (Vec<AttachedNode>, Vec<(usize, f64)>) = Default::default();
    for &node in &tie.slaves {
        let Some((found, distance)) = surface.nearest(node) else { continue };
        if master_nodes.contains(&node) {
            attached.push(AttachedNode { is_shared: true, ..found });
            continue;
        }
        let chosen = match &tie.chosen {
            Some(list) => list.binary_search(&node).is_ok(),
            None => distance <= tolerance,
        };
        if chosen {
            attached.push(found);
        } else {
            untied.push((node, distance));
        }
    }
    let tied = attached.iter().filter(|a| !a.is_shared).count();
    report_untied_nodes(model, tie, &untied, tied, tolerance, diagnostics);
    note_moved_nodes(model, tie, &attached, diagnostics);
    attached
}

/// Returns the length of a facet.
pub fn length(model: &Model, facet: &Facet) -> f64 {
    let [a, b] = facet.nodes.map(|n| model.mesh.points[n]);
    (b[0] - a[0]).portable_hypot(b[1] - a[1])
}

/// The facets of a master surface.
pub struct MasterSurface<'a> {
    model: &'a Model,
    pub facets: Vec<Facet>,
    boxes: SortedBoxes,
    /// Mean length of the facets.
    length: f64,
}

/// The nearest point of a facet to a position.
struct FacetPoint {
    facet: usize,
    /// Distance from the first node of the facet, as a fraction of its length.
    part: f64,
    coordinates: [f64; 2],
    distance: f64,
}

impl MasterSurface<'_> {
    pub fn new<'a>(model: &'a Model, tie: &SurfaceTie) -> MasterSurface<'a> {
        let facets = facets_of(model, &tie.masters);
        let length = facets.iter().map(|f| length(model, f)).sum::<f64>() / facets.len().max(1) as f64;
        let mut boxes = SortedBoxes::default();
        boxes.sort(facets.iter().map(|f| bounding_box(f.nodes.map(|n| model.mesh.points[n]))).zip(0..));
        MasterSurface { model, facets, boxes, length }
    }

    /// Returns the largest distance at which a node is tied, with a margin for rounding.
    pub fn tolerance(&self, tie: &SurfaceTie) -> f64 {
        tie.tolerance.unwrap_or(0.05 * self.length) * (1.0 + 1e-9)
    }

    /// Returns the indices of the facets whose boxes are within `margin` of the box of two points.
    pub fn near(&self, ends: [[f64; 2]; 2], margin: f64) -> Vec<usize> {
        let mut near = Vec::new();
        self.boxes.near(bounding_box(ends), margin, |index| near.push(index as usize));
        near.sort_unstable();
        near
    }

    /// Returns the nearest point of the surface to a node, and its distance; `None` if there are no facets.
    pub fn nearest(&self, node: usize) -> Option<(AttachedNode, f64)> {
        let p = self.model.mesh.points[node];
        let mut margin = self.length;
        let FacetPoint { facet, part, coordinates, distance } = loop {
            // Of equally distant facets the first one is used.
            let near = self.near([p; 2], margin).into_iter();
            let closest = near.map(|f| self.point_on(f, p)).min_by(|a, b| a.distance.total_cmp(&b.distance));
            // Facets outside of the margin are at a larger distance than the margin.
            match closest {
                Some(closest) if closest.distance <= margin => break closest,
                _ if margin == f64::INFINITY => break closest?,
                _ => margin = if margin > 0.0 { 4.0 * margin } else { f64::INFINITY },
            }
        };
        let Facet { nodes, element } = self.facets[facet];
        let shares = [(nodes[0], 1.0 - part), (nodes[1], part)];
        let shares = shares.into_iter().filter(|s| s.1 > 0.0).collect();
        Some((AttachedNode { node, element, shares, place: coordinates, is_shared: false }, distance))
    }

    /// Returns the nearest point of a facet to a position.
    fn point_on(&self, facet: usize, p: [f64; 2]) -> FacetPoint {
        let [a, b] = self.facets[facet].nodes.map(|n| self.model.mesh.points[n]);
        let along = [b[0] - a[0], b[1] - a[1]];
        let length = along[0] * along[0] + along[1] * along[1];
        let part = ((p[0] - a[0]) * along[0] + (p[1] - a[1]) * along[1]) / length;
        let part = if part < ON_NODE { 0.0 } else { part };
        let part = if part > 1.0 - ON_NODE { 1.0 } else { part };
        let coordinates = match part {
            0.0 => a,
            1.0 => b,
            _ => [a[0] + part * along[0], a[1] + part * along[1]],
        };
        let distance = (p[0] - coordinates[0]).portable_hypot(p[1] - coordinates[1]);
        FacetPoint { facet, part, coordinates, distance }
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
    let (count, total) = (left.len(), left.len() + tied);
    let message =
        format!("{count} of {total} nodes of the slave surface of tie {} are not tied: {named}{more}", tie.name);
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

/// Lists the nodes that a tie moves.
fn note_moved_nodes(model: &Model, tie: &SurfaceTie, attached: &[AttachedNode], diagnostics: &mut Diagnostics) {
    let distance = |a: &AttachedNode| {
        let [r, z] = model.mesh.points[a.node];
        (a.node, (a.place[0] - r).portable_hypot(a.place[1] - z))
    };
    let moved = attached.iter().filter(|a| tie.adjust && !a.is_shared).map(distance).collect();
    let Some(list) = largest_distances(model, moved) else { return };
    let message = format!("{} nodes of tie {} are moved onto the master surface without strain", list.count, tie.name);
    diagnostics.push(Diagnostic::note("P125", message).at(tie.span, format!("distances: {}", list.text)));
}

/// Returns a model in which tied nodes are moved onto their master surfaces without strain (`ADJUST=YES`); `None` if no
/// node moves. A node of several ties is moved by the first one.
pub fn adjusted(model: &Model, attached: &[Vec<AttachedNode>]) -> Option<Model> {
    let mut known = HashSet::new();
    let ties = model.constraints.ties.iter().zip(attached);
    let tied = ties.flat_map(|(tie, nodes)| nodes.iter().filter(|a| !a.is_shared).map(move |a| (tie.adjust, a)));
    let first = tied.filter(|(_, a)| known.insert(a.node));
    let moved: Vec<&AttachedNode> =
        first.filter(|(adjust, a)| *adjust && model.mesh.points[a.node] != a.place).map(|m| m.1).collect();
    if moved.is_empty() {
        return None;
    }
    let mut model = model.clone();
    moved.iter().for_each(|a| model.mesh.points[a.node] = a.place);
    Some(model)
}
