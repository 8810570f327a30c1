//! Six-node triangles (CAX6M): groups of composite elements with three integration points.

mod block;
mod calls;
mod group;
mod triangles;

pub use group::SixNodeTriangles;
