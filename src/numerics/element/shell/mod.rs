//! Two-node axisymmetric shells (SAX1): element group, section properties, points through the thickness.

mod block;
mod group;
mod record;
pub mod section;

pub use group::ShellGroup;
