//! Six-node triangles (CAX6M): groups of composite elements with three points each.
//! Never here: gradient operators, laws of materials.

mod block;
mod group;
mod triangles;

pub use group::SixNodeTriangles;
