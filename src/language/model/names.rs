//! Labels of nodes and elements by scope, and lookup of names.

use std::collections::HashMap;

use crate::deck::{Span, Word};

/// Labels of nodes or of elements. Each part, each instance and the assembly is a scope.
#[derive(Debug, Default)]
pub struct LabelTable {
    scopes: Vec<(String, ScopeLabels)>,
    places: HashMap<String, usize>,
    count: usize,
    pub duplicates: Vec<DuplicateLabel>,
}

/// A label that was defined twice.
#[derive(Debug)]
pub struct DuplicateLabel {
    pub label: i64,
    pub first: Span,
    pub second: Span,
}

/// Labels of one scope. Mostly consecutive labels are indices of a list; others are hashed.
#[derive(Debug, Default)]
pub struct ScopeLabels {
    /// Index by label, or [`NONE`].
    dense: Vec<u32>,
    sparse: HashMap<i64, u32>,
    count: usize,
}

/// Marks unused labels.
const NONE: u32 = u32::MAX;
/// Limit of the list length: a number per label, plus a constant.
const LIST_LIMIT: [usize; 2] = [4, 1000];

impl ScopeLabels {
    /// Returns the index of a label.
    pub fn find(&self, label: i64) -> Option<usize> {
        let dense = usize::try_from(label).ok().and_then(|at| self.dense.get(at)).filter(|index| **index != NONE);
        dense.or_else(|| self.sparse.get(&label)).map(|index| *index as usize)
    }

    /// Returns the largest label; 0 if there are none.
    pub fn largest(&self) -> i64 {
        let dense = self.dense.iter().rposition(|index| *index != NONE).map_or(0, |label| label as i64);
        self.sparse.keys().copied().fold(dense, i64::max)
    }

    /// Sets the index of a label; returns the previous one.
    fn insert(&mut self, label: i64, index: usize) -> Option<usize> {
        let previous = self.find(label);
        // The size limit of a model is far below the range of u32.
        let index = u32::try_from(index).unwrap_or(NONE);
        let limit = LIST_LIMIT[0] * self.count + LIST_LIMIT[1];
        match usize::try_from(label).ok().filter(|at| *at < limit && !self.sparse.contains_key(&label)) {
            Some(at) => {
                if at >= self.dense.len() {
                    self.dense.resize(at + 1, NONE);
                }
                self.dense[at] = index;
            }
            None => drop(self.sparse.insert(label, index)),
        }
        self.count += usize::from(previous.is_none());
        previous
    }
}

impl LabelTable {
    /// Returns the index of a label in a scope, an upper-case instance name or empty.
    pub fn find(&self, scope: &str, label: i64) -> Option<usize> {
        self.scopes[self.place(scope)?].1.find(label)
    }

    /// Returns the labels of a scope, for repeated lookups.
    pub fn scope(&self, scope: &str) -> Option<&ScopeLabels> {
        self.place(scope).map(|place| &self.scopes[place].1)
    }

    /// Returns the position of a scope. The last scope is the most frequent and needs no hash.
    fn place(&self, scope: &str) -> Option<usize> {
        match self.scopes.last() {
            // The test of emptiness is faster than the comparison of two empty texts.
            Some((last, _)) if last.len() == scope.len() && (scope.is_empty() || last == scope) => {
                Some(self.scopes.len() - 1)
            }
            _ => self.places.get(scope).copied(),
        }
    }

    /// Sets the index of a label; returns the previous one.
    pub fn insert(&mut self, scope: &str, label: i64, index: usize) -> Option<usize> {
        let scope_index = self.place(scope).unwrap_or_else(|| {
            self.scopes.push((scope.to_owned(), ScopeLabels::default()));
            self.places.insert(scope.to_owned(), self.scopes.len() - 1);
            self.scopes.len() - 1
        });
        let previous = self.scopes[scope_index].1.insert(label, index);
        self.count += usize::from(previous.is_none());
        previous
    }

    /// Returns the index of a label given as `12` or `INSTANCE.12`.
    pub fn resolve(&self, scope: &str, word: &Word) -> Option<usize> {
        if let Ok(label) = word.text.parse::<i64>() {
            return self.find(scope, label);
        }
        let (instance, label) = word.text.rsplit_once('.')?;
        self.find(&upper(instance), label.parse().ok()?)
    }

    /// Returns the number of labels.
    pub fn len(&self) -> usize {
        self.count
    }
}

/// Kind of the members of a set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SetKind {
    Nodes,
    Elements,
}

/// Converts a name to upper case, in which names are compared.
pub fn upper(text: &str) -> String {
    text.trim().to_uppercase()
}

/// Returns a name in a scope: `INSTANCE.NAME` in an instance.
pub fn qualified(scope: &str, name: &str) -> String {
    if scope.is_empty() { upper(name) } else { format!("{scope}.{}", upper(name)) }
}

/// Returns the ordinal of each card of a keyword by its upper-case `NAME`; the first one for duplicate names.
pub fn places(deck: &crate::deck::Deck, keyword: &str) -> indexmap::IndexMap<String, usize> {
    let cards = deck.cards.iter().filter(|c| c.keyword.name == keyword);
    let mut places = indexmap::IndexMap::new();
    for (place, name) in cards.filter_map(|c| c.value("NAME")).enumerate() {
        places.entry(upper(&name.text)).or_insert(place);
    }
    places
}

#[cfg(test)]
mod tests {
    use super::LabelTable;

    #[test]
    fn dense_and_sparse_labels_are_found() {
        let mut labels = LabelTable::default();
        let numbers = [1, 2, 999, 1000, 5000, -7, i64::MAX, 3, 1001, 5001];
        for (i, label) in numbers.into_iter().enumerate() {
            assert_eq!((labels.find("A", label), labels.insert("A", label, i)), (None, None), "{label}");
        }
        // The list could hold 5000 now, but its entry remains in the hash map.
        for label in 10_000..20_000 {
            labels.insert("A", label, 7);
        }
        assert_eq!((labels.insert("A", 5000, 44), labels.find("A", 5000)), (Some(4), Some(44)));
        for (i, label) in numbers.into_iter().enumerate().filter(|(i, _)| *i != 4) {
            assert_eq!(labels.find("A", label), Some(i), "{label}");
        }
        assert_eq!((labels.find("B", 1), labels.find("A", 4), labels.len()), (None, None, 10_010));
    }
}
