//! Latest state of a run as named JSON texts, for the event streams of all pages.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::Duration;

/// Part of the state: name of its event, and JSON text.
pub type StatePart = (&'static str, Arc<str>);

#[derive(Default)]
struct StateParts {
    revision: u64,
    /// Each part with the revision of its last change.
    parts: Vec<(u64, StatePart)>,
}

/// State of a run. Threads that wait are woken at each change.
#[derive(Default)]
pub struct StateBoard {
    state: Mutex<StateParts>,
    changed: Condvar,
    /// Number of event streams now, and since the start.
    readers: AtomicUsize,
    all_readers: AtomicUsize,
}

impl StateBoard {
    /// Replaces a part; nothing happens if its text is unchanged.
    pub fn post(&self, name: &'static str, json: String) {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let position = state.parts.iter().position(|part| part.1.0 == name);
        if position.is_some_and(|i| *state.parts[i].1.1 == *json) {
            return;
        }
        state.revision += 1;
        let part = (state.revision, (name, json.into()));
        match position {
            Some(i) => state.parts[i] = part,
            None => state.parts.push(part),
        }
        self.changed.notify_all();
    }

    /// Waits for changes after a revision; returns the last revision and the parts that have changed, none if the time
    /// ends.
    pub fn changes_after(&self, seen: u64, patience: Duration) -> (u64, Vec<StatePart>) {
        let state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let waited = self.changed.wait_timeout_while(state, patience, |state| state.revision <= seen);
        let (state, _) = waited.unwrap_or_else(PoisonError::into_inner);
        let changed = state.parts.iter().filter(|part| part.0 > seen);
        (state.revision, changed.map(|part| part.1.clone()).collect())
    }

    /// Counts an event stream until the returned guard is dropped; `None` if there are `most` already.
    pub fn join(self: &Arc<Self>, most: usize) -> Option<ReaderGuard> {
        let has_room = self.readers.fetch_add(1, Ordering::SeqCst) < most;
        let guard = ReaderGuard(self.clone());
        has_room.then(|| {
            self.all_readers.fetch_add(1, Ordering::SeqCst);
            guard
        })
    }

    /// Returns the number of event streams now, and since the start.
    pub fn readers(&self) -> [usize; 2] {
        [&self.readers, &self.all_readers].map(|count| count.load(Ordering::SeqCst))
    }
}

/// An event stream that is counted.
pub struct ReaderGuard(Arc<StateBoard>);

impl Drop for ReaderGuard {
    fn drop(&mut self) {
        self.0.readers.fetch_sub(1, Ordering::SeqCst);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn readers_receive_what_changed_since_their_last_look() {
        let board = Arc::new(StateBoard::default());
        board.post("a", "1".into());
        board.post("b", "2".into());
        let (seen, parts) = board.changes_after(0, Duration::ZERO);
        assert_eq!(parts, [("a", "1".into()), ("b", "2".into())]);
        board.post("a", "1".into());
        assert_eq!(board.changes_after(seen, Duration::ZERO), (seen, Vec::new()), "nothing has changed");
        let other = board.clone();
        let waiting = std::thread::spawn(move || other.changes_after(seen, Duration::from_secs(600)).1);
        board.post("b", "3".into());
        assert_eq!(waiting.join().expect("woken"), [("b", "3".into())]);
        let guard = board.join(1).expect("a stream");
        assert!(board.join(1).is_none());
        assert_eq!(board.readers(), [1, 1]);
        drop(guard);
        assert_eq!(board.readers(), [0, 1]);
    }
}
