//! Meshes of projectiles for `revolve mesh`: shapes as profile curves, quadrilaterals in blocks, sets, surfaces, quality.

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
pub use mesh::{Cavity, DeckLabels, Fill, Mesh, MeshRequest};
pub use profile::Point;
pub use shape::Nose;
