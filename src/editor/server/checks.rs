//! The full check of decks on its own thread: the newest text of each deck is checked, and a check whose text has been
//! edited is given up between its phases.

use std::collections::HashMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use super::documents::path_key;
use super::publish::{FileDiagnostic, file_diagnostics};
use crate::deck;
use crate::features::DeckFacts;
use crate::job::{PreparedJob, ValidatedDeck};
use crate::text::{ColumnEncoding, TextBuffer};
use crate::user::Routines;

/// Longest time that a check waits for further edits.
const LONGEST_WAIT: Duration = Duration::from_millis(600);
/// Checks that take less time begin without waiting.
const QUICK: Duration = Duration::from_millis(40);

/// A deck with the texts of all open files.
pub struct CheckRequest {
    pub root: PathBuf,
    /// Number of the request; later requests have larger numbers.
    pub generation: u64,
    pub text: TextBuffer,
    /// Texts of all open files by [`path_key`].
    pub open: Arc<HashMap<PathBuf, TextBuffer>>,
    pub encoding: ColumnEncoding,
}

pub struct CheckResult {
    pub root: PathBuf,
    pub generation: u64,
    /// All diagnostics of `revolve check`.
    pub diagnostics: Vec<FileDiagnostic>,
    /// Properties of the model; `None` if the deck has errors.
    pub facts: Option<DeckFacts>,
    /// Wall-clock time of the check.
    pub duration: Duration,
}

/// Requests that wait, and times of earlier checks.
#[derive(Default)]
struct CheckQueue {
    waiting: Vec<(Instant, CheckRequest)>,
    durations: HashMap<PathBuf, Duration>,
    /// Newest generation of each deck.
    newest: HashMap<PathBuf, u64>,
    is_closed: bool,
}

/// Handle of the checking thread, which ends when the handle is dropped.
pub struct DeckChecker {
    shared: Arc<(Mutex<CheckQueue>, Condvar)>,
}

impl DeckChecker {
    /// Starts the thread. `deliver` receives each result, and returns whether further results are wanted.
    pub fn start(deliver: impl Fn(CheckResult) -> bool + Send + 'static) -> DeckChecker {
        let shared = Arc::new((Mutex::default(), Condvar::new()));
        let checker = DeckChecker { shared: Arc::clone(&shared) };
        std::thread::spawn(move || {
            let thread = DeckChecker { shared };
            while let Some(request) = thread.next_request() {
                if let Some(result) = thread.check(request)
                    && !deliver(result)
                {
                    break;
                }
            }
        });
        checker
    }

    /// Adds a request, which replaces an earlier one for the same deck.
    pub fn submit(&self, request: CheckRequest) {
        let mut queue = self.queue();
        let last = queue.durations.get(&request.root).copied().unwrap_or_default();
        let wait = if last < QUICK { Duration::ZERO } else { last.min(LONGEST_WAIT) };
        queue.newest.insert(request.root.clone(), request.generation);
        queue.waiting.retain(|(_, other)| other.root != request.root);
        queue.waiting.push((Instant::now() + wait, request));
        self.shared.1.notify_all();
    }

    /// Withdraws the requests of a deck.
    pub fn withdraw(&self, root: &Path) {
        let mut queue = self.queue();
        queue.waiting.retain(|(_, other)| other.root != root);
        queue.newest.remove(root);
    }

    fn queue(&self) -> MutexGuard<'_, CheckQueue> {
        self.shared.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for the request that is due first; `None` when the server ends.
    fn next_request(&self) -> Option<CheckRequest> {
        let mut queue = self.queue();
        loop {
            if queue.is_closed {
                return None;
            }
            let first =
                queue.waiting.iter().enumerate().min_by_key(|(_, (due, _))| *due).map(|(i, (due, _))| (i, *due));
            let now = Instant::now();
            queue = match first {
                Some((index, due)) if due <= now => return Some(queue.waiting.swap_remove(index).1),
                Some((_, due)) => {
                    let waited = self.shared.1.wait_timeout(queue, due - now);
                    waited.unwrap_or_else(PoisonError::into_inner).0
                }
                None => self.shared.1.wait(queue).unwrap_or_else(PoisonError::into_inner),
            };
        }
    }

    fn is_superseded(&self, request: &CheckRequest) -> bool {
        let queue = self.queue();
        queue.is_closed || queue.newest.get(&request.root) != Some(&request.generation)
    }

    /// Checks a deck; `None` if it has been edited meanwhile.
    fn check(&self, request: CheckRequest) -> Option<CheckResult> {
        let start = Instant::now();
        let checked = catch_unwind(AssertUnwindSafe(|| self.check_unguarded(&request)));
        let duration = start.elapsed();
        self.queue().durations.insert(request.root.clone(), duration);
        let (diagnostics, facts) = match checked {
            Ok(found) => found?,
            Err(_) => (vec![FileDiagnostic::internal_error(&request.root)], None),
        };
        let CheckRequest { root, generation, .. } = request;
        Some(CheckResult { root, generation, diagnostics, facts, duration })
    }

    fn check_unguarded(&self, request: &CheckRequest) -> Option<(Vec<FileDiagnostic>, Option<DeckFacts>)> {
        let open = |path: &Path| request.open.get(&path_key(path)).map(TextBuffer::text);
        let text_of = |path: &Path| if path == request.root { Some(request.text.text()) } else { open(path) };
        let read = deck::read_open(&request.root, request.text.text(), &open);
        if self.is_superseded(request) {
            return None;
        }
        let mut validated = ValidatedDeck::new(read);
        if self.is_superseded(request) {
            return None;
        }
        // The plan of a large mesh takes most of the memory. Open files have their texts already.
        let is_open = |path: &Path| path == request.root || request.open.contains_key(&path_key(path));
        validated.release_texts(is_open);
        let (prepared, model) = validated.plan(&Routines::none());
        let accepted = !prepared.diagnostics.has_errors();
        let facts = accepted.then(|| DeckFacts::of(&model, &prepared));
        let PreparedJob { mut deck, diagnostics, plan, state, .. } = prepared;
        drop((plan, state, model));
        if self.is_superseded(request) {
            return None;
        }
        Arc::make_mut(&mut deck.sources).restore_texts(&text_of);
        Some((file_diagnostics(&deck, &diagnostics, request.encoding), facts))
    }
}

impl Drop for DeckChecker {
    fn drop(&mut self) {
        self.queue().is_closed = true;
        self.shared.1.notify_all();
    }
}
