//! Decks of the table of pairs: a deck with changes that make an entry of the keyword table effective, and the same deck with
//! a change of this entry.

use std::collections::HashMap;

use crate::common;

/// Decks that the table changes.
const BASES: [&str; 5] = ["solid", "shell", "cohesive", "rigid", "parts"];

/// One line of the table of pairs.
pub struct DeckPair {
    pub name: String,
    pub texts: [String; 2],
    /// Name of the deck without changes.
    pub base: String,
    /// Changes that make the entry effective.
    pub scene: Vec<String>,
    /// Changes of the entry.
    pub variation: Vec<String>,
}

impl DeckPair {
    /// Returns the keyword of the entry.
    pub fn keyword(&self) -> &str {
        self.name.split(", ").next().expect("a keyword")
    }
}

/// Applies changes: `from => to`, or `@mark lines`. The error is a change whose text is not in the deck.
pub fn changed(text: &str, changes: &[String]) -> Result<String, String> {
    let mut text = text.to_owned();
    for change in changes {
        let plain = |s: &str| s.replace("\\n", "\n");
        let (from, to) = match change.strip_prefix('@') {
            Some(rest) => {
                let (mark, lines) = rest.split_once(' ').expect("a mark and lines");
                (format!("**{mark}\n"), format!("**{mark}\n{}\n", plain(lines)))
            }
            None => {
                let (from, to) = change.split_once("=>").unwrap_or_else(|| panic!("no change: {change}"));
                (plain(from.strip_suffix(' ').unwrap_or(from)), plain(to.strip_prefix(' ').unwrap_or(to)))
            }
        };
        if !text.contains(&from) {
            return Err(change.to_owned());
        }
        text = text.replacen(&from, &to, 1);
    }
    Ok(text)
}

/// Splits a text of changes, in which `$name` is replaced by the changes of a definition.
fn split(changes: &str, definitions: &HashMap<&str, &str>) -> Vec<String> {
    let of_change = |change: &str| match change.strip_prefix('$') {
        Some(name) => split(definitions[name.trim()], definitions),
        None => vec![change.to_owned()],
    };
    changes.split(";;").map(str::trim).filter(|change| !change.is_empty()).flat_map(of_change).collect()
}

/// Returns the text of a deck that the table changes.
pub fn base(name: &str) -> String {
    std::fs::read_to_string(common::project(&format!("tests/deck/words/{name}.inp"))).expect("a deck of the pairs")
}

pub fn pairs() -> Vec<DeckPair> {
    let bases: HashMap<&str, String> = BASES.map(|name| (name, base(name))).into();
    let table = std::fs::read_to_string(common::project("tests/deck/words/pairs.txt")).expect("the table of pairs");
    let lines = table.lines().filter(|l| !l.is_empty() && !l.starts_with('#'));
    let (definitions, lines): (Vec<&str>, Vec<&str>) = lines.partition(|l| l.starts_with("def "));
    let definitions: HashMap<&str, &str> =
        definitions.iter().map(|l| l[4..].split_once('|').expect("a definition")).map(|(n, t)| (n.trim(), t)).collect();
    let pair = |line: &&str| {
        let columns: Vec<&str> = line.split(" | ").collect();
        let [name, deck, last] = columns[..] else { panic!("three columns: {line}") };
        let mut parts = deck.split(" + ");
        let base = parts.next().expect("a deck").trim();
        let of_part = |part: &str| split(definitions.get(part.trim()).copied().unwrap_or(part), &definitions);
        let scene: Vec<String> = parts.flat_map(of_part).collect();
        let variation = split(last, &definitions);
        let apply = |text: &str, changes: &[String]| {
            changed(text, changes).unwrap_or_else(|change| panic!("{name}: `{change}` finds nothing in\n{text}"))
        };
        let text = apply(&bases[base], &scene);
        let other = apply(&text, &variation);
        DeckPair { name: name.trim().into(), texts: [text, other], base: base.into(), scene, variation }
    };
    lines.iter().map(pair).collect()
}
