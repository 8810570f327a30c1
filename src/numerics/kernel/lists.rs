//! Lists: sorting without duplicates, and memory use.

use std::iter::Sum;
use std::ops::Add;

/// Returns the members in ascending order without duplicates.
pub fn sorted_unique<T: Ord>(members: impl IntoIterator<Item = T>) -> Vec<T> {
    let mut sorted: Vec<T> = members.into_iter().collect();
    sorted.sort_unstable();
    sorted.dedup();
    sorted
}

/// Returns two members in ascending order, for example as the key of an edge between two nodes.
pub fn sorted_pair<T: Ord>([a, b]: [T; 2]) -> [T; 2] {
    if b < a { [b, a] } else { [a, b] }
}

/// Returns the number of bytes that a list has allocated, used or not.
pub fn heap_bytes<T>(list: &Vec<T>) -> usize {
    size_of::<T>() * list.capacity()
}

/// Memory of lists. The operating system assigns no memory to the reserved part before it is written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MemoryUse {
    /// Bytes of entries.
    pub used: usize,
    /// Bytes reserved for entries that are added during the run.
    pub reserved: usize,
}

impl MemoryUse {
    /// Returns the bytes in use and in reserve of a list.
    pub fn of<T>(list: &Vec<T>) -> MemoryUse {
        MemoryUse { used: size_of::<T>() * list.len(), reserved: size_of::<T>() * (list.capacity() - list.len()) }
    }

    /// Returns memory in use without reserve.
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
