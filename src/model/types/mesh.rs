//! Nodes, elements, sets and surfaces of elements.
//! Never here: what surfaces carry.

use std::collections::HashMap;

use crate::deck::Span;
use crate::kernel::lists::heap_bytes;
use crate::kernel::topology::Topology;
use crate::model::element_nodes::ElementNodes;
use crate::model::name::Name;

/// Nodes and elements.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Node names as the deck knows them (`12` or `INSTANCE.12`).
    pub node_names: Vec<Name>,
    /// Node coordinates `[r, z]`, in the deck's length unit.
    pub points: Vec<[f64; 2]>,
    /// Elements.
    pub elements: Vec<Element>,
}

impl Mesh {
    /// Bytes of its lists.
    pub fn bytes(&self) -> usize {
        let names: usize = self.node_names.iter().map(Name::bytes_elsewhere).sum();
        let element = |e: &Element| e.name.bytes_elsewhere() + e.nodes.bytes_elsewhere();
        names
            + heap_bytes(&self.node_names)
            + heap_bytes(&self.points)
            + heap_bytes(&self.elements)
            + self.elements.iter().map(element).sum::<usize>()
    }

    pub(in crate::model) fn room_for_nodes(&mut self, more: usize) {
        self.points.reserve(more);
        self.node_names.reserve(more);
    }

    pub(in crate::model) fn room_for_elements(&mut self, more: usize) {
        self.elements.reserve(more);
    }

    /// Nodes of the quadrilaterals that a solid element consists of, counter-clockwise. A triangle is a quadrilateral whose last two
    /// corners coincide: the formulas of polygons hold, and every motion of three nodes is linear, so hourglass control finds
    /// nothing.
    pub fn cells(&self, element: usize) -> impl Iterator<Item = [usize; 4]> {
        let Element { kind, nodes, .. } = &self.elements[element];
        let cells = kind.topology().map_or(&[][..], Topology::cells);
        cells.iter().map(move |cell| cell.map(|i| nodes[i.min(nodes.len() - 1)]))
    }

    /// Places of the corners of these quadrilaterals.
    pub fn cells_at_start(&self, element: usize) -> impl Iterator<Item = [[f64; 2]; 4]> {
        self.cells(element).map(|cell| cell.map(|n| self.points[n]))
    }

    /// The ends of one side of an element, the way it runs counter-clockwise; `None` if it has no such side.
    pub fn ends(&self, element: usize, side: Side) -> Option<[usize; 2]> {
        let nodes = &self.elements[element].nodes;
        let (from, to) = match side {
            Side::Positive | Side::Negative => (0, 1),
            Side::Face(n) => (usize::from(n).checked_sub(1)?, usize::from(n) % nodes.len()),
        };
        Some([*nodes.get(from)?, *nodes.get(to)?])
    }

    /// Faces of solids that lie outside: those that one element alone has, by element and number.
    pub fn outside(&self) -> Vec<(usize, Side)> {
        let faces = |e: usize| {
            let nodes = &self.elements[e].nodes;
            let count = if nodes.len() > 2 { nodes.len() } else { 0 };
            (0..count).map(move |i| (i, [nodes[i], nodes[(i + 1) % count]])).filter(|(_, [a, b])| a != b)
        };
        let all = || (0..self.elements.len()).flat_map(move |e| faces(e).map(move |(i, edge)| (e, i, edge)));
        let mut shared: HashMap<[usize; 2], usize> = HashMap::new();
        for (.., [a, b]) in all() {
            *shared.entry([a.min(b), a.max(b)]).or_default() += 1;
        }
        let bare = all().filter(|&(.., [a, b])| shared[&[a.min(b), a.max(b)]] == 1);
        bare.map(|(e, i, _)| (e, Side::Face(i as u8 + 1))).collect()
    }
}

/// What an element is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ElementKind {
    /// Two-node axisymmetric rigid surface element.
    Rax2,
    /// Two-node axisymmetric shell.
    Sax1,
    /// Three-node axisymmetric triangle.
    Cax3,
    /// Four-node axisymmetric quadrilateral, one integration point.
    Cax4r,
    /// The triangle with temperatures at its nodes.
    Cax3t,
    /// The quadrilateral with temperatures at its nodes.
    Cax4rt,
    /// Six-node axisymmetric triangle, modified, three integration points.
    Cax6m,
    /// One-node point mass.
    Mass,
    /// One-node rotary inertia.
    RotaryInertia,
    /// Spring along the line between two nodes.
    SpringA,
    /// Spring between a node and the ground.
    Spring1,
    /// Dashpot along the line between two nodes.
    DashpotA,
    /// Dashpot between a node and the ground.
    Dashpot1,
}

/// One element.
#[derive(Clone, Debug)]
pub struct Element {
    /// Name as the deck knows it.
    pub name: Name,
    /// Type.
    pub kind: ElementKind,
    /// Indices into [`Mesh::points`]; as many as the type has nodes, of solids around the boundary
    /// ([`ElementKind::around`]).
    pub nodes: ElementNodes,
    /// The data line (or mesh card) that made it.
    pub span: Span,
}

/// A named set of indices.
#[derive(Clone, Debug, Default)]
pub struct Set {
    /// Ascending, without repetition.
    pub members: Vec<usize>,
    /// First definition.
    pub span: Span,
}

/// A side of an element that faces outward.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Side {
    /// The side of the positive normal of a RAX2 or a SAX1: first to second node turned 90 degrees counter-clockwise in (r, z).
    Positive,
    /// The other side.
    Negative,
    /// Number (1-based) of the part of the boundary of a solid element from one node to the next: face S1 of CAX3 and CAX4R is
    /// the first, of CAX6M the first two.
    Face(u8),
}

/// A surface made of element sides.
#[derive(Clone, Debug, Default)]
pub struct Surface {
    /// The name as written.
    pub name: String,
    /// `(element index, side)` in deck order.
    pub faces: Vec<(usize, Side)>,
    /// Elements of which all that lies bare is meant: no side was named.
    pub whole: Vec<usize>,
    /// First definition.
    pub span: Span,
}

/// Where a distributed load acts.
#[derive(Clone, Debug, PartialEq)]
pub struct Sides {
    /// Name of the surface or element set, as written.
    pub name: String,
    /// Whether it came by `*DSLOAD` (a surface) or `*DLOAD` (elements).
    pub surface: bool,
    /// `(element index, side)`.
    pub faces: Vec<(usize, Side)>,
    /// Elements of which all that lies bare is meant, as others are deleted too.
    pub whole: Vec<usize>,
}
