//! What resists the patterns of elements that one integration point does not see: a spring of the pattern, which the corner forces
//! of the uniform stress carry along, or stresses of assumed strains, which need what these have found.
//! Never here: stresses.
#![allow(clippy::needless_range_loop)] // Loops over lanes are the form that compilers turn into vectors.

use crate::kernel::assumed::{hoop, ring};
use crate::kernel::lanes::{Lanes, column, dot};
use crate::kernel::quad::Operators;
use crate::kernel::real::Real;

/// What resists the patterns of a block's elements.
pub(super) trait Control<T: Real = f64> {
    /// Whether it is assumed strains instead of a spring of the pattern.
    const ENHANCED: bool;

    /// Takes a lane as the corner forces of the uniform stress have found it.
    fn see(&mut self, l: usize, lane: &Lane<'_, T>);
}

/// The spring and the dashpot of the pattern.
pub(super) struct Spring;

impl<T: Real> Control<T> for Spring {
    const ENHANCED: bool = false;

    #[inline(always)]
    fn see(&mut self, _l: usize, _lane: &Lane<'_, T>) {}
}

/// A lane as the corner forces of the uniform stress have found it.
pub(super) struct Lane<'a, T = f64> {
    pub g: &'a Operators<T>,
    /// One over the volume.
    pub per: T,
    /// The hourglass pattern by base vectors, and its products with the velocities along r and z.
    pub shape: [T; 3],
    pub rate: [T; 2],
    /// Sums of the velocities along r.
    pub v_r: [T; 4],
    /// Sum of the squares of all operators over the masses of the corners.
    pub squares: T,
}

/// What stresses of assumed strains take from there, so that nothing is reckoned twice.
#[derive(Default)]
#[repr(C, align(64))]
pub(super) struct Seen {
    /// The hourglass pattern by base vectors, and its products with the velocities along r and z.
    pub shape: [Lanes; 3],
    pub rate: [Lanes; 2],
    /// Operators of the hoop strains along r and z ([`hoop`]), and their products with the velocities along r.
    pub hoop: [[Lanes; 4]; 2],
    pub hoop_rate: [Lanes; 2],
    /// One over the mean radius and the volume ([`crate::kernel::assumed::Directions::of`]).
    pub ring: Lanes,
    pub volume: Lanes,
    /// Sum of the squares of all operators over the masses of the corners and the square of the volume.
    pub squares: Lanes,
}

impl Control for Seen {
    const ENHANCED: bool = true;

    #[inline(always)]
    fn see(&mut self, l: usize, lane: &Lane<'_>) {
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

impl Seen {
    /// The hourglass pattern and the operators of the hoop strains of a lane.
    #[inline(always)]
    pub fn operators(&self, l: usize) -> ([f64; 3], [[f64; 4]; 2]) {
        ([self.shape[0][l], self.shape[1][l], self.shape[2][l]], [column(&self.hoop[0], l), column(&self.hoop[1], l)])
    }
}
