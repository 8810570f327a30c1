//! Refinement of any mesh: every edge, or the edges of some elements, are divided into equal parts, before surfaces, loads and all other cards
//! that refer to nodes and elements are read. These cards then find the refined sets and faces by themselves.

pub mod apply;
pub mod curves;
mod edges;
mod lattice;
pub mod listed;
mod local;
pub mod mesh;
pub mod pass;
mod relations;
mod selection;
mod smooth;
mod templates;
