//! Many runs of a deck: sweeps, convergence and ablation studies, ballistic limits, identification, Monte Carlo,
//! charts.

mod ablation;
#[cfg(feature = "cli")]
pub(crate) mod cases;
pub mod causes;
#[cfg(feature = "cli")]
pub mod chosen;
#[cfg(feature = "cli")]
pub(crate) mod columns;
pub mod compare;
pub mod convergence;
#[cfg(feature = "cli")]
pub(crate) mod dakota;
pub mod effects;
mod error;
pub mod evaluate;
pub mod expansion;
mod field;
#[cfg(feature = "cli")]
pub(crate) mod fragments;
pub mod grid;
pub mod identify;
#[cfg(feature = "cli")]
pub mod inputs;
pub mod jitter;
#[cfg(feature = "cli")]
pub(crate) mod law;
#[cfg(feature = "cli")]
pub mod limit;
pub mod local;
pub mod log;
#[cfg(feature = "cli")]
pub mod map;
#[cfg(feature = "cli")]
pub mod material;
pub mod noise;
mod passage;
mod price;
pub mod quantity;
pub mod record;
pub mod refinement;
pub mod richardson;
#[cfg(feature = "cli")]
pub mod rubber;
pub mod runner;
#[cfg(feature = "cli")]
pub(crate) mod scatter;
pub mod sensitivity;
pub mod settings;
pub mod shot;
pub mod statistics;
pub mod strength;
pub mod sweep;
pub mod target;
#[cfg(feature = "cli")]
pub mod uncertainty;

pub use error::StudyError;
#[cfg(feature = "cli")]
pub(crate) use revolve_results::axis;
pub use revolve_results::{chart, table};
