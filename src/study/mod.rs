//! What runs a deck many times: sweeps, refinement and its price, effects left out, comparison with references, charts.
//! Never here: a solver of its own.

mod ablation;
pub mod asked;
#[cfg(feature = "cli")]
pub(crate) mod axis;
pub mod bench;
pub mod cases;
pub mod chart;
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
#[cfg(feature = "resistance")]
pub mod law;
pub mod price;
pub mod quantity;
pub mod record;
pub mod refinement;
pub mod richardson;
pub mod settings;
pub mod sweep;
pub mod table;
pub mod target;

pub use error::StudyError;
