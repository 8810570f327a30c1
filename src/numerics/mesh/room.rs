//! Clones of lists that keep their capacity, because lists that grow during increments must not allocate.

/// Clones a list with its capacity, which `Vec::clone` does not preserve.
pub fn clone_with_capacity<T: Clone>(list: &Vec<T>) -> Vec<T> {
    let mut copy = Vec::with_capacity(list.capacity());
    copy.extend_from_slice(list);
    copy
}
