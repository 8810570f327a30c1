//! Decks in the manner of pre-processors and analysts: each generator writes the input file of one physical scene, the
//! program runs it, and a result is compared with a closed-form estimate.
//!
//! A module holds the decks of one writer. Every scene also asserts its warnings and its energy balance. Units are mm,
//! t, s, N and MPa unless a scene states others. `cargo test --test corpus -- --nocapture` prints what the user would
//! read.

#[path = "../common/mod.rs"]
mod common;

mod abapy;
mod cae;
mod cae_contact;
mod forms;
mod gmsh;
mod grid;
mod hypermesh;
mod prepomax;
mod run;
mod typed;
