//! Characteristic lengths, and the element geometry passed to VUCHARLENGTH.

use crate::kernel::lanes::InlineMap;
use crate::kernel::quad::section;
use crate::kernel::topology::PerNode;
use crate::routines::LoadFailure;

/// Positions of the nodes of elements, as arguments of a subroutine.
#[derive(Clone, Debug)]
pub struct ShownElements {
    /// Nodes per element: 6, 3 if all elements have three nodes, else 4.
    pub nodes: usize,
    /// Positions of the nodes (`coordNode`).
    pub places: Vec<f64>,
}

impl ShownElements {
    /// Allocates the positions for `count` elements with so many nodes each.
    pub fn new(count: usize, nodes: usize) -> Self {
        ShownElements { nodes, places: vec![0.0; 2 * nodes * count] }
    }

    pub fn bytes(&self) -> usize {
        size_of_val(&*self.places)
    }

    /// Sets the nodes of an element, given in the order of its topology.
    pub fn set(&mut self, element: usize, around: &PerNode<[f64; 2]>) {
        let count = self.places.len() / (2 * self.nodes);
        for i in 0..self.nodes {
            // The deck gives the corners of a six-node triangle before the middle nodes.
            let position = around[if self.nodes == 6 { 2 * i % 6 + i / 3 } else { i }];
            for (axis, x) in position.into_iter().enumerate() {
                self.places[(axis * self.nodes + i) * count + element] = x;
            }
        }
    }
}

/// Returns the mean of the corners `[r, z]` of an element; the last two corners of a triangle coincide.
pub fn middle(r: [f64; 4], z: [f64; 4]) -> [f64; 2] {
    if r[2] == r[3] && z[2] == z[3] {
        return [r, z].inline_map(|x| (x[0] + x[1] + x[2]) * (1.0 / 3.0));
    }
    [r, z].inline_map(|x| 0.25 * ((x[0] + x[1]) + (x[2] + x[3])))
}

/// Returns the default characteristic length: the square root of the element's area in the (r, z) plane.
pub fn by_default(r: [f64; 4], z: [f64; 4]) -> f64 {
    section(r, z).abs().sqrt()
}

/// Checks that all lengths are positive and finite.
///
/// # Errors
/// The first invalid length.
pub fn above_zero(lengths: &[f64]) -> Result<(), LoadFailure> {
    let Some(point) = lengths.iter().position(|l| !(*l > 0.0 && l.is_finite())) else { return Ok(()) };
    let reason = format!("it returned charLength(k, 1) = {}; a length must be greater than zero", lengths[point]);
    Err(LoadFailure { point: Some(point), reason })
}

/// Returns the user's element number from its name.
pub fn user_number(name: &str) -> i32 {
    name.rsplit('.').next().and_then(|number| number.parse().ok()).unwrap_or(0)
}
