//! What runs a deck many times: sweeps, refinement and its price, effects left out, comparison with references, charts.
//! Never here: a solver of its own.

mod ablation;
pub mod asked;
#[cfg(feature = "cli")]
pub(crate) mod axis;
pub mod bench;
pub mod cases;
pub mod chart;
pub mod columns;
pub mod compare;
pub mod dakota;
#[cfg(feature = "cli")]
pub mod draw;
pub mod effects;
mod error;
pub mod evaluate;
#[cfg(feature = "resistance")]
pub mod expansion;
pub mod field;
pub mod grid;
mod histories;
pub mod identify;
pub mod inputs;
#[cfg(feature = "resistance")]
pub mod law;
pub mod limit;
pub mod price;
pub mod quantity;
pub mod record;
pub mod refinement;
pub mod richardson;
pub mod scatter;
pub mod settings;
pub mod statistics;
pub mod sweep;
pub mod table;
pub mod target;

pub use error::StudyError;
