//! Lists of the entries that an increment has written, so that the next one resets these alone.

use super::active_pairs::ActivePairs;
use super::sweeps::reserve_total;
use crate::kernel::lists::Memory;

/// Entries of an array that differ from their initial value.
#[derive(Clone, Debug, Default, Memory)]
pub(super) struct WrittenEntries {
    list: Vec<u32>,
    /// Whether all written entries are in the list.
    is_complete: bool,
}

impl WrittenEntries {
    /// Allocates for this number of entries. Copies of the list have no reserve.
    pub(super) fn reserve(&mut self, entries: usize) {
        reserve_total(&mut self.list, entries);
    }

    /// Notes that entries outside the list may have been written.
    pub(super) fn forget(&mut self) {
        self.is_complete = false;
    }

    /// Notes that an entry is written.
    #[inline]
    pub(super) fn add(&mut self, entry: u32) {
        if self.list.len() < self.list.capacity() {
            self.list.push(entry);
        } else {
            self.is_complete = false;
        }
    }

    /// Resets the written entries of an array.
    pub(super) fn reset<T: Copy>(&mut self, values: &mut [T], value: T) {
        self.reset_with(values, value, |values| values.fill(value));
    }

    /// Resets the written entries of an array over keys; only keys of active pairs are written.
    pub(super) fn reset_keys<T: Copy>(&mut self, values: &mut [T], value: T, active: &ActivePairs) {
        self.reset_with(values, value, |values| active.fill(values, value));
    }

    fn reset_with<T: Copy>(&mut self, values: &mut [T], value: T, reset_all: impl FnOnce(&mut [T])) {
        if std::mem::replace(&mut self.is_complete, true) {
            self.list.iter().for_each(|entry| values[*entry as usize] = value);
        } else {
            reset_all(values);
        }
        self.list.clear();
    }
}
