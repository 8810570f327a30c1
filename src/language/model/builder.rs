//! The model builder: state of reading the cards in order, and helpers that all cards use. Each family of cards has its
//! own file.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use crate::deck::keywords::KeywordTier;
use crate::deck::names::nearest;
use crate::deck::read::ReadCard;
use crate::deck::{Card, DataLine, Deck, Diagnostic, Diagnostics, Span, Word};
use crate::kernel::lists::sorted_unique;

use indexmap::IndexMap;

use super::budget::{BudgetedItem, SizeBudget};
use super::coarsening::mesh::CoarsenedMesh;
use super::coupling::PendingCoupling;
use super::degrees::RotationalCondition;
use super::derivation::DerivationRequest;
use super::lost::{MissingDefinitions, is_skipped};
use super::names::{LabelTable, qualified, upper};
use super::refinement::curves::EdgeCurves;
use super::refinement::mesh::RefinedMesh;
use super::refinement::pair::NodePair;
use super::refinement::pass::ReadPass;
use super::relisting::edits::DeckEdits;
use super::steps::StepState;
use super::types::{
    AdaptiveControls, BlastProperty, IgnoredCard, MaterialDefinition, MaterialId, Model, ModelOrigin, SectionControls,
    SurfaceId,
};

/// Largest number of nodes, elements or set members that one card may generate.
pub(super) const MAX_GENERATED: usize = 20_000_000;

/// Number of unknown names for which similar names are suggested.
const SUGGESTIONS: usize = 20;

/// A block without its end card yet, such as `*PART` without `*END PART`.
#[derive(Debug)]
pub(super) struct OpenBlock {
    /// `PART`, `ASSEMBLY`, `INSTANCE` or `STEP`.
    pub kind: &'static str,
    pub span: Span,
}

/// A section that has section controls.
#[derive(Clone, Copy, Debug)]
pub enum SectionIndex {
    Solid(usize),
    Cohesive(usize),
}

/// State of reading a deck.
pub(super) struct ModelBuilder<'a> {
    pub deck: &'a Deck,
    pub model: Model,
    pub diagnostics: Diagnostics,
    pub nodes: LabelTable,
    pub elements: LabelTable,
    /// Scope of labels and set names: an instance name, or empty.
    pub scope: String,
    pub blocks: Vec<OpenBlock>,
    /// Cards of each part, read again for each instance.
    pub parts: HashMap<String, Vec<&'a Card>>,
    /// Names of instances.
    pub instances: HashSet<String>,
    /// Initial conditions by the number of their members and the first member.
    pub repeated_conditions: HashMap<(usize, Option<usize>), Vec<usize>>,
    pub recording: Option<String>,
    pub instance: Option<super::parts::InstancePlacement>,
    pub step: Option<StepState>,
    pub carried: StepState,
    pub output: Option<super::types::OutputRequest>,
    /// Definitions that are missing because of reported errors.
    pub missing: MissingDefinitions,
    /// Cards with a reported error.
    pub faulty: HashSet<Span>,
    /// Nodes that were redefined at other coordinates, and the card that did so.
    pub moved: HashMap<usize, Span>,
    /// Element labels that were defined twice: label, second and first position.
    pub used_twice: Vec<(i64, Span, Span)>,
    /// Card being read.
    pub current: Span,
    /// Cards that generated existing nodes at other coordinates: first label, and number of nodes.
    pub regenerated_by_card: HashMap<Span, (i64, usize)>,
    /// Nodes generated again at other coordinates, and elements that are degenerate because of them.
    pub regenerated: HashSet<usize>,
    pub shapeless_elements: HashSet<usize>,
    /// Origin and axes of the local system of node coordinates (`*SYSTEM`).
    pub system: Option<([f64; 2], [[f64; 2]; 2])>,
    /// Surfaces of `*INTEGRATED OUTPUT SECTION`, by section name.
    pub sections: HashMap<String, SurfaceId>,
    /// Nodes with transformed directions (`*TRANSFORM`).
    pub transforms: Vec<(Vec<usize>, Span)>,
    /// Members of UNSORTED node sets in the given order, by set name.
    pub unsorted: HashMap<String, Vec<usize>>,
    /// Source position of the section, mass, spring or dashpot of each element, by kind of property.
    pub property_of: HashMap<&'static str, Vec<Option<Span>>>,
    /// Controls of adaptive meshes by name.
    pub adaptive_controls: IndexMap<String, AdaptiveControls>,
    /// Section controls by name.
    pub controls: IndexMap<String, SectionControls>,
    /// Sections that refer to section controls, which may be defined later.
    pub controls_used: Vec<(SectionIndex, Word)>,
    /// The `*COUPLING` card whose `*KINEMATIC` or `*DISTRIBUTING` card follows.
    pub coupling: Option<PendingCoupling>,
    /// Blast waves.
    pub blasts: Vec<BlastProperty>,
    /// Whether the last `*MATERIAL` or `*SURFACE INTERACTION` was a surface interaction.
    pub in_interaction: bool,
    /// Names of surface interactions used by contact, which may be defined later.
    pub interactions_used: Vec<Word>,
    /// Initial clearances of general contact, by name.
    pub clearances: IndexMap<String, super::types::PrescribedClearance>,
    /// Boundary conditions on degrees of freedom above 2 only.
    pub rotational: Vec<RotationalCondition>,
    /// Cavity expansion constants to be derived after all cards are read.
    pub derivations: Vec<DerivationRequest>,
    /// Index of each `*MATERIAL`, and of each `*SURFACE INTERACTION`, by upper-case name.
    pub material_places: IndexMap<String, usize>,
    pub interaction_places: IndexMap<String, usize>,
    /// Index of each amplitude that was read, by upper-case name.
    pub amplitude_places: HashMap<String, usize>,
    /// Size of the model so far.
    pub budget: SizeBudget,
    /// Number of unknown names for which similar names were suggested.
    pub suggested: usize,
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

impl<'a> ModelBuilder<'a> {
    pub fn new(deck: &'a Deck) -> Self {
        ModelBuilder {
            deck,
            model: Model {
                origin: ModelOrigin {
                    sources: Arc::clone(&deck.sources),
                    last_card: deck.cards.last().map(|card| card.span),
                    ..ModelOrigin::default()
                },
                ..Model::default()
            },
            diagnostics: Diagnostics::default(),
            nodes: LabelTable::default(),
            elements: LabelTable::default(),
            scope: String::new(),
            blocks: Vec::new(),
            parts: HashMap::new(),
            instances: HashSet::new(),
            repeated_conditions: HashMap::new(),
            recording: None,
            instance: None,
            step: None,
            carried: StepState::default(),
            output: None,
            missing: MissingDefinitions::from_deck(deck),
            faulty: HashSet::new(),
            moved: HashMap::new(),
            used_twice: Vec::new(),
            current: Span::default(),
            regenerated_by_card: HashMap::new(),
            regenerated: HashSet::new(),
            shapeless_elements: HashSet::new(),
            system: None,
            sections: HashMap::new(),
            transforms: Vec::new(),
            unsorted: HashMap::new(),
            property_of: HashMap::new(),
            controls: IndexMap::new(),
            adaptive_controls: IndexMap::new(),
            controls_used: Vec::new(),
            coupling: None,
            blasts: Vec::new(),
            in_interaction: false,
            interactions_used: Vec::new(),
            clearances: super::named_clearances::named_clearances(deck),
            rotational: Vec::new(),
            derivations: Vec::new(),
            amplitude_places: HashMap::new(),
            material_places: super::names::places(deck, "MATERIAL"),
            interaction_places: super::names::places(deck, "SURFACE INTERACTION"),
            budget: SizeBudget::default(),
            suggested: 0,
            pass: ReadPass::All,
            curves: EdgeCurves::default(),
            refined: None,
            coarsened: None,
            regions: Vec::new(),
            linked_pairs: Vec::new(),
            edits: None,
        }
    }

    /// Creates a builder of a deck whose cards have been checked.
    pub fn checked(deck: &'a Deck) -> Self {
        let mut builder = ModelBuilder::new(deck);
        (builder.model.origin.inert, builder.faulty) = super::check::check(deck, &mut builder.diagnostics);
        builder
    }

    /// Returns the cards of the deck in reading order.
    pub fn ordered_cards(&self) -> Vec<&'a Card> {
        super::order::ordered(&self.deck.cards.iter().collect::<Vec<_>>(), &self.deck.sources)
    }

    /// Reads a card, or records it if a part is open.
    pub fn card(&mut self, card: &'a Card) {
        if self.record(card) || !self.pass.reads(card) {
            return;
        }
        let name = card.keyword.name;
        let is_of_output = name.ends_with(" OUTPUT") || name == "OUTPUT EXPRESSION";
        if card.keyword.tier == KeywordTier::Used && !is_of_output {
            self.output = None;
        }
        self.current = card.span;
        self.read(card, Self::dispatch);
    }

    /// Calls the reader of a card and notes what an erroneous card would have defined.
    fn read(&mut self, card: &'a Card, read: impl FnOnce(&mut Self, &'a Card)) {
        let faulty = card.faulty || self.faulty.contains(&card.span);
        let before = self.diagnostics.error_count();
        if !faulty || !is_skipped(card) {
            read(self, card);
        }
        if faulty || self.diagnostics.error_count() > before {
            self.missing.note_faulty_card(card);
        }
    }

    fn dispatch(&mut self, card: &'a Card) {
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
            "DAMAGE INITIATION" if self.in_interaction => self.cohesive_initiation(card),
            "DAMAGE EVOLUTION" if self.in_interaction => self.cohesive_evolution(card),
            "DAMAGE STABILIZATION" if self.in_interaction => self.cohesive_stabilization(card),
            _ if card.keyword.place.is_below("MATERIAL") => self.material_card(card),
            "PHYSICAL CONSTANTS" => self.physical_constants(card),
            "SOLID SECTION" => self.solid_section(card),
            "SHELL SECTION" => self.shell_section(card),
            "COHESIVE SECTION" => self.cohesive_section(card),
            "SECTION CONTROLS" => self.section_controls(card),
            "EROSION" => self.erosion(card),
            "REMESH" => self.remeshing(card),
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
            | "CONTACT CONTROLS ASSIGNMENT"
            | "CONTACT FORMULATION" => self.general_contact_card(card),
            // Only values without effect are allowed.
            "SURFACE PROPERTY ASSIGNMENT" => {}
            "CONTACT CONTROLS" => self.contact_controls(card),
            "CLEARANCE" => self.pair_clearance(card),
            "SURFACE INTERACTION" => self.surface_interaction(card),
            "SURFACE BEHAVIOR" => self.surface_behavior(card),
            "CONTACT DAMPING" => self.contact_damping(card),
            "COHESIVE BEHAVIOR" => self.cohesive_behavior(card),
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
            "ADAPTIVE MESH" => self.adaptive_mesh(card),
            "ADAPTIVE MESH CONTROLS" => self.adaptive_controls(card),
            "ADAPTIVE MESH CONSTRAINT" => self.adaptive_constraint(card),
            "BOUNDARY" => self.boundary(card),
            "CLOAD" | "DLOAD" | "DSLOAD" => self.load_card(card),
            "INCIDENT WAVE INTERACTION PROPERTY" => self.blast_property(card),
            "CONWEP CHARGE PROPERTY" => self.blast_charge(card),
            "INCIDENT WAVE INTERACTION" => self.incident_wave(card),
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
            let message = format!("this *{} is not closed", block.kind);
            let diagnostic = Diagnostic::error("M105", message).at(block.span, "opened here");
            self.diagnostics.push(diagnostic.help(format!("end it with *END {}", block.kind)));
        }
        self.close_step();
        self.end_coupling();
        self.apply_masses();
        self.report_duplicate_labels();
        self.report_shape_faults();
        self.report_regenerated_nodes();
        self.check_transforms();
        self.apply_controls();
        self.apply_interactions();
        self.complete();
        self.reduce_output_sets();
        let mesh = &mut *self.model.mesh;
        mesh.points.shrink_to_fit();
        mesh.node_names.shrink_to_fit();
        mesh.elements.shrink_to_fit();
        self.model.origin.bodies_read = !self.missing.bodies;
        (self.model, self.diagnostics)
    }

    pub fn inert(&mut self, card: &Card, why: String) {
        self.model.origin.inert.push(IgnoredCard { keyword: card.keyword.name.into(), span: card.span, why });
    }

    /// Returns the values of a card, which have been checked.
    pub fn values<T: ReadCard>(&self, card: &Card) -> T {
        T::read(card)
    }

    /// Returns the value of a required parameter; reports an error if it is missing.
    pub fn required<'c>(&mut self, card: &'c Card, name: &str) -> Option<&'c Word> {
        let value = card.value(name);
        if value.is_none() && !card.faulty {
            let message = format!("*{} requires {name}=", card.keyword.name);
            self.diagnostics.push(Diagnostic::error("M101", message).at(card.span, format!("{name}= is missing")));
        }
        value
    }

    /// Returns the number in a required field; reports an error if it is missing.
    pub fn number(&mut self, line: &DataLine, index: usize, what: &str) -> Option<f64> {
        match line.field(index) {
            Some(word) => word.number(&mut self.diagnostics),
            None => {
                let diagnostic = Diagnostic::error("M102", format!("{what} is missing"));
                self.diagnostics.refuse(diagnostic.at(line.span, format!("field {} should be {what}", index + 1)))
            }
        }
    }

    /// Returns the number in an optional field.
    pub fn number_or(&mut self, line: &DataLine, index: usize, default: f64) -> Option<f64> {
        line.field(index).map_or(Some(default), |w| w.number(&mut self.diagnostics))
    }

    /// Returns the integer in a required field; reports an error if it is missing.
    pub fn integer(&mut self, line: &DataLine, index: usize, what: &str) -> Option<i64> {
        match line.field(index) {
            Some(word) => word.integer(&mut self.diagnostics),
            None => {
                let diagnostic = Diagnostic::error("M102", format!("{what} is missing"));
                self.diagnostics.refuse(diagnostic.at(line.span, format!("field {} should be {what}", index + 1)))
            }
        }
    }

    pub fn out_of_range(&mut self, span: Span, message: impl Into<String>) {
        self.diagnostics.push(Diagnostic::error("M103", message).at(span, "here"));
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

    /// Notes that a card gives elements a property, and reports elements that already have one of this kind.
    pub fn assign_property(&mut self, kind: &'static str, elements: &[usize], span: Span) {
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
        let more =
            if twice.len() > 1 { format!(" and {} more already have", twice.len() - 1) } else { " already has".into() };
        let diagnostic = Diagnostic::error("M165", format!("element {name}{more} a {kind}"));
        self.diagnostics.push(
            diagnostic
                .at(span, "second definition")
                .at(first, "first definition")
                .help("remove one of the definitions, or limit them to different elements"),
        );
    }

    /// Reports an unknown name, with a similar existing name as help.
    pub fn unknown(&mut self, code: &'static str, what: &str, word: &Word, names: impl FnOnce(&Self) -> Vec<String>) {
        if self.missing.explains(what, word) {
            return;
        }
        let diagnostic =
            Diagnostic::error(code, format!("there is no {what} `{}`", word.text)).at(word.span, "not defined");
        // Each suggestion compares all names, and only the first ones are read.
        if self.suggested == SUGGESTIONS {
            return self.diagnostics.push(diagnostic);
        }
        self.suggested += 1;
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
    pub(super) fn fits_budget(&mut self, good: BudgetedItem, count: u128, span: Span) -> bool {
        let mesh = [self.model.mesh.points.len(), self.model.mesh.elements.len()];
        let Err(too_much) = self.budget.spend(good, count, mesh) else { return true };
        if !std::mem::replace(&mut self.budget.reported, true) {
            self.diagnostics.push(Diagnostic::error("M125", too_much).at(span, "limit exceeded here"));
        }
        self.missing.everything = true;
        false
    }

    /// Returns the material with a name, or reports that it is unknown.
    pub fn material(&mut self, word: &Word) -> Option<MaterialId> {
        let name = upper(&word.text);
        let place = self.material_places.get(&name).copied();
        let found =
            place.filter(|&place| self.model.materials.get(place).is_some_and(|m: &MaterialDefinition| m.name == name));
        if found.is_none() {
            self.unknown("M111", "material", word, |b| b.model.materials.iter().map(|m| m.name.clone()).collect());
        }
        found.map(MaterialId::new)
    }

    /// Returns the nodes of an element set given in place of a node set, with a warning, and adds that node set.
    fn nodes_of_element_set(&mut self, word: &Word) -> Option<Vec<usize>> {
        let names = [qualified(&self.scope, &word.text), upper(&word.text)];
        let (name, set) = names.into_iter().find_map(|n| Some((n.clone(), self.model.element_sets.get(&n)?)))?;
        let members: Vec<usize> =
            sorted_unique(set.members.iter().flat_map(|&e| self.model.mesh.elements[e].nodes.iter().copied()));
        let message = format!("`{}` is an element set; the nodes of its elements are used", word.text);
        let diagnostic = Diagnostic::warning("M168", message).at(word.span, "a node set is expected");
        self.diagnostics.push(diagnostic.help(format!("define the node set with *NSET, NSET={name}, ELSET={name}")));
        self.model.node_sets.insert(name, super::types::MemberSet { members: members.clone(), span: word.span });
        Some(members)
    }

    /// Returns the nodes of a set or label, or reports that it is unknown.
    pub fn node_members(&mut self, word: &Word) -> Option<Vec<usize>> {
        for name in [qualified(&self.scope, &word.text), upper(&word.text)] {
            if let Some(count) = self.model.node_sets.get(&name).map(|set| set.members.len()) {
                let affords = self.fits_budget(BudgetedItem::Members, count as u128, word.span);
                return affords.then(|| self.model.node_sets[&name].members.clone());
            }
        }
        if let Some(node) = self.nodes.resolve(&self.scope, word) {
            if self.coarsened.as_ref().is_some_and(|merged| merged.is_removed[node]) {
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

    /// Returns the elements of a set or label, or reports that it is unknown.
    pub fn element_members(&mut self, word: &Word) -> Option<Vec<usize>> {
        for name in [qualified(&self.scope, &word.text), upper(&word.text)] {
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
}

/// Returns whether a word is a node or element label.
fn is_label(word: &Word) -> bool {
    word.text.parse::<i64>().is_ok()
}

fn first_of(names: &[String]) -> String {
    let shown: Vec<_> = names.iter().take(12).map(String::as_str).collect();
    format!("{}{}", shown.join(", "), if names.len() > 12 { ", …" } else { "" })
}
