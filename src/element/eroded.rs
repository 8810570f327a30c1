//! Which elements of a block were deleted from outside.
//! Never here: why, what is done about it.

use crate::kernel::lanes::Lanes;
use crate::kernel::quad::UNIT;
use crate::state::archive::persist_struct;

/// Elements of a block that were deleted from outside, whatever their laws say.
#[derive(Clone, Copy, Debug, Default)]
pub struct Eroded {
    /// Height of the ring that stands in place of each; 0 of those that are there.
    height: Lanes,
}

impl Eroded {
    /// Takes an element of this volume at the start.
    pub(super) fn take(&mut self, lane: usize, volume: f64) {
        self.height[lane] = height(volume);
    }

    /// Height of the ring that stands in place of a lane.
    pub(super) fn height(&self, lane: usize) -> f64 {
        self.height[lane]
    }

    pub(super) fn has(&self, lane: usize) -> bool {
        self.height[lane] > 0.0
    }

    #[inline(always)]
    pub(super) fn any(&self) -> bool {
        self.height.iter().any(|h| *h > 0.0)
    }
}

/// Height of a ring from 1 to 2 of some volume, which is 3 pi a height.
#[inline(always)]
pub(super) fn height(volume: f64) -> f64 {
    volume / (24.0 * UNIT)
}

persist_struct!(Eroded { height });
