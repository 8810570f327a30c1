//! Forces of elements on their corners, block by block, in the precision of what makes them.
//! Never here: which node a corner belongs to.

use std::ops::Range;

use crate::kernel::lanes::{Corners, InlineMap};
use crate::kernel::lists::heap_bytes;
use crate::kernel::real::Real;
use crate::state::archive::{Archive, Persist};

/// Corner forces of all elements of a scene.
#[derive(Clone, Debug)]
pub enum CornerForces {
    /// In double precision.
    Double(Vec<Corners>),
    /// In single precision: of a scene whose elements all are.
    Single(Vec<Corners<f32>>),
}

/// Those of some blocks, to be written.
pub enum Slots<'a> {
    /// In double precision.
    Double(&'a mut [Corners]),
    /// In single precision.
    Single(&'a mut [Corners<f32>]),
}

impl Default for CornerForces {
    fn default() -> Self {
        CornerForces::Double(Vec::new())
    }
}

impl CornerForces {
    /// Zeros for so many blocks.
    pub fn new(blocks: usize, single: bool) -> Self {
        if single {
            CornerForces::Single(vec![Corners::default(); blocks])
        } else {
            CornerForces::Double(vec![Corners::default(); blocks])
        }
    }

    /// Those of some blocks.
    pub fn slots(&mut self, blocks: Range<usize>) -> Slots<'_> {
        match self {
            CornerForces::Double(list) => Slots::Double(&mut list[blocks]),
            CornerForces::Single(list) => Slots::Single(&mut list[blocks]),
        }
    }

    /// The force on a corner of an element of a block.
    pub fn of(&self, block: usize, lane: usize, corner: usize) -> [f64; 2] {
        match self {
            CornerForces::Double(list) => list[block].0[corner][lane],
            CornerForces::Single(list) => list[block].0[corner][lane].inline_map(Real::wide),
        }
    }

    /// Sets the forces of an element of a block to zero.
    pub fn clear(&mut self, block: usize, lane: usize) {
        match self {
            CornerForces::Double(list) => list[block].clear(lane),
            CornerForces::Single(list) => list[block].clear(lane),
        }
    }

    /// Bytes of them.
    pub fn bytes(&self) -> usize {
        match self {
            CornerForces::Double(list) => heap_bytes(list),
            CornerForces::Single(list) => heap_bytes(list),
        }
    }
}

impl Slots<'_> {
    /// Those in double precision, of a group that has no other.
    pub fn double(&mut self) -> &mut [Corners] {
        match self {
            Slots::Double(list) => list,
            Slots::Single(_) => unreachable!("corner forces are single where all groups are"),
        }
    }
}

impl Persist for CornerForces {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        match self {
            CornerForces::Double(list) => list.as_mut_slice().persist(archive),
            CornerForces::Single(list) => list.as_mut_slice().persist(archive),
        }
    }
}
