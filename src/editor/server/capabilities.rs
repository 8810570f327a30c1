//! What the server can do, as the answer to `initialize` lists it.

use serde_json::{Value, json};

use crate::features::tokens::{TOKEN_MODIFIERS, TOKEN_TYPES};
use crate::text::ColumnEncoding;

/// Returns the unit of columns: UTF-8 if the client offers it, UTF-16 otherwise.
pub fn chosen_encoding(capabilities: &Value) -> ColumnEncoding {
    let offered = capabilities.pointer("/general/positionEncodings").and_then(Value::as_array);
    let has_utf8 = offered.is_some_and(|all| all.iter().any(|name| name == "utf-8"));
    if has_utf8 { ColumnEncoding::Utf8 } else { ColumnEncoding::Utf16 }
}

pub fn initialize_result(encoding: ColumnEncoding) -> Value {
    let encoding = match encoding {
        ColumnEncoding::Utf8 => "utf-8",
        ColumnEncoding::Utf16 => "utf-16",
    };
    json!({
        "capabilities": {
            "positionEncoding": encoding,
            "textDocumentSync": { "openClose": true, "change": 2, "save": true },
            "hoverProvider": true,
            "completionProvider": { "triggerCharacters": ["*", ",", "=", " ", "<"], "resolveProvider": true },
            "definitionProvider": true,
            "referencesProvider": true,
            "documentHighlightProvider": true,
            "renameProvider": { "prepareProvider": true },
            "documentSymbolProvider": true,
            "documentLinkProvider": { "resolveProvider": false },
            "foldingRangeProvider": true,
            "semanticTokensProvider": {
                "legend": { "tokenTypes": TOKEN_TYPES, "tokenModifiers": TOKEN_MODIFIERS },
                "full": true,
                "range": true,
            },
            "codeActionProvider": { "codeActionKinds": ["quickfix"] },
            "inlayHintProvider": true,
            "documentFormattingProvider": true,
            "documentRangeFormattingProvider": true,
        },
        "serverInfo": { "name": "revolve", "version": env!("CARGO_PKG_VERSION") },
    })
}
