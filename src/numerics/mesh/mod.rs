//! Surfaces, and the assembly of element forces into nodal forces.

pub mod corner_forces;
pub mod gather;
pub mod hidden;
mod room;
pub mod surface;
