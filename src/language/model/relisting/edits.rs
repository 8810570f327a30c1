//! Changes of the text of a deck that make it refer to its refined or coarsened mesh.

use std::collections::BTreeMap;

use indexmap::IndexMap;

use crate::model::names::qualified;
use crate::model::types::{MemberSet, Model};

/// Kind of a new set.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum NewSetKind {
    /// Nodes.
    Nodes,
    /// Nodes in a given order.
    OrderedNodes,
    /// Elements.
    Elements,
}

/// Condition under which a replacement applies.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum EditCondition {
    /// No condition.
    Always,
    /// History output reduces the element set of this name to one element.
    IfReduced(String),
    /// History output does not reduce the element set of this name.
    UnlessReduced(String),
}

/// A text in place of a word of the deck.
#[derive(Clone, Debug)]
pub struct Replacement {
    /// Byte after the replaced word.
    pub end: u32,
    /// New text.
    pub text: String,
    /// When the replacement applies.
    pub condition: EditCondition,
}

/// Place of a change: scope, file, and first byte.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct EditPlace {
    pub scope: String,
    pub file: u32,
    pub start: u32,
}

/// Changes of the text of a deck.
#[derive(Debug, Default)]
pub struct DeckEdits {
    /// Node sets of the mesh before other cards are read.
    pub node_sets: IndexMap<String, MemberSet>,
    /// Element sets of the mesh before other cards are read.
    pub element_sets: IndexMap<String, MemberSet>,
    /// Replaced words.
    pub replaced: BTreeMap<EditPlace, Replacement>,
    /// Texts after a position.
    pub added: BTreeMap<EditPlace, String>,
    /// Words whose lines are removed.
    pub removed: Vec<EditPlace>,
    /// New sets by scope, kind and name.
    pub sets: IndexMap<(String, NewSetKind, String), Vec<usize>>,
    /// Cards at the end of the model data.
    pub tail: String,
}

impl DeckEdits {
    /// Creates an empty list of changes of a deck with a given mesh.
    pub fn of(model: &Model) -> DeckEdits {
        let (node_sets, element_sets) = (model.node_sets.clone(), model.element_sets.clone());
        DeckEdits { node_sets, element_sets, ..DeckEdits::default() }
    }

    /// Returns the name of a new set with given members, which is added if it does not exist.
    pub fn set(&mut self, scope: &str, kind: NewSetKind, base: &str, members: &[usize]) -> String {
        let known = if kind == NewSetKind::Elements { &self.element_sets } else { &self.node_sets };
        let (mut name, mut count) = (base.to_owned(), 1);
        loop {
            let other = self.sets.get(&(scope.to_owned(), kind, name.clone()));
            if other.map_or(!known.contains_key(&qualified(scope, &name)), |other| other == members) {
                break;
            }
            count += 1;
            name = format!("{base}-{count}");
        }
        self.sets.entry((scope.to_owned(), kind, name.clone())).or_insert_with(|| members.to_vec());
        name
    }
}
