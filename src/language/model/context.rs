//! What all readers of cards share: the deck, the model that grows, diagnostics, labels and names. The methods report
//! missing, invalid and unknown input, and find materials, nodes, elements and surfaces by name.

use std::sync::Arc;

use indexmap::IndexMap;

use super::budget::{BudgetedItem, SizeBudget};
use super::coarsening::mesh::CoarsenedMesh;
use super::faults::ValueCheck;
use super::lost::MissingDefinitions;
use super::named_clearances::named_clearances;
use super::names::{LabelTable, SetKind, places, qualified, upper};
use super::refinement::curves::EdgeCurves;
use super::refinement::mesh::{NodePair, RefinedMesh};
use super::refinement::pass::ReadPass;
use super::relisting::edits::DeckEdits;
use super::types::{
    IgnoredCard, MaterialDefinition, MaterialId, MemberSet, Model, ModelOrigin, PrescribedClearance, SurfaceId,
};
use crate::deck::names::nearest;
use crate::deck::{Card, DataLine, Deck, Diagnostic, Diagnostics, Span, Word};
use crate::kernel::lists::sorted_unique;

/// Largest number of nodes, elements or set members that one card may generate.
pub const MAX_GENERATED: usize = 20_000_000;

/// Number of unknown names for which similar names are suggested.
const SUGGESTIONS: usize = 20;

/// State that all readers of cards share.
pub struct Context<'a> {
    pub deck: &'a Deck,
    pub model: Model,
    pub diagnostics: Diagnostics,
    /// Definitions that are missing because of reported errors.
    pub missing: MissingDefinitions,
    pub nodes: LabelTable,
    pub elements: LabelTable,
    /// Scope of labels and set names: an instance name, or empty.
    pub scope: String,
    pub names: DefinitionNames,
    /// Size of the model so far.
    pub budget: SizeBudget,
    pub scaling: ScalingState,
}

/// Definitions by upper-case name: their index, or their value. Cards may refer to them before they are read.
#[derive(Default)]
pub struct DefinitionNames {
    pub materials: IndexMap<String, usize>,
    pub interactions: IndexMap<String, usize>,
    /// Amplitudes that have been read.
    pub amplitudes: IndexMap<String, usize>,
    /// Initial clearances of general contact.
    pub clearances: IndexMap<String, PrescribedClearance>,
    /// Names of surface interactions that contact refers to.
    pub interactions_used: Vec<Word>,
}

/// Refinement or coarsening of the mesh.
#[derive(Default)]
pub struct ScalingState {
    /// Cards that are read at present.
    pub pass: ReadPass,
    /// Curved edges, and the refined mesh after the cards of the mesh are read.
    pub curves: EdgeCurves,
    pub refined: Option<RefinedMesh>,
    /// The coarsened mesh after the cards of the mesh are read.
    pub coarsened: Option<CoarsenedMesh>,
    /// Names of node sets, and elements whose nodes they contain, for a refined mesh.
    pub regions: Vec<(String, Vec<usize>)>,
    /// Pairs of nodes that `*MPC` links, for a refined mesh.
    pub linked_pairs: Vec<NodePair>,
    /// Changes of the text for the refined or coarsened mesh, if the deck is to be written.
    pub edits: Option<Box<DeckEdits>>,
}

impl<'a> Context<'a> {
    pub fn new(deck: &'a Deck) -> Self {
        let origin = ModelOrigin {
            sources: Arc::clone(&deck.sources),
            last_card: deck.cards.last().map(|card| card.span),
            ..ModelOrigin::default()
        };
        Context {
            deck,
            model: Model { origin, ..Model::default() },
            diagnostics: Diagnostics::default(),
            missing: MissingDefinitions::from_deck(deck),
            nodes: LabelTable::default(),
            elements: LabelTable::default(),
            scope: String::new(),
            names: DefinitionNames {
                materials: places(deck, "MATERIAL"),
                interactions: places(deck, "SURFACE INTERACTION"),
                clearances: named_clearances(deck),
                ..DefinitionNames::default()
            },
            budget: SizeBudget::default(),
            scaling: ScalingState::default(),
        }
    }

    /// Lists a card as ignored.
    pub fn inert(&mut self, card: &Card, why: &str) {
        self.ignore(card.keyword.name, card.span, why);
    }

    /// Lists input as ignored.
    pub fn ignore(&mut self, keyword: impl Into<String>, span: Span, why: &str) {
        self.model.origin.inert.push(IgnoredCard { keyword: keyword.into(), span, why: why.into() });
    }

    /// Returns the value of a required parameter; reports an error if it is missing.
    pub fn required<'c>(&mut self, card: &'c Card, name: &str) -> Option<&'c Word> {
        let value = card.value(name);
        if value.is_none() && !card.faulty {
            let message = format!("*{} requires {name}=", card.keyword.name);
            self.error("M101", message, card.span, format!("{name}= is missing"));
        }
        value
    }

    pub fn first_line<'c>(&mut self, card: &'c Card) -> Option<&'c DataLine> {
        let line = card.lines.first();
        if line.is_none() {
            let message = format!("*{} requires a data line", card.keyword.name);
            self.error("M107", message, card.span, "data line missing");
        }
        line
    }

    /// Returns the number in a required field; reports an error if it is missing.
    pub fn number(&mut self, line: &DataLine, index: usize, what: &str) -> Option<f64> {
        self.required_field(line, index, what)?.number(&mut self.diagnostics)
    }

    fn required_field<'l>(&mut self, line: &'l DataLine, index: usize, what: &str) -> Option<&'l Word> {
        let word = line.field(index);
        if word.is_none() {
            let label = format!("field {} should be {what}", index + 1);
            self.error("M102", format!("{what} is missing"), line.span, label);
        }
        word
    }

    /// Returns the number in an optional field.
    pub fn number_or(&mut self, line: &DataLine, index: usize, default: f64) -> Option<f64> {
        line.field(index).map_or(Some(default), |w| w.number(&mut self.diagnostics))
    }

    /// Returns the numbers in optional fields from `first` on.
    pub fn numbers_or<const N: usize>(&mut self, line: &DataLine, first: usize, default: f64) -> Option<[f64; N]> {
        let mut numbers = [default; N];
        for (index, number) in numbers.iter_mut().enumerate() {
            *number = self.number_or(line, first + index, default)?;
        }
        Some(numbers)
    }

    /// Returns what an optional word names; `None` if `find` reports that it is unknown.
    pub fn optional<T>(
        &mut self,
        word: Option<&Word>,
        find: impl FnOnce(&mut Self, &Word) -> Option<T>,
    ) -> Option<Option<T>> {
        word.map_or(Some(None), |word| find(self, word).map(Some))
    }

    /// Returns the names that a word of the deck may mean, in upper case: in the current scope, and in the whole deck.
    pub fn names_of(&self, word: &Word) -> [String; 2] {
        [qualified(&self.scope, &word.text), upper(&word.text)]
    }

    /// Returns the integer in a required field; reports an error if it is missing.
    pub fn integer(&mut self, line: &DataLine, index: usize, what: &str) -> Option<i64> {
        self.required_field(line, index, what)?.integer(&mut self.diagnostics)
    }

    /// Reports an error with a label.
    pub fn error(&mut self, code: &'static str, message: impl Into<String>, span: Span, label: impl Into<String>) {
        self.diagnostics.push(Diagnostic::error(code, message).at(span, label));
    }

    /// Reports a card that does not follow the card that it needs.
    pub fn misplaced(&mut self, card: &Card, message: impl Into<String>, missing: &str) {
        self.error("M105", message, card.span, format!("no *{missing} before"));
    }

    pub fn out_of_range(&mut self, span: Span, message: impl Into<String>) {
        self.error("M103", message, span, "here");
    }

    /// Reports the fault of a card that a check has found. Returns whether there is none.
    pub fn accepts(&mut self, card: &Card, check: ValueCheck) -> bool {
        let line = check.as_ref().err().and_then(|fault| card.lines.get(fault.line?));
        self.accepts_at(line.map_or(card.span, |line| line.span), check)
    }

    /// Reports a fault at a place. Returns whether there is none.
    pub fn accepts_at(&mut self, span: Span, check: ValueCheck) -> bool {
        check.map_err(|fault| self.diagnostics.push(fault.at("", span))).is_ok()
    }

    /// Issues a warning with a label and a help text.
    pub fn warning(&mut self, code: &'static str, message: impl Into<String>, span: Span, label: &str, help: &str) {
        self.diagnostics.push(Diagnostic::warning(code, message).at(span, label).help(help));
    }

    /// Warns of a definition that replaces an earlier one.
    pub fn warn_replaced(&mut self, message: impl Into<String>, [earlier, later]: [Span; 2]) {
        let diagnostic = Diagnostic::warning("M160", message).at(later, "second definition");
        self.diagnostics.push(diagnostic.at(earlier, "has no effect").help("remove one definition"));
    }

    /// Refuses a definition because of an earlier one.
    pub fn refuse_second(&mut self, message: impl Into<String>, [earlier, later]: [Span; 2]) {
        let diagnostic = Diagnostic::error("M160", message).at(later, "second definition");
        self.diagnostics.push(diagnostic.at(earlier, "first definition").help("remove one definition"));
    }

    pub fn unsupported(&mut self, span: Span, message: impl Into<String>, help: &str) {
        let diagnostic = Diagnostic::error("M104", message).at(span, "not supported");
        self.diagnostics.push(if help.is_empty() { diagnostic } else { diagnostic.help(help) });
    }

    /// Reports a value out of range and returns `None`.
    pub fn refuse_value<T>(&mut self, span: Span, message: impl Into<String>) -> Option<T> {
        self.out_of_range(span, message);
        None
    }

    /// Reports unsupported input and returns `None`.
    pub fn refuse_unsupported<T>(&mut self, span: Span, message: impl Into<String>, help: &str) -> Option<T> {
        self.unsupported(span, message, help);
        None
    }

    /// Reports an unknown name, with a similar existing name as help.
    pub fn unknown(&mut self, code: &'static str, what: &str, word: &Word, names: impl FnOnce(&Self) -> Vec<String>) {
        if self.missing.explains(what, word) {
            return;
        }
        let diagnostic =
            Diagnostic::error(code, format!("there is no {what} `{}`", word.text)).at(word.span, "not defined");
        // Each suggestion compares all names, and only the first ones are read.
        if self.missing.suggested == SUGGESTIONS {
            return self.diagnostics.push(diagnostic);
        }
        self.missing.suggested += 1;
        let names = &names(self)[..];
        let near = nearest(&word.text, names.iter().map(String::as_str)).map(str::to_owned);
        let diagnostic = match near.filter(|_| !is_label(word)) {
            _ if what.starts_with("element set") && self.model.node_sets.contains_key(&upper(&word.text)) => {
                diagnostic.help(format!("`{}` is a node set; element sets are: {}", word.text, first_of(names)))
            }
            None if is_label(word) => diagnostic,
            Some(near) => diagnostic.help(format!("did you mean {near}?")),
            None if names.is_empty() => diagnostic.help(format!("the deck defines no {what}")),
            None => diagnostic.help(format!("defined are: {}", first_of(names))),
        };
        self.diagnostics.push(diagnostic);
    }

    /// Counts model items against the size limits. The first excess is reported at the card; returns `false` then.
    pub fn fits_budget(&mut self, item: BudgetedItem, count: u128, span: Span) -> bool {
        let mesh = [self.model.mesh.points.len(), self.model.mesh.elements.len()];
        let Err(too_much) = self.budget.spend(item, count, mesh) else { return true };
        if !std::mem::replace(&mut self.budget.reported, true) {
            self.error("M125", too_much, span, "limit exceeded here");
        }
        self.missing.everything = true;
        false
    }

    /// Returns the material with a name, or reports that it is unknown.
    pub fn material(&mut self, word: &Word) -> Option<MaterialId> {
        let name = upper(&word.text);
        let index = self.names.materials.get(&name).copied();
        let material =
            index.filter(|&index| self.model.materials.get(index).is_some_and(|m: &MaterialDefinition| m.name == name));
        if material.is_none() {
            self.unknown("M111", "material", word, |b| b.model.materials.iter().map(|m| m.name.clone()).collect());
        }
        material.map(MaterialId::new)
    }

    /// Returns the nodes of an element set given in place of a node set, with a warning, and adds that node set.
    fn nodes_of_element_set(&mut self, word: &Word) -> Option<Vec<usize>> {
        let (name, set) =
            self.names_of(word).into_iter().find_map(|n| Some((n.clone(), self.model.element_sets.get(&n)?)))?;
        let members: Vec<usize> =
            sorted_unique(set.members.iter().flat_map(|&e| self.model.mesh.elements[e].nodes.iter().copied()));
        let message = format!("`{}` is an element set; the nodes of its elements are used", word.text);
        let diagnostic = Diagnostic::warning("M168", message).at(word.span, "a node set is expected");
        self.diagnostics.push(diagnostic.help(format!("define the node set with *NSET, NSET={name}, ELSET={name}")));
        self.model.node_sets.insert(name, MemberSet { members: members.clone(), span: word.span });
        Some(members)
    }

    /// Returns the nodes of a set or label, or reports that it is unknown.
    pub fn node_members(&mut self, word: &Word) -> Option<Vec<usize>> {
        for name in self.names_of(word) {
            if let Some(count) = self.model.node_sets.get(&name).map(|set| set.members.len()) {
                let affords = self.fits_budget(BudgetedItem::Members, count as u128, word.span);
                return affords.then(|| self.model.node_sets[&name].members.clone());
            }
        }
        if let Some(node) = self.nodes.resolve(&self.scope, word) {
            if self.scaling.coarsened.as_ref().is_some_and(|merged| merged.is_removed[node]) {
                self.remove_line(word);
                return Some(Vec::new());
            }
            return Some(vec![node]);
        }
        if let Some(members) = self.nodes_of_element_set(word) {
            return Some(members);
        }
        let what = if is_label(word) { "node" } else { "node set or node" };
        self.unknown("M110", what, word, |b| b.model.node_sets.keys().cloned().collect());
        None
    }

    /// Returns the labels of nodes or elements.
    pub fn labels(&self, kind: SetKind) -> &LabelTable {
        match kind {
            SetKind::Nodes => &self.nodes,
            SetKind::Elements => &self.elements,
        }
    }

    /// Returns the members of a set or label, or reports that it is unknown.
    pub fn members(&mut self, kind: SetKind, word: &Word) -> Option<Vec<usize>> {
        match kind {
            SetKind::Nodes => self.node_members(word),
            SetKind::Elements => self.element_members(word),
        }
    }

    /// Returns the node that `what` requires, or reports a set of several nodes.
    pub fn single_node(&mut self, word: &Word, what: &str) -> Option<usize> {
        match self.node_members(word)?[..] {
            [node] => Some(node),
            ref nodes => {
                self.refuse_value(word.span, format!("{what} must be one node, found a set of {}", nodes.len()))
            }
        }
    }

    /// Returns the elements of a set or label, or reports that it is unknown.
    pub fn element_members(&mut self, word: &Word) -> Option<Vec<usize>> {
        for name in self.names_of(word) {
            if let Some(count) = self.model.element_sets.get(&name).map(|set| set.members.len()) {
                if !self.fits_budget(BudgetedItem::Members, count as u128, word.span) {
                    return None;
                }
                let members = self.model.element_sets[&name].members.clone();
                self.edit_elements(word, &members, false);
                return Some(members);
            }
        }
        if let Some(element) = self.elements.resolve(&self.scope, word) {
            let members = self.replacements(element);
            self.edit_elements(word, &members, true);
            return Some(members);
        }
        let what = if is_label(word) { "element" } else { "element set or element" };
        self.unknown("M110", what, word, |b| b.model.element_sets.keys().cloned().collect());
        None
    }

    pub fn region<'l>(&mut self, line: &'l DataLine) -> Option<&'l Word> {
        let word = line.field(0);
        if word.is_none() {
            self.error("M102", "the set or surface is missing", line.span, "first field");
        }
        word
    }

    /// Reports a value that the line does not read.
    pub fn report_surplus(&mut self, word: &Word, why: &str) {
        let diagnostic = Diagnostic::error("M161", format!("too many values: `{}`", word.text));
        self.diagnostics.push(diagnostic.at(word.span, why));
    }

    pub fn surface_id(&mut self, word: &Word) -> Option<SurfaceId> {
        let index = self.names_of(word).iter().find_map(|name| self.model.surfaces.faces.get_index_of(name));
        if index.is_none() {
            self.unknown("M114", "surface", word, |b| b.model.surfaces.faces.keys().cloned().collect());
        }
        index.map(SurfaceId::new)
    }

    pub fn last_material(&mut self) -> &mut MaterialDefinition {
        let last = self.model.materials.len() - 1;
        &mut self.model.materials[last]
    }
}

/// Returns whether a word is a node or element label.
fn is_label(word: &Word) -> bool {
    word.text.parse::<i64>().is_ok()
}

fn first_of(names: &[String]) -> String {
    let first_names: Vec<_> = names.iter().take(12).map(String::as_str).collect();
    format!("{}{}", first_names.join(", "), if names.len() > 12 { ", …" } else { "" })
}
