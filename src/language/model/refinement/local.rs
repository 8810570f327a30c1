//! Edges that are divided if only some elements are refined, such that the mesh remains conforming.
//!
//! All edges of refined elements are divided. A quadrilateral next to them can be replaced by quadrilaterals if the number
//! of its divided edges is even, a cohesive element if both faces are divided or none. Elements with an odd number are
//! connected in pairs, or with a triangle or the boundary of the mesh, by shortest paths through elements; the edges that
//! a path crosses are divided, or no longer divided. Two neighbouring transition elements share one such edge.

use std::collections::{BTreeSet, HashMap, VecDeque};

use super::edges::{EdgeTable, edges_of};
use crate::model::types::Element;

/// Returns whether each edge of the table is divided, in its order.
pub fn divided_edges(elements: &[Element], edges: &EdgeTable, is_refined: &[bool]) -> Vec<bool> {
    let mut division = Division::new(elements, edges);
    let mut requested: Vec<usize> = (0..elements.len()).filter(|&e| is_refined.get(e) == Some(&true)).collect();
    while !requested.is_empty() {
        division.refine(elements, requested);
        requested = division.pair_odd_elements();
    }
    division.is_divided
}

struct Division {
    /// Edges of each element, as places in the table.
    sides: Vec<Vec<usize>>,
    /// Solid and cohesive elements at each edge.
    neighbours: Vec<Vec<usize>>,
    /// Whether the number of divided edges of an element must be even, unless it is refined.
    needs_pairs: Vec<bool>,
    is_refined: Vec<bool>,
    is_divided: Vec<bool>,
    /// Whether an edge belongs to a refined element.
    is_fixed: Vec<bool>,
}

impl Division {
    fn new(elements: &[Element], edges: &EdgeTable) -> Division {
        let places = |element: &Element| edges_of(element).filter_map(|ends| edges.index(ends)).collect();
        let sides: Vec<Vec<usize>> = elements.iter().map(places).collect();
        let mut neighbours = vec![Vec::new(); edges.len()];
        for (at, element) in elements.iter().enumerate() {
            if element.kind.is_solid() || element.kind.is_cohesive() {
                sides[at].iter().for_each(|&edge| neighbours[edge].push(at));
            }
        }
        let needs_pairs = |(element, sides): (&Element, &Vec<usize>)| {
            element.kind.is_solid() && sides.len() == 4 || element.kind.is_cohesive() && sides.len() == 2
        };
        Division {
            needs_pairs: elements.iter().zip(&sides).map(needs_pairs).collect(),
            is_refined: vec![false; elements.len()],
            is_divided: vec![false; edges.len()],
            is_fixed: vec![false; edges.len()],
            sides,
            neighbours,
        }
    }

    /// Divides all edges of elements, and of all six-node triangles that are connected with a divided one.
    fn refine(&mut self, elements: &[Element], mut requested: Vec<usize>) {
        while let Some(element) = requested.pop() {
            if std::mem::replace(&mut self.is_refined[element], true) {
                continue;
            }
            for &edge in &self.sides[element] {
                (self.is_divided[edge], self.is_fixed[edge]) = (true, true);
                requested.extend(self.neighbours[edge].iter().filter(|&&e| elements[e].nodes.len() == 6));
            }
        }
    }

    /// Returns whether an element has an odd number of divided edges.
    fn is_odd(&self, element: usize) -> bool {
        let divided = self.sides[element].iter().filter(|&&edge| self.is_divided[edge]).count();
        self.needs_pairs[element] && !self.is_refined[element] && divided % 2 == 1
    }

    /// Connects elements with an odd number of divided edges, those with the fewest such neighbours first. Returns an
    /// element that cannot be connected.
    fn pair_odd_elements(&mut self) -> Vec<usize> {
        let mut odd: BTreeSet<usize> = (0..self.sides.len()).filter(|&e| self.is_odd(e)).collect();
        let count = |odd: &BTreeSet<usize>, e: usize| self.around(e).filter(|(_, other)| odd.contains(other)).count();
        let mut counts: HashMap<usize, usize> = odd.iter().map(|&e| (e, count(&odd, e))).collect();
        let mut queue: BTreeSet<(usize, usize)> = counts.iter().map(|(&element, &count)| (count, element)).collect();
        while let Some((_, start)) = queue.pop_first() {
            let Some(path) = self.path_from(start, &odd) else { return vec![start] };
            path.edges.iter().for_each(|&edge| self.is_divided[edge] = !self.is_divided[edge]);
            for paired in [Some(start), path.end].into_iter().flatten() {
                odd.remove(&paired);
                queue.remove(&(counts[&paired], paired));
                let neighbours: Vec<usize> = self.around(paired).map(|(_, other)| other).collect();
                for other in neighbours.into_iter().filter(|other| odd.contains(other)) {
                    let Some(count) = counts.get_mut(&other) else { continue };
                    queue.remove(&(*count, other));
                    *count = count.saturating_sub(1);
                    queue.insert((*count, other));
                }
            }
        }
        Vec::new()
    }

    /// Returns the edges of an element that a path can cross, with the elements on their other sides.
    fn around(&self, element: usize) -> impl Iterator<Item = (usize, usize)> {
        let open = self.sides[element].iter().filter(|&&edge| !self.is_fixed[edge]);
        open.flat_map(move |&edge| self.neighbours[edge].iter().map(move |&other| (edge, other)))
            .filter(move |&(_, other)| other != element)
    }

    /// Returns the shortest path from an element to another one with an odd number of divided edges or, if it is shorter, to
    /// a triangle or the boundary.
    fn path_from(&self, start: usize, odd: &BTreeSet<usize>) -> Option<Path> {
        let mut came: HashMap<usize, CrossedEdge> = HashMap::new();
        let mut queue = VecDeque::from([(start, 0)]);
        let mut sink: Option<(usize, Path)> = None;
        while let Some((element, length)) = queue.pop_front() {
            if let Some((_, path)) = sink.take_if(|(shortest, _)| *shortest <= length) {
                return Some(path);
            }
            for (edge, other) in self.around(element) {
                if other == start || came.contains_key(&other) {
                    continue;
                }
                let crossed = CrossedEdge { edge, from: element };
                if odd.contains(&other) {
                    return Some(Path { edges: edges_to(&came, crossed, start), end: Some(other) });
                }
                if self.needs_pairs[other] {
                    came.insert(other, crossed);
                    queue.push_back((other, length + 1));
                } else if sink.is_none() {
                    sink = Some((length + 1, Path { edges: edges_to(&came, crossed, start), end: None }));
                }
            }
            let is_boundary = |edge: &&usize| !self.is_fixed[**edge] && self.neighbours[**edge].len() == 1;
            if let (None, Some(&edge)) = (&sink, self.sides[element].iter().find(is_boundary)) {
                let edges = edges_to(&came, CrossedEdge { edge, from: element }, start);
                sink = Some((length + 1, Path { edges, end: None }));
            }
        }
        sink.map(|(_, path)| path)
    }
}

/// Edge that a path crosses, and the element before it.
#[derive(Clone, Copy)]
struct CrossedEdge {
    edge: usize,
    from: usize,
}

/// Edges that a path crosses, and the element with an odd number of divided edges at its end.
struct Path {
    edges: Vec<usize>,
    end: Option<usize>,
}

/// Returns the edges of a path from `start` to its last edge.
fn edges_to(came: &HashMap<usize, CrossedEdge>, last: CrossedEdge, start: usize) -> Vec<usize> {
    let mut crossed = last;
    let mut edges = vec![crossed.edge];
    while crossed.from != start {
        crossed = came[&crossed.from];
        edges.push(crossed.edge);
    }
    edges
}
