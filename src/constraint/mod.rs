//! Constraints: what is prescribed, tied, linked or kept apart, one file a kind.
//! Never here: loads.

pub mod distortion;
pub mod equation;
pub mod motion;
pub mod node_user_motion;
pub mod tie;
pub mod user_motion;
pub mod wall;
