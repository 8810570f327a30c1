//! Curves of contact: what of a surface lies bare and what is hidden within bodies, its points and what carries them, how deep behind
//! a facet something still meets it.
//! Never here: which curves meet.

use std::collections::{HashMap, HashSet};

use super::Compiler;
use super::pieces::pieces;
use crate::constraint::contact::analytical::Analytical;
use crate::constraint::contact::curve::{Carrier, Curve, Point};
use crate::deck::Diagnostic;
use crate::model::{Side, Sides, SurfaceContact};

/// A facet is met from behind no deeper than this many of its lengths.
const DEEPEST: f64 = 2.0;
/// The same of a shell at least.
const LEAST_DEPTH: f64 = 0.1;

/// Points and curves as they are found.
#[derive(Default)]
pub(super) struct Found {
    pub(super) points: Vec<Point>,
    pub(super) places: Vec<[f64; 2]>,
    point_of_node: HashMap<usize, u32>,
    pub(super) curves: Vec<Curve>,
    /// The element and the nodes of each facet that lies bare.
    pub(super) behind: Vec<Vec<(usize, [usize; 2])>>,
    /// The longest facet and the mean length of each, and whether what carries it deforms.
    pub(super) lengths: Vec<[f64; 2]>,
    pub(super) deforms: Vec<bool>,
    by_name: HashMap<(String, bool), usize>,
    pub(super) analyticals: Vec<Analytical>,
}

/// What points and facets are judged by.
pub(super) struct Around<'a> {
    /// Degrees of freedom whose motion is prescribed, and that follow others.
    pub(super) prescribed: &'a HashSet<(usize, usize)>,
    pub(super) kept: &'a HashSet<(usize, usize)>,
    /// The outside of what is solid.
    pub(super) skin: &'a Skin,
}

type Edge = [[f64; 2]; 2];

/// The outside of what is solid, but for the axis, and which piece of elements that hang together each edge and element is of.
#[derive(Default)]
pub(super) struct Skin {
    edges: Vec<(Edge, usize)>,
    piece_of: HashMap<usize, usize>,
}

impl Skin {
    /// What may end the body behind a facet of an element: its own piece, or where it is none of a solid all.
    fn behind(&self, element: usize) -> impl Iterator<Item = Edge> + '_ {
        let own = self.piece_of.get(&element).copied();
        self.edges.iter().filter(move |e| own.is_none_or(|own| own == e.1)).map(|e| e.0)
    }
}

fn is_off_axis(edge: &Edge) -> bool {
    edge.iter().any(|p| p[0] != 0.0)
}

impl Compiler<'_> {
    /// One surface of a pair; `None` where it cannot be in contact, which is told.
    pub(super) fn curve(
        &mut self,
        contact: &SurfaceContact,
        which: usize,
        around: &Around<'_>,
        found: &mut Found,
    ) -> Option<usize> {
        let sides = &contact.sides[which];
        let key = (sides.name.clone(), contact.thin);
        if let Some(&known) = found.by_name.get(&key) {
            return Some(known);
        }
        let (mut facets, mut behind) = (Vec::new(), Vec::new());
        for &(element, side) in &sides.faces {
            let Some(mut ends) = self.model.mesh.ends(element, side) else { continue };
            // The body lies to the left of the way; seen from the side of its normal a shell lies to the right.
            if side == Side::Positive {
                ends.reverse();
            }
            let mut facet = [0; 2];
            for (point, node) in facet.iter_mut().zip(ends) {
                *point = match self.point_of(node, around, found) {
                    Ok(point) => point,
                    Err(why) => {
                        return self.diagnostics.refuse(Diagnostic::error("P021", why).at(contact.span, "this pair"));
                    }
                };
            }
            facets.push((facet, element));
            behind.push((element, ends));
        }
        // What lies on the axis is the inside of a body.
        facets.retain(|(f, _)| f.iter().any(|&p| found.places[p as usize][0] != 0.0));
        behind.retain(|(_, ends)| ends.iter().any(|&n| self.model.mesh.points[n][0] != 0.0));
        if facets.is_empty() {
            let message = format!("surface `{}` has no facets that could meet anything", sides.name);
            return self.diagnostics.refuse(Diagnostic::error("P021", message).at(contact.span, "this pair"));
        }
        let bare = facets.len();
        if self.deletes() {
            self.hidden_facets(around, found, &mut facets);
        }
        let lift = facets.iter().map(|f| if contact.thin { 0.0 } else { 0.5 * self.thickness_of(f.1) }).collect();
        let curve = found.add_curve(&facets, lift, bare, (around.skin, &self.shells_of(sides)));
        found.behind.push(behind);
        found.by_name.insert(key, curve);
        Some(curve)
    }

    /// Adds the faces between elements of the bodies that bare facets belong to, one for each side: they lie bare when the element
    /// in front is deleted.
    fn hidden_facets(&self, around: &Around<'_>, found: &mut Found, facets: &mut Vec<([u32; 2], usize)>) {
        let mesh = &self.model.mesh;
        let own: HashSet<usize> = facets.iter().map(|f| f.1).collect();
        let solids: Vec<usize> =
            self.places.elements.keys().copied().filter(|e| mesh.elements[*e].kind.is_solid()).collect();
        for piece in pieces(mesh, &solids).iter().filter(|p| p.iter().any(|e| own.contains(e))) {
            let edges = |e: usize| {
                let nodes = &mesh.elements[e].nodes;
                (0..nodes.len()).map(move |i| [nodes[i], nodes[(i + 1) % nodes.len()]])
            };
            let all: HashSet<[usize; 2]> = piece.iter().flat_map(|&e| edges(e)).collect();
            for &e in piece {
                for edge in edges(e).filter(|[a, b]| all.contains(&[*b, *a])) {
                    let points = edge.map(|node| match found.point_of_node.get(&node) {
                        Some(&known) => Some(known),
                        None => {
                            let point = self.contact_point(node, around).ok()?;
                            Some(found.add(node, point, mesh.points[node]))
                        }
                    });
                    // What follows other nodes is left out: it never lies bare to contact.
                    if let [Some(a), Some(b)] = points {
                        facets.push(([a, b], e));
                    }
                }
            }
        }
    }

    /// Thickness of a shell at the start; 0 of other elements.
    fn thickness_of(&self, element: usize) -> f64 {
        let section = self.model.shell_sections.iter().find(|s| s.elements.contains(&element));
        section.map_or(0.0, |s| s.thickness)
    }

    pub(super) fn point_of(&self, node: usize, around: &Around<'_>, found: &mut Found) -> Result<u32, String> {
        match found.point_of_node.get(&node) {
            Some(&known) => Ok(known),
            None => Ok(found.add(node, self.contact_point(node, around)?, self.model.mesh.points[node])),
        }
    }

    /// What carries a point of a surface in contact, and along which axes it moves freely.
    fn contact_point(&self, node: usize, Around { prescribed, kept, .. }: &Around<'_>) -> Result<Point, String> {
        let mesh = &self.model.mesh;
        if let Some(place) = self.places.free_node(node) {
            if kept.contains(&(place, 0)) || kept.contains(&(place, 1)) {
                let name = &mesh.node_names[node];
                let why = "follows others (*EQUATION, *MPC, *COUPLING, *TIE): leave it out of the surface";
                return Err(format!("node {name} is in contact and {why}"));
            }
            let free = [0, 1].map(|axis| !prescribed.contains(&(place, axis)));
            return Ok(Point { carrier: Carrier::Node(place), free });
        }
        let body = self.places.tied.get(&node).or_else(|| self.body_of_node.get(&node));
        match body {
            Some(&body) => Ok(Point { carrier: Carrier::Body(body, mesh.points[node]), free: [false, true] }),
            None => Err(format!("node {} belongs to no body", mesh.node_names[node])),
        }
    }

    /// The outside of all solids, but for the axis.
    pub(super) fn solid_skin(&self) -> Skin {
        let mesh = &self.model.mesh;
        let solids: Vec<usize> = (0..mesh.elements.len()).filter(|e| mesh.elements[*e].kind.is_solid()).collect();
        let mut skin = Skin::default();
        for (piece, elements) in pieces(mesh, &solids).into_iter().enumerate() {
            skin.piece_of.extend(elements.into_iter().map(|e| (e, piece)));
        }
        for (element, side) in mesh.outside() {
            let (Some(ends), Some(&piece)) = (mesh.ends(element, side), skin.piece_of.get(&element)) else { continue };
            let edge = ends.map(|n| mesh.points[n]);
            skin.edges.extend(is_off_axis(&edge).then_some((edge, piece)));
        }
        skin
    }

    fn shells_of(&self, sides: &Sides) -> Vec<Edge> {
        let mesh = &self.model.mesh;
        let shells = sides.faces.iter().filter(|f| matches!(f.1, Side::Positive | Side::Negative));
        let shells = shells.filter_map(|&(e, side)| mesh.ends(e, side)).map(|e| e.map(|n| mesh.points[n]));
        shells.filter(is_off_axis).collect()
    }
}

impl Found {
    fn add(&mut self, node: usize, point: Point, place: [f64; 2]) -> u32 {
        let index = self.points.len() as u32;
        self.points.push(point);
        self.places.push(place);
        self.point_of_node.insert(node, index);
        index
    }

    /// A point that a body carries at the origin.
    pub(super) fn add_carried(&mut self, body: usize) -> u32 {
        self.points.push(Point { carrier: Carrier::Body(body, [0.0; 2]), free: [false, true] });
        self.places.push([0.0; 2]);
        self.points.len() as u32 - 1
    }

    /// How deep in an analytical surface the points of a curve may be where it gives way.
    pub(super) fn deepest(&self, curve: usize) -> f64 {
        DEEPEST * self.lengths[curve][0]
    }

    /// A curve of points without facets.
    pub(super) fn add_points(&mut self, curve: Curve) -> usize {
        self.deforms.push(true);
        // They have no length that gaps could be held against.
        self.lengths.push([f64::INFINITY; 2]);
        self.behind.push(Vec::new());
        self.curves.push(curve);
        self.curves.len() - 1
    }

    fn add_curve(
        &mut self,
        facets: &[([u32; 2], usize)],
        lift: Vec<f64>,
        bare: usize,
        (solids, shells): (&Skin, &[Edge]),
    ) -> usize {
        let ends = |f: &[u32; 2]| f.map(|p| self.places[p as usize]);
        let lengths: Vec<f64> = facets.iter().map(|(f, _)| length(ends(f))).collect();
        let mut depths: Vec<f64> = facets[..bare]
            .iter()
            .zip(&lengths)
            .map(|((f, element), l)| depth(ends(f), *l, solids.behind(*element).chain(shells.iter().copied())))
            .collect();
        // Behind a facet that comes to lie bare there may be no more than one element.
        depths.extend(lengths[bare..].iter().map(|l| 0.5 * l));
        // What lies behind the middle surface of a shell is on its other side.
        for (depth, (half, length)) in depths.iter_mut().zip(lift.iter().zip(&lengths)).filter(|d| *d.1.0 > 0.0) {
            *depth = half.max(LEAST_DEPTH * length);
        }
        let lengths = &lengths[..bare];
        let longest = lengths.iter().copied().fold(0.0, f64::max);
        let node = |p: u32| matches!(self.points[p as usize].carrier, Carrier::Node(_));
        self.deforms.push(facets[..bare].iter().any(|(f, _)| f.iter().any(|p| node(*p))));
        self.lengths.push([longest, lengths.iter().sum::<f64>() / lengths.len() as f64]);
        self.curves.push(Curve::new(facets.iter().map(|f| f.0).collect(), depths, bare, &self.places).lifted(lift));
        self.curves.len() - 1
    }

    /// Which of two curves carries the pressures, and the other: the finer of two that deform, never a rigid one.
    pub(super) fn order(&self, first: usize, second: usize) -> [usize; 2] {
        let swaps = match (self.deforms[first], self.deforms[second]) {
            (true, true) => self.lengths[second][1] < self.lengths[first][1],
            (deforms, _) => !deforms,
        };
        if swaps { [second, first] } else { [first, second] }
    }
}

fn length([a, b]: [[f64; 2]; 2]) -> f64 {
    libm::hypot(b[0] - a[0], b[1] - a[1])
}

/// How deep behind a facet something is still in contact with it: half the way to the next skin of its body behind it, and no more than
/// [`DEEPEST`] lengths.
fn depth([a, b]: Edge, length: f64, skin: impl Iterator<Item = Edge>) -> f64 {
    let middle = [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
    let inward = [-(b[1] - a[1]) / length, (b[0] - a[0]) / length];
    let mut nearest = 2.0 * DEEPEST * length;
    for [p, q] in skin {
        let (d, e) = ([p[0] - middle[0], p[1] - middle[1]], [q[0] - p[0], q[1] - p[1]]);
        let cross = inward[0] * e[1] - inward[1] * e[0];
        let way = (d[0] * e[1] - d[1] * e[0]) / cross;
        let part = (d[0] * inward[1] - d[1] * inward[0]) / cross;
        if (0.0..=1.0).contains(&part) && way > 1e-6 * length && way < nearest {
            nearest = way;
        }
    }
    0.5 * nearest
}
