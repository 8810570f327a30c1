//! Characteristic lengths, and the element geometry passed to VUCHARLENGTH.

use crate::kernel::quad::section;
use crate::routines::LoadFailure;

/// Positions of elements and their corners, as arguments of a subroutine.
#[derive(Clone, Debug)]
pub struct ShownElements {
    /// Corners per element: 3 if all are triangles, else 4.
    pub corners: usize,
    /// Centres of the elements (`coordMp`).
    pub middles: Vec<f64>,
    /// Corner positions (`coordNode`).
    pub places: Vec<f64>,
}

impl ShownElements {
    /// Allocates the arrays for `count` elements with `corners` corners each.
    pub fn new(count: usize, corners: usize) -> Self {
        let places = vec![0.0; 2 * corners * count];
        ShownElements { corners, middles: vec![0.0; 2 * count], places }
    }

    pub fn bytes(&self) -> usize {
        size_of_val(&*self.middles) + size_of_val(&*self.places)
    }

    pub fn set(&mut self, element: usize, r: [f64; 4], z: [f64; 4]) {
        let count = self.middles.len() / 2;
        for (axis, x) in [r, z].into_iter().enumerate() {
            for (corner, x) in x.into_iter().take(self.corners).enumerate() {
                self.places[(axis * self.corners + corner) * count + element] = x;
            }
            self.middles[axis * count + element] = 0.25 * ((x[0] + x[1]) + (x[2] + x[3]));
        }
    }
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
