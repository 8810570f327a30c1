//! Resistance of a target from its stress-strain curve: spherical or cylindrical cavity expansion, and the fit of A, B, C to its
//! pressure (`docs/resistance.md`).

pub mod codes;
mod cracked;
pub mod derive;
mod fault;
pub mod fit;
mod front;
mod integrate;
pub mod law_target;
mod overstress;
pub mod rate;
mod root;
mod shock_wave;
pub mod similarity;
pub mod target;

pub use derive::{DerivedResistance, ExpansionTarget, FitRequest, TargetScale, derive};
pub use fault::ResistanceError;
pub use law_target::LawTarget;
pub use target::{CavityShape, ScaledTarget, TargetMaterial, TargetSizes, YieldCurve};
