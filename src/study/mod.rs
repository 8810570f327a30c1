//! What runs a deck many times: sweeps, comparison with references, charts.
//! Never here: a solver of its own.

pub mod chart;
pub mod compare;
pub mod grid;
pub mod quantity;
pub mod sweep;
pub mod table;
