//! Analysis of Revolve: many runs of a deck, pages about results, and the command line. The public interface is in the
//! crate `revolve`.
#![forbid(unsafe_code)]
#![warn(missing_docs)]
// Links to private items serve readers of the sources.
#![allow(rustdoc::private_intra_doc_links)]

use revolve_host as user;
use revolve_language::{deck, generate, model};
use revolve_numerics::{
    constraint, element, kernel, load, material, platform, probability, resistance, state, variables,
};
use revolve_results as output;
#[cfg(feature = "cli")]
use revolve_solver::overview;
use revolve_solver::{job, plan, solve};

// Private, so that functions that the program does not call are not compiled.
#[cfg(feature = "cli")]
#[allow(missing_docs)]
mod command;
pub mod explain;
#[cfg(feature = "cli")]
#[doc(hidden)]
#[allow(missing_docs)]
pub mod report;
pub mod study;
#[cfg(feature = "cli")]
#[allow(missing_docs)]
mod view;

#[cfg(feature = "cli")]
#[doc(hidden)]
pub use command::{CommandStatus, line::command_line, threads::default as default_threads};
