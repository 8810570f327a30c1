//! Generation of meshes for `revolve mesh`: projectiles from profiles, bodies with a rectangular section, structured
//! quadrilateral blocks, sets, surfaces and quality.

pub mod codes;
mod deck;
mod measure;
mod mesh;
mod nose;
mod picture;
mod profile;
mod quality;
mod rectangle;
mod shape;
mod sheet;
mod spacing;

pub use measure::{MeshMeasure, PartVolume, QuadQuality};
pub use mesh::{CaseCavity, CavityFill, DeckLabels, MeshRequest, ProjectileMesh};
pub use profile::MeridianPoint;
pub use rectangle::{BodyLabels, RectangleMesh, RectangleRequest};
pub use shape::NoseShape;
