//! Connectivity of an adaptive mesh domain: its elements, the edges between them, and its boundary.

use std::collections::HashMap;
use std::ops::Range;

use crate::element::group::ElementGroup;
use crate::kernel::lanes::InlineMap;
use crate::kernel::lists::{Memory, sorted_pair, sorted_unique};
use crate::kernel::quad;
use crate::kernel::shape::elements_around;

/// Edge of an element from corner `nodes[0]` to `nodes[1]` with the element `left` on its left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DomainEdge {
    /// Nodes, by their position in the domain.
    pub nodes: [u32; 2],
    /// Elements on both sides, by their position in the domain; both are the same on the boundary.
    pub left: u32,
    pub right: u32,
    /// Index of the edge in the lists of both elements.
    pub sides: [u8; 2],
    /// Whether the edge is on an Eulerian boundary, through which material flows.
    pub is_open: bool,
}

impl DomainEdge {
    /// Returns whether the edge is between two elements.
    pub fn is_inner(&self) -> bool {
        self.left != self.right
    }

    /// Returns whether material can pass through the edge.
    pub fn is_passed(&self) -> bool {
        self.is_inner() || self.is_open
    }
}

/// Edge of an element from a corner to the next one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ElementSide {
    pub edge: u32,
    /// Element on the other side; the element itself on the boundary.
    pub beside: u32,
    /// Whether the element is on the left of the edge.
    pub is_left: bool,
}

/// Node of the boundary with its neighbours along it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BoundaryNode {
    pub node: u32,
    pub before: u32,
    pub after: u32,
    /// Whether the edges from `before` and to `after` are on an Eulerian boundary.
    pub is_open: [bool; 2],
}

/// Lists of variable length, one after another.
#[derive(Clone, Debug, Default, Memory)]
pub struct PackedLists {
    ends: Vec<u32>,
    items: Vec<u32>,
}

impl PackedLists {
    fn of(lists: &[Vec<u32>]) -> PackedLists {
        let mut packed = PackedLists::default();
        for list in lists {
            packed.items.extend(list);
            packed.ends.push(packed.items.len() as u32);
        }
        packed
    }

    pub fn list(&self, at: usize) -> &[u32] {
        &self.items[self.range(at)]
    }

    /// Returns the range of a list among all items.
    pub fn range(&self, at: usize) -> Range<usize> {
        let start = if at == 0 { 0 } else { self.ends[at - 1] as usize };
        start..self.ends[at] as usize
    }
}

/// Connectivity of a domain; elements and nodes are numbered by their position in it.
#[derive(Clone, Debug, Default, Memory)]
pub struct DomainTopology {
    /// Index in the group of each element.
    pub elements: Vec<u32>,
    /// Index in the solver of each node.
    pub nodes: Vec<u32>,
    /// Corners of each element, counter-clockwise; the last two of a triangle are equal.
    pub corners: Vec<[u32; 4]>,
    pub edges: Vec<DomainEdge>,
    /// Edges of each element, from its corner i to the next one.
    pub sides: Vec<[ElementSide; 4]>,
    pub boundary: Vec<BoundaryNode>,
    /// Edges on Eulerian boundaries.
    pub open: Vec<u32>,
    /// Edges at each node.
    pub edges_at: PackedLists,
    /// Elements at each node.
    pub around: PackedLists,
    /// Nodes that share an edge with each node.
    pub adjacent: PackedLists,
    /// Whether each node can move inside the domain: it is neither on the boundary nor shared with other elements.
    pub inside: Vec<bool>,
}

impl DomainTopology {
    /// Creates the connectivity of elements of a group. `is_open` returns whether an edge of the boundary, given by the
    /// indices of its nodes in the solver, is on an Eulerian boundary.
    pub fn new(group: &dyn ElementGroup, elements: Vec<u32>, is_open: impl Fn([u32; 2]) -> bool) -> DomainTopology {
        let corners_of = |e: &u32| [0, 1, 2, 3].inline_map(|c| group.nodes(*e as usize)[c]);
        let global: Vec<[u32; 4]> = elements.iter().map(corners_of).collect();
        let nodes = sorted_unique(global.iter().flatten().copied());
        let positions: HashMap<u32, u32> = nodes.iter().enumerate().map(|(i, n)| (*n, i as u32)).collect();
        let corners: Vec<[u32; 4]> = global.iter().map(|c| c.inline_map(|n| positions[&n])).collect();
        let around = elements_around(&corners, nodes.len());
        let (mut edges, sides) = edges(&corners);
        let mut inside = vec![true; nodes.len()];
        let (mut outer, mut open) = (Vec::new(), Vec::new());
        for (i, edge) in edges.iter_mut().enumerate().filter(|(_, e)| !e.is_inner() && e.nodes[0] != e.nodes[1]) {
            edge.is_open = is_open(edge.nodes.inline_map(|n| nodes[n as usize]));
            open.extend(edge.is_open.then_some(i as u32));
            edge.nodes.iter().for_each(|n| inside[*n as usize] = false);
            outer.push((edge.nodes, edge.is_open));
        }
        DomainTopology {
            edges_at: PackedLists::of(&edges_at(&edges, nodes.len())),
            sides,
            adjacent: PackedLists::of(&adjacent(&corners, nodes.len())),
            boundary: boundary(&outer),
            open,
            around: PackedLists::of(&around),
            edges,
            inside,
            elements,
            nodes,
            corners,
        }
    }

    /// Returns the boundary at a node; `None` for nodes inside, and where parts of the boundary meet.
    pub fn boundary_at(&self, node: u32) -> Option<&BoundaryNode> {
        self.boundary.binary_search_by_key(&node, |b| b.node).ok().map(|at| &self.boundary[at])
    }

    /// Returns the volume of an element with nodes at these places.
    pub fn volume(&self, element: usize, places: &[[f64; 2]]) -> f64 {
        quad::volume(self.corners[element].inline_map(|n| places[n as usize]))
    }
}

fn edges_at(edges: &[DomainEdge], count: usize) -> Vec<Vec<u32>> {
    let mut lists = vec![Vec::new(); count];
    for (i, edge) in edges.iter().enumerate().filter(|(_, e)| e.nodes[0] != e.nodes[1]) {
        edge.nodes.iter().for_each(|n| lists[*n as usize].push(i as u32));
    }
    lists
}

fn adjacent(corners: &[[u32; 4]], count: usize) -> Vec<Vec<u32>> {
    let mut adjacent = vec![Vec::new(); count];
    for corners in corners {
        for [a, b] in [0, 1, 2, 3].inline_map(|i: usize| [corners[i], corners[(i + 1) % 4]]) {
            if a == b {
                continue;
            }
            adjacent[a as usize].push(b);
            adjacent[b as usize].push(a);
        }
    }
    adjacent.into_iter().map(sorted_unique).collect()
}

/// Returns all edges, and those of each element.
fn edges(corners: &[[u32; 4]]) -> (Vec<DomainEdge>, Vec<[ElementSide; 4]>) {
    let mut open: HashMap<[u32; 2], u32> = HashMap::new();
    let mut edges: Vec<DomainEdge> = Vec::new();
    let mut sides = vec![[ElementSide::default(); 4]; corners.len()];
    for (e, own) in corners.iter().enumerate() {
        for i in 0..4 {
            let nodes = [own[i], own[(i + 1) % 4]];
            let (key, element) = (sorted_pair(nodes), e as u32);
            let known = if nodes[0] == nodes[1] { None } else { open.remove(&key) };
            let index = known.unwrap_or(edges.len() as u32);
            if known.is_some() {
                let edge = &mut edges[index as usize];
                (edge.right, edge.sides[1]) = (element, i as u8);
                sides[edge.left as usize][edge.sides[0] as usize].beside = element;
                sides[e][i] = ElementSide { edge: index, beside: edge.left, is_left: false };
            } else {
                open.insert(key, index);
                edges.push(DomainEdge { nodes, left: element, right: element, sides: [i as u8; 2], is_open: false });
                sides[e][i] = ElementSide { edge: index, beside: element, is_left: true };
            }
        }
    }
    (edges, sides)
}

/// Returns the nodes with exactly two edges on the boundary.
fn boundary(outer: &[([u32; 2], bool)]) -> Vec<BoundaryNode> {
    let mut ends: HashMap<u32, [Vec<(u32, bool)>; 2]> = HashMap::new();
    for ([a, b], is_open) in outer {
        ends.entry(*a).or_default()[1].push((*b, *is_open));
        ends.entry(*b).or_default()[0].push((*a, *is_open));
    }
    let mut list: Vec<BoundaryNode> = ends
        .into_iter()
        .filter_map(|(node, [before, after])| match (&before[..], &after[..]) {
            ([before], [after]) => {
                Some(BoundaryNode { node, before: before.0, after: after.0, is_open: [before.1, after.1] })
            }
            _ => None,
        })
        .collect();
    list.sort_unstable_by_key(|b| b.node);
    list
}
