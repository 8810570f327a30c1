//! Meshes of projectiles for `revolve mesh`: shapes as profile curves, quadrilaterals in blocks, sets, surfaces, quality.
//! Never here: decks that are read, physics, the command line.

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

pub use measure::{Measure, Part};
pub use mesh::{Cavity, Fill, Labels, Mesh, Wanted};
pub use profile::Point;
pub use shape::Nose;
