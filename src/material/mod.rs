//! Materials: hardening, volumetric law, failure, one file a law.
//! Never here: elements, meshes.

pub mod eos;
pub mod failure;
pub mod hyperelastic;
pub mod kinematic;
pub mod kinematic_rate;
pub mod plasticity;
pub mod volumetric;
