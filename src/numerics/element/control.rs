//! Resistance to hourglass patterns, which one integration point cannot detect: an hourglass spring and dashpot,
//! applied with the corner forces of the uniform stress, or stresses of assumed strains, which use intermediate results
//! of the corner forces.
#![allow(clippy::needless_range_loop)] // Compilers vectorize loops over lanes in this form.

use crate::kernel::assumed::{hoop, ring};
use crate::kernel::lanes::{Lanes, column, dot};
use crate::kernel::quad::QuadOperators;
use crate::kernel::real::Real;

/// Type of hourglass resistance of a block.
pub(super) trait HourglassScheme<T: Real = f64> {
    /// Whether assumed strains replace the hourglass spring.
    const ENHANCED: bool;

    /// Stores the intermediate results of a lane.
    fn store_lane(&mut self, l: usize, lane: &LaneKinematics<'_, T>);
}

/// Hourglass spring and dashpot.
pub(super) struct PatternSpring;

impl<T: Real> HourglassScheme<T> for PatternSpring {
    const ENHANCED: bool = false;

    #[inline(always)]
    fn store_lane(&mut self, _l: usize, _lane: &LaneKinematics<'_, T>) {}
}

/// Intermediate results of a lane from the corner forces of the uniform stress.
pub(super) struct LaneKinematics<'a, T = f64> {
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
    fn store_lane(&mut self, l: usize, lane: &LaneKinematics<'_>) {
        let (g, shape, [by_r, by_z]) = (lane.g, lane.shape, hoop(lane.g));
        for i in 0..3 {
            self.shape[i][l] = shape[i];
        }
        for i in 0..4 {
            self.hoop[0][i][l] = by_r[i];
            self.hoop[1][i][l] = by_z[i];
        }
        self.rate[0][l] = lane.rate[0];
        self.rate[1][l] = lane.rate[1];
        self.hoop_rate[0][l] = dot(by_r, lane.v_r);
        self.hoop_rate[1][l] = dot(by_z, lane.v_r);
        let square = lane.per * lane.per;
        self.ring[l] = ring(g, square);
        self.volume[l] = g.volume;
        self.squares[l] = lane.squares * square;
    }
}

impl EnhancedInput {
    /// Returns the hourglass pattern and the hoop-strain operators of a lane.
    #[inline(always)]
    pub fn operators(&self, l: usize) -> ([f64; 3], [[f64; 4]; 2]) {
        ([self.shape[0][l], self.shape[1][l], self.shape[2][l]], [column(&self.hoop[0], l), column(&self.hoop[1], l)])
    }
}
