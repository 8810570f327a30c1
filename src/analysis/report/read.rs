//! Reading of result files; errors have the path of the file.

use std::fmt::Display;
use std::path::Path;

use serde_json::Value;

use crate::deck::files;
use crate::output::sums::Checksums;

/// Adds the path of a file to an error.
pub(super) fn in_file<T>(path: &Path, result: Result<T, impl Display>) -> Result<T, String> {
    result.map_err(|e| format!("{}: {e}", path.display()))
}

pub(super) fn text(path: &Path) -> Result<String, String> {
    in_file(path, files::read_text(path))
}

/// Reads a file whose checksum, if it is listed, is right.
pub(super) fn verified_text(path: &Path, sums: &Checksums) -> Result<String, String> {
    sums.verify(path)?;
    text(path)
}

pub(super) fn json(path: &Path) -> Result<Value, String> {
    in_file(path, serde_json::from_str(&text(path)?))
}

pub(super) fn verified_json(path: &Path, sums: &Checksums) -> Result<Value, String> {
    sums.verify(path)?;
    json(path)
}
