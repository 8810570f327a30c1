//! Cards together and cards apart: a card that changes the results of a deck also does so with the cards of another keyword
//! that have a common target, and without another card of the deck, or a message names it.
//!
//! Goal: no card takes the effect of another one silently. Source: the scenes of `pairs.txt`; which keywords have a target in
//! common follows from the keyword table.

use std::collections::{BTreeMap, BTreeSet};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::time::{Duration, Instant};

use super::scenes::{DeckPair, base, changed, pairs};
use super::{block, differences, files, prepare, results, results_of, test_subroutines};
use revolve::deck::keywords::{CardPlace, Keyword, KeywordTier, keywords};
use revolve::deck::name_kinds::{field_name_kind, parameter_name_usage};
use revolve::deck::{self, Card, Deck};
use revolve::plan::ledger::UnusedCard;
use revolve::user::Routines;

/// Time after which a small deck is considered as unbounded.
const LONGEST: Duration = Duration::from_secs(20);
/// Largest number of entries of a card that are tried until one changes the results.
const MOST_TRIALS: usize = 4;

/// Outcome of a deck and of the same deck with a change of an entry.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Outcome {
    /// The results change.
    Effective,
    /// Nothing changes, and a message or the list of unused input names the card.
    Named,
    /// The deck is rejected.
    Rejected,
    /// Nothing changes without a message.
    Silent,
    /// The program panics, or it takes too long.
    Fault(String),
}

/// A card that has no effect without another card, for a reason that needs no message.
struct IdleCard {
    /// Entry of the table, or all entries of a keyword.
    name: &'static str,
    /// Keyword of the other card.
    without: &'static str,
    reason: &'static str,
}

const IDLE: &[IdleCard] = &[
    IdleCard { name: "SURFACE", without: "DSLOAD", reason: "programs define many sets and surfaces that nothing uses" },
    IdleCard { name: "CONTACT PAIR, CPSET", without: "CONTACT CONTROLS", reason: "only the name of a set of pairs" },
    IdleCard {
        name: "DAMAGE INITIATION",
        without: "DAMAGE EVOLUTION",
        reason: "the ledger has a row: evaluated without damage (DMICRT)",
    },
    IdleCard { name: "DEPVAR", without: "ELEMENT OUTPUT", reason: "its variables appear in the output only" },
    IdleCard {
        name: "USER DEFINED FIELD",
        without: "PLASTIC",
        reason: "the subroutine is called, and its field and state variables can be requested",
    },
    IdleCard { name: "CAVITY EXPANSION", without: "DSLOAD", reason: "the target, which has no load, is listed" },
    IdleCard { name: "CAVITY EXPANSION", without: "INITIAL CONDITIONS", reason: "the body is at rest" },
    IdleCard { name: "EROSION, ELSET", without: "INITIAL CONDITIONS", reason: "the limit is not reached at rest" },
    IdleCard { name: "CONCRETE FAILURE, TYPE", without: "INITIAL CONDITIONS", reason: "no cracks at rest" },
    IdleCard { name: "POROUS FAILURE CRITERIA", without: "INITIAL CONDITIONS", reason: "no pores grow at rest" },
    IdleCard {
        name: "CONTACT CLEARANCE",
        without: "CONTACT INCLUSIONS",
        reason: "the assignment that names it is listed",
    },
    IdleCard {
        name: "CONTACT INITIALIZATION DATA",
        without: "CONTACT INCLUSIONS",
        reason: "the assignment that names it is listed",
    },
    IdleCard { name: "EXPANSION", without: "BOUNDARY", reason: "the temperature is then constant" },
    IdleCard {
        name: "CONCRETE TENSION STIFFENING, TYPE",
        without: "CONCRETE TENSION DAMAGE",
        reason: "the elements of the scene have the length 1: strains are displacements",
    },
];

/// Returns the index of the exception for an entry without another card.
fn idle_card(entry: &DeckPair, removed: &str) -> Option<usize> {
    IDLE.iter().position(|idle| (idle.name == entry.name || idle.name == entry.keyword()) && idle.without == removed)
}

/// Number of outcomes of each kind, and the faults.
#[derive(Default)]
struct OutcomeCounts {
    effective: usize,
    named: usize,
    rejected: usize,
    faults: Vec<String>,
}

impl OutcomeCounts {
    fn add(&mut self, what: &str, outcome: &Outcome) {
        match outcome {
            Outcome::Effective => self.effective += 1,
            Outcome::Named => self.named += 1,
            Outcome::Rejected => self.rejected += 1,
            Outcome::Silent => self.faults.push(format!("{what}: no effect without a message")),
            Outcome::Fault(why) => self.faults.push(format!("{what}: {why}")),
        }
    }

    /// Prints the numbers and asserts that there is no fault.
    fn report(&self, what: &str) {
        let OutcomeCounts { effective, named, rejected, faults } = self;
        let count = effective + named + rejected + faults.len();
        println!(
            "{count} {what}: {effective} with effect, {named} named in a message, {rejected} rejected, {} silent",
            faults.len()
        );
        assert!(faults.is_empty(), "{} faults:\n{}", faults.len(), faults.join("\n"));
    }
}

/// Returns the kinds of objects to which a card refers: by its parameters and data lines, its parent and the step.
fn target_kinds(keyword: &Keyword) -> BTreeSet<&'static str> {
    let of_parameters = keyword.parameters.iter().filter_map(|rule| parameter_name_usage(keyword, rule));
    let fields = keyword.data.iter().flat_map(|data| data.shape.rules());
    let mut kinds: BTreeSet<&str> = of_parameters.map(|usage| usage.kind.words()).collect();
    kinds.extend(fields.filter_map(field_name_kind).map(|kind| kind.words()));
    match keyword.place {
        CardPlace::Below(parents) => kinds.extend(parents),
        CardPlace::Step | CardPlace::EachStep => _ = kinds.insert("step"),
        CardPlace::Anywhere => {}
    }
    kinds
}

/// Returns whether a card is of the kind below which another one is: *MATERIAL for *ELASTIC, *CONTACT for *CONTACT FORMULATION.
fn is_parent(above: &Card, card: &Card) -> bool {
    let (name, parent) = (card.keyword.name, above.keyword.name);
    let is_option = name.strip_prefix(parent).is_some_and(|rest| rest.starts_with(' '));
    is_option || card.keyword.place.is_below(parent)
}

/// Returns the indices of the lines of the cards of a keyword, and of the cards below which they are.
fn lines_of_keyword(text: &str, deck: &Deck, keyword: &str) -> BTreeSet<usize> {
    let line_of = |at: u32| text[..at as usize].matches('\n').count();
    let mut lines = BTreeSet::new();
    for (index, card) in deck.cards.iter().enumerate().filter(|(_, card)| card.keyword.name == keyword) {
        let first = line_of(card.span.start);
        lines.extend(first..first + block(text, deck, index).lines().count());
        let parent = deck.cards[..index].iter().rev().find(|above| is_parent(above, card));
        lines.extend(parent.map(|parent| line_of(parent.span.start)));
    }
    lines
}

/// Returns whether a message contains the name of a keyword, which is not the begin of a longer one.
fn has_keyword(message: &str, keyword: &str) -> bool {
    let name = format!("*{keyword}");
    message.match_indices(&name).any(|(at, _)| {
        let text = &message[at + 1..];
        !keywords().any(|other| other.name.len() > keyword.len() && text.starts_with(other.name))
    })
}

/// Returns whether a message or the list of unused input names a card of an entry, or its parameter, with or without user
/// subroutines.
fn is_named(folder: &Path, text: &str, entry: &DeckPair) -> bool {
    let (keyword, parameter) = (entry.keyword(), entry.name.split(", ").nth(1).unwrap_or_default());
    let prepared = prepare(folder, text, &test_subroutines());
    let (deck, _) = deck::read_text(&folder.join("pair.inp").display().to_string(), text, &[]);
    let lines = lines_of_keyword(text, &deck, keyword);
    let is_in_lines = |at: u32| lines.contains(&text[..at as usize].matches('\n').count());
    let line_of = |place: &str| place.rsplit(':').next().and_then(|line| line.parse::<usize>().ok());
    let has_message = prepared.diagnostics.iter().any(|message| {
        let labels = message.labels.iter().filter(|label| label.span.file == 0);
        has_keyword(&message.message, keyword) || labels.map(|label| label.span.start).any(is_in_lines)
    });
    let plain = prepare(folder, text, &Routines::none());
    let unused = prepared.plan.ledger.unused.iter().chain(&plain.plan.ledger.unused);
    let is_listed = |card: &UnusedCard| {
        let is_in_card = line_of(&card.asked_by).is_some_and(|line| lines.contains(&(line - 1)));
        is_in_card
            || card.what.starts_with(parameter)
            || has_keyword(&card.what, keyword)
            || has_keyword(&card.why, keyword)
    };
    has_message || unused.clone().any(is_listed)
}

/// Compares a deck with the same deck after the change of an entry.
fn compare(folder: &Path, [text, varied]: &[String; 2], entry: &DeckPair) -> Outcome {
    let begin = Instant::now();
    let outcome = catch_unwind(AssertUnwindSafe(|| {
        let prepared = prepare(folder, text, &test_subroutines());
        if prepared.diagnostics.has_errors() {
            return Outcome::Rejected;
        }
        if results_of(&prepared) != results(folder, varied) {
            return Outcome::Effective;
        }
        if [text, varied].iter().any(|text| is_named(folder, text, entry)) { Outcome::Named } else { Outcome::Silent }
    }));
    match outcome {
        _ if begin.elapsed() > LONGEST => Outcome::Fault(format!("takes {:?}", begin.elapsed())),
        Ok(outcome) => outcome,
        Err(_) => Outcome::Fault("panics".into()),
    }
}

/// Returns the scene of an entry with the changes of another scene, and the same deck with the change of the entry; `None` if
/// one scene changes text that the other needs.
fn combined(entry: &DeckPair, other: &DeckPair) -> Option<[String; 2]> {
    let base = base(&entry.base);
    let in_order = |first: &DeckPair, second: &DeckPair| {
        let more: Vec<String> = second.scene.iter().filter(|change| !first.scene.contains(change)).cloned().collect();
        changed(&changed(&base, &first.scene).ok()?, &more).ok()
    };
    let text = in_order(entry, other).or_else(|| in_order(other, entry))?;
    let varied = changed(&text, &entry.variation).ok()?;
    is_variation(&text, &varied, entry).then_some([text, varied])
}

/// Returns whether two decks differ only in the entry.
fn is_variation(text: &str, varied: &str, entry: &DeckPair) -> bool {
    let [a, b] = [text, varied].map(|text| deck::read_text("pair.inp", text, &[]).0);
    let names = |deck: &Deck| deck.cards.iter().map(|card| card.keyword.name).collect::<Vec<_>>();
    names(&a) == names(&b) && differences(&a, &b) == BTreeSet::from([entry.name.clone()])
}

/// Returns the best outcome of several decks: the first in which the card has an effect or is named, otherwise the first in
/// which it is silent. A fault of the program is never hidden by another deck.
fn best_outcome(outcomes: impl Iterator<Item = Outcome>) -> Option<Outcome> {
    let (mut best, mut trials) = (None, 0);
    for outcome in outcomes {
        match outcome {
            Outcome::Fault(_) | Outcome::Effective | Outcome::Named => return Some(outcome),
            Outcome::Silent => best = Some(outcome),
            Outcome::Rejected => best = best.or(Some(outcome)),
        }
        trials += 1;
        if trials >= MOST_TRIALS {
            break;
        }
    }
    best
}

/// Returns the scenes by keyword.
fn by_keyword(pairs: &[DeckPair]) -> BTreeMap<&str, Vec<&DeckPair>> {
    let mut scenes: BTreeMap<&str, Vec<&DeckPair>> = BTreeMap::new();
    for pair in pairs {
        scenes.entry(pair.keyword()).or_default().push(pair);
    }
    scenes
}

/// Returns the first scene of each keyword, base and set of changes.
fn different_scenes<'p>(pairs: &[&'p DeckPair]) -> Vec<&'p DeckPair> {
    let mut seen = BTreeSet::new();
    pairs.iter().filter(|pair| seen.insert((&pair.base, &pair.scene))).copied().collect()
}

#[test]
fn cards_with_a_common_target_keep_their_effects() {
    let folder = tempfile::tempdir().expect("a folder");
    files(folder.path());
    let pairs = pairs();
    let scenes = by_keyword(&pairs);
    let used = keywords().filter(|keyword| keyword.tier == KeywordTier::Used);
    let kinds: BTreeMap<&str, BTreeSet<&str>> = used.map(|keyword| (keyword.name, target_kinds(keyword))).collect();
    let (mut counts, mut not_combined, mut tried) = (OutcomeCounts::default(), BTreeSet::new(), BTreeSet::new());
    for (keyword, entries) in &scenes {
        for (other_keyword, others) in &scenes {
            if keyword == other_keyword || kinds[keyword].is_disjoint(&kinds[other_keyword]) {
                continue;
            }
            let others = different_scenes(others);
            let decks = entries.iter().flat_map(|entry| {
                let of_base = others.iter().filter(|other| other.base == entry.base);
                of_base.filter_map(|other| Some((*entry, combined(entry, other)?))).take(2)
            });
            let pair = [keyword.min(other_keyword), keyword.max(other_keyword)];
            match best_outcome(decks.map(|(entry, texts)| compare(folder.path(), &texts, entry))) {
                Some(outcome) => {
                    tried.insert(pair);
                    counts.add(&format!("*{keyword} with *{other_keyword}"), &outcome);
                }
                None => _ = not_combined.insert(pair),
            }
        }
    }
    let never = not_combined.difference(&tried).count();
    println!("{} pairs of cards with a common target, {never} pairs have no common deck", tried.len());
    counts.report("cards with another card");
}

/// Returns the deck without the card at an index.
fn without_card(text: &str, deck: &Deck, index: usize) -> String {
    text.replacen(block(text, deck, index), "", 1)
}

#[test]
fn cards_without_another_card_are_obeyed_or_named() {
    let folder = tempfile::tempdir().expect("a folder");
    files(folder.path());
    let pairs = pairs();
    let (mut counts, mut tried, mut idle) = (OutcomeCounts::default(), BTreeSet::new(), BTreeSet::new());
    for entry in &pairs {
        let keyword = entry.keyword();
        let base_cards: BTreeSet<String> = {
            let text = base(&entry.base);
            let (deck, _) = deck::read_text("base.inp", &text, &[]);
            (0..deck.cards.len()).map(|index| block(&text, &deck, index).to_owned()).collect()
        };
        let [(text, deck), (varied, varied_deck)] =
            entry.texts.each_ref().map(|text| (text, deck::read_text("pair.inp", text, &[]).0));
        if deck.cards.len() != varied_deck.cards.len() {
            continue;
        }
        for (index, card) in deck.cards.iter().enumerate() {
            let removed = card.keyword.name;
            // Cards of the deck without changes once for each keyword, added cards for each entry.
            let is_of_base = base_cards.contains(block(text, &deck, index));
            let is_new = tried.insert((keyword, removed, if is_of_base { "" } else { entry.name.as_str() }));
            if removed == keyword || !is_new {
                continue;
            }
            let texts = [without_card(text, &deck, index), without_card(varied, &varied_deck, index)];
            if !is_variation(&texts[0], &texts[1], entry) {
                continue;
            }
            let outcome = compare(folder.path(), &texts, entry);
            match idle_card(entry, removed).filter(|_| outcome == Outcome::Silent) {
                Some(exception) => _ = idle.insert(exception),
                None => counts.add(&format!("{} without *{removed}", entry.name), &outcome),
            }
        }
    }
    let unneeded = (0..IDLE.len()).filter(|index| !idle.contains(index)).map(|index| IDLE[index].name);
    assert_eq!(unneeded.collect::<Vec<_>>(), Vec::<&str>::new(), "exceptions that no deck needs");
    for exception in IDLE {
        println!("{} without *{}: {}", exception.name, exception.without, exception.reason);
    }
    counts.report("entries without another card");
}
