//! Forces of elements on their corner nodes, stored by blocks of elements.

use std::ops::Range;

use crate::kernel::lanes::{BlockCornerForces, InlineMap};
use crate::kernel::lists::heap_bytes;
use crate::kernel::real::Real;
use crate::state::archive::{Persist, StateArchive};

/// Corner forces of all elements.
#[derive(Clone, Debug)]
pub enum CornerForces {
    /// In double precision.
    Double(Vec<BlockCornerForces>),
    /// In single precision, if all elements use single precision.
    Single(Vec<BlockCornerForces<f32>>),
}

/// Mutable corner forces of a range of blocks.
pub enum CornerForceSlots<'a> {
    /// In double precision.
    Double(&'a mut [BlockCornerForces]),
    /// In single precision.
    Single(&'a mut [BlockCornerForces<f32>]),
}

impl Default for CornerForces {
    fn default() -> Self {
        CornerForces::Double(Vec::new())
    }
}

impl CornerForces {
    /// Creates zero forces for a number of blocks.
    pub fn new(blocks: usize, single: bool) -> Self {
        if single {
            CornerForces::Single(vec![BlockCornerForces::default(); blocks])
        } else {
            CornerForces::Double(vec![BlockCornerForces::default(); blocks])
        }
    }

    /// Returns the corner forces of a range of blocks.
    pub fn slots(&mut self, blocks: Range<usize>) -> CornerForceSlots<'_> {
        match self {
            CornerForces::Double(list) => CornerForceSlots::Double(&mut list[blocks]),
            CornerForces::Single(list) => CornerForceSlots::Single(&mut list[blocks]),
        }
    }

    /// Returns the force `[r, z]` on a corner of an element.
    pub fn of(&self, block: usize, lane: usize, corner: usize) -> [f64; 2] {
        match self {
            CornerForces::Double(list) => list[block].0[corner][lane],
            CornerForces::Single(list) => list[block].0[corner][lane].inline_map(Real::wide),
        }
    }

    /// Sets the corner forces of an element to zero.
    pub fn clear(&mut self, block: usize, lane: usize) {
        match self {
            CornerForces::Double(list) => list[block].clear(lane),
            CornerForces::Single(list) => list[block].clear(lane),
        }
    }

    /// Returns the heap memory in bytes.
    pub fn bytes(&self) -> usize {
        match self {
            CornerForces::Double(list) => heap_bytes(list),
            CornerForces::Single(list) => heap_bytes(list),
        }
    }
}

impl CornerForceSlots<'_> {
    /// Returns the double-precision forces of an element group.
    pub fn double(&mut self) -> &mut [BlockCornerForces] {
        match self {
            CornerForceSlots::Double(list) => list,
            CornerForceSlots::Single(_) => unreachable!("corner forces are single where all groups are"),
        }
    }
}

impl Persist for CornerForces {
    fn persist(&mut self, archive: &mut StateArchive<'_>) {
        match self {
            CornerForces::Double(list) => list.as_mut_slice().persist(archive),
            CornerForces::Single(list) => list.as_mut_slice().persist(archive),
        }
    }
}
