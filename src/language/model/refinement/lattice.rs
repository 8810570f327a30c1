//! Lattices of nodes in elements, and the elements between them.

use super::curves::EdgeCurves;
use super::edges::{EdgeTable, edges_of};
use super::local;
use super::mesh::RefinedMesh;
use super::templates::{self, ChildElement};
use crate::model::element_nodes::NodeIndices;
use crate::model::types::{Element, ElementKind, Mesh};

/// Nodes of the deck and their weights in the position of a new node; unused entries have the weight 0.
pub type NodeWeights = [(usize, f64); 4];

/// Divides each edge of a mesh into `factor` parts, or into two parts the edges of some elements, and of elements that
/// these require for a conforming mesh. New nodes have no names yet, and all children have the name of their parent.
pub fn refine(mesh: &mut Mesh, factor: usize, refined_elements: Option<&[bool]>, curves: &EdgeCurves) -> RefinedMesh {
    let Some(elements) = refined_elements else {
        let parents = std::mem::take(&mut mesh.elements);
        return divide(mesh, parents, factor, curves, |_, _| vec![true]);
    };
    let mut is_refined = elements.to_vec();
    loop {
        let parents = mesh.elements.clone();
        let refined =
            divide(mesh, parents, factor, curves, |parents, edges| local::divided_edges(parents, edges, &is_refined));
        let concave = refined.concave_transitions(mesh);
        if concave.is_empty() {
            return refined;
        }
        // Where edges are curved, a transition can be concave: these elements are refined.
        is_refined.resize(refined.parents.len(), false);
        concave.into_iter().for_each(|parent| is_refined[parent] = true);
        mesh.points.truncate(refined.originals);
        mesh.elements = refined.parents;
    }
}

/// Divides the edges of a mesh for which `divided` returns true, in the order of the table; one value is that of all edges.
fn divide(
    mesh: &mut Mesh,
    parents: Vec<Element>,
    factor: usize,
    curves: &EdgeCurves,
    divided: impl Fn(&[Element], &EdgeTable) -> Vec<bool>,
) -> RefinedMesh {
    let originals = mesh.points.len();
    let mut edges = EdgeTable::new(&parents);
    let is_divided = divided(&parents, &edges);
    edges.divide(factor, originals, |place| is_divided.get(place).copied().unwrap_or(is_divided[0]));
    let mut refined = RefinedMesh {
        factor,
        originals,
        first_inside: Vec::with_capacity(parents.len() + 1),
        first_child: Vec::with_capacity(parents.len() + 1),
        outer_sides: Vec::new(),
        middle_child: Vec::with_capacity(parents.len()),
        parents,
        edges,
    };
    refined.number_nodes();
    refined.place_nodes(&mut mesh.points, curves);
    mesh.elements.clear();
    for parent in 0..refined.parents.len() {
        refined.first_child.push(mesh.elements.len());
        refined.add_children(parent, mesh);
        refined.middle_child.push(middle(mesh, refined.first_child[parent]));
    }
    refined.first_child.push(mesh.elements.len());
    refined
}

/// Returns the element that is nearest to the mean position of the elements from `first` on.
fn middle(mesh: &Mesh, first: usize) -> usize {
    let centre = |element: &Element| {
        let scale = 1.0 / element.nodes.len() as f64;
        [0, 1].map(|i| element.nodes.iter().map(|&n| scale * mesh.points[n][i]).sum::<f64>())
    };
    let centres: Vec<[f64; 2]> = mesh.elements[first..].iter().map(centre).collect();
    let mean = [0, 1].map(|i| centres.iter().map(|c| c[i]).sum::<f64>() / centres.len() as f64);
    let distance = |c: &[f64; 2]| (c[0] - mean[0]).powi(2) + (c[1] - mean[1]).powi(2);
    // Of children at equal distances up to rounding, the first one.
    let least = centres.iter().map(distance).fold(f64::INFINITY, f64::min);
    first + centres.iter().position(|c| distance(c) <= least * (1.0 + 1e-9)).unwrap_or(0)
}

/// Returns the number of lattice nodes inside an element whose edges are all divided.
fn inner_count(kind: ElementKind, factor: usize) -> usize {
    match kind.node_count() {
        _ if !kind.is_solid() => 0,
        4 => (factor - 1) * (factor - 1),
        count => {
            let parts = count / 3 * factor;
            parts.saturating_sub(1) * parts.saturating_sub(2) / 2
        }
    }
}

impl RefinedMesh {
    /// Returns the number of new nodes inside an element of the deck.
    fn inner_count(&self, parent: usize) -> usize {
        let kind = self.parents[parent].kind;
        match self.partial_division(parent) {
            Some(sides) => templates::inner_count(kind, sides),
            None => inner_count(kind, self.factor),
        }
    }

    /// Returns the elements with some, but not all edges divided, of whose children one is not convex.
    fn concave_transitions(&self, mesh: &Mesh) -> Vec<usize> {
        let is_concave = |&parent: &usize| {
            let is_transition = self.partial_division(parent).is_some_and(|sides| sides != 0);
            is_transition && self.children(parent).any(|child| !templates::is_convex(mesh, &mesh.elements[child].nodes))
        };
        let is_convex = |parent: &usize| templates::is_convex(mesh, &self.parents[*parent].nodes);
        (0..self.parents.len()).filter(is_concave).filter(is_convex).collect()
    }

    /// Returns the divided sides of an element, as bits, if not all its edges are divided.
    fn partial_division(&self, parent: usize) -> Option<u8> {
        let Element { kind, nodes, .. } = &self.parents[parent];
        let is_divided = |ends: [usize; 2]| self.edges.is_divided(ends);
        if self.factor == 1 || kind.is_discrete() || edges_of(&self.parents[parent]).all(is_divided) {
            return None;
        }
        Some(if kind.is_solid() && nodes.len() <= 4 { self.divided_sides(parent) } else { 0 })
    }

    fn number_nodes(&mut self) {
        let mut next = self.edges.end();
        for parent in 0..self.parents.len() {
            self.first_inside.push(next);
            next += self.inner_count(parent);
        }
        self.first_inside.push(next);
    }

    fn place_nodes(&self, points: &mut Vec<[f64; 2]>, curves: &EdgeCurves) {
        let end = self.first_inside[self.parents.len()];
        points.reserve(end - self.originals);
        for node in self.originals..end {
            let position = self.place(node, points, curves);
            points.push(position);
        }
    }

    /// Returns the position of a new node: the mean of nodes of its edge or element, plus the offset of curved edges.
    fn place(&self, node: usize, points: &[[f64; 2]], curves: &EdgeCurves) -> [f64; 2] {
        let offset = match self.edges.place(node) {
            Some((ends, part)) => curves.offset(points, ends, part as f64 / self.factor as f64),
            None => self.offset_inside(node, points, curves),
        };
        let [first, rest @ ..] = self.weights(node);
        let from = points[first.0];
        [0, 1].map(|i| {
            let more: f64 = rest.iter().map(|&(n, weight)| weight * (points[n][i] - from[i])).sum();
            from[i] + more + offset[i]
        })
    }

    /// Returns the nodes of the deck from which a new node is interpolated.
    pub fn weights(&self, node: usize) -> NodeWeights {
        let factor = self.factor as f64;
        if let Some(([a, b], part)) = self.edges.place(node) {
            let share = part as f64 / factor;
            return [(a, 1.0 - share), (b, share), (a, 0.0), (a, 0.0)];
        }
        let (parent, [i, j]) = self.lattice_place(node);
        let nodes = &self.parents[parent].nodes;
        if let &[a, b, c, d] = &nodes[..] {
            let (s, t) = (i as f64 / factor, j as f64 / factor);
            return [(a, (1.0 - s) * (1.0 - t)), (b, s * (1.0 - t)), (c, s * t), (d, (1.0 - s) * t)];
        }
        let ([a, b, c], [u, v]) = self.triangle(nodes, i, j);
        [(a, 1.0 - u - v), (b, u), (c, v), (a, 0.0)]
    }

    /// Returns the three-node triangle that contains a lattice node of a triangle, and the fractions of its first and
    /// last side.
    fn triangle(&self, nodes: &[usize], i: usize, j: usize) -> ([usize; 3], [f64; 2]) {
        let n = self.factor;
        let (corners, i, j) = match nodes {
            // Corners and midside nodes of six-node triangles alternate.
            &[a, ab, b, bc, c, ca] => match () {
                () if i + j <= n => ([a, ab, ca], i, j),
                () if i >= n => ([ab, b, bc], i - n, j),
                () if j >= n => ([ca, bc, c], i, j - n),
                () => ([bc, ca, ab], n - i, n - j),
            },
            nodes => ([nodes[0], nodes[1], nodes[2]], i, j),
        };
        (corners, [i as f64 / n as f64, j as f64 / n as f64])
    }

    /// Returns the parent of a node inside an element, and column and row of the node in its lattice.
    fn lattice_place(&self, node: usize) -> (usize, [usize; 2]) {
        let parent = self.first_inside.partition_point(|&first| first <= node) - 1;
        let mut offset = node - self.first_inside[parent];
        let kind = self.parents[parent].kind;
        if kind.node_count() == 4 {
            let row = self.factor - 1;
            return (parent, [offset % row + 1, offset / row + 1]);
        }
        // The rows of a triangle become shorter by one node.
        let (mut row, mut j) = (kind.node_count() / 3 * self.factor - 2, 1);
        while offset >= row {
            (offset, row, j) = (offset - row, row - 1, j + 1);
        }
        (parent, [offset + 1, j])
    }

    /// Returns the offset of a node inside an element, blended from the offsets of its curved edges (transfinite
    /// interpolation).
    fn offset_inside(&self, node: usize, points: &[[f64; 2]], curves: &EdgeCurves) -> [f64; 2] {
        let (parent, [i, j]) = self.lattice_place(node);
        let nodes = &self.parents[parent].nodes;
        let offset = |edge: [usize; 2], share: f64| curves.offset(points, edge, share);
        let parts = if let &[a, b, c, d] = &nodes[..] {
            let (s, t) = (i as f64 / self.factor as f64, j as f64 / self.factor as f64);
            let sides = [([a, b], s, 1.0 - t), ([b, c], t, s), ([d, c], s, t), ([a, d], t, 1.0 - s)];
            sides.map(|(edge, share, weight)| (offset(edge, share), weight))
        } else {
            let ([a, b, c], [u, v]) = self.triangle(nodes, i, j);
            let w = 1.0 - u - v;
            let side = |edge, from: f64, to: f64| (offset(edge, to / (from + to).max(f64::MIN_POSITIVE)), from + to);
            [side([a, b], w, u), side([b, c], u, v), side([c, a], v, w), ([0.0; 2], 0.0)]
        };
        [0, 1].map(|i| parts.iter().map(|(offset, weight)| weight * offset[i]).sum())
    }

    fn add_children(&mut self, parent: usize, mesh: &mut Mesh) {
        let Element { kind, nodes, .. } = &self.parents[parent];
        let (kind, n) = (*kind, self.factor);
        let mut children: Vec<ChildElement> = Vec::new();
        match (nodes.len(), self.partial_division(parent)) {
            (count, Some(sides)) => {
                let middle = |side: usize| self.edges.node([nodes[side], nodes[(side + 1) % count]], 1);
                children = templates::children(nodes, sides, middle, self.first_inside[parent]);
            }
            _ if kind.is_discrete() => children.push((nodes.clone(), 0)),
            (2, None) => {
                let node = |i| self.edges.node([nodes[0], nodes[1]], i);
                children.extend((0..n).map(|i| (NodeIndices::from(&[node(i), node(i + 1)][..]), 0)));
            }
            _ if kind.is_cohesive() => {
                let bottom = |i| self.edges.node([nodes[0], nodes[1]], i);
                let top = |i| self.edges.node([nodes[3], nodes[2]], i);
                let between = |i| [bottom(i), bottom(i + 1), top(i + 1), top(i)];
                children.extend((0..n).map(|i| (NodeIndices::from(&between(i)[..]), 0)));
            }
            (4, None) => children.extend((0..n * n).map(|at| self.quadrilateral(parent, at % n, at / n))),
            _ => {
                for j in 0..n {
                    children.extend((0..n - j).map(|i| self.upright_triangle(parent, i, j)));
                    children.extend((0..n - j - 1).map(|i| self.inverted_triangle(parent, i, j)));
                }
            }
        }
        let Element { name, span, .. } = self.parents[parent].clone();
        for (nodes, sides) in children {
            mesh.elements.push(Element { name: name.clone(), kind, nodes, span });
            self.outer_sides.push(sides);
        }
    }

    fn quadrilateral(&self, parent: usize, i: usize, j: usize) -> (NodeIndices, u8) {
        let last = self.factor - 1;
        let node = |i, j| self.quadrilateral_node(parent, i, j);
        let nodes = [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)];
        (NodeIndices::from(&nodes[..]), bits([j == 0, i == last, j == last, i == 0]))
    }

    fn quadrilateral_node(&self, parent: usize, i: usize, j: usize) -> usize {
        let (nodes, n) = (&self.parents[parent].nodes, self.factor);
        let on = |from: usize, to: usize, part: usize| self.edges.node([nodes[from], nodes[to]], part);
        match (i, j) {
            (_, 0) => on(0, 1, i),
            _ if i == n => on(1, 2, j),
            _ if j == n => on(3, 2, i),
            (0, _) => on(0, 3, j),
            _ => self.first_inside[parent] + (j - 1) * (n - 1) + i - 1,
        }
    }

    fn upright_triangle(&self, parent: usize, i: usize, j: usize) -> (NodeIndices, u8) {
        let sides = [j == 0, i + j + 1 == self.factor, i == 0];
        let sides = if self.parts_of_side(parent) == 2 { bits(sides.map(|s| [s; 2]).concat()) } else { bits(sides) };
        (self.triangle_nodes(parent, [[i, j], [i + 1, j], [i, j + 1]]), sides)
    }

    fn inverted_triangle(&self, parent: usize, i: usize, j: usize) -> (NodeIndices, u8) {
        (self.triangle_nodes(parent, [[i + 1, j + 1], [i, j + 1], [i + 1, j]]), 0)
    }

    /// Returns the number of edges of a side of a triangle: two with a midside node.
    fn parts_of_side(&self, parent: usize) -> usize {
        self.parents[parent].nodes.len() / 3
    }

    /// Returns the nodes of a child with given corners, with its midside nodes if it has any.
    fn triangle_nodes(&self, parent: usize, corners: [[usize; 2]; 3]) -> NodeIndices {
        let parts = self.parts_of_side(parent);
        let mut nodes = Vec::with_capacity(3 * parts);
        for (at, [i, j]) in corners.into_iter().enumerate() {
            let [k, l] = corners[(at + 1) % 3];
            nodes.push(self.triangle_node(parent, parts * i, parts * j));
            if parts == 2 {
                nodes.push(self.triangle_node(parent, i + k, j + l));
            }
        }
        nodes[..].into()
    }

    fn triangle_node(&self, parent: usize, i: usize, j: usize) -> usize {
        let (nodes, parts) = (&self.parents[parent].nodes, self.parts_of_side(parent));
        let end = parts * self.factor;
        let on_side = |side: usize, at: usize| {
            let edge = side * parts + at / self.factor;
            let ends = [nodes[edge % nodes.len()], nodes[(edge + 1) % nodes.len()]];
            self.edges.node(ends, at % self.factor)
        };
        match (i, j) {
            (_, 0) => on_side(0, i),
            _ if i + j == end => on_side(1, j),
            (0, _) => on_side(2, end - j),
            _ => self.first_inside[parent] + (j - 1) * (end - 1) - j * (j - 1) / 2 + i - 1,
        }
    }
}

/// Returns the sides that are true as bits.
fn bits(sides: impl IntoIterator<Item = bool>) -> u8 {
    sides.into_iter().enumerate().map(|(at, side)| u8::from(side) << at).sum()
}
