//! The builder that walks over the cards: which block it is in, and helpers every card uses.
//! Never here: what a card means (one file per family of cards).

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use crate::deck::keywords::{Place, Tier};
use crate::deck::names::nearest;
use crate::deck::read::ReadCard;
use crate::deck::{Card, DataLine, Deck, Diagnostic, Diagnostics, Span, Word};
use crate::kernel::lists::sorted_unique;

use indexmap::IndexMap;

use super::budget::{Budget, Good};
use super::coupling::Coupling;
use super::degrees::Rotational;
#[cfg(feature = "resistance")]
use super::derivation::Asked;
use super::lost::{Lost, is_skipped};
use super::names::{Labels, qualified, upper};
use super::steps::StepState;
use super::types::{Inert, Material, MaterialId, Model, Origin, SectionControls, SurfaceId};

/// The most nodes, elements or members that one card may generate.
pub(super) const MOST: usize = 20_000_000;

/// Unknown names for which the nearest known ones are looked for.
const SUGGESTIONS: usize = 20;

/// A block that is open.
#[derive(Debug)]
pub(super) struct Block {
    /// `PART`, `ASSEMBLY`, `INSTANCE` or `STEP`.
    pub kind: &'static str,
    pub span: Span,
}

/// What is collected while the cards are read.
pub(super) struct Builder<'a> {
    pub deck: &'a Deck,
    pub model: Model,
    pub diagnostics: Diagnostics,
    pub nodes: Labels,
    pub elements: Labels,
    /// Name space of labels and sets: an instance, or empty.
    pub scope: String,
    pub blocks: Vec<Block>,
    /// Cards of each part, replayed for each instance.
    pub parts: HashMap<String, Vec<&'a Card>>,
    pub recording: Option<String>,
    pub instance: Option<super::parts::Placement>,
    pub step: Option<StepState>,
    pub carried: StepState,
    pub output: Option<super::types::OutputRequest>,
    /// What errors have taken away.
    pub lost: Lost,
    /// Cards with a fault that has been told.
    pub faulty: HashSet<Span>,
    /// Nodes given another place than they had, and where.
    pub moved: HashMap<usize, Span>,
    /// Element labels given again: label, where, and where first.
    pub used_twice: Vec<(i64, Span, Span)>,
    /// The card that is being read.
    pub current: Span,
    /// Cards that generated nodes which were elsewhere already: the first label, and how many.
    pub again: HashMap<Span, (i64, usize)>,
    /// Those nodes, and how many elements with them have no shape.
    pub regenerated: HashSet<usize>,
    pub spoilt: HashSet<usize>,
    /// Origin and directions of the coordinates of nodes (`*SYSTEM`).
    pub system: Option<([f64; 2], [[f64; 2]; 2])>,
    /// Surfaces of `*INTEGRATED OUTPUT SECTION` by the name of the section.
    pub sections: HashMap<String, SurfaceId>,
    /// Nodes with turned directions.
    pub transforms: Vec<(Vec<usize>, Span)>,
    /// Members of UNSORTED node sets in the order given, by the name of the set.
    pub unsorted: HashMap<String, Vec<usize>>,
    /// Where elements were given a section, a mass, a spring or a dashpot.
    pub property_of: HashMap<&'static str, Vec<Option<Span>>>,
    /// Section controls by name.
    pub controls: IndexMap<String, SectionControls>,
    /// Sections that name controls, which may follow.
    pub controls_used: Vec<(usize, Word)>,
    /// The `*COUPLING` whose kind is to follow.
    pub coupling: Option<Coupling>,
    /// Surface interactions that contact refers to: some may be defined below.
    pub interactions_used: Vec<Word>,
    /// Clearances of general contact by name.
    pub clearances: IndexMap<String, super::types::Clearance>,
    /// Boundaries on degrees of freedom above 2 alone.
    pub rotational: Vec<Rotational>,
    /// Resistances that are derived once all cards are read.
    #[cfg(feature = "resistance")]
    pub derivations: Vec<Asked>,
    /// Place of each `*MATERIAL` and of each `*SURFACE INTERACTION` among its kind, by its name in upper case.
    pub material_places: IndexMap<String, usize>,
    pub interaction_places: IndexMap<String, usize>,
    /// What the deck has asked for so far.
    pub budget: Budget,
    /// Unknown names for which others were suggested.
    pub suggested: usize,
}

impl<'a> Builder<'a> {
    pub fn new(deck: &'a Deck) -> Self {
        Builder {
            deck,
            model: Model {
                origin: Origin {
                    sources: Arc::clone(&deck.sources),
                    last_card: deck.cards.last().map(|card| card.span),
                    ..Origin::default()
                },
                ..Model::default()
            },
            diagnostics: Diagnostics::default(),
            nodes: Labels::default(),
            elements: Labels::default(),
            scope: String::new(),
            blocks: Vec::new(),
            parts: HashMap::new(),
            recording: None,
            instance: None,
            step: None,
            carried: StepState::default(),
            output: None,
            lost: Lost::of(deck),
            faulty: HashSet::new(),
            moved: HashMap::new(),
            used_twice: Vec::new(),
            current: Span::default(),
            again: HashMap::new(),
            regenerated: HashSet::new(),
            spoilt: HashSet::new(),
            system: None,
            sections: HashMap::new(),
            transforms: Vec::new(),
            unsorted: HashMap::new(),
            property_of: HashMap::new(),
            controls: IndexMap::new(),
            controls_used: Vec::new(),
            coupling: None,
            interactions_used: Vec::new(),
            clearances: super::named_clearances::named_clearances(deck),
            rotational: Vec::new(),
            #[cfg(feature = "resistance")]
            derivations: Vec::new(),
            material_places: super::names::places(deck, "MATERIAL"),
            interaction_places: super::names::places(deck, "SURFACE INTERACTION"),
            budget: Budget::default(),
            suggested: 0,
        }
    }

    /// Reads one card.
    pub fn card(&mut self, card: &'a Card) {
        if self.record(card) {
            return;
        }
        let name = card.keyword.name;
        let is_of_output = name.ends_with(" OUTPUT") || name == "OUTPUT EXPRESSION";
        if card.keyword.tier == Tier::Used && !is_of_output {
            self.output = None;
        }
        self.current = card.span;
        self.read(card, Self::understand);
    }

    /// Reads a card; what an error on it takes away is remembered.
    fn read(&mut self, card: &'a Card, read: impl FnOnce(&mut Self, &'a Card)) {
        let faulty = card.faulty || self.faulty.contains(&card.span);
        let before = self.diagnostics.error_count();
        if !faulty || !is_skipped(card) {
            read(self, card);
        }
        if faulty || self.diagnostics.error_count() > before {
            self.lost.card(card);
        }
    }

    fn understand(&mut self, card: &'a Card) {
        match card.keyword.name {
            "HEADING" => self.heading(card),
            "UNITS" => self.units(card),
            "NODE" => self.node(card),
            "NGEN" => self.ngen(card),
            "NFILL" => self.nfill(card),
            "NCOPY" => self.ncopy(card),
            "NMAP" => self.nmap(card),
            "SYSTEM" => self.system(card),
            "TRANSFORM" => self.transform(card),
            "ELEMENT" => self.element(card),
            "ELGEN" => self.elgen(card),
            "ELCOPY" => self.elcopy(card),
            "NSET" => self.nset(card),
            "ELSET" => self.elset(card),
            "SURFACE" => self.surface(card),
            "RIGID SURFACE" => self.rigid_surface(card),
            "MESH" => self.mesh_file(card),
            "PART" | "END PART" | "ASSEMBLY" | "END ASSEMBLY" | "INSTANCE" | "END INSTANCE" => self.block(card),
            "MATERIAL" => self.begin_material(card),
            _ if card.keyword.place == Place::Below("MATERIAL") => self.material_card(card),
            "PHYSICAL CONSTANTS" => self.physical_constants(card),
            "SOLID SECTION" => self.solid_section(card),
            "SHELL SECTION" => self.shell_section(card),
            "SECTION CONTROLS" => self.section_controls(card),
            "EROSION" => self.erosion(card),
            "RIGID BODY" => self.rigid_body(card),
            "MASS" => self.mass(card),
            "ROTARY INERTIA" => self.rotary_inertia(card),
            "ATTITUDE" => self.attitude(card),
            "CONTACT PAIR" => self.contact_pair(card),
            "CONTACT" => self.general_contact(card),
            "CONTACT INCLUSIONS"
            | "CONTACT EXCLUSIONS"
            | "CONTACT PROPERTY ASSIGNMENT"
            | "CONTACT CLEARANCE ASSIGNMENT"
            | "CONTACT INITIALIZATION ASSIGNMENT"
            | "CONTACT CONTROLS ASSIGNMENT" => self.general_contact_card(card),
            "CONTACT CONTROLS" => self.contact_controls(card),
            "CLEARANCE" => self.pair_clearance(card),
            "SURFACE INTERACTION" => self.surface_interaction(card),
            "SURFACE BEHAVIOR" => self.surface_behavior(card),
            "FRICTION" => self.friction(card),
            "GAP CONDUCTANCE" => self.gap_conductance(card),
            "GAP HEAT GENERATION" => self.gap_heat_generation(card),
            "SPRING" | "DASHPOT" => self.connector(card),
            "EQUATION" => self.equation(card),
            "MPC" => self.multi_point(card),
            "COUPLING" => self.coupling(card),
            "KINEMATIC" | "DISTRIBUTING" => self.coupling_kind(card),
            "TIE" => self.tie(card),
            "TARGET" => self.target(card),
            "AMPLITUDE" => self.amplitude(card),
            "INITIAL CONDITIONS" => self.initial_conditions(card),
            "STEP" => self.begin_step(card),
            "END STEP" => self.end_step(card),
            "DYNAMIC" | "DYNAMIC TEMPERATURE-DISPLACEMENT" => self.dynamic(card),
            "BULK VISCOSITY" => self.bulk_viscosity(card),
            "FIXED MASS SCALING" | "VARIABLE MASS SCALING" => self.mass_scaling(card),
            "ENERGY LIMIT" => self.energy_limit(card),
            "BOUNDARY" => self.boundary(card),
            "CLOAD" | "DLOAD" | "DSLOAD" => self.load_card(card),
            "FIELD" => self.prescribed_fields(card),
            "CFLUX" | "DFLUX" | "DSFLUX" | "FILM" | "SFILM" => self.heat_card(card),
            "OUTPUT"
            | "NODE OUTPUT"
            | "ELEMENT OUTPUT"
            | "ENERGY OUTPUT"
            | "INCREMENTATION OUTPUT"
            | "CONTACT OUTPUT"
            | "INTEGRATED OUTPUT" => self.output_card(card),
            "OUTPUT EXPRESSION" => self.output_expressions(card),
            "INTEGRATED OUTPUT SECTION" => self.integrated_section(card),
            "TIME POINTS" => self.time_points(card),
            "RESTART" => self.restart_card(card),
            _ => {}
        }
    }

    pub fn finish(mut self) -> (Model, Diagnostics) {
        for block in std::mem::take(&mut self.blocks) {
            let message = format!("this *{} is never closed", block.kind);
            let finding = Diagnostic::error("M105", message).at(block.span, "opened here");
            self.diagnostics.push(finding.help(format!("end it with *END {}", block.kind)));
        }
        self.close_step();
        self.end_coupling();
        self.apply_masses();
        self.tell_labels_used_twice();
        self.tell_shape_faults();
        self.tell_generated_again();
        self.check_transforms();
        self.apply_controls();
        self.apply_interactions();
        self.complete();
        self.model.origin.bodies_read = !self.lost.bodies;
        (self.model, self.diagnostics)
    }

    pub fn inert(&mut self, card: &Card, why: String) {
        self.model.origin.inert.push(Inert { keyword: card.keyword.name.into(), span: card.span, why });
    }

    /// The values of a card, which have been checked.
    pub fn values<T: ReadCard>(&self, card: &Card) -> T {
        T::read(card)
    }

    /// A parameter value that must be there.
    pub fn required<'c>(&mut self, card: &'c Card, name: &str) -> Option<&'c Word> {
        let value = card.value(name);
        if value.is_none() && !card.faulty {
            let message = format!("*{} needs {name}=", card.keyword.name);
            self.diagnostics.push(Diagnostic::error("M101", message).at(card.span, format!("{name}= is missing")));
        }
        value
    }

    /// A number that must be there.
    pub fn number(&mut self, line: &DataLine, index: usize, what: &str) -> Option<f64> {
        match line.field(index) {
            Some(word) => word.number(&mut self.diagnostics),
            None => {
                let finding = Diagnostic::error("M102", format!("{what} is missing"));
                self.diagnostics.refuse(finding.at(line.span, format!("field {} should be {what}", index + 1)))
            }
        }
    }

    /// A number, or a default where the field is empty or absent.
    pub fn number_or(&mut self, line: &DataLine, index: usize, default: f64) -> Option<f64> {
        line.field(index).map_or(Some(default), |w| w.number(&mut self.diagnostics))
    }

    /// A whole number that must be there.
    pub fn integer(&mut self, line: &DataLine, index: usize, what: &str) -> Option<i64> {
        match line.field(index) {
            Some(word) => word.integer(&mut self.diagnostics),
            None => {
                let finding = Diagnostic::error("M102", format!("{what} is missing"));
                self.diagnostics.refuse(finding.at(line.span, format!("field {} should be {what}", index + 1)))
            }
        }
    }

    pub fn out_of_range(&mut self, span: Span, message: impl Into<String>) {
        self.diagnostics.push(Diagnostic::error("M103", message).at(span, "here"));
    }

    pub fn unsupported(&mut self, span: Span, message: impl Into<String>, help: &str) {
        let finding = Diagnostic::error("M104", message).at(span, "not supported");
        self.diagnostics.push(if help.is_empty() { finding } else { finding.help(help) });
    }

    /// Reports a value out of range in place of what would have been read.
    pub fn refuse_value<T>(&mut self, span: Span, message: impl Into<String>) -> Option<T> {
        self.out_of_range(span, message);
        None
    }

    /// Reports what is not supported in place of what would have been read.
    pub fn refuse_unsupported<T>(&mut self, span: Span, message: impl Into<String>, help: &str) -> Option<T> {
        self.unsupported(span, message, help);
        None
    }

    /// An element has one property of a kind: what gives it a second one is an error.
    pub fn claim(&mut self, kind: &'static str, elements: &[usize], span: Span) {
        let mut twice: Vec<(usize, Span)> = Vec::new();
        let of_kind = self.property_of.entry(kind).or_default();
        of_kind.resize(of_kind.len().max(self.model.mesh.elements.len()), None);
        for &element in elements {
            let first = *of_kind[element].get_or_insert(span);
            if first != span {
                twice.push((element, first));
            }
        }
        let Some(&(element, first)) = twice.first() else { return };
        let name = &self.model.mesh.elements[element].name;
        let more = if twice.len() > 1 { format!(" and {} more have", twice.len() - 1) } else { " has".into() };
        let finding = Diagnostic::error("M165", format!("element {name}{more} a {kind} already"));
        self.diagnostics.push(finding.at(span, "a second one").at(first, "the first").help("an element has one"));
    }

    /// Says that a name refers to nothing, with the nearest that exists.
    pub fn unknown(&mut self, code: &'static str, what: &str, word: &Word, names: impl FnOnce(&Self) -> Vec<String>) {
        if self.lost.explains(what, word) {
            return;
        }
        let finding =
            Diagnostic::error(code, format!("there is no {what} `{}`", word.text)).at(word.span, "not defined");
        // Of many that are unknown no more are read, and each look at all names takes its time.
        if self.suggested == SUGGESTIONS {
            return self.diagnostics.push(finding);
        }
        self.suggested += 1;
        let names = &names(self)[..];
        let near = nearest(&word.text, names.iter().map(String::as_str)).map(str::to_owned);
        let finding = match near.filter(|_| !is_label(word)) {
            _ if what.starts_with("element set") && self.model.node_sets.contains_key(&upper(&word.text)) => {
                finding.help(format!("`{}` is a node set; element sets are: {}", word.text, first_of(names)))
            }
            None if is_label(word) => finding,
            Some(near) => finding.help(format!("did you mean {near}?")),
            None if names.is_empty() => finding.help(format!("the deck defines no {what}")),
            None => finding.help(format!("there are: {}", first_of(names))),
        };
        self.diagnostics.push(finding);
    }

    /// Whether the deck may have so many more; where it may not that is told once, with the card.
    pub(super) fn affords(&mut self, good: Good, count: u128, span: Span) -> bool {
        let mesh = [self.model.mesh.points.len(), self.model.mesh.elements.len()];
        let Err(too_much) = self.budget.spend(good, count, mesh) else { return true };
        if !std::mem::replace(&mut self.budget.told, true) {
            self.diagnostics.push(Diagnostic::error("M125", too_much).at(span, "too many with this"));
        }
        self.lost.everything = true;
        false
    }

    /// The material of a name.
    pub fn material(&mut self, word: &Word) -> Option<MaterialId> {
        let name = upper(&word.text);
        let place = self.material_places.get(&name).copied();
        let found = place.filter(|&place| self.model.materials.get(place).is_some_and(|m: &Material| m.name == name));
        if found.is_none() {
            self.unknown("M111", "material", word, |b| b.model.materials.iter().map(|m| m.name.clone()).collect());
        }
        found.map(MaterialId::new)
    }

    /// An element set in the place of a node set: its nodes can be meant only; it is a node set from here on.
    fn nodes_of_element_set(&mut self, word: &Word) -> Option<Vec<usize>> {
        let names = [qualified(&self.scope, &word.text), upper(&word.text)];
        let (name, set) = names.into_iter().find_map(|n| Some((n.clone(), self.model.element_sets.get(&n)?)))?;
        let members: Vec<usize> =
            sorted_unique(set.members.iter().flat_map(|&e| self.model.mesh.elements[e].nodes.iter().copied()));
        let message = format!("`{}` is an element set: the nodes of its elements are taken", word.text);
        let finding = Diagnostic::warning("M168", message).at(word.span, "a node set is asked for");
        self.diagnostics.push(finding.help(format!("*NSET, NSET={name}, ELSET={name} says the same")));
        self.model.node_sets.insert(name, super::types::Set { members: members.clone(), span: word.span });
        Some(members)
    }

    /// The nodes a word stands for: a set or a label.
    pub fn node_members(&mut self, word: &Word) -> Option<Vec<usize>> {
        for name in [qualified(&self.scope, &word.text), upper(&word.text)] {
            if let Some(count) = self.model.node_sets.get(&name).map(|set| set.members.len()) {
                let affords = self.affords(Good::Members, count as u128, word.span);
                return affords.then(|| self.model.node_sets[&name].members.clone());
            }
        }
        if let Some(node) = self.nodes.resolve(&self.scope, word) {
            return Some(vec![node]);
        }
        if let Some(members) = self.nodes_of_element_set(word) {
            return Some(members);
        }
        let what = if is_label(word) { "node" } else { "node set or node" };
        self.unknown("M110", what, word, |b| b.model.node_sets.keys().cloned().collect());
        None
    }

    /// The elements a word stands for: a set or a label.
    pub fn element_members(&mut self, word: &Word) -> Option<Vec<usize>> {
        for name in [qualified(&self.scope, &word.text), upper(&word.text)] {
            if let Some(count) = self.model.element_sets.get(&name).map(|set| set.members.len()) {
                let affords = self.affords(Good::Members, count as u128, word.span);
                return affords.then(|| self.model.element_sets[&name].members.clone());
            }
        }
        if let Some(element) = self.elements.resolve(&self.scope, word) {
            return Some(vec![element]);
        }
        let what = if is_label(word) { "element" } else { "element set or element" };
        self.unknown("M110", what, word, |b| b.model.element_sets.keys().cloned().collect());
        None
    }
}

/// Whether a word is a number, of a node or an element.
fn is_label(word: &Word) -> bool {
    word.text.parse::<i64>().is_ok()
}

fn first_of(names: &[String]) -> String {
    let shown: Vec<_> = names.iter().take(12).map(String::as_str).collect();
    format!("{}{}", shown.join(", "), if names.len() > 12 { ", …" } else { "" })
}
