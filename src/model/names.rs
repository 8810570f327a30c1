//! Names: node and element labels by scope, sets, and how a word of a deck is looked up.
//! Never here: geometry.

use std::collections::HashMap;

use crate::deck::Word;

/// Labels of nodes or elements: each part, instance and the assembly has its own.
#[derive(Debug, Default)]
pub struct Labels {
    scopes: Vec<(String, Scope)>,
    places: HashMap<String, usize>,
    count: usize,
}

/// Labels of one scope. Most follow each other and are places in a list.
#[derive(Debug, Default)]
pub struct Scope {
    /// Index by label; [`NONE`] where there is none.
    dense: Vec<u32>,
    sparse: HashMap<i64, u32>,
    count: usize,
}

/// No index.
const NONE: u32 = u32::MAX;
/// A list has no more places than so many for each label, and these.
const PLACES: [usize; 2] = [4, 1000];

impl Scope {
    /// Index of a label.
    pub fn find(&self, label: i64) -> Option<usize> {
        let dense = usize::try_from(label).ok().and_then(|at| self.dense.get(at)).filter(|index| **index != NONE);
        dense.or_else(|| self.sparse.get(&label)).map(|index| *index as usize)
    }

    /// Returns the index before.
    fn insert(&mut self, label: i64, index: usize) -> Option<usize> {
        let before = self.find(label);
        // The budget of a deck is far below what the number takes.
        let index = u32::try_from(index).unwrap_or(NONE);
        let most = PLACES[0] * self.count + PLACES[1];
        match usize::try_from(label).ok().filter(|at| *at < most && !self.sparse.contains_key(&label)) {
            Some(at) => {
                if at >= self.dense.len() {
                    self.dense.resize(at + 1, NONE);
                }
                self.dense[at] = index;
            }
            None => drop(self.sparse.insert(label, index)),
        }
        self.count += usize::from(before.is_none());
        before
    }
}

impl Labels {
    /// Index of a label in a scope (an upper-case instance name, or empty).
    pub fn find(&self, scope: &str, label: i64) -> Option<usize> {
        self.scopes[self.place(scope)?].1.find(label)
    }

    /// The labels of a scope, for many questions.
    pub fn scope(&self, scope: &str) -> Option<&Scope> {
        self.place(scope).map(|place| &self.scopes[place].1)
    }

    /// Most questions are on the scope that came last: they need no hash.
    fn place(&self, scope: &str) -> Option<usize> {
        match self.scopes.last() {
            // To compare texts that are both empty takes long: a masked load from nowhere.
            Some((last, _)) if last.len() == scope.len() && (scope.is_empty() || last == scope) => {
                Some(self.scopes.len() - 1)
            }
            _ => self.places.get(scope).copied(),
        }
    }

    /// Sets a label; returns the index it had before.
    pub fn insert(&mut self, scope: &str, label: i64, index: usize) -> Option<usize> {
        let place = self.place(scope).unwrap_or_else(|| {
            self.scopes.push((scope.to_owned(), Scope::default()));
            self.places.insert(scope.to_owned(), self.scopes.len() - 1);
            self.scopes.len() - 1
        });
        let before = self.scopes[place].1.insert(label, index);
        self.count += usize::from(before.is_none());
        before
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
        self.count
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

/// Place of each card of a keyword among those of the deck, by its `NAME`; the first of a name.
pub(super) fn places(deck: &crate::deck::Deck, keyword: &str) -> indexmap::IndexMap<String, usize> {
    let cards = deck.cards.iter().filter(|c| c.keyword.name == keyword);
    let mut places = indexmap::IndexMap::new();
    for (place, name) in cards.filter_map(|c| c.value("NAME")).enumerate() {
        places.entry(upper(&name.text)).or_insert(place);
    }
    places
}

#[cfg(test)]
mod tests {
    use super::Labels;

    #[test]
    fn labels_are_found_wherever_they_lie() {
        let mut labels = Labels::default();
        let all = [1, 2, 999, 1000, 5000, -7, i64::MAX, 3, 1001, 5001];
        for (i, label) in all.into_iter().enumerate() {
            assert_eq!((labels.find("A", label), labels.insert("A", label, i)), (None, None), "{label}");
        }
        // By now 5000 would have a place in the list; it stays where it is.
        for label in 10_000..20_000 {
            labels.insert("A", label, 7);
        }
        assert_eq!((labels.insert("A", 5000, 44), labels.find("A", 5000)), (Some(4), Some(44)));
        for (i, label) in all.into_iter().enumerate().filter(|(i, _)| *i != 4) {
            assert_eq!(labels.find("A", label), Some(i), "{label}");
        }
        assert_eq!((labels.find("B", 1), labels.find("A", 4), labels.len()), (None, None, 10_010));
    }
}
