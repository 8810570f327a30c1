//! Lists: members in order without repetition, and the memory that they occupy.
//! Never here: what they list.

/// Members in ascending order, each once.
pub fn sorted_unique<T: Ord>(members: impl IntoIterator<Item = T>) -> Vec<T> {
    let mut sorted: Vec<T> = members.into_iter().collect();
    sorted.sort_unstable();
    sorted.dedup();
    sorted
}

/// Bytes of the allocation of a list.
pub fn heap_bytes<T>(list: &Vec<T>) -> usize {
    size_of::<T>() * list.capacity()
}
