//! Revolve: axisymmetric explicit finite elements with user-load hooks. An ABAQUS-flavoured deck goes in, histories and frames
//! come out.
//!
//! Text becomes a [`deck::Deck`], a [`model::Model`], an immutable [`plan::Plan`] with its [`plan::State`] at the start, and a run
//! shows what it comes to. [`job`] has the whole way in one call:
//!
//! ```
//! use revolve::{job, user::Routines};
//!
//! let disc = "
//! *Node, nset=REF
//!  1, 0., 0.
//! *Node
//!  2, 0.1, 0.
//! *Element, type=RAX2, elset=DISC
//!  1, 1, 2
//! *Surface, name=TOP
//!  DISC, SPOS
//! *Rigid Body, elset=DISC, ref node=1, density=7850.
//!  0.01,
//! *Step
//! *Dynamic, Explicit
//!  , 1.e-3
//! *Dsload
//!  TOP, P, 1.e4
//! *Output, history, number interval=10
//! *Node Output, nset=REF
//!  U2
//! *End Step
//! ";
//! let prepared = job::prepare_text("disc.inp", disc, &[], &Routines::none());
//! assert!(!prepared.diagnostics.has_errors(), "{}", prepared.diagnostics.render(&prepared.deck.sources));
//! assert!(prepared.plan.ledger.render(true).contains("disc.inp:16")); // The line that asks for the pressure.
//! let (outcome, history) = job::run_in_memory(&prepared);
//! assert!(outcome.halt.is_none());
//! // u = -p t^2 / (2 rho h)
//! let u = history.0["U2@REF"].last;
//! assert!((u + 1e4 * 1e-6 / (2.0 * 7850.0 * 0.01)).abs() < 1e-9 * u.abs());
//!
//! // The same with a pressure by a closure: PNU calls it, as it calls a VDLOAD in Fortran.
//! let text = disc.replace("TOP, P, 1.e4", "TOP, PNU");
//! let routines = Routines::none().with_pressure(|points, i| if points.r[i] < 0.1 { 1e4 } else { 0.0 });
//! let (_, by_closure) = job::run_in_memory(&job::prepare_text("disc.inp", &text, &[], &routines));
//! assert!((by_closure.0["U2@REF"].last - u).abs() < 1e-9 * u.abs());
//! ```
//!
//! | to | look at |
//! |---|---|
//! | compose a scene in Rust, without a deck | [`model::Model`], [`job::prepare_model`] |
//! | give a load, a material or a motion of one's own | [`user`] |
//! | see every row and frame of a run | [`solve::run`], [`solve::Sink`] |
//! | write the files of a run | [`job::run_to_files`] |
//! | run a deck many times, know its error and its price | [`study`] |
//! | know what a keyword, a variable or a code means | [`explain`] |
//!
//! Without the default feature `cli` neither the program nor its charts and reports are compiled.
#![warn(missing_docs)]
#[cfg(feature = "cli")]
mod command;
#[cfg_attr(not(test), warn(clippy::disallowed_methods))]
mod constraint;
#[macro_use]
pub mod deck;
#[cfg_attr(not(test), warn(clippy::disallowed_methods))]
mod element;
pub mod explain;
pub mod generate;
#[cfg_attr(not(test), warn(clippy::disallowed_methods))]
mod heat;
pub mod job;
#[cfg_attr(not(test), warn(clippy::disallowed_methods))]
mod kernel;
#[cfg_attr(not(test), warn(clippy::disallowed_methods))]
mod load;
#[cfg_attr(not(test), warn(clippy::disallowed_methods))]
mod material;
#[cfg_attr(not(test), warn(clippy::disallowed_methods))]
mod mesh;
pub mod model;
pub mod output;
pub mod overview;
pub mod plan;
mod platform;
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod report;
#[cfg(feature = "resistance")]
pub mod resistance;
#[cfg_attr(not(test), warn(clippy::disallowed_methods))]
pub mod solve;
#[cfg_attr(not(test), warn(clippy::disallowed_methods))]
mod state;
pub mod study;
pub mod user;
pub mod variables;

#[cfg(feature = "cli")]
pub use command::{Status, line::command_line, threads::default as default_threads};

/// What the project's own tests and benches look into; no part of the library.
#[doc(hidden)]
pub mod internals {
    pub use crate::element::{constants, group, values};
    pub use crate::kernel::{lanes, quad, rotation};
    pub use crate::material::{plasticity, volumetric, von_mises};
    pub use crate::mesh::corner_forces;
    pub use crate::state::nodes;
}
