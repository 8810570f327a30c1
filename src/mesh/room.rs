//! Lists that grow inside increments, where nothing allocates: copies that keep their capacity.
//! Never here: what is listed.

/// A copy that has the room of the original, which an ordinary copy loses.
pub fn with_room<T: Clone>(list: &Vec<T>) -> Vec<T> {
    let mut copy = Vec::with_capacity(list.capacity());
    copy.extend_from_slice(list);
    copy
}
