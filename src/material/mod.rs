//! Materials: hardening, volumetric law, failure, one file a law.
//! Never here: elements, meshes.

pub mod eos;
pub mod explosive;
pub mod failure;
pub mod foam;
pub mod hyperelastic;
pub mod kinematic;
pub mod kinematic_rate;
pub mod plasticity;
pub mod strain_energy;
pub mod volumetric;
