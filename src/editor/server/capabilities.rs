//! What the server can do, as the answer to `initialize` lists it.

use serde_json::{Value, json};

use crate::features::tokens::{TOKEN_MODIFIERS, TOKEN_TYPES};
use crate::text::Encoding;

/// Returns the unit of columns: UTF-8 if the client offers it, UTF-16 otherwise.
pub fn chosen_encoding(capabilities: &Value) -> Encoding {
    let offered = capabilities.pointer("/general/positionEncodings").and_then(Value::as_array);
    let has_utf8 = offered.is_some_and(|all| all.iter().any(|name| name == "utf-8"));
    if has_utf8 { Encoding::Utf8 } else { Encoding::Utf16 }
}

/// Returns the result of `initialize`.
pub fn initialize_result(encoding: Encoding) -> Value {
    let encoding = match encoding {
        Encoding::Utf8 => "utf-8",
        Encoding::Utf16 => "utf-16",
    };
    json!({
        "capabilities": {
            "positionEncoding": encoding,
            "textDocumentSync": { "openClose": true, "change": 2, "save": true },
            "hoverProvider": true,
            "completionProvider": { "triggerCharacters": ["*", ",", "=", " "] },
            "definitionProvider": true,
            "referencesProvider": true,
            "documentHighlightProvider": true,
            "renameProvider": { "prepareProvider": true },
            "documentSymbolProvider": true,
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
