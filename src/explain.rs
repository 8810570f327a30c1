//! `revolve explain`: keywords and diagnostic codes.
//! Never here: the tables themselves.

use crate::deck::{self, Code, manual};
use crate::{model, output, plan, user};

/// What is to be said of a word, if it is a keyword, a code, or `keywords`.
pub fn explain(word: &str) -> Option<String> {
    if word.eq_ignore_ascii_case("keywords") {
        return Some(manual::keyword_manual());
    }
    let code = codes().find(|c| c.code.eq_ignore_ascii_case(word.trim()));
    code.map(|c| format!("{}: {}\n\n{}\n", c.code, c.title, c.text)).or_else(|| manual::explain_keyword(word))
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
