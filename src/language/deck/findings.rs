//! Errors for cards whose keyword is known but unsupported.

use indexmap::IndexMap;

use super::diagnostic::{Diagnostic, Diagnostics, SourceLabel};
use super::keywords::{Keyword, KeywordTier};
use super::syntax::{Card, Deck};
use super::ways::alternative_or_removal;

/// Reports unsupported cards, with one error for each group of related keywords.
pub fn tier_findings(deck: &Deck, diagnostics: &mut Diagnostics) {
    // `*RESTART, READ` continues from the state of another job.
    let reads_restart = |c: &Card| c.keyword.name == "RESTART" && c.has("READ");
    let cards = || deck.cards.iter().filter(|c| c.keyword.tier == KeywordTier::UnsupportedPhysics || reads_restart(c));
    let heads: Vec<&str> = cards().map(|c| c.keyword.name).collect();
    let mut unsupported: IndexMap<&str, Vec<&Card>> = IndexMap::new();
    for card in cards() {
        unsupported.entry(head(card.keyword.name, &heads)).or_default().push(card);
    }
    for cards in unsupported.values() {
        diagnostics.push(unsupported_finding(cards));
    }
}

/// Returns the keyword of the deck to which a keyword is subordinate: `*CAP PLASTICITY` for `*CAP HARDENING`; the
/// keyword itself if there is none.
fn head<'n>(name: &'n str, there: &[&'n str]) -> &'n str {
    let parent = match name {
        "CLAY HARDENING" => Some("CLAY PLASTICITY"),
        _ if name.starts_with("CAST IRON ") => Some("CAST IRON PLASTICITY"),
        "BRITTLE SHEAR" | "BRITTLE FAILURE" => Some("BRITTLE CRACKING"),
        _ => None,
    };
    let is_begun = |other: &str| name.strip_prefix(other).is_some_and(|rest| rest.starts_with(' '));
    let goes_with = |other: &&&str| **other != name && (parent == Some(**other) || is_begun(other));
    match there.iter().filter(goes_with).min_by_key(|n| n.len()) {
        Some(above) => head(above, there),
        None => name,
    }
}

fn unsupported_finding(cards: &[&Card]) -> Diagnostic {
    let card = cards[0];
    let Keyword { name, summary, .. } = card.keyword;
    let what = Diagnostic::error("D201", format!("*{name} is not supported"))
        .at(card.span, format!("{}: ignoring it would change the result", lower_first(summary)))
        .help(alternative_or_removal(name));
    also_at(what, &cards[1..])
}

fn also_at(mut what: Diagnostic, others: &[&Card]) -> Diagnostic {
    let text = |c: &Card| format!("*{} here", c.keyword.name);
    what.labels.extend(others.iter().take(3).map(|c| SourceLabel { span: c.span, text: text(c) }));
    if others.len() > 3 {
        what.message += &format!(" ({} cards)", others.len() + 1);
    }
    what
}

fn lower_first(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |c| c.to_lowercase().chain(letters).collect())
}
