//! What is said of cards for the tier their keyword stands in.
//! Never here: checks of what a card says.

use indexmap::IndexMap;

use super::diagnostic::{Diagnostic, Diagnostics, Label};
use super::keywords::{Keyword, Tier};
use super::source::Span;
use super::syntax::{Card, Deck};

/// Tells of unsupported cards, once per keyword, and of cards that change only another program's output, once for all.
pub fn tier_findings(deck: &Deck, diagnostics: &mut Diagnostics) {
    let mut unsupported: IndexMap<&str, Vec<&Card>> = IndexMap::new();
    for card in &deck.cards {
        if matches!(card.keyword.tier, Tier::UnsupportedPhysics | Tier::UnsupportedInert) || reads_restart(card) {
            unsupported.entry(card.keyword.name).or_default().push(card);
        }
    }
    for cards in unsupported.values() {
        diagnostics.push(unsupported_finding(cards));
    }
    output_only(deck, diagnostics);
}

/// Going on from another job's state is no mere output.
fn reads_restart(card: &Card) -> bool {
    card.keyword.name == "RESTART" && card.has("READ")
}

fn unsupported_finding(cards: &[&Card]) -> Diagnostic {
    let card = cards[0];
    let Keyword { name, tier, summary, .. } = card.keyword;
    let what = match tier {
        Tier::UnsupportedInert => Diagnostic::note("D202", format!("*{name} is not supported and is ignored"))
            .at(card.span, "changes no result"),
        _ => Diagnostic::error("D201", format!("*{name} is not supported"))
            .at(card.span, format!("{}: leaving it out would change the answer", lower_first(summary)))
            .help(instead(name)),
    };
    also_at(what, &cards[1..])
}

fn also_at(mut what: Diagnostic, others: &[&Card]) -> Diagnostic {
    what.labels.extend(others.iter().take(3).map(|c| Label { span: c.span, text: "also here".into() }));
    if others.len() > 3 {
        what.message += &format!(" ({} cards)", others.len() + 1);
    }
    what
}

/// What is there in place of an unsupported keyword.
fn instead(name: &str) -> &'static str {
    match name {
        "STATIC"
        | "VISCO"
        | "HEAT TRANSFER"
        | "COUPLED TEMPERATURE-DISPLACEMENT"
        | "FREQUENCY"
        | "BUCKLE"
        | "SOILS"
        | "GEOSTATIC" => "the supported procedure is *DYNAMIC, EXPLICIT",
        "SHELL SECTION" | "SHELL GENERAL SECTION" | "BEAM SECTION" | "BEAM GENERAL SECTION" | "MEMBRANE SECTION" => {
            "the supported section is *SOLID SECTION"
        }
        "RESTART" => "to go on with a halted run, use `revolve run --resume`",
        _ => "remove it if the analysis does not need it",
    }
}

fn output_only(deck: &Deck, diagnostics: &mut Diagnostics) {
    let mut where_from: IndexMap<&str, Vec<Span>> = IndexMap::new();
    for card in deck.cards.iter().filter(|c| c.keyword.tier == Tier::OutputOnly) {
        where_from.entry(card.keyword.name).or_default().push(card.span);
    }
    let Some(first) = where_from.values().flatten().next() else { return };
    let list: Vec<String> = where_from.iter().map(|(name, spans)| listed(deck, name, spans)).collect();
    let what = Diagnostic::note("D203", format!("ignored, for they change only other output: {}", list.join(", ")));
    diagnostics.push(what.at(*first, "the first of them"));
}

fn listed(deck: &Deck, name: &str, spans: &[Span]) -> String {
    let lines: Vec<String> = spans.iter().take(5).map(|s| deck.sources.line_column(*s).0.to_string()).collect();
    let more = if spans.len() > 5 { ", …" } else { "" };
    format!("*{name} (line {}{more})", lines.join(", "))
}

fn lower_first(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |c| c.to_lowercase().chain(letters).collect())
}
