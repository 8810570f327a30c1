//! `*NSET` and `*ELSET`. A set that is defined again is extended.

use super::budget::BudgetedItem;
use super::builder::ModelBuilder;
use super::names::{qualified, upper};
use super::refinement::pass::ReadPass;
use super::types::MemberSet;
use crate::deck::rows::words;
use crate::deck::{Card, DataLine, Diagnostic, Span};

impl ModelBuilder<'_> {
    pub(super) fn nset(&mut self, card: &Card) {
        let Some(name) = self.required(card, "NSET") else { return };
        let outer = self.enter_instance(card);
        let mut members = self.members(card, true);
        if let Some(elements) = card.value("ELSET") {
            let elements = self.element_members(elements).unwrap_or_default();
            members.extend(elements.iter().flat_map(|&element| &self.model.mesh.elements[element].nodes));
            if self.pass == ReadPass::Mesh {
                self.regions.push((qualified(&outer, &name.text), elements));
            }
        }
        self.scope = outer;
        if card.has("UNSORTED") || self.unsorted.contains_key(&qualified(&self.scope, &name.text)) {
            self.unsorted.entry(qualified(&self.scope, &name.text)).or_default().extend(&members);
        }
        self.add_node_set(&name.text, members, card.span);
    }

    pub(super) fn elset(&mut self, card: &Card) {
        let Some(name) = self.required(card, "ELSET") else { return };
        let outer = self.enter_instance(card);
        let members = self.members(card, false);
        self.scope = outer;
        self.add_element_set(&name.text, members, card.span);
    }

    /// Enters the scope of `INSTANCE=` and returns the previous scope.
    fn enter_instance(&mut self, card: &Card) -> String {
        if let Some(word) = card.value("INSTANCE").filter(|word| !self.instances.contains(&upper(&word.text))) {
            let word = word.clone();
            self.unknown("M115", "instance", &word, |builder| builder.instances.iter().cloned().collect());
        }
        let inner = card.value("INSTANCE").map_or_else(|| self.scope.clone(), |w| upper(&w.text));
        std::mem::replace(&mut self.scope, inner)
    }

    fn members(&mut self, card: &Card, nodes: bool) -> Vec<usize> {
        let mut members = Vec::new();
        let sources = &self.deck.sources;
        let mut name = String::new();
        for row in &card.rows {
            if card.has("GENERATE") {
                self.generated(&row.line(sources), nodes, &mut members);
                continue;
            }
            let before = members.len();
            if row.text(sources).is_some_and(|text| self.labels(text, nodes, &mut name, &mut members)) {
                continue;
            }
            members.truncate(before);
            for word in row.line(sources).fields.iter().filter(|w| !w.text.is_empty()) {
                let found = if nodes { self.node_members(word) } else { self.element_members(word) };
                members.extend(found.unwrap_or_default());
            }
        }
        members
    }

    /// Adds the labels of a line to a set; `false` if the line also has set names. `name` is a buffer.
    fn labels(&self, text: &str, nodes: bool, name: &mut String, members: &mut Vec<usize>) -> bool {
        let (labels, sets) = match nodes {
            true => (&self.nodes, &self.model.node_sets),
            false => (&self.elements, &self.model.element_sets),
        };
        let Some(scope) = labels.scope(&self.scope) else { return false };
        let is_set = |word: &str, name: &mut String| {
            name.clear();
            name.extend([&self.scope, ".", word]);
            sets.contains_key(word) || !self.scope.is_empty() && sets.contains_key(name)
        };
        words(text).all(|word| {
            let found = word.parse().ok().and_then(|label| scope.find(label)).filter(|_| !is_set(word, name));
            members.extend(found);
            found.is_some()
        })
    }

    fn generated(&mut self, line: &DataLine, nodes: bool, members: &mut Vec<usize>) {
        let (Some(first), Some(last)) =
            (self.integer(line, 0, "the first label"), self.integer(line, 1, "the last label"))
        else {
            return;
        };
        let step = line.field(2).map_or(Some(1), |w| w.integer(&mut self.diagnostics));
        let Some(step) = step.filter(|s| *s > 0) else {
            return self.out_of_range(line.span, "the increment must be a positive integer");
        };
        let count = (i128::from(last) - i128::from(first)) / i128::from(step) + 1;
        if !self.fits_budget(BudgetedItem::Members, count.max(0).unsigned_abs(), line.span) {
            return;
        }
        let labels = if nodes { &self.nodes } else { &self.elements };
        let before = members.len();
        let lost = self.missing.everything || if nodes { self.missing.nodes } else { self.missing.elements };
        members.extend((0..count.max(0)).filter_map(|i| labels.find(&self.scope, first + step * i as i64)));
        if lost {
            return;
        }
        let missing = count.max(0) - (members.len() - before) as i128;
        if members.len() == before {
            let message = format!("no label from {first} to {last} in increments of {step} is defined");
            self.diagnostics.push(Diagnostic::error("M110", message).at(line.span, "empty range"));
        } else if missing > 0 || (last - first) % step != 0 {
            let what = if nodes { "nodes" } else { "elements" };
            let message = match missing {
                0 => format!("{last} is not reached from {first} in increments of {step}"),
                _ => {
                    format!(
                        "{missing} of the {count} {what} from {first} to {last} \
                             in increments of {step} are not defined"
                    )
                }
            };
            let diagnostic = Diagnostic::warning("M166", message).at(line.span, "the set has the other members");
            self.diagnostics.push(diagnostic.help("give existing first and last labels"));
        }
    }

    pub(super) fn add_node_set(&mut self, name: &str, members: Vec<usize>, span: Span) {
        let name = qualified(&self.scope, name);
        unite(self.model.node_sets.entry(name).or_insert_with(|| MemberSet { members: Vec::new(), span }), members);
    }

    pub(super) fn add_element_set(&mut self, name: &str, members: Vec<usize>, span: Span) {
        let name = qualified(&self.scope, name);
        unite(self.model.element_sets.entry(name).or_insert_with(|| MemberSet { members: Vec::new(), span }), members);
    }
}

/// Adds members; cards that extend a set in ascending order cost no sorting of the members before.
fn unite(set: &mut MemberSet, members: Vec<usize>) {
    let last = set.members.last().copied();
    let continues =
        members.is_sorted_by(|a, b| a < b) && last.is_none_or(|last| members.first().is_none_or(|m| *m > last));
    set.members.extend(members);
    if !continues {
        set.members.sort_unstable();
        set.members.dedup();
    }
}
