//! Two-node axisymmetric shells (SAX1): element group, section properties, points through the thickness.

mod group;
mod point;
mod record;
pub mod section;

pub use group::ShellGroup;
