//! Generation of projectile meshes for `revolve mesh`: profiles, structured quadrilateral blocks, sets, surfaces and
//! quality.

pub mod codes;
mod deck;
mod measure;
mod mesh;
mod nose;
mod picture;
mod profile;
mod quality;
mod shape;
mod sheet;
mod spacing;

pub use measure::{MeshMeasure, PartVolume};
pub use mesh::{CaseCavity, CavityFill, DeckLabels, MeshRequest, ProjectileMesh};
pub use profile::MeridianPoint;
pub use shape::NoseShape;
