//! Answers to requests about files.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use lsp_server::ErrorCode;
use serde_json::{Value, json};

use super::documents::{path_key, path_of_document};
use super::publish::FileDiagnostic;
use super::requests::{RequestResult, error, parameters};
use super::state::ServerState;
use crate::features::letter_case::correction_as_in_line;
use crate::features::navigation::{NamePlace, invalid_name, places_of_name, renamed_word};
use crate::features::{DeckView, FeatureContext, completion, folding, format, hints, hover, symbols, tokens};
use crate::protocol::{DocumentParams, FileLocation, TextEdit};
use crate::text::{TextPosition, TextRange};

impl ServerState {
    /// Answers a request about a file.
    pub fn answer_about_document(&self, method: &str, params: Value) -> RequestResult {
        let name = method.strip_prefix("textDocument/").unwrap_or_default();
        let answer: fn(&DocumentQuestion<'_>) -> RequestResult = match name {
            "hover" => hover_answer,
            "completion" => completion_answer,
            "definition" => definition_answer,
            "references" => references_answer,
            "documentHighlight" => highlight_answer,
            "prepareRename" => prepare_rename_answer,
            "rename" => rename_answer,
            "documentSymbol" => |question| Ok(symbols::document_symbols(&question.context).into()),
            "foldingRange" => |question| Ok(folding::folding_ranges(question.context.text).into()),
            "semanticTokens/full" | "semanticTokens/range" => tokens_answer,
            "documentLink" => links_answer,
            "codeAction" => code_action_answer,
            "inlayHint" => hints_answer,
            "formatting" | "rangeFormatting" => formatting_answer,
            _ => return Err(error(ErrorCode::MethodNotFound, format!("`{method}` is not supported"))),
        };
        let params: DocumentParams = parameters(params)?;
        let key = path_of_document(&params.text_document.uri);
        let (Some(document), Some((_, root))) = (self.documents.open.get(&key), self.root_of(&key)) else {
            return Err(error(ErrorCode::InvalidParams, "the file is not open"));
        };
        let context = FeatureContext {
            text: &document.text,
            file: root.outline.paths().position(|of| path_key(of) == key).unwrap_or(0) as u32,
            root: DeckView { outline: &root.outline, facts: root.facts.as_ref() },
            encoding: self.encoding,
        };
        answer(&DocumentQuestion { state: self, context, params, key })
    }

    fn location(&self, place: &NamePlace) -> FileLocation {
        FileLocation { uri: self.documents.uri(&place.path), range: place.range }
    }
}

struct DocumentQuestion<'a> {
    state: &'a ServerState,
    context: FeatureContext<'a>,
    params: DocumentParams,
    key: PathBuf,
}

impl DocumentQuestion<'_> {
    fn lines(&self) -> (u32, u32) {
        let count = self.context.text.line_count();
        self.params.range.map_or((0, count), |range| (range.start.line.min(count), (range.end.line + 1).min(count)))
    }
}

fn hover_answer(question: &DocumentQuestion<'_>) -> RequestResult {
    let documentation = hover::hover(&question.context, question.params.position);
    Ok(documentation.map_or(
        Value::Null,
        |(text, range)| json!({ "contents": { "kind": "markdown", "value": text }, "range": range }),
    ))
}

fn completion_answer(question: &DocumentQuestion<'_>) -> RequestResult {
    let defaults = question.state.client.pointer("/textDocument/completion/completionList/itemDefaults");
    let has_range =
        defaults.and_then(Value::as_array).is_some_and(|names| names.iter().any(|name| name == "editRange"));
    Ok(completion::completion_list(&question.context, question.params.position, has_range))
}

fn places(question: &DocumentQuestion<'_>) -> Vec<NamePlace> {
    places_of_name(&question.context, question.params.position)
}

fn definition_answer(question: &DocumentQuestion<'_>) -> RequestResult {
    let name_places = places(question);
    let names = name_places.iter().filter(|place| place.defines).map(|place| question.state.location(place));
    let files = question.context.included_files().filter(|(_, range)| range.touches(question.params.position));
    let files =
        files.map(|(path, _)| FileLocation { uri: question.state.documents.uri(path), range: TextRange::default() });
    Ok(json!(names.chain(files).collect::<Vec<_>>()))
}

fn references_answer(question: &DocumentQuestion<'_>) -> RequestResult {
    let with_definitions = question.params.context.include_declaration;
    let name_places = places(question);
    let selected = name_places.iter().filter(|place| with_definitions || !place.defines);
    Ok(json!(selected.map(|place| question.state.location(place)).collect::<Vec<_>>()))
}

fn highlight_answer(question: &DocumentQuestion<'_>) -> RequestResult {
    let name_places = places(question);
    let in_this_file = name_places.iter().filter(|place| path_key(&place.path) == question.key);
    let kind = |place: &NamePlace| if place.defines { 3 } else { 2 };
    Ok(in_this_file.map(|place| json!({ "range": place.range, "kind": kind(place) })).collect())
}

fn prepare_rename_answer(question: &DocumentQuestion<'_>) -> RequestResult {
    let renamed = renamed_word(&question.context, question.params.position);
    Ok(renamed.map_or(Value::Null, |(range, text)| json!({ "range": range, "placeholder": text })))
}

fn rename_answer(question: &DocumentQuestion<'_>) -> RequestResult {
    let new_name = question.params.new_name.trim();
    let Some(one) = question.context.name_at(question.params.position) else {
        return Err(error(ErrorCode::RequestFailed, "there is no name at this position"));
    };
    if let Some(reason) = invalid_name(one.kind, new_name) {
        return Err(error(ErrorCode::InvalidParams, reason));
    }
    let name_places = places(question);
    let mut changes: BTreeMap<String, Vec<TextEdit>> = BTreeMap::new();
    for place in &name_places {
        let edit = TextEdit { range: place.range, new_text: new_name.to_owned() };
        changes.entry(question.state.documents.uri(&place.path)).or_default().push(edit);
    }
    Ok(json!({ "changes": changes }))
}

fn links_answer(question: &DocumentQuestion<'_>) -> RequestResult {
    let link =
        |(path, range): (&Path, TextRange)| json!({ "range": range, "target": question.state.documents.uri(path) });
    Ok(question.context.included_files().map(link).collect())
}

fn tokens_answer(question: &DocumentQuestion<'_>) -> RequestResult {
    let (first, last) = question.lines();
    Ok(json!({ "data": tokens::semantic_tokens(&question.context, first, last) }))
}

fn hints_answer(question: &DocumentQuestion<'_>) -> RequestResult {
    let whole_text = TextRange { start: TextPosition::default(), end: TextPosition { line: u32::MAX, character: 0 } };
    Ok(hints::inlay_hints(&question.context, question.params.range.unwrap_or(whole_text)).into())
}

fn formatting_answer(question: &DocumentQuestion<'_>) -> RequestResult {
    let (first, last) = question.lines();
    if last.saturating_sub(first) > format::MOST_LINES {
        let message = format!("more than {} lines: select the lines to format", format::MOST_LINES);
        return Err(error(ErrorCode::RequestFailed, message));
    }
    Ok(json!(format::formatting_edits(question.context.text, first, last, question.context.encoding)))
}

fn code_action_answer(question: &DocumentQuestion<'_>) -> RequestResult {
    let selection = question.params.range.unwrap_or_default();
    let uri = |path: &Path| question.state.documents.uri(path);
    let action = |(diagnostic, is_foreign): (&FileDiagnostic, bool)| {
        let edit = diagnostic.correction.as_ref().filter(|_| diagnostic.range.meets(&selection))?;
        let edit = correction_as_in_line(&question.context, diagnostic.code, edit);
        let published = diagnostic.document(diagnostic.level(question.state.options.mode, is_foreign), &uri);
        let title = if edit.new_text.contains('\n') {
            "Add the missing line".into()
        } else {
            format!("Write `{}`", edit.new_text)
        };
        let changes = BTreeMap::from([(uri(&diagnostic.path), [edit])]);
        Some(json!({
            "title": title,
            "kind": "quickfix",
            "diagnostics": [published],
            "isPreferred": true,
            "edit": { "changes": changes },
        }))
    };
    Ok(question.state.diagnostics_of(&question.key).filter_map(action).collect())
}
