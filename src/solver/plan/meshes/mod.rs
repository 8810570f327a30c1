//! Meshes of the plan: numbering, connected parts, surfaces, labels, and meshes that change during the run.

pub mod adaptive;
pub mod automatic;
pub mod labels;
pub mod numbering;
pub mod pieces;
pub mod places;
pub mod remesh;
pub mod renewal;
pub mod surfaces;
