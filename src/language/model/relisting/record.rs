//! Records the changes of a deck while the cards that refer to its mesh are read.

use std::fmt::Write as _;

use super::edits::{EditCondition, EditPlace, NewSetKind, Replacement};
use super::listing::quoted;
use crate::deck::{Span, Word};
use crate::model::context::Context;
use crate::model::names::upper;
use crate::model::types::ElementSide;

/// Returns a set name made from a word of the deck and an ending.
fn derived_name(word: &Word, kind: NewSetKind, ending: &str) -> String {
    let base = upper(&word.text).replace('.', "-");
    let base = match kind {
        NewSetKind::Elements if base.starts_with(|c: char| c.is_ascii_digit()) => format!("ELEMENT-{base}"),
        _ if base.starts_with(|c: char| c.is_ascii_digit()) => format!("NODE-{base}"),
        _ => base,
    };
    format!("{base}-{ending}")
}

impl Context<'_> {
    fn edit_place(&self, file: u32, start: u32) -> EditPlace {
        EditPlace { scope: self.scope.clone(), file, start }
    }

    /// Replaces a word by the name of a new set with given members.
    fn replace_by_set(&mut self, word: &Word, (kind, name): (NewSetKind, &str), members: &[usize], on: EditCondition) {
        let Some(edits) = &mut self.scaling.edits else { return };
        let name = edits.set(&self.scope, kind, name, members);
        self.replace_word(word, name, on);
    }

    fn replace_word(&mut self, word: &Word, text: String, condition: EditCondition) {
        let word_start = self.edit_place(word.span.file, word.span.start);
        let Some(edits) = &mut self.scaling.edits else { return };
        edits.replaced.insert(word_start, Replacement { end: word.span.end, text: quoted(&text), condition });
    }

    /// Records a number that depends on the size of elements.
    pub(in crate::model) fn edit_number(&mut self, word: &Word, value: f64) {
        self.replace_word(word, format!("{value:e}"), EditCondition::Always);
    }

    /// Records a reference to elements by a set name or a label.
    pub(in crate::model) fn edit_elements(&mut self, word: &Word, members: &[usize], is_label: bool) {
        let Some(first) = members.first().filter(|_| self.scaling.edits.is_some()) else { return };
        let elements = NewSetKind::Elements;
        if is_label {
            let name = self.model.mesh.elements[*first].name.to_string();
            match members {
                [_] if self.names_of(word).contains(&name) => {}
                [_] if !self.scope.is_empty() => {
                    let label = name.rsplit('.').next().unwrap_or_default().to_owned();
                    self.replace_word(word, label, EditCondition::Always);
                }
                [_] => self.replace_word(word, name, EditCondition::Always),
                _ => {
                    let name = derived_name(word, elements, "PARTS");
                    self.replace_by_set(word, (elements, &name), members, EditCondition::Always);
                }
            }
        } else if self
            .scaling
            .refined
            .as_ref()
            .is_some_and(|refined| members.len() > 1 && refined.has_one_parent(members))
        {
            let mut names = self.names_of(word).into_iter();
            let Some(key) = names.find(|name| self.model.element_sets.contains_key(name)) else { return };
            let name = derived_name(word, elements, "PARTS");
            self.replace_by_set(word, (elements, &name), members, EditCondition::IfReduced(key));
        }
    }

    /// Records a reference to elements by an output request, for which history output may reduce the set `key`.
    pub(in crate::model) fn edit_output_elements(&mut self, word: &Word, key: &str) {
        let word_start = self.edit_place(word.span.file, word.span.start);
        let Some(edits) = &mut self.scaling.edits else { return };
        let Some(known) = edits.replaced.get_mut(&word_start) else { return };
        match known.condition {
            EditCondition::IfReduced(_) => drop(edits.replaced.remove(&word_start)),
            _ => known.condition = EditCondition::UnlessReduced(key.to_owned()),
        }
    }

    /// Records the elements of a side of a set: those whose side is on the side of an element of the deck.
    pub(in crate::model) fn edit_sides(&mut self, word: &Word, side: &Word, faces: &[(usize, ElementSide)]) {
        let is_face = |face: &(usize, ElementSide)| matches!(face.1, ElementSide::Face(_));
        if self.scaling.edits.is_none() || self.scaling.refined.is_none() || !faces.iter().all(is_face) {
            return;
        }
        let mut elements: Vec<usize> = faces.iter().map(|face| face.0).collect();
        elements.dedup();
        let name = derived_name(word, NewSetKind::Elements, &upper(&side.text));
        self.replace_by_set(word, (NewSetKind::Elements, &name), &elements, EditCondition::Always);
    }

    /// Records a reference to the nodes of a set that the deck defines, without new nodes.
    pub(in crate::model) fn edit_nodes(&mut self, word: &Word, nodes: &[usize], is_ordered: bool) {
        let (kind, ending) =
            if is_ordered { (NewSetKind::OrderedNodes, "ORDERED") } else { (NewSetKind::Nodes, "ORIGINAL") };
        let name = derived_name(word, kind, ending);
        self.replace_by_set(word, (kind, &name), nodes, EditCondition::Always);
    }

    /// Records a data line after the line at `after`, with new nodes in its first field.
    pub(in crate::model) fn add_node_line(&mut self, after: Span, nodes: &[usize], rest: &str) {
        let line_end = self.edit_place(after.file, after.end);
        let Some(edits) = &mut self.scaling.edits else { return };
        let name = edits.set(&self.scope, NewSetKind::Nodes, &format!("NEW-NODES-{}", edits.sets.len() + 1), nodes);
        let text = edits.added.entry(line_end).or_default();
        let _ = write!(text, "\n {name},{rest}");
    }

    /// Records a parameter of the current keyword line.
    pub(in crate::model) fn add_parameter(&mut self, keyword: Span, text: &str) {
        let line_end = self.edit_place(keyword.file, keyword.end);
        let Some(edits) = &mut self.scaling.edits else { return };
        edits.added.insert(line_end, format!(", {text}"));
    }

    /// Records that the line of a word refers to removed nodes only.
    pub(in crate::model) fn remove_line(&mut self, word: &Word) {
        let word_start = self.edit_place(word.span.file, word.span.start);
        self.scaling.edits.iter_mut().for_each(|edits| edits.removed.push(word_start.clone()));
    }

    /// Records a card at the end of the model data.
    pub(in crate::model) fn add_card(&mut self, card: &str) {
        self.scaling.edits.iter_mut().for_each(|edits| edits.tail.push_str(card));
    }
}
