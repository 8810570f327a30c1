//! Elements of a block that were deleted by `*EROSION`.

use crate::kernel::lanes::Lanes;
use crate::kernel::quad::UNIT;
use crate::state::archive::Persist;

/// Deletion state of a block's elements, independent of their materials.
#[derive(Clone, Copy, Debug, Default, Persist)]
pub struct ErodedLanes {
    /// Height of the ring that replaces each deleted element; 0 for active elements.
    height: Lanes,
}

impl ErodedLanes {
    /// Deletes an element with this initial volume.
    pub(super) fn take(&mut self, lane: usize, volume: f64) {
        self.height[lane] = height(volume);
    }

    /// Returns the height of the ring that replaces a lane.
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

/// Returns the height of a ring of this volume with radii 1 and 2; the ring's volume is 3π times its height.
#[inline(always)]
pub(super) fn height(volume: f64) -> f64 {
    volume / (24.0 * UNIT)
}
