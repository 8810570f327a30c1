//! Variables of routines in a checkpoint, and how a run saves and restores them.
//! Never here: the memory of libraries (`native/memory.rs`).

use crate::state::archive::{Archive, Persist, UnfitState, persist_fields};

/// Memory of routines in a checkpoint.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SavedMemory {
    /// Changed cells, if all of them are valid in another process.
    pub(super) memory: Option<Vec<u8>>,
    /// Descriptions of the state that is not saved.
    pub lost: Vec<String>,
}

/// Variables of routines, in this process or another.
pub trait PersistentMemory: Send + Sync {
    /// Notes that a run begins on this thread: files open now do not belong to the routines.
    fn begin(&self);
    /// Notes that the run on this thread is over, and warns of threads that still run.
    fn end(&self);
    /// Saves the memory, on the thread that calls the routines.
    fn keep(&self) -> SavedMemory;
    /// Restores a saved memory; without one nothing changes.
    ///
    /// # Errors
    /// If it is not the memory of these libraries; then nothing is written.
    fn take_up(&self, kept: &SavedMemory) -> Result<(), UnfitState>;
}

#[cfg_attr(not(compiled_routines), allow(dead_code))]
impl SavedMemory {
    /// No memory, with the reason.
    pub fn nothing(why: &str) -> SavedMemory {
        SavedMemory { memory: None, lost: vec![why.to_owned()] }
    }
}

impl Persist for SavedMemory {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let SavedMemory { memory, lost } = self;
        let mut there = memory.is_some();
        persist_fields!(archive; lost, &mut there);
        if there {
            archive.blob(memory.get_or_insert_default());
        } else {
            *memory = None;
        }
    }
}
