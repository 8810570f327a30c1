//! What a block keeps of stresses of assumed strains.
//! Never here: what they answer.

use crate::kernel::lanes::Lanes;
use crate::state::archive::persist_struct;

/// What a block keeps of its patterns.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub struct Assumed {
    /// Stress of each pattern at the edge of the element: along its direction, and hoop.
    pub(super) stress: [[Lanes; 2]; 2],
    /// Von Mises stress at which the element flows as far as it is known; 0 if not.
    pub(super) limit: Lanes,
}

impl Assumed {
    /// Takes the stresses of a lane away.
    pub(super) fn clear(&mut self, lane: usize) {
        self.stress.as_flattened_mut().iter_mut().for_each(|s| s[lane] = 0.0);
    }
}

persist_struct!(Assumed { stress, limit });
