//! Forces of elements on their corner nodes, stored by blocks of elements.

use std::ops::Range;

use crate::kernel::lanes::{BlockCornerForces, LANES};
use crate::kernel::lists::Memory;
use crate::state::archive::{Persist, StateArchive};

/// Numbers of a block.
const BLOCK: usize = 8 * LANES;
/// Bytes of a cache line. Blocks begin with a line, because a vector register that crosses lines is written slowly.
const LINE: usize = 64;

/// Corner forces of all elements.
#[derive(Debug, Memory)]
pub struct CornerForces {
    /// Numbers of all blocks, after those before the first cache line.
    list: Vec<f64>,
    start: usize,
}

impl Default for CornerForces {
    fn default() -> Self {
        CornerForces::new(0)
    }
}

impl Clone for CornerForces {
    fn clone(&self) -> Self {
        let mut copy = CornerForces::new(self.values().len() / BLOCK);
        copy.values_mut().copy_from_slice(self.values());
        copy
    }
}

impl CornerForces {
    /// Creates zero forces for a number of blocks.
    pub fn new(blocks: usize) -> Self {
        let per_line = LINE / size_of::<f64>();
        let mut list = vec![0.0; blocks * BLOCK + per_line];
        let start = list.as_ptr().align_offset(LINE).min(per_line);
        list.truncate(start + blocks * BLOCK);
        CornerForces { list, start }
    }

    /// Returns the corner forces of a range of blocks.
    pub fn slots(&mut self, blocks: Range<usize>) -> &mut [BlockCornerForces] {
        let lists = self.values_mut().as_chunks_mut::<LANES>().0;
        &mut lists.as_chunks_mut::<2>().0.as_chunks_mut::<4>().0[blocks]
    }

    /// Returns the numbers of all blocks: [`LANES`] forces along r and as many along z for each of four corners.
    #[inline(always)]
    pub fn values(&self) -> &[f64] {
        &self.list[self.start..]
    }

    fn values_mut(&mut self) -> &mut [f64] {
        &mut self.list[self.start..]
    }

    /// Returns the index in [`CornerForces::values`] of the force along r on a corner of an element; the force along z
    /// is [`LANES`] numbers later.
    pub fn index(block: usize, lane: usize, corner: usize) -> usize {
        block * BLOCK + corner * 2 * LANES + lane
    }

    /// Returns the block of an index, and the index within the block.
    pub fn place(index: u32) -> (usize, usize) {
        (index as usize / BLOCK, index as usize % BLOCK)
    }

    /// Returns whether there are no blocks.
    pub fn is_empty(&self) -> bool {
        self.values().is_empty()
    }

    /// Returns the force `[r, z]` on a corner of an element.
    pub fn of(&self, block: usize, lane: usize, corner: usize) -> [f64; 2] {
        let index = CornerForces::index(block, lane, corner);
        [self.values()[index], self.values()[index + LANES]]
    }

    /// Sets the corner forces of an element to zero.
    pub fn clear(&mut self, block: usize, lane: usize) {
        clear_lane(&mut self.slots(block..block + 1)[0], lane);
    }
}

/// Sets the corner forces of a lane to zero.
#[inline(always)]
pub fn clear_lane(corners: &mut BlockCornerForces, lane: usize) {
    corners.as_flattened_mut().iter_mut().for_each(|list| list[lane] = 0.0);
}

/// Returns whether all forces are zero.
pub fn are_zero(corners: &[BlockCornerForces]) -> bool {
    corners.as_flattened().as_flattened().as_flattened().iter().all(|force| *force == 0.0)
}

impl Persist for CornerForces {
    fn persist(&mut self, archive: &mut StateArchive<'_>) {
        self.values_mut().persist(archive);
    }
}
