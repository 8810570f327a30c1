//! Lists: sorting without duplicates, and memory use.

use std::iter::Sum;
use std::ops::Add;

pub use revolve_derive::Memory;

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

/// A type with lists on the heap.
///
/// `#[derive(Memory)]` adds the memory that all fields own: lists, boxes, options, arrays, tuples, types with
/// this trait, and `Copy` types, which own none. `#[memory(role: field, field; role: field)]` lists the exceptions:
///
/// - `uncounted`: memory that is shared, counted elsewhere or not counted
/// - `flat`: a list without the memory that its entries own
/// - `inside`: the memory that the entries of a list or the content of a box own, without the list or box itself
///
/// A field of another type does not compile until it is listed:
///
/// ```compile_fail,E0599
/// use revolve_numerics::kernel::lists::Memory;
///
/// struct Mesh(Vec<u32>);
///
/// #[derive(Memory)]
/// struct Probe {
///     values: Vec<f64>,
///     mesh: Mesh, // neither `Copy` nor `Memory`
/// }
/// ```
///
/// ```
/// # use revolve_numerics::kernel::lists::Memory;
/// #[derive(Memory)]
/// struct Mesh(Vec<u32>);
///
/// #[derive(Memory)]
/// struct Probe {
///     values: Vec<f64>,
///     mesh: Mesh,
/// }
/// assert_eq!(Probe { values: vec![1.0; 3], mesh: Mesh(vec![0; 2]) }.bytes(), 3 * 8 + 2 * 4);
/// ```
pub trait Memory {
    /// Returns the memory that the value owns outside itself.
    fn memory(&self) -> MemoryUse;

    /// Returns the bytes that the value has allocated, used or not.
    fn bytes(&self) -> usize {
        let MemoryUse { used, reserved } = self.memory();
        used + reserved
    }
}

impl Memory for String {
    fn memory(&self) -> MemoryUse {
        MemoryUse { used: self.len(), reserved: self.capacity() - self.len() }
    }
}

/// A field of a type that derives [`Memory`]. Method resolution tries [`MemoryOfOwner`] before [`MemoryOfCopy`], which
/// needs one more reference.
#[doc(hidden)]
#[derive(Debug)]
pub struct FieldMemory<'a, T: ?Sized>(pub &'a T);

#[doc(hidden)]
pub trait MemoryOfOwner {
    fn memory_of_field(&self) -> MemoryUse;
}

impl<T: Memory + ?Sized> MemoryOfOwner for FieldMemory<'_, T> {
    fn memory_of_field(&self) -> MemoryUse {
        self.0.memory()
    }
}

#[doc(hidden)]
pub trait MemoryOfCopy {
    fn memory_of_field(&self) -> MemoryUse;
}

impl<T: Copy> MemoryOfCopy for &FieldMemory<'_, T> {
    fn memory_of_field(&self) -> MemoryUse {
        MemoryUse::default()
    }
}
