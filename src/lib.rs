//! Revolve: axisymmetric explicit finite elements with user-load hooks.
#![warn(missing_docs)]
mod constraint;
pub mod deck;
mod element;
pub mod explain;
pub mod job;
mod kernel;
mod load;
mod material;
mod mesh;
pub mod model;
pub mod output;
pub mod plan;
#[cfg(feature = "cli")]
pub mod report;
pub mod solve;
mod state;
pub mod study;
pub mod user;

/// What the project's own tests and benches look into; no part of the library.
#[doc(hidden)]
pub mod internals {
    pub use crate::element::{constants, group, values};
    pub use crate::kernel::{lanes, quad};
    pub use crate::material::{failure, plasticity, volumetric};
    pub use crate::state::nodes;
}
