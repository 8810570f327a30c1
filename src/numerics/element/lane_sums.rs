//! Sums and the largest rate of a task, lane by lane.
#![allow(clippy::needless_range_loop)] // Compilers vectorize loops over lanes in this form.

use crate::kernel::lanes::{LANES, Lanes};
use crate::state::archive::Persist;

/// Blocks of one task of a thread. The number is fixed, so that sums do not depend on the number of threads.
pub const TASK: usize = 16;

/// Energy increments and the largest rate of a task in one increment, lane by lane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Persist)]
pub struct LaneSums {
    /// Work of the stress.
    pub internal: Lanes,
    /// Plastic dissipation in the increment, energy.
    pub plastic: Lanes,
    /// Elastic energy lost by damage, a part of `plastic`.
    pub damaged: Lanes,
    /// Work of the bulk viscosity.
    pub viscous: Lanes,
    /// Work of the hourglass control.
    pub artificial: Lanes,
    /// Two over the stable time increment of the element that limits each lane, 1/time.
    pub rate: Lanes,
    /// Index of the block with that element; a float, so that lanes select it without a branch.
    pub limiting: Lanes,
}

impl LaneSums {
    /// Adds the sums of later blocks, lane by lane.
    pub(super) fn add(&mut self, later: &LaneSums) {
        for l in 0..LANES {
            self.internal[l] += later.internal[l];
            self.plastic[l] += later.plastic[l];
            self.damaged[l] += later.damaged[l];
            self.viscous[l] += later.viscous[l];
            self.artificial[l] += later.artificial[l];
            if is_larger(later.rate[l], self.rate[l]) {
                (self.rate[l], self.limiting[l]) = (later.rate[l], later.limiting[l]);
            }
        }
    }
}

/// Returns the larger of two numbers; `b` if either is NaN.
#[inline(always)]
pub(super) fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// Returns whether `rate` replaces the largest rate so far. NaN counts as the largest, and the first NaN is kept, so
/// that the element with the error is reported.
#[inline(always)]
pub fn is_larger(rate: f64, largest: f64) -> bool {
    (rate > largest) | (rate.is_nan() & !largest.is_nan())
}

/// Returns the sum over lanes, always in the same order.
pub fn across(list: &Lanes) -> f64 {
    let mut sums = *list;
    let mut width = LANES / 2;
    while width > 0 {
        for l in 0..width {
            sums[l] += sums[l + width];
        }
        width /= 2;
    }
    sums[0]
}
