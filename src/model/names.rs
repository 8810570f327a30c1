//! Names: node and element labels by scope, sets, and how a word of a deck is looked up.
//! Never here: geometry.

use std::collections::HashMap;

use crate::deck::Word;

/// Labels of nodes or elements: each part, instance and the assembly has its own.
#[derive(Debug, Default)]
pub struct Labels {
    by_name: HashMap<(String, i64), usize>,
}

impl Labels {
    /// Index of a label in a scope (an upper-case instance name, or empty).
    pub fn find(&self, scope: &str, label: i64) -> Option<usize> {
        self.by_name.get(&(scope.to_owned(), label)).copied()
    }

    /// Sets a label; returns the index it had before.
    pub fn insert(&mut self, scope: &str, label: i64, index: usize) -> Option<usize> {
        self.by_name.insert((scope.to_owned(), label), index)
    }

    /// Index of a word: `12`, or `INSTANCE.12`.
    pub fn resolve(&self, scope: &str, word: &Word) -> Option<usize> {
        if let Ok(label) = word.text.parse::<i64>() {
            return self.find(scope, label);
        }
        let (instance, label) = word.text.rsplit_once('.')?;
        self.find(&upper(instance), label.parse().ok()?)
    }

    /// How many labels there are.
    pub fn len(&self) -> usize {
        self.by_name.len()
    }
}

/// Names are compared in upper case.
pub fn upper(text: &str) -> String {
    text.trim().to_uppercase()
}

/// A name as seen from a scope: `INSTANCE.NAME` inside an instance.
pub fn qualified(scope: &str, name: &str) -> String {
    if scope.is_empty() { upper(name) } else { format!("{scope}.{}", upper(name)) }
}

/// Place of each material among those of the deck, by its name; the first of a name.
pub(super) fn material_places(deck: &crate::deck::Deck) -> indexmap::IndexMap<String, usize> {
    let materials = deck.cards.iter().filter(|c| c.keyword.name == "MATERIAL");
    let mut places = indexmap::IndexMap::new();
    for (place, name) in materials.filter_map(|c| c.value("NAME")).enumerate() {
        places.entry(upper(&name.text)).or_insert(place);
    }
    places
}
