//! Elements: groups of one kind and one material, springs and dashpots, and what follows from all of them together.
//! Never here: nodes' motion, deck words.

mod back_stress;
pub mod block;
pub mod connector;
pub mod constants;
pub mod damping;
mod deletion;
pub mod distortion;
pub mod elements;
pub mod enhanced;
mod estimate;
pub mod frequency;
pub mod group;
pub mod instructions;
pub mod mass_scaling;
mod mean_stress;
pub mod points;
pub mod quiescent;
pub mod record;
mod rescale;
pub mod rings;
#[cfg(test)]
mod same_bits;
pub mod shell;
mod user_chunk;
mod user_flow;
pub mod user_law;
pub mod user_quads;
pub mod values;
pub mod volume_guard;
