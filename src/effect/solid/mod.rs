//! Deformable bodies: groups of elements of one kind and one material.
//! Never here: nodes' motion, deck words.

pub mod area;
pub mod block;
pub mod body;
pub mod connector;
pub mod distortion;
pub mod eos;
pub mod equation;
pub mod failure;
pub mod frequency;
pub mod group;
pub mod guard;
pub mod hyperelastic;
pub mod instructions;
pub mod kinematic;
pub mod law;
pub mod loads;
pub mod mass_scaling;
pub mod moving;
pub mod points;
pub mod record;
mod rest;
#[cfg(test)]
mod same_bits;
pub mod tie;
pub mod user_body;
pub mod user_material;
pub mod user_motion;
pub mod volumetric;
pub mod wall;

use crate::state::archive::{Archive, Persist};

/// Elements side by side in the inner loop.
pub const LANES: usize = 8;

/// One number of each element of a block.
pub type Lanes = [f64; LANES];

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
