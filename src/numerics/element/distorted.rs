//! Elements of a block that may be distorted, found in lanes: most elements are clear of the limit and need no exact value.

use pulp::NullaryFnOnce;

use crate::kernel::corners::is_clear;
use crate::kernel::lanes::{InlineMap, LANES, Lanes};
use crate::state::nodes::Node;

/// Operation that returns the lanes of a block whose scaled Jacobian may be at most `least`, as bits.
pub(super) struct DistortedLanes<'a> {
    /// Nodes of the corners.
    pub(super) corners: &'a [[u32; LANES]; 4],
    pub(super) nodes: &'a [Node],
    pub(super) least: f64,
}

impl NullaryFnOnce for DistortedLanes<'_> {
    type Output = u32;

    #[inline(always)]
    fn call(self) -> u32 {
        let mut places = [[[0.0; LANES]; 2]; 4];
        for (list, corner) in places.iter_mut().zip(self.corners) {
            for l in 0..LANES {
                let node = &self.nodes[corner[l] as usize];
                (list[0][l], list[1][l]) = (node.r, node.z);
            }
        }
        let mut clear = [true; LANES];
        for i in 0..4 {
            let [at, next, before] = [places[i], places[(i + 1) % 4], places[(i + 3) % 4]];
            for l in 0..LANES {
                let [at, next, before] = [&at, &next, &before].inline_map(|list: &[Lanes; 2]| [list[0][l], list[1][l]]);
                clear[l] &= is_clear([at, next, before], self.least);
            }
        }
        lanes_with(|lane| !clear[lane])
    }
}

/// Returns the lanes for which a condition holds, as bits.
#[inline(always)]
pub(super) fn lanes_with(condition: impl Fn(usize) -> bool) -> u32 {
    (0..LANES).fold(0, |lanes, lane| lanes | u32::from(condition(lane)) << lane)
}
