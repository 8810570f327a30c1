//! Uniform refinement of any mesh: every edge is divided into equal parts, before surfaces, loads and all other cards
//! that refer to nodes and elements are read. These cards then find the refined sets and faces by themselves.

pub mod apply;
pub mod curves;
mod edges;
mod lattice;
pub mod listed;
pub mod mesh;
pub mod pass;
mod relations;
mod selection;
mod smooth;
