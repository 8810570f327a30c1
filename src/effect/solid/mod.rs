//! Deformable bodies: groups of elements of one kind and one material.
//! Never here: nodes' motion, deck words.

pub mod block;
pub mod body;
pub mod connector;
pub mod distortion;
pub mod eos;
pub mod equation;
pub mod failure;
pub mod group;
pub mod guard;
pub mod hyperelastic;
pub mod kinematic;
pub mod law;
pub mod loads;
pub mod mass_scaling;
pub mod points;
pub mod record;
mod rest;
pub mod tie;
pub mod user_body;
pub mod user_material;
pub mod user_motion;
pub mod volumetric;
pub mod wall;

/// Elements side by side in the inner loop.
pub const LANES: usize = 8;

/// One number of each element of a block.
pub type Lanes = [f64; LANES];

/// Forces of a block's elements on their corners: r and z of the first corner, of the second, and so on. Like all that the
/// inner loop touches it begins with a cache line.
#[derive(Clone, Debug, Default, PartialEq)]
#[repr(C, align(64))]
pub struct Corners(pub [Lanes; 8]);
