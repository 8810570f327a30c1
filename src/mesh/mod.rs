//! Surfaces and the way from elements to nodes.
//! Never here: time.

pub mod corner_forces;
pub mod gather;
pub mod hidden;
mod room;
pub mod surface;
