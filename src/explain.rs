//! `revolve explain`: keywords, output variables and diagnostic codes.
//! Never here: the tables themselves.

use crate::deck::{self, Code, manual};
use crate::{model, output, plan, user};

/// What is to be said of a word, if it is a keyword, an output variable, a code, `keywords` or `variables`. Of a word that is
/// a variable's name a keyword is meant only if it is the whole of the keyword's.
pub fn explain(word: &str) -> Option<String> {
    match word.trim().to_ascii_lowercase().as_str() {
        "keywords" => return Some(manual::keyword_manual()),
        "variables" => return Some(crate::variables::manual::variable_manual()),
        _ => {}
    }
    if let Some(code) = codes().find(|c| c.code.eq_ignore_ascii_case(word.trim())) {
        return Some(format!("{}: {}\n\n{}\n", code.code, code.title, code.text));
    }
    let variable = crate::variables::manual::explain_variable(word);
    let keyword = manual::explain_keyword(word).filter(|_| variable.is_none() || manual::is_keyword(word));
    let texts: Vec<String> = keyword.into_iter().chain(variable).collect();
    (!texts.is_empty()).then(|| texts.join("\n"))
}

/// All diagnostic codes of all rooms.
pub fn codes() -> impl Iterator<Item = &'static Code> {
    deck::CODES
        .iter()
        .chain(model::codes::CODES)
        .chain(plan::codes::CODES)
        .chain(user::codes::CODES)
        .chain(output::codes::CODES)
}
