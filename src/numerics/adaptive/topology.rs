//! Connectivity of an adaptive mesh domain: its elements, the edges between them, and its boundary.

use std::collections::HashMap;
use std::ops::Range;

use crate::element::group::ElementGroup;
use crate::kernel::lanes::InlineMap;
use crate::kernel::lists::{heap_bytes, sorted_pair, sorted_unique};

/// Edge between two elements of a domain. It runs from node `a` to node `b` with the element `left` on its left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InnerEdge {
    /// Elements on both sides, by their position in the domain.
    pub left: u32,
    pub right: u32,
    /// Nodes, by their position in the domain.
    pub a: u32,
    pub b: u32,
    /// Corners of `left` and `right` at `a` and at `b`.
    pub corners: [[u8; 2]; 2],
}

/// Edges between two nodes around an element: index, and whether the edge runs in the direction of the element.
pub type ElementLinks = [(u32, bool); 4];

/// Node of the boundary with its neighbours along it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BoundaryNode {
    pub node: u32,
    pub before: u32,
    pub after: u32,
}

/// Lists of variable length, one after another.
#[derive(Clone, Debug, Default)]
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

    /// Returns a list.
    pub fn list(&self, at: usize) -> &[u32] {
        &self.items[self.range(at)]
    }

    /// Returns the range of a list among all items.
    pub fn range(&self, at: usize) -> Range<usize> {
        let start = if at == 0 { 0 } else { self.ends[at - 1] as usize };
        start..self.ends[at] as usize
    }

    fn bytes(&self) -> usize {
        heap_bytes(&self.ends) + heap_bytes(&self.items)
    }
}

/// Connectivity of a domain; elements and nodes are numbered by their position in it.
#[derive(Clone, Debug, Default)]
pub struct DomainTopology {
    /// Index in the group of each element.
    pub elements: Vec<u32>,
    /// Index in the solver of each node.
    pub nodes: Vec<u32>,
    /// Corners of each element, counter-clockwise.
    pub corners: Vec<[u32; 4]>,
    pub edges: Vec<InnerEdge>,
    pub boundary: Vec<BoundaryNode>,
    /// Edges between two nodes, and those of each element from its corner i to the next one: index, and whether the
    /// edge runs in this direction.
    pub links: Vec<[u32; 2]>,
    pub links_of: Vec<ElementLinks>,
    /// Elements at each node.
    pub around: PackedLists,
    /// Nodes that share an edge with each node.
    pub adjacent: PackedLists,
    /// Whether each node can move inside the domain: it is neither on the boundary nor shared with other elements.
    pub inside: Vec<bool>,
}

impl DomainTopology {
    /// Creates the connectivity of elements of a group.
    pub fn new(group: &dyn ElementGroup, elements: Vec<u32>) -> DomainTopology {
        let corners_of = |e: &u32| [0, 1, 2, 3].inline_map(|c| group.nodes(*e as usize)[c]);
        let global: Vec<[u32; 4]> = elements.iter().map(corners_of).collect();
        let nodes = sorted_unique(global.iter().flatten().copied());
        let place: HashMap<u32, u32> = nodes.iter().enumerate().map(|(i, n)| (*n, i as u32)).collect();
        let corners: Vec<[u32; 4]> = global.iter().map(|c| c.inline_map(|n| place[&n])).collect();
        let around = around(&corners, nodes.len());
        let (edges, outer) = edges(&corners);
        let (links, links_of) = links(&corners);
        let mut inside = vec![true; nodes.len()];
        outer.iter().flatten().for_each(|n| inside[*n as usize] = false);
        DomainTopology {
            links,
            links_of,
            adjacent: PackedLists::of(&adjacent(&corners, nodes.len())),
            boundary: boundary(&outer),
            around: PackedLists::of(&around),
            edges,
            inside,
            elements,
            nodes,
            corners,
        }
    }

    /// Returns the size of the lists in bytes.
    pub fn bytes(&self) -> usize {
        let lists = heap_bytes(&self.links) + heap_bytes(&self.links_of) + self.around.bytes() + self.adjacent.bytes();
        let nodes = heap_bytes(&self.elements) + heap_bytes(&self.nodes) + heap_bytes(&self.corners);
        lists + nodes + heap_bytes(&self.edges) + heap_bytes(&self.boundary) + heap_bytes(&self.inside)
    }
}

fn around(corners: &[[u32; 4]], count: usize) -> Vec<Vec<u32>> {
    let mut around = vec![Vec::new(); count];
    for (e, corners) in corners.iter().enumerate() {
        corners.iter().for_each(|n| around[*n as usize].push(e as u32));
    }
    around
}

/// Returns the edges between two nodes, and those of each element.
fn links(corners: &[[u32; 4]]) -> (Vec<[u32; 2]>, Vec<ElementLinks>) {
    let mut known: HashMap<[u32; 2], u32> = HashMap::new();
    let mut links = Vec::new();
    let of = |corners: &[u32; 4]| {
        [0, 1, 2, 3].inline_map(|i: usize| {
            let ends = [corners[i], corners[(i + 1) % 4]];
            let index = *known.entry(sorted_pair(ends)).or_insert_with(|| {
                links.push(sorted_pair(ends));
                links.len() as u32 - 1
            });
            (index, ends == sorted_pair(ends))
        })
    };
    let links_of = corners.iter().map(of).collect();
    (links, links_of)
}

fn adjacent(corners: &[[u32; 4]], count: usize) -> Vec<Vec<u32>> {
    let mut adjacent = vec![Vec::new(); count];
    for corners in corners {
        for i in 0..4 {
            let [a, b] = [corners[i], corners[(i + 1) % 4]];
            adjacent[a as usize].push(b);
            adjacent[b as usize].push(a);
        }
    }
    adjacent.into_iter().map(sorted_unique).collect()
}

/// Returns the edges between two elements, and those of one element with it on their left.
fn edges(corners: &[[u32; 4]]) -> (Vec<InnerEdge>, Vec<[u32; 2]>) {
    let mut first: HashMap<[u32; 2], (u32, u8)> = HashMap::new();
    let (mut inner, mut paired) = (Vec::new(), Vec::new());
    for (e, own) in corners.iter().enumerate() {
        for i in 0..4u8 {
            let [a, b] = [own[i as usize], own[(i as usize + 1) % 4]];
            let next = (i + 1) % 4;
            match first.get(&sorted_pair([a, b])) {
                None => {
                    first.insert(sorted_pair([a, b]), (e as u32, i));
                }
                // Corner i of this element is at the end of the edge of the other.
                Some(&(left, at)) => {
                    let corners = [[at, next], [(at + 1) % 4, i]];
                    inner.push(InnerEdge { left, right: e as u32, a: b, b: a, corners });
                    paired.push(sorted_pair([a, b]));
                }
            }
        }
    }
    for key in &paired {
        first.remove(key);
    }
    let mut outer: Vec<(u32, u8)> = first.into_values().collect();
    outer.sort_unstable();
    let nodes = |(e, i): (u32, u8)| [corners[e as usize][i as usize], corners[e as usize][(i as usize + 1) % 4]];
    (inner, outer.into_iter().map(nodes).collect())
}

/// Returns the nodes with exactly two edges on the boundary.
fn boundary(outer: &[[u32; 2]]) -> Vec<BoundaryNode> {
    let mut ends: HashMap<u32, (Vec<u32>, Vec<u32>)> = HashMap::new();
    for [a, b] in outer {
        ends.entry(*a).or_default().1.push(*b);
        ends.entry(*b).or_default().0.push(*a);
    }
    let mut list: Vec<BoundaryNode> = ends
        .into_iter()
        .filter_map(|(node, (before, after))| match (&before[..], &after[..]) {
            ([before], [after]) => Some(BoundaryNode { node, before: *before, after: *after }),
            _ => None,
        })
        .collect();
    list.sort_unstable_by_key(|b| b.node);
    list
}
