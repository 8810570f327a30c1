//! State of a session: open files, checked decks, and the messages to send.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use lsp_server::{Message, Notification};
use serde_json::{Value, json};

use super::checks::{CheckRequest, CheckResult, DeckChecker};
use super::documents::{DocumentStore, OpenDocument, may_read, path_key, path_of_document};
use super::publish::{FileDiagnostic, is_foreign, outline_diagnostics};
use super::roots::{RootDeck, find_including_deck};
use crate::outline::DeckOutline;
use crate::protocol::{ChangeParams, DocumentDiagnostic, DocumentParams, InitializationOptions, OpenParams};
use crate::text::{ColumnEncoding, TextBuffer};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SessionPhase {
    /// Before `initialize`.
    Starting,
    /// Requests are answered.
    Running,
    /// After `shutdown`.
    ShutDown,
    /// After `exit`.
    Exited { after_shutdown: bool },
}

/// Checks that take less time are awaited instead of showing the diagnostics of the syntax first.
const SHORT_CHECK: Duration = Duration::from_millis(25);

pub struct ServerState {
    pub phase: SessionPhase,
    pub outbox: Vec<Message>,
    pub documents: DocumentStore,
    pub encoding: ColumnEncoding,
    pub options: InitializationOptions,
    pub client: Value,
    /// Checked decks by path.
    pub roots: BTreeMap<PathBuf, RootDeck>,
    /// Decks on disk that include an open file.
    disk_roots: BTreeSet<PathBuf>,
    /// Diagnostics that the client shows, by URI.
    published: HashMap<String, Vec<DocumentDiagnostic>>,
    checker: Box<DeckChecker>,
    generation: u64,
}

impl ServerState {
    /// Creates the state at the start of a session.
    pub fn new(checker: Box<DeckChecker>) -> ServerState {
        ServerState {
            phase: SessionPhase::Starting,
            outbox: Vec::new(),
            documents: DocumentStore::default(),
            encoding: ColumnEncoding::default(),
            options: InitializationOptions::default(),
            client: Value::Null,
            roots: BTreeMap::new(),
            disk_roots: BTreeSet::new(),
            published: HashMap::new(),
            checker,
            generation: 0,
        }
    }

    /// Adds a notification to the messages to send.
    pub fn notify(&mut self, method: &str, params: Value) {
        self.outbox.push(Notification { method: method.to_owned(), params }.into());
    }

    /// Opens a file.
    pub fn open(&mut self, params: OpenParams) {
        let opened = params.text_document;
        let key = path_of_document(&opened.uri);
        let text = TextBuffer::new(&opened.text);
        let has_step = has_keyword(&text, "*step");
        self.documents.open.insert(key.clone(), OpenDocument { uri: opened.uri, version: opened.version, text });
        self.mark_edited(&key);
        if !has_step && let Some(deck) = find_including_deck(&key).filter(|deck| may_read(deck, &key)) {
            let deck = path_key(&deck);
            self.disk_roots.insert(deck.clone());
            self.roots.entry(deck).or_insert_with(RootDeck::unread);
        }
    }

    /// Applies the changes of a file.
    pub fn change(&mut self, params: ChangeParams) {
        let key = path_of_document(&params.text_document.uri);
        let encoding = self.encoding;
        let Some(document) = self.documents.open.get_mut(&key) else { return };
        document.version = params.text_document.version.unwrap_or(document.version);
        let mut moves = Vec::new();
        for change in params.content_changes {
            let previous_count = i64::from(document.text.line_count());
            let edited = match change.range {
                Some(range) => document.text.replace(range, &change.text, encoding),
                None => {
                    document.text = TextBuffer::new(&change.text);
                    continue;
                }
            };
            moves.push((edited, i64::from(document.text.line_count()) - previous_count));
        }
        for root in self.roots.values_mut() {
            moves.iter().for_each(|(edited, added)| root.move_diagnostics(&key, edited, *added));
        }
        self.mark_edited(&key);
    }

    /// Closes a file.
    pub fn close(&mut self, params: &DocumentParams) {
        let key = path_of_document(&params.text_document.uri);
        self.documents.open.remove(&key);
        self.mark_edited(&key);
    }

    /// Reads all decks again, after files on disk have changed.
    pub fn files_changed(&mut self) {
        self.roots.values_mut().for_each(RootDeck::mark_edited);
    }

    /// Marks all decks with a file as edited.
    fn mark_edited(&mut self, key: &Path) {
        for (path, root) in &mut self.roots {
            if path == key || root.outline.paths().any(|of| path_key(of) == key) {
                root.mark_edited();
            }
        }
    }

    /// Brings the outlines up to date, and decides which decks are checked.
    pub fn update_outlines(&mut self) {
        for path in self.documents.open.keys() {
            self.roots.entry(path.clone()).or_insert_with(RootDeck::unread);
        }
        for (path, root) in self.roots.iter_mut().filter(|(_, root)| root.needs_outline) {
            let documents = &self.documents;
            let included = |file: &Path| documents.text(file);
            root.outline = documents
                .text(path)
                .map_or_else(DeckOutline::default, |text| DeckOutline::read(path, &text, &included));
            root.needs_outline = false;
        }
        let unwanted: Vec<PathBuf> = self.roots.keys().filter(|path| !self.is_root(path)).cloned().collect();
        for path in unwanted {
            self.roots.remove(&path);
            self.checker.withdraw(&path);
        }
        self.disk_roots.retain(|path| self.roots.contains_key(path));
    }

    /// Returns whether a deck is checked by itself: it is open and no other deck includes it, or it includes an open
    /// file.
    fn is_root(&self, path: &Path) -> bool {
        let includes = |deck: &RootDeck, file: &Path| deck.outline.paths().skip(1).any(|of| path_key(of) == file);
        let is_included = self.roots.iter().any(|(other, deck)| {
            // Of two files that include each other, the first one is checked.
            other.as_path() != path
                && includes(deck, path)
                && (other.as_path() < path || !self.roots.get(path).is_some_and(|own| includes(own, other)))
        });
        let is_open = self.documents.open.contains_key(path);
        let deck = self.roots.get(path);
        let of_open_file = || deck.is_some_and(|deck| self.documents.open.keys().any(|file| includes(deck, file)));
        !is_included && (is_open || self.disk_roots.contains(path) && of_open_file())
    }

    /// Brings outlines and diagnostics up to date, requests checks and publishes.
    pub fn update_diagnostics(&mut self) {
        if self.phase != SessionPhase::Running {
            return;
        }
        self.update_outlines();
        let encoding = self.encoding;
        let mut requests = Vec::new();
        for (path, root) in self.roots.iter_mut().filter(|(_, root)| root.needs_check) {
            root.needs_check = false;
            self.generation += 1;
            root.generation = self.generation;
            requests.push(path.clone());
            if root.duration.is_none_or(|duration| duration > SHORT_CHECK) {
                let mut merged = outline_diagnostics(&root.outline, encoding);
                merged.extend(root.diagnostics.drain(..).filter(|d| !d.is_of_syntax()));
                root.diagnostics = merged;
            }
        }
        if !requests.is_empty() {
            self.request_checks(&requests);
        }
        self.publish();
    }

    fn request_checks(&self, roots: &[PathBuf]) {
        let open = self.documents.open.iter().map(|(path, document)| (path.clone(), document.text.clone()));
        let open: Arc<HashMap<PathBuf, TextBuffer>> = Arc::new(open.collect());
        for path in roots {
            let (Some(text), Some(root)) = (self.documents.text(path), self.roots.get(path)) else { continue };
            self.checker.submit(CheckRequest {
                root: path.clone(),
                generation: root.generation,
                text,
                open: Arc::clone(&open),
                encoding: self.encoding,
            });
        }
    }

    /// Takes the result of a check, unless the deck has been edited meanwhile.
    pub fn take_result(&mut self, result: CheckResult) {
        let Some(root) = self.roots.get_mut(&result.root) else { return };
        root.duration = Some(result.duration);
        if root.generation != result.generation || root.needs_check {
            return;
        }
        root.diagnostics = result.diagnostics;
        root.facts = result.facts.or(root.facts.take());
    }

    /// Sends the diagnostics of all files whose diagnostics have changed.
    fn publish(&mut self) {
        let mut by_uri: HashMap<String, Vec<DocumentDiagnostic>> = HashMap::new();
        for document in self.documents.open.values() {
            by_uri.entry(document.uri.clone()).or_default();
        }
        let uris = RefCell::new(HashMap::new());
        let uri = |path: &Path| -> String {
            let mut uris = uris.borrow_mut();
            uris.entry(path.to_owned()).or_insert_with(|| self.documents.uri(path)).clone()
        };
        for root in self.roots.values() {
            let is_foreign = is_foreign(self.options.mode, &root.diagnostics);
            for diagnostic in &root.diagnostics {
                let document_diagnostic = diagnostic.document(diagnostic.level(self.options.mode, is_foreign), &uri);
                let list = by_uri.entry(uri(&diagnostic.path)).or_default();
                if !list.contains(&document_diagnostic) {
                    list.push(document_diagnostic);
                }
            }
        }
        let gone: Vec<String> = self.published.keys().filter(|uri| !by_uri.contains_key(*uri)).cloned().collect();
        for uri in gone {
            self.published.remove(&uri);
            self.notify("textDocument/publishDiagnostics", json!({ "uri": uri, "diagnostics": [] }));
        }
        let mut sorted: Vec<_> = by_uri.into_iter().collect();
        sorted.sort_by(|a, b| a.0.cmp(&b.0));
        for (uri, diagnostics) in sorted {
            if self.published.get(&uri) != Some(&diagnostics) {
                let version = self.documents.open.values().find(|d| d.uri == uri).map(|d| d.version);
                let mut params = json!({ "uri": uri, "diagnostics": diagnostics });
                if let (Some(version), Some(object)) = (version, params.as_object_mut()) {
                    object.insert("version".into(), version.into());
                }
                self.published.insert(uri, diagnostics);
                self.notify("textDocument/publishDiagnostics", params);
            }
        }
    }

    /// Returns the deck to which a file belongs, and its path.
    pub fn root_of(&self, key: &Path) -> Option<(&PathBuf, &RootDeck)> {
        let exact = self.roots.get_key_value(key);
        exact.or_else(|| self.roots.iter().find(|(_, root)| root.outline.paths().any(|of| path_key(of) == key)))
    }

    /// Returns the diagnostics of a file that are shown now.
    pub fn diagnostics_of(&self, key: &Path) -> impl Iterator<Item = (&FileDiagnostic, bool)> {
        self.roots.values().flat_map(move |root| {
            let is_foreign = is_foreign(self.options.mode, &root.diagnostics);
            root.diagnostics.iter().filter(move |d| path_key(&d.path) == key).map(move |d| (d, is_foreign))
        })
    }
}

/// Returns whether a text has a keyword line that begins with a lower-case text.
fn has_keyword(text: &TextBuffer, begin: &str) -> bool {
    let is_wanted =
        |line: &str| line.trim_start().get(..begin.len()).is_some_and(|head| head.eq_ignore_ascii_case(begin));
    text.blocks().any(|(_, block)| block.keywords().iter().any(|line| is_wanted(block.line(*line as usize))))
}
