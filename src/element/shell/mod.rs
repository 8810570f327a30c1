//! Shells: groups of two-node axisymmetric shells (SAX1), their section, their points through the thickness.
//! Never here: what of a deck makes a section, the motion of nodes.

mod group;
mod point;
mod record;
pub mod section;

pub use group::Shells;
