//! Revolve: axisymmetric explicit finite-element code for ABAQUS-style decks with user subroutines.
//!
//! A deck text is read into a [`deck::Deck`], validated as a [`model::Model`], and compiled to an immutable
//! [`plan::Plan`] with its initial [`plan::State`]; a run of the plan gives histories, frames and a summary. The module
//! [`job`] combines these steps:
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
//! assert!(prepared.plan.ledger.render(true).contains("disc.inp:16")); // The line of the pressure.
//! let (outcome, history) = job::run_in_memory(&prepared);
//! assert!(outcome.halt.is_none());
//! // u = -p t^2 / (2 rho h)
//! let u = history.0["U2@REF"].last;
//! assert!((u + 1e4 * 1e-6 / (2.0 * 7850.0 * 0.01)).abs() < 1e-9 * u.abs());
//!
//! // The same pressure from a closure: PNU calls it like a VDLOAD in Fortran.
//! let text = disc.replace("TOP, P, 1.e4", "TOP, PNU");
//! let routines = Routines::none().with_pressure(|points, i| if points.r[i] < 0.1 { 1e4 } else { 0.0 });
//! let (_, by_closure) = job::run_in_memory(&job::prepare_text("disc.inp", &text, &[], &routines));
//! assert!((by_closure.0["U2@REF"].last - u).abs() < 1e-9 * u.abs());
//! ```
//!
//! | task | see |
//! |---|---|
//! | define a model in Rust, without a deck | [`model::Model`], [`job::prepare_model`] |
//! | implement a load, a material or a prescribed motion | [`user`] |
//! | receive every history row and frame of a run | [`solve::run`], [`solve::Sink`] |
//! | write the result files of a run | [`job::run_to_files`] |
//! | run a deck many times, estimate its error and run time | [`study`] |
//! | explain a keyword, a variable or a diagnostic code | [`explain`] |
//!
//! Without the default feature `cli`, the program, its charts and its reports are not compiled. The feature `study`, part of
//! `cli`, compiles [`study`] and [`explain`].
#![forbid(unsafe_code)]
#![warn(missing_docs)]

#[cfg(feature = "study")]
#[doc(inline)]
pub use revolve_analysis::{explain, study};
#[doc(inline)]
pub use revolve_host as user;
#[doc(inline)]
pub use revolve_language::{deck, generate, model};
#[doc(inline)]
pub use revolve_numerics::{resistance, variables};
#[doc(inline)]
pub use revolve_results as output;
#[doc(inline)]
pub use revolve_solver::{job, overview, plan, solve};

#[cfg(feature = "cli")]
#[doc(hidden)]
pub use revolve_analysis::report;

#[cfg(feature = "cli")]
#[doc(inline)]
pub use revolve_analysis::{CommandStatus, command_line, default_threads};

/// Internal modules for the tests and benchmarks of the project; not part of the public API.
#[doc(hidden)]
pub mod internals {
    pub use revolve_numerics::element::quad::QuadGroup;
    pub use revolve_numerics::element::{constants, group, values};
    pub use revolve_numerics::kernel::{bulk_viscosity, lanes, quad, rotation};
    pub use revolve_numerics::material::{plasticity, volumetric, von_mises};
    pub use revolve_numerics::mesh::corner_forces;
    pub use revolve_numerics::state::nodes;
}
