//! Characteristic lengths, and elements as a routine of characteristic lengths is shown them.
//! Never here: what takes a length.

use crate::kernel::quad::section;
use crate::user::LoadFailure;

/// Where elements and their corners are, as a routine is shown them.
#[derive(Clone, Debug)]
pub struct ShownElements {
    /// Corners of an element: 3 where all are triangles, 4 else.
    pub corners: usize,
    /// `coordMp`.
    pub middles: Vec<f64>,
    /// `coordNode`.
    pub places: Vec<f64>,
}

impl ShownElements {
    /// Room for so many elements, which all have so many corners.
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

/// The characteristic length unless a routine says otherwise: the root of the element's area in the (r, z) plane.
pub fn by_default(r: [f64; 4], z: [f64; 4]) -> f64 {
    section(r, z).abs().sqrt()
}

/// Whether all lengths are above zero.
///
/// # Errors
/// The first that is not.
pub fn above_zero(lengths: &[f64]) -> Result<(), LoadFailure> {
    let Some(point) = lengths.iter().position(|l| !(*l > 0.0 && l.is_finite())) else { return Ok(()) };
    let reason = format!("it gave charLength(k, 1) = {}; a length is above zero", lengths[point]);
    Err(LoadFailure { point: Some(point), reason })
}

/// The user's number of an element, by its name.
pub fn user_number(name: &str) -> i32 {
    name.rsplit('.').next().and_then(|number| number.parse().ok()).unwrap_or(0)
}
