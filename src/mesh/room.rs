//! Lists that grow inside increments, where nothing allocates: copies that keep their capacity, and the memory that they take.
//! Never here: what is listed.

use std::iter::Sum;
use std::ops::Add;

/// A copy that has the room of the original, which an ordinary copy loses.
pub fn with_room<T: Clone>(list: &Vec<T>) -> Vec<T> {
    let mut copy = Vec::with_capacity(list.capacity());
    copy.extend_from_slice(list);
    copy
}

/// Bytes of lists. The system assigns no memory to the reserved part before it is written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MemoryUse {
    /// Bytes of entries.
    pub used: usize,
    /// Bytes reserved for entries that are added during the run.
    pub reserved: usize,
}

impl MemoryUse {
    /// Memory of a list.
    pub fn of<T>(list: &Vec<T>) -> MemoryUse {
        MemoryUse { used: size_of::<T>() * list.len(), reserved: size_of::<T>() * (list.capacity() - list.len()) }
    }

    /// Memory without reserve.
    pub fn in_use(bytes: usize) -> MemoryUse {
        MemoryUse { used: bytes, reserved: 0 }
    }
}

impl Add for MemoryUse {
    type Output = MemoryUse;

    fn add(self, other: MemoryUse) -> MemoryUse {
        MemoryUse { used: self.used + other.used, reserved: self.reserved + other.reserved }
    }
}

impl Sum for MemoryUse {
    fn sum<I: Iterator<Item = MemoryUse>>(parts: I) -> MemoryUse {
        parts.fold(MemoryUse::default(), Add::add)
    }
}
