//! `revolve explain`: texts on keywords, output variables, diagnostic codes and other topics.

mod topics;

use crate::deck::{self, DiagnosticCode, manual, names::nearest};
use crate::{generate, model, output, plan, user};
use topics::TOPICS;

/// Explains a keyword, output variable, diagnostic code, element type, function or topic. A variable takes precedence
/// over a partial keyword. `None` for an unknown word.
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
    let topic_name = word.trim().trim_end_matches("()");
    let topic = TOPICS.iter().find(|topic| topic.words.iter().any(|w| w.eq_ignore_ascii_case(topic_name)));
    let topic = topic.map(|topic| topic.text.to_owned());
    let texts: Vec<String> = keyword.into_iter().chain(variable).chain(topic).collect();
    (!texts.is_empty()).then(|| texts.join("\n"))
}

/// Returns the known word that is most similar to an unknown one.
pub fn nearest_word(word: &str) -> Option<&'static str> {
    let topics = TOPICS.iter().flat_map(|topic| topic.words.iter().copied());
    let all = manual::keyword_names().chain(crate::variables::manual::variable_names()).chain(topics);
    nearest(word.trim().trim_start_matches('*'), all)
}

/// Returns the diagnostic codes of all modules.
pub fn codes() -> impl Iterator<Item = &'static DiagnosticCode> {
    deck::CODES
        .iter()
        .chain(model::codes::CODES)
        .chain(plan::codes::CODES)
        .chain(user::codes::CODES)
        .chain(output::codes::CODES)
        .chain(crate::resistance::codes::CODES)
        .chain(generate::codes::CODES)
}
