//! Six-node triangles (CAX6M): groups of composite elements with three integration points.

mod block;
mod solid;
mod triangles;

pub use solid::SixNodeTriangles;
