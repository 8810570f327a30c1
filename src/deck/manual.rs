//! The keyword manual, written from the keyword table.
//! Never here: anything the table does not say.

use super::keywords::{KEYWORDS, Keyword, Lookup, ParameterRule, Tier, find_keyword};
use super::names::fold;

/// The text of `docs/keywords.md`.
pub fn keyword_manual() -> String {
    let mut text = String::from(HEAD);
    text += &chapter("Used", "Parsed and used.", |k| k.tier == Tier::Used && !k.extension);
    text += &chapter("Extensions", "Not in ABAQUS: ours.", |k| k.extension);
    text +=
        &chapter("Parsed", "Understood; used where the capability is there, otherwise the check says why not.", |k| {
            k.tier == Tier::Parsed
        });
    text += &table("Output of another program", "Accepted with one note: they change no result.", Tier::OutputOnly);
    text +=
        &table("Unsupported", "Known and refused: without them the answer would be another.", Tier::UnsupportedPhysics);
    text += &table(
        "Unsupported without effect",
        "Known and ignored with a note: no result depends on them.",
        Tier::UnsupportedInert,
    );
    text
}

const HEAD: &str = "# Keywords\n\nWritten from the keyword table; do not edit by hand (`REVOLVE_BLESS=1 cargo test --test deck` writes it anew).\n\
Case and blanks do not count, unambiguous abbreviations are understood. An empty field means its default.\n";

fn chapter(title: &str, about: &str, belongs: fn(&Keyword) -> bool) -> String {
    let entries: String = KEYWORDS.iter().filter(|k| belongs(k)).map(entry).collect();
    format!("\n## {title}\n\n{about}\n{entries}")
}

fn entry(keyword: &Keyword) -> String {
    let mut text = format!("\n### *{}\n\n{}.\n", keyword.name, keyword.summary);
    if !keyword.parameters.is_empty() {
        text += "\n";
    }
    for rule in keyword.parameters {
        text += &format!("- `{}`{}: {}\n", rule.name, mark(rule.extension), help(rule));
    }
    if !keyword.data.is_empty() {
        text += "\nData lines:\n";
    }
    for (i, line) in keyword.data.iter().enumerate() {
        text += &format!("{}. {line}\n", i + 1);
    }
    text
}

fn table(title: &str, about: &str, tier: Tier) -> String {
    let line = |k: &Keyword| format!("- `*{}`: {}\n", k.name, k.summary);
    let lines: String = KEYWORDS.iter().filter(|k| k.tier == tier).map(line).collect();
    format!("\n## {title}\n\n{about}\n\n{lines}")
}

fn mark(extension: bool) -> &'static str {
    if extension { " (extension)" } else { "" }
}

/// The help of a parameter without the table's mark of extensions.
fn help(rule: &ParameterRule) -> &'static str {
    rule.help.strip_prefix('+').unwrap_or(rule.help)
}

/// What `revolve explain` says of a keyword, with or without its star, abbreviated or not.
pub fn explain_keyword(name: &str) -> Option<String> {
    match find_keyword(name.trim().trim_start_matches('*')) {
        Lookup::Found(keyword) => Some(explain(keyword)),
        _ => None,
    }
}

/// Whether a word, with or without its star, is the whole name of a keyword.
pub fn is_keyword(name: &str) -> bool {
    let wanted = fold(name.trim().trim_start_matches('*'));
    KEYWORDS.iter().any(|k| fold(k.name) == wanted)
}

fn explain(keyword: &Keyword) -> String {
    let width = keyword.parameters.iter().map(|r| r.name.len()).max().unwrap_or(0);
    let mut text =
        format!("*{}{}: {}.\n{}.\n", keyword.name, mark(keyword.extension), keyword.summary, standing(keyword.tier));
    for rule in keyword.parameters {
        text += &format!("  {:width$}  {}{}\n", rule.name, help(rule), mark(rule.extension));
    }
    for line in keyword.data {
        text += &format!("  data: {line}\n");
    }
    text
}

fn standing(tier: Tier) -> &'static str {
    match tier {
        Tier::Used => "Supported",
        Tier::OutputOnly => "Accepted and ignored: changes only output of another program",
        Tier::Parsed => "Understood; used where the capability is there",
        Tier::UnsupportedPhysics => "Not supported: a deck with it is refused",
        Tier::UnsupportedInert => "Not supported; ignored, for no result depends on it",
    }
}
