//! Eight numbers side by side: the width in which inner loops are written, so that compilers make vectors of them.
//! Never here: what the numbers mean.

/// Elements side by side in the inner loop.
pub const LANES: usize = 8;

/// One number of each element of a block.
pub type Lanes = [f64; LANES];

/// Forces of a block's elements on their corners: r and z of the first corner, of the second, and so on. Like all that the
/// inner loop touches it begins with a cache line.
#[derive(Clone, Debug, Default, PartialEq)]
#[repr(C, align(64))]
pub struct Corners(pub [Lanes; 8]);
