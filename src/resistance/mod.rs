//! Resistance of a target from its stress-strain curve: expansion of a spherical cavity, and A, B, C fitted to its pressure
//! (`docs/resistance.md`).

pub mod codes;
mod cracked;
pub mod derive;
mod fault;
pub mod fit;
mod front;
mod integrate;
mod overstress;
pub mod rate;
mod root;
pub mod similarity;
pub mod target;

pub use derive::{Derived, Request, derive};
pub use fault::ResistanceError;
pub use target::{Curve, Material, Target};
