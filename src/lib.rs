//! Revolve: axisymmetric explicit finite elements with user-load hooks.
#![warn(missing_docs)]
pub mod constraint;
pub mod deck;
pub mod element;
pub mod explain;
pub mod job;
pub mod kernel;
pub mod load;
pub mod material;
pub mod mesh;
pub mod model;
pub mod output;
pub mod plan;
#[cfg(feature = "cli")]
pub mod report;
pub mod solve;
pub mod state;
pub mod study;
pub mod user;
