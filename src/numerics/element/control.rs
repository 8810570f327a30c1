//! Resistance to hourglass patterns, which one integration point cannot detect: an hourglass spring and dashpot,
//! applied with the corner forces of the uniform stress, or stresses of assumed strains, which use intermediate results
//! of the corner forces.

use pulp::Simd;

use crate::kernel::assumed::{hoop, ring};
use crate::kernel::lanes::{Lanes, column, dot};
use crate::kernel::pack::{Pack, PackPosition};
use crate::kernel::quad::QuadOperators;

/// Type of hourglass resistance of a block.
pub(super) trait HourglassScheme {
    /// Whether assumed strains replace the hourglass spring.
    const ENHANCED: bool;

    /// Stores the intermediate results of a pack.
    fn store_pack<S: Simd>(&mut self, at: PackPosition<S>, lane: &LaneKinematics<'_, Pack<S>>);
}

/// Hourglass spring and dashpot.
pub(super) struct PatternSpring;

impl HourglassScheme for PatternSpring {
    const ENHANCED: bool = false;

    #[inline(always)]
    fn store_pack<S: Simd>(&mut self, _at: PackPosition<S>, _lane: &LaneKinematics<'_, Pack<S>>) {}
}

/// Intermediate results of a lane from the corner forces of the uniform stress.
pub(super) struct LaneKinematics<'a, T> {
    pub g: &'a QuadOperators<T>,
    /// One over the volume.
    pub per: T,
    /// Hourglass pattern in base vectors, and its products with the velocities along r and z.
    pub shape: [T; 3],
    pub rate: [T; 2],
    /// Velocities along r, combined by [`sums`](crate::kernel::quad::sums).
    pub v_r: [T; 4],
    /// Sum of the squares of all operators over the corner masses.
    pub squares: T,
}

/// Intermediate results that the stresses of assumed strains reuse.
#[derive(Default)]
#[repr(C, align(64))]
pub(super) struct EnhancedInput {
    /// Hourglass pattern in base vectors, and its products with the velocities along r and z.
    pub shape: [Lanes; 3],
    pub rate: [Lanes; 2],
    /// Operators of the hoop strains along r and z ([`hoop`]), and their products with the velocities along r.
    pub hoop: [[Lanes; 4]; 2],
    pub hoop_rate: [Lanes; 2],
    /// One over the product of mean radius and volume ([`crate::kernel::assumed::AssumedDirections::of`]), and the
    /// volume.
    pub ring: Lanes,
    pub volume: Lanes,
    /// Sum of the squares of all operators over the corner masses and the squared volume.
    pub squares: Lanes,
}

impl HourglassScheme for EnhancedInput {
    const ENHANCED: bool = true;

    #[inline(always)]
    fn store_pack<S: Simd>(&mut self, at: PackPosition<S>, lane: &LaneKinematics<'_, Pack<S>>) {
        let (g, shape, [by_r, by_z]) = (lane.g, lane.shape, hoop(lane.g));
        at.store_all(shape, &mut self.shape);
        at.store_all(by_r, &mut self.hoop[0]);
        at.store_all(by_z, &mut self.hoop[1]);
        at.store_all(lane.rate, &mut self.rate);
        at.store_all([dot(by_r, lane.v_r), dot(by_z, lane.v_r)], &mut self.hoop_rate);
        let square = lane.per * lane.per;
        at.store(ring(g, square), &mut self.ring);
        at.store(g.volume, &mut self.volume);
        at.store(lane.squares * square, &mut self.squares);
    }
}

impl EnhancedInput {
    /// Returns the hourglass pattern and the hoop-strain operators of a lane.
    #[inline(always)]
    pub fn operators(&self, l: usize) -> ([f64; 3], [[f64; 4]; 2]) {
        ([self.shape[0][l], self.shape[1][l], self.shape[2][l]], [column(&self.hoop[0], l), column(&self.hoop[1], l)])
    }
}
