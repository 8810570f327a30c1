//! Structures of requests and answers. Only the members that the server reads or writes.

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::text::{TextPosition, TextRange};

/// Arguments of `initialize`.
#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct InitializeParams {
    /// What the client can do.
    pub capabilities: Value,
    /// Options of this server.
    pub initialization_options: Option<InitializationOptions>,
}

/// Options of this server, given by the client at the start.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(default)]
pub struct InitializationOptions {
    /// How decks that Revolve cannot run are shown.
    pub mode: ServerMode,
}

/// How unsupported input is shown.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub enum ServerMode {
    /// As errors in decks for Revolve, as information in decks for other analyses of ABAQUS.
    #[default]
    Auto,
    /// As errors, as `revolve check` does.
    Revolve,
    /// As information.
    Abaqus,
}

/// A file by its URI.
#[derive(Clone, Debug, Deserialize)]
pub struct DocumentIdentifier {
    pub uri: String,
    /// Version of the text; it increases with each change.
    pub version: Option<i64>,
}

/// A file that a client has opened.
#[derive(Debug, Deserialize)]
pub struct OpenedDocument {
    pub uri: String,
    pub version: i64,
    pub text: String,
}

/// Arguments of `textDocument/didOpen`.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct OpenParams {
    pub text_document: OpenedDocument,
}

/// Arguments of `textDocument/didChange`.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct ChangeParams {
    pub text_document: DocumentIdentifier,
    /// Changes, in the order in which they are applied.
    pub content_changes: Vec<ContentChange>,
}

/// A change of a text.
#[derive(Debug, Deserialize)]
pub struct ContentChange {
    /// Replaced range; `None` for the whole text.
    pub range: Option<TextRange>,
    pub text: String,
}

/// Arguments of requests and notifications about a file, with those of single requests.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct DocumentParams {
    pub text_document: DocumentIdentifier,
    #[serde(default)]
    pub position: TextPosition,
    #[serde(default)]
    pub range: Option<TextRange>,
    #[serde(default)]
    pub new_name: String,
    #[serde(default)]
    pub context: ReferenceContext,
}

/// Context of a request for references.
#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct ReferenceContext {
    /// Whether definitions are included.
    pub include_declaration: bool,
}

#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct FileLocation {
    pub uri: String,
    pub range: TextRange,
}

#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct RelatedPlace {
    pub location: FileLocation,
    pub message: String,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum DiagnosticLevel {
    /// The deck is invalid.
    Error = 1,
    /// Probably a mistake.
    Warning = 2,
    /// Something to know.
    Information = 3,
    /// Something that an editor shows unobtrusively.
    Hint = 4,
}

impl Serialize for DiagnosticLevel {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_u8(*self as u8)
    }
}

/// A diagnostic of a file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct DocumentDiagnostic {
    pub range: TextRange,
    pub severity: DiagnosticLevel,
    /// Code, explained by `revolve explain CODE`; empty if the check itself failed.
    #[serde(skip_serializing_if = "str::is_empty")]
    pub code: &'static str,
    /// Name of the program.
    pub source: &'static str,
    /// The problem, its reason, and its correction.
    pub message: String,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub related_information: Vec<RelatedPlace>,
}

#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct TextEdit {
    pub range: TextRange,
    pub new_text: String,
}
