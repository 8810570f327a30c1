//! Cards that list the nodes, elements and sets of a mesh.

use std::fmt::Write as _;

use super::ListedMesh;
use super::edits::{EditCondition, NewSetKind};
use crate::model::types::{Element, ElementKind};

/// Number of labels on a line.
const PER_LINE: usize = 16;

/// Splits the name of a node or element into scope and label.
fn split(name: &str) -> (&str, &str) {
    name.rsplit_once('.').unwrap_or(("", name))
}

/// Returns a name in quotes if a keyword line requires it.
pub fn quoted(name: &str) -> String {
    if name.contains([' ', ',', '=']) { format!("\"{name}\"") } else { name.to_owned() }
}

/// Returns nodes in the order of ABAQUS: corners, then midside nodes.
fn corners_first(element: &Element) -> Vec<usize> {
    match (element.kind, &element.nodes[..]) {
        (ElementKind::Cax6m, &[a, ab, b, bc, c, ca]) => vec![a, b, c, ab, bc, ca],
        (_, nodes) => nodes.to_vec(),
    }
}

impl ListedMesh {
    /// Returns the cards of the nodes, elements and sets of a scope: an instance, or the whole deck.
    pub fn cards(&self, scope: &str, instances: &[String]) -> String {
        let mut text = self.nodes(scope);
        self.elements(scope, &mut text);
        let split_key = |key: &str| match key.split_once('.') {
            Some((inner, name)) if instances.iter().any(|i| i == inner) => (inner.to_owned(), name.to_owned()),
            _ => (String::new(), key.to_owned()),
        };
        for (key, set) in &self.edits.node_sets {
            let (inner, name) = split_key(key);
            if inner == scope {
                self.set(scope, (NewSetKind::Nodes, &name), &set.members, &mut text);
            }
        }
        for (key, set) in &self.edits.element_sets {
            let (inner, name) = split_key(key);
            if inner == scope {
                let reduced = self.model.element_sets.get(key).filter(|_| self.is_reduced(key));
                self.set(scope, (NewSetKind::Elements, &name), &reduced.unwrap_or(set).members, &mut text);
            }
        }
        for ((inner, kind, name), members) in &self.edits.sets {
            if inner == scope && self.is_used(scope, name) {
                self.set(scope, (*kind, name), members, &mut text);
            }
        }
        text
    }

    /// Returns whether history output has reduced an element set to one element.
    fn is_reduced(&self, key: &str) -> bool {
        let count_before = self.edits.element_sets.get(key).map_or(usize::MAX, |set| set.members.len());
        self.model.element_sets.get(key).is_some_and(|set| set.members.len() < count_before)
    }

    /// Returns whether the condition of a replacement holds.
    pub fn applies(&self, condition: &EditCondition) -> bool {
        match condition {
            EditCondition::Always => true,
            EditCondition::IfReduced(key) => self.is_reduced(key),
            EditCondition::UnlessReduced(key) => self.model.element_sets.get(key).is_none_or(|s| s.members.len() > 1),
        }
    }

    /// Returns whether a new set occurs in the text.
    fn is_used(&self, scope: &str, name: &str) -> bool {
        let mut uses =
            self.edits.replaced.iter().filter(|(place, edit)| place.scope == scope && edit.text == quoted(name));
        let is_unused = |edit: &super::edits::Replacement| !self.applies(&edit.condition);
        let mut are_unused = uses.by_ref().map(|(_, edit)| is_unused(edit)).peekable();
        are_unused.peek().is_none() || are_unused.any(|is_unused| !is_unused)
    }

    fn nodes(&self, scope: &str) -> String {
        let mut text = String::new();
        let mesh = &self.model.mesh;
        for (node, (name, [r, z])) in mesh.node_names.iter().zip(&mesh.points).enumerate() {
            let (inner, label) = split(name);
            if inner != scope || self.is_removed.get(node) == Some(&true) {
                continue;
            }
            if text.is_empty() {
                text.push_str("*Node\n");
            }
            let _ = writeln!(text, " {label}, {r:?}, {z:?}");
        }
        text
    }

    fn elements(&self, scope: &str, text: &mut String) {
        let mesh = &self.model.mesh;
        let mut kind = None;
        for element in &mesh.elements {
            let (inner, label) = split(&element.name);
            if inner != scope {
                continue;
            }
            if kind != Some(element.kind) {
                let _ = writeln!(text, "*Element, type={}", element.kind.name());
                kind = Some(element.kind);
            }
            let _ = write!(text, " {label}");
            for node in corners_first(element) {
                let name = &mesh.node_names[node];
                let (inner, label) = split(name);
                let _ = write!(text, ", {}", if inner == scope { label } else { name });
            }
            text.push('\n');
        }
    }

    /// Adds the cards of a set: one for each group of members in the same instance.
    fn set(&self, scope: &str, (kind, name): (NewSetKind, &str), members: &[usize], text: &mut String) {
        let mesh = &self.model.mesh;
        let name_of = |&member: &usize| match kind {
            NewSetKind::Elements => split(&mesh.elements[member].name),
            NewSetKind::Nodes | NewSetKind::OrderedNodes => split(&mesh.node_names[member]),
        };
        for group in members.chunk_by(|a, b| name_of(a).0 == name_of(b).0) {
            let (inner, _) = name_of(&group[0]);
            let keyword = if kind == NewSetKind::Elements { "Elset, elset" } else { "Nset, nset" };
            let _ = write!(text, "*{keyword}={}", quoted(name));
            if inner != scope {
                let _ = write!(text, ", instance={}", quoted(inner));
            }
            text.push_str(if kind == NewSetKind::OrderedNodes { ", unsorted\n" } else { "\n" });
            for line in group.chunks(PER_LINE) {
                let labels: Vec<&str> = line.iter().map(|member| name_of(member).1).collect();
                let _ = writeln!(text, " {},", labels.join(", "));
            }
        }
    }
}
