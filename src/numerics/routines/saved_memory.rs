//! State of user subroutines in a checkpoint: their variables and the action they requested, and the trait by which a run saves and restores them.

use crate::state::archive::{Persist, StateArchive, UnfitState, persist_fields};

/// Variables of user subroutines in a checkpoint.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SavedMemory {
    /// Changed memory, if its content is valid in another process.
    pub memory: Option<Vec<u8>>,
    /// Descriptions of the state that is not saved.
    pub lost: Vec<String>,
}

/// Variables of user subroutines, in this process or another.
pub trait PersistentMemory: Send + Sync {
    /// Records that a run begins on this thread: files that are already open do not belong to user subroutines.
    fn begin(&self);
    /// Records that the run on this thread has ended, and warns about threads that still run.
    fn end(&self);
    /// Saves the memory, on the thread that calls the user subroutines.
    fn save(&self) -> SavedMemory;
    /// Restores a saved memory, if there is one.
    ///
    /// # Errors
    /// If it belongs to other libraries; nothing is written then.
    fn restore(&self, kept: &SavedMemory) -> Result<(), UnfitState>;
    /// Ends a separate process of the subroutines after the last run, and waits until it has closed their files.
    fn close(&self) {}
}

impl SavedMemory {
    /// Returns an empty memory with the reason why nothing is saved.
    pub fn not_saved(why: &str) -> SavedMemory {
        SavedMemory { memory: None, lost: vec![why.to_owned()] }
    }
}

impl Persist for SavedMemory {
    fn persist(&mut self, archive: &mut StateArchive<'_>) {
        let SavedMemory { memory, lost } = self;
        let mut is_saved = memory.is_some();
        persist_fields!(archive; lost, &mut is_saved);
        if is_saved {
            archive.blob(memory.get_or_insert_default());
        } else {
            *memory = None;
        }
    }
}
