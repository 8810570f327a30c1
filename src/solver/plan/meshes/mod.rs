//! Meshes of the plan: numbering, connected parts, surfaces, labels, and meshes that change during the run.

pub(crate) mod adaptive;
pub(crate) mod labels;
pub(crate) mod numbering;
pub(crate) mod pieces;
pub(crate) mod places;
pub(crate) mod remesh;
pub(crate) mod surfaces;
