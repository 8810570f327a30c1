//! Elements: groups of one kind and one material, springs and dashpots, and what follows from all of them together.
//! Never here: nodes' motion, deck words.

mod back_stress;
pub mod block;
pub mod body;
pub mod connector;
pub mod constants;
mod deletion;
pub mod frequency;
pub mod group;
pub mod instructions;
pub mod mass_scaling;
mod mean_stress;
pub mod points;
mod quiescent;
pub mod record;
pub mod rings;
#[cfg(test)]
mod same_bits;
pub mod user_quads;
pub mod volume_guard;

use crate::kernel::lanes::Lanes;
use crate::state::archive::{Archive, Persist};

/// Forces of a block's elements on their corners: r and z of the first corner, of the second, and so on. Like all that the
/// inner loop touches it begins with a cache line.
#[derive(Clone, Debug, Default, PartialEq)]
#[repr(C, align(64))]
pub struct Corners(pub [Lanes; 8]);

impl Persist for Corners {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        self.0.persist(archive);
    }
}
