//! Blocks of quadrilaterals between kept mesh lines, and their merged elements.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use super::kept_lines::KeptLines;
use super::mesh::{CoarsenedMesh, CoarseningFault};
use super::quadrilaterals::{Quadrilaterals, Regions};
use crate::model::element_nodes::NodeIndices;
use crate::model::types::{Element, Mesh};

/// A rectangular block of quadrilaterals.
pub struct Block {
    /// Number of elements along both directions.
    size: [usize; 2],
    /// Elements row by row, and the side of each that is the lower one in the block.
    cells: Vec<(usize, usize)>,
}

/// Column, row and rotation of an element in its block.
type Place = ([i64; 2], usize);

/// Steps across the four sides of a block, which are in the order of the sides of an element.
const STEPS: [[i64; 2]; 4] = [[0, -1], [1, 0], [0, 1], [-1, 0]];

/// Returns the blocks of all quadrilaterals.
pub fn find_blocks(quads: &Quadrilaterals<'_>, regions: &Regions, fixed: &[usize]) -> Vec<Block> {
    let mut fixed = fixed.to_vec();
    loop {
        let lines = KeptLines::find(quads, regions, &fixed);
        match blocks_between(quads, &lines) {
            Ok(blocks) => return blocks,
            // A closed ring begins at any of its lines.
            Err(node) => fixed.push(node),
        }
    }
}

/// Returns the blocks, or a node of a block that is a closed ring.
fn blocks_between(quads: &Quadrilaterals<'_>, lines: &KeptLines) -> Result<Vec<Block>, usize> {
    let mut known: HashMap<usize, Place> = HashMap::new();
    let mut blocks = Vec::new();
    for &first in &quads.elements {
        if let Entry::Vacant(start) = known.entry(first) {
            start.insert(([0; 2], 0));
            let elements = connected(quads, lines, first, &mut known)?;
            blocks.push(Block::new(&elements, &known));
        }
    }
    Ok(blocks)
}

/// Returns the elements of the block of an element, and adds their places.
fn connected(
    quads: &Quadrilaterals<'_>,
    lines: &KeptLines,
    first: usize,
    known: &mut HashMap<usize, Place>,
) -> Result<Vec<usize>, usize> {
    let mut elements = vec![first];
    let mut index = 0;
    while let Some(&element) = elements.get(index) {
        let ([i, j], turn) = known[&element];
        for (direction, step) in STEPS.iter().enumerate() {
            let side = (direction + turn) % 4;
            let is_end = lines.edges[quads.edge(element, side)];
            let Some((next, other)) = quads.neighbour(element, side).filter(|_| !is_end) else { continue };
            // The neighbour has the opposite side there.
            let position = ([i + step[0], j + step[1]], (other + 6 - direction) % 4);
            match known.insert(next, position) {
                None => elements.push(next),
                Some(before) if before == position => {}
                Some(_) => return Err(quads.mesh.elements[element].nodes[side]),
            }
        }
        index += 1;
    }
    Ok(elements)
}

impl Block {
    fn new(all: &[usize], known: &HashMap<usize, Place>) -> Block {
        let extreme = |axis: usize| {
            let places = all.iter().map(|element| known[element].0[axis]);
            places.fold([i64::MAX, i64::MIN], |[low, high], x| [low.min(x), high.max(x)])
        };
        let ranges = [extreme(0), extreme(1)];
        let size = ranges.map(|[low, high]| (high - low + 1) as usize);
        let mut cells: Vec<(usize, usize)> = all.iter().map(|&element| (element, known[&element].1)).collect();
        cells.sort_by_key(|cell| (known[&cell.0].0[1], known[&cell.0].0[0]));
        Block { size, cells }
    }

    /// Returns why the block cannot be merged, if it cannot.
    pub fn fault(&self, mesh: &Mesh, factor: usize) -> Option<CoarseningFault> {
        let [n, m] = self.size;
        let element = &mesh.elements[self.cells[0].0];
        if n % factor == 0 && m % factor == 0 && n * m == self.cells.len() {
            return None;
        }
        let message = format!("a block of {n} by {m} elements cannot be merged by {factor} in both directions");
        Some(CoarseningFault::new(message, format!("element {} of the block", element.name), element.span))
    }

    /// Adds the merged elements. Each has the order of nodes of its first part.
    pub fn merge(&self, fine: &Mesh, factor: usize, coarse: (&mut Mesh, &mut CoarsenedMesh)) {
        let (mesh, merged) = coarse;
        let row = self.size[0];
        let cell = |i: usize, j: usize| self.cells[j * row + i];
        for (i, j) in (0..self.size[1] / factor).flat_map(|j| (0..row / factor).map(move |i| (i * factor, j * factor)))
        {
            let end = factor - 1;
            let corners = [cell(i, j), cell(i + end, j), cell(i + end, j + end), cell(i, j + end)];
            let node = |corner: usize| {
                let (element, turn) = corners[corner];
                fine.elements[element].nodes[(corner + turn) % 4]
            };
            let (first, turn) = corners[0];
            let nodes: [usize; 4] = [0, 1, 2, 3].map(|local| node((local + 4 - turn) % 4));
            let parts = (0..factor * factor).map(|at| cell(i + at % factor, j + at / factor).0).collect();
            let element = Element { nodes: NodeIndices::from(&nodes[..]), ..fine.elements[first].clone() };
            merged.add(element, parts, mesh);
        }
    }
}
