//! Deletion criteria of `*EROSION`, and the quick test of a block of elements.

use crate::state::nodes::Node;

/// Deletion criteria of an element; one is sufficient.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DeletionCriteria {
    /// Scaled Jacobian less than or equal to this value.
    pub distortion: Option<f64>,
    /// Equivalent plastic strain greater than or equal to this value; for shells at the middle point.
    pub plastic: Option<f64>,
    /// Largest principal logarithmic strain greater than or equal to this value.
    pub strain: Option<f64>,
    /// Own stable time increment less than or equal to this value.
    pub increment: Option<f64>,
}

/// Quick test of deletion criteria in lanes.
pub trait DeletionFilter {
    /// Returns the lanes of a block whose elements may meet deletion criteria, as bits; others meet none.
    fn may_meet(&self, _criteria: &DeletionCriteria, _block: usize, _nodes: &[Node]) -> u32 {
        u32::MAX
    }
}
