//! `revolve explain`: texts on keywords, output variables, diagnostic codes and other topics.

mod topics;

use crate::deck::{self, DiagnosticCode, manual, names::nearest};
use crate::{generate, job, model, output, plan, user};
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
        let verdict = job::effect_of(code.code).map_or(String::new(), |effect| {
            format!("\nVerdict of the run: {}. Helps: {}\n", effect.verdict.word(), effect.card)
        });
        return Some(format!("{}: {}\n\n{}\n{verdict}", code.code, code.title, code.text));
    }
    let variable = crate::variables::manual::explain_variable(word);
    let keyword = manual::explain_keyword(word).filter(|_| variable.is_none() || manual::is_keyword(word));
    let topic_name = word.trim().trim_end_matches("()");
    let topic = TOPICS.iter().find(|topic| topic.words.iter().any(|w| w.eq_ignore_ascii_case(topic_name)));
    let topic = topic.map(|topic| topic.text.to_owned());
    let texts: Vec<String> = keyword.into_iter().chain(variable).chain(topic).collect();
    (!texts.is_empty()).then(|| texts.join("\n"))
}

/// Largest number of matches of a search.
const MOST_MATCHES: usize = 20;

/// Lists the keywords, variables, codes and topics whose texts contain all words, with their first lines. Matches in
/// the name or first line are first. `None` without a match.
pub fn search(words: &str) -> Option<String> {
    let words: Vec<String> = words.split_whitespace().map(str::to_lowercase).collect();
    let contains = |text: &str| {
        let text = text.to_lowercase();
        words.iter().all(|word| text.contains(word))
    };
    let keywords =
        manual::keyword_names().filter_map(|name| Some((format!("*{name}"), manual::explain_keyword(name)?)));
    let variables = crate::variables::manual::variable_names()
        .filter_map(|name| Some((name.to_owned(), crate::variables::manual::explain_variable(name)?)));
    let topics = TOPICS.iter().map(|topic| (topic.words[0].to_owned(), topic.text.to_owned()));
    let codes = codes().map(|code| (code.code.to_owned(), format!("{}\n{}", code.title, code.text)));
    let matches =
        keywords.chain(codes).chain(variables).chain(topics).filter(|(name, text)| contains(&format!("{name} {text}")));
    let mut ranked: Vec<(bool, String)> = matches
        .map(|(name, text)| {
            let first = text.lines().next().unwrap_or_default();
            let first = first.strip_prefix(&name).unwrap_or(first).trim_start_matches([':', ' ']);
            let line = format!("  {name:<28} {first}");
            (!contains(&line), line)
        })
        .collect();
    ranked.sort_by_key(|(below, _)| *below);
    let more = ranked.len().saturating_sub(MOST_MATCHES);
    let lines: Vec<String> = ranked.into_iter().take(MOST_MATCHES).map(|(_, line)| line).collect();
    let more = if more > 0 { format!("\n  and {more} more") } else { String::new() };
    (!lines.is_empty()).then(|| {
        format!("texts with `{}`; `revolve explain NAME` prints one:\n{}{more}", words.join(" "), lines.join("\n"))
    })
}

/// Returns the known word that is most similar to an unknown one.
pub fn nearest_word(word: &str) -> Option<&'static str> {
    let topics = TOPICS.iter().flat_map(|topic| topic.words.iter().copied());
    let known_words = manual::keyword_names().chain(crate::variables::manual::variable_names()).chain(topics);
    nearest(word.trim().trim_start_matches('*'), known_words)
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

#[cfg(test)]
mod tests {
    use super::search;

    #[test]
    fn search_finds_texts_with_all_words() {
        for (words, name) in
            [("johnson cook", "*PLASTIC"), ("JWL", "*EOS"), ("drift", "R208"), ("hourglass energy", "ALLAE")]
        {
            let listed = search(words).unwrap_or_default();
            assert!(listed.lines().any(|line| line.trim_start().starts_with(name)), "{words}: {listed}");
        }
        assert_eq!(search("no such words"), None);
    }
}
