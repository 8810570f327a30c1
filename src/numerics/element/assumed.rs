//! Stored state of the stresses of assumed strains of a block.

use crate::kernel::lanes::Lanes;
use crate::material::carried::carried_state;
use crate::state::archive::Persist;

/// Stresses of assumed strains of a block.
#[derive(Clone, Copy, Debug, Default, Persist)]
#[repr(C, align(64))]
pub struct AssumedStresses {
    /// Stress of each pattern at the edge of the element: in its direction, and hoop.
    pub(super) stress: [[Lanes; 2]; 2],
    /// Yield stress, as far as it is known; 0 if not.
    pub(super) limit: Lanes,
}

impl AssumedStresses {
    /// Sets the assumed stresses of a lane to zero.
    pub(super) fn clear(&mut self, lane: usize) {
        self.stress.as_flattened_mut().iter_mut().for_each(|s| s[lane] = 0.0);
    }
}

carried_state!(AssumedStresses { stress, limit });
