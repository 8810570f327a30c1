//! Open files, and texts of other files that decks include.

use std::cell::RefCell;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use crate::deck::{files, source, untrusted};
use crate::protocol::{path_of_uri, uri_of_path};
use crate::text::TextBuffer;

pub struct OpenDocument {
    /// URI that the client uses.
    pub uri: String,
    pub version: i64,
    pub text: TextBuffer,
}

/// Open files by [`path_key`], and texts of files on disk.
#[derive(Default)]
pub struct DocumentStore {
    pub open: HashMap<PathBuf, OpenDocument>,
    disk: RefCell<HashMap<PathBuf, DiskText>>,
}

/// Text of a file on disk, valid as long as the file has this time and length.
struct DiskText {
    changed: Option<SystemTime>,
    length: u64,
    text: TextBuffer,
}

/// Largest file that is read from disk for the outline, bytes.
const LARGEST: u64 = 2 << 30;

impl DocumentStore {
    /// Returns the text of a file, open or on disk; `None` if it cannot be read.
    pub fn text(&self, path: &Path) -> Option<TextBuffer> {
        let key = path_key(path);
        match self.open.get(&key) {
            Some(document) => Some(document.text.clone()),
            None => self.disk_text(key),
        }
    }

    fn disk_text(&self, key: PathBuf) -> Option<TextBuffer> {
        let metadata = std::fs::metadata(&key).ok().filter(|m| m.is_file() && m.len() <= LARGEST)?;
        let (changed, length) = (metadata.modified().ok(), metadata.len());
        let mut disk = self.disk.borrow_mut();
        if let Some(known) = disk.get(&key).filter(|known| known.changed == changed && known.length == length) {
            return Some(known.text.clone());
        }
        let text = TextBuffer::new(&source::decode(files::read(&key).ok()?));
        disk.insert(key, DiskText { changed, length, text: text.clone() });
        Some(text)
    }

    /// Returns the URI of a file: that of the client if the file is open.
    pub fn uri(&self, path: &Path) -> String {
        let key = path_key(path);
        self.open.get(&key).map_or_else(|| uri_of_path(&key), |document| document.uri.clone())
    }
}

/// Returns the path of the file of a URI. A text that is not saved has its URI as path.
pub fn path_of_document(uri: &str) -> PathBuf {
    path_of_uri(uri).map_or_else(|| PathBuf::from(uri), |path| path_key(&path))
}

/// Returns the path by which a file is known: without symbolic links, if the file exists.
pub fn path_key(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_owned())
}

/// Returns whether a file may be read for a deck.
pub fn may_read(root: &Path, path: &Path) -> bool {
    !untrusted::forbids(root.parent().unwrap_or(Path::new("")), path)
}
