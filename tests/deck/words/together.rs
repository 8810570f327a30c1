//! Cards together: an entry that changes the results alone also does so with the cards of another keyword for the same set, or
//! there is a message.
//!
//! Goal: no card takes the effect of another one silently. Source: the pairs of `pairs.txt`, two at a time.

use std::collections::{BTreeMap, BTreeSet};

use super::{DeckPair, base, files, pairs, results, try_changed, unused_input};
use revolve::deck;

/// One of so many combinations is tried, unless `REVOLVE_ALL_PAIRS` is set.
const SHARE: usize = 16;

/// Combinations in which an entry has no effect for a physical reason that no message needs to state: keyword of the entry,
/// keyword of the other cards, reason.
const WITHOUT_EFFECT: &[(&str, &str, &str)] = &[];

/// Returns the names of sets, surfaces, materials and other objects that added text refers to.
fn targets(changes: &str, names: &BTreeSet<String>) -> BTreeSet<String> {
    let words = changes.split(|c: char| !c.is_alphanumeric() && c != '_').map(str::to_ascii_uppercase);
    words.filter(|word| names.contains(word)).collect()
}

/// Returns the values of NSET, ELSET, NAME and MATERIAL in a deck.
fn defined_names(text: &str) -> BTreeSet<String> {
    let (deck, _) = deck::read_text("names.inp", text, &[]);
    let parameters = deck.cards.iter().flat_map(|card| &card.parameters);
    let naming = parameters.filter(|parameter| ["NSET", "ELSET", "NAME", "MATERIAL"].contains(&parameter.name));
    naming.filter_map(|parameter| Some(parameter.value.as_ref()?.text.to_ascii_uppercase())).collect()
}

/// Returns the combinations of an entry with the cards of another keyword that name the same object.
fn combinations(pairs: &[DeckPair]) -> Vec<(&DeckPair, &DeckPair)> {
    let keyword = |pair: &DeckPair| pair.name.split(", ").next().expect("a keyword").to_owned();
    let mut first_scenes: BTreeMap<(String, String), &DeckPair> = BTreeMap::new();
    for pair in pairs {
        first_scenes.entry((pair.base.clone(), keyword(pair))).or_insert(pair);
    }
    let mut all = Vec::new();
    for entry in pairs {
        for ((other_base, other_keyword), other) in &first_scenes {
            if *other_base != entry.base || *other_keyword == keyword(entry) || other.changes[0] == entry.changes[0] {
                continue;
            }
            let names = defined_names(&entry.texts[0]);
            let [of_entry, of_other] =
                [entry, other].map(|pair| targets(&format!("{} {}", pair.changes[0], pair.changes[1]), &names));
            if !of_entry.is_disjoint(&of_other) {
                all.push((entry, *other));
            }
        }
    }
    all
}

#[test]
fn entries_keep_their_effect_with_other_cards_for_the_same_object() {
    let folder = tempfile::tempdir().expect("a folder");
    files(folder.path());
    let pairs = pairs();
    let all = combinations(&pairs);
    let share = if std::env::var_os("REVOLVE_ALL_PAIRS").is_some() { 1 } else { SHARE };
    let (mut tried, mut refused, mut faults) = (0, 0, Vec::new());
    for (entry, other) in all.iter().step_by(share) {
        let Ok(text) = try_changed(&base(&entry.base), &format!("{};;{}", entry.changes[0], other.changes[0])) else {
            continue;
        };
        let Ok(changed) = try_changed(&text, &entry.changes[1]) else { continue };
        let (deck, found) = deck::read_text("pair.inp", &text, &[]);
        if found.has_errors() || revolve::model::build(&deck).1.has_errors() {
            refused += 1;
            continue;
        }
        tried += 1;
        let shown = |text: &str| (results(folder.path(), text), unused_input(text));
        let keyword = |pair: &DeckPair| pair.name.split(", ").next().expect("a keyword").to_owned();
        let is_known = |known: &&(&str, &str, &str)| known.0 == keyword(entry) && known.1 == keyword(other);
        if shown(&text) == shown(&changed) && !WITHOUT_EFFECT.iter().any(|known| is_known(&known)) {
            faults.push(format!("{}: no effect with *{}", entry.name, keyword(other)));
        }
    }
    println!("{tried} of {} combinations tried, {refused} refused", all.len());
    assert!(tried >= 100, "{tried} combinations");
    assert!(faults.is_empty(), "{} faults:\n{}", faults.len(), faults.join("\n"));
}
