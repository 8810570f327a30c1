//! What gaps at the start are taken as: `*CLEARANCE` of contact pairs, `*CONTACT CLEARANCE` and `*CONTACT INITIALIZATION DATA` of
//! general contact, with their assignments.
//! Never here: which surfaces there are, where they meet.

use super::builder::Builder;
use super::names::upper;
use super::types::Clearance;
use crate::deck::table::constraints as cards;
use crate::deck::{Card, Word};

impl Builder<'_> {
    /// The clearance of a name.
    pub(super) fn clearance(&mut self, word: &Word) -> Option<Clearance> {
        let found = self.clearances.get(&upper(&word.text)).copied();
        if found.is_none() {
            self.unknown("M114", "clearance of contact", word, |b| b.clearances.keys().cloned().collect());
        }
        found
    }

    /// ABAQUS Keywords Reference Guide, *CLEARANCE: an initial clearance of all pairs of a set.
    pub(super) fn pair_clearance(&mut self, card: &Card) {
        let Some(set) = self.required(card, "CPSET").cloned() else { return };
        let cards::Clearance { gap } = self.values(card);
        let [above, below] = [Some(f64::INFINITY); 2];
        self.state().pair_clearances.push((set, Clearance { gap, above, below }));
    }

    /// Gives pairs the clearances and the factors on penalty springs that cards of the step give their sets.
    pub(super) fn apply_to_sets(&mut self) {
        let state = self.state();
        let (clearances, factors) =
            (std::mem::take(&mut state.pair_clearances), std::mem::take(&mut state.penalty_factors));
        let mut pairs = std::mem::take(&mut state.surface_contacts);
        let names: Vec<String> = pairs.iter().filter_map(|p| p.cpset.clone()).collect();
        for (word, _) in clearances.iter().filter(|c| !names.contains(&upper(&c.0.text))) {
            self.unknown("M114", "set of contact pairs", word, |_| names.clone());
        }
        for (word, _) in factors.iter().filter(|f| !names.contains(&upper(&f.0.text))) {
            self.unknown("M114", "set of contact pairs", word, |_| names.clone());
        }
        for pair in &mut pairs {
            let is_of = |word: &Word| pair.cpset.as_ref().is_some_and(|set| *set == upper(&word.text));
            let clearance = clearances.iter().rfind(|c| is_of(&c.0)).map(|c| c.1);
            let factor = factors.iter().rfind(|f| is_of(&f.0)).map(|f| f.1);
            pair.clearance = clearance.or(pair.clearance);
            pair.penalty = pair.penalty.map(|now| factor.unwrap_or(now));
        }
        self.state().surface_contacts = pairs;
    }
}
