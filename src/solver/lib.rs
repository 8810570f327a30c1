//! Solver of Revolve: the plan of a model, the time loop, and the pipeline from text to result files. The public
//! interface is in the crate `revolve`.
#![forbid(unsafe_code)]
#![warn(missing_docs)]
// Links to private items serve readers of the sources.
#![allow(rustdoc::private_intra_doc_links)]

use revolve_host as user;
use revolve_language::{deck, model};
use revolve_numerics::{
    adaptive, constraint, element, heat, kernel, load, material, mesh, platform, remesh, state, variables,
};
use revolve_results as output;

pub mod job;
pub mod overview;
pub mod plan;
#[cfg_attr(not(test), warn(clippy::disallowed_methods))]
pub mod solve;
