//! Resistance of a target from its own stress-strain curve: dynamic expansion of a spherical cavity, and the constants A, B, C
//! fitted to what presses on it (`docs/resistance.md`).
//! Never here: decks, models, what a resistance does to a projectile (`load/cavity`).

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
pub use fault::Fault;
pub use target::{Curve, Material, Target};
