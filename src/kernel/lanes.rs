//! Eight numbers side by side: the width in which inner loops are written, so that compilers make vectors of them.
//! Never here: what the numbers mean.

/// Elements side by side in the inner loop.
pub const LANES: usize = 8;

/// One number of each element of a block.
pub type Lanes = [f64; LANES];
