//! Four-node axisymmetric cohesive elements (COHAX4): element group, bounds of the stable time increment.

pub mod bounds;
mod group;

pub use group::{CohesiveElement, CohesiveGroup};
