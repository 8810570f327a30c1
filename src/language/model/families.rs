//! Families of cards: the state that the readers of each family keep between cards.

use std::collections::{HashMap, HashSet};

use indexmap::IndexMap;

use super::context::Context;
use super::history::StepHistory;
use super::placement::InstancePlacement;
use super::rubber_fit::RubberFit;
use super::types::{
    AdaptiveControls, AdaptiveMesh, AdaptiveRegion, BlastProperty, BoundaryCondition, EnergyLimit, GeneralContact,
    Load, MassScaling, OutputRequest, PrescribedClearance, PrescribedField, RestartRequest, SectionControls, Step,
    SurfaceContact, SurfaceId,
};
use crate::deck::{Card, Diagnostic, Span, Word};
use crate::kernel::bulk_viscosity::BulkViscosity;
use crate::resistance::{FitRequest, TargetSizes};

/// A block without its end card yet, such as `*PART` without `*END PART`.
#[derive(Debug)]
pub struct OpenBlock {
    /// `PART`, `ASSEMBLY`, `INSTANCE` or `STEP`.
    pub kind: &'static str,
    pub span: Span,
}

/// Parts, instances and other blocks.
#[derive(Default)]
pub struct PartReader<'a> {
    pub blocks: Vec<OpenBlock>,
    /// Cards of each part, read again for each instance.
    pub cards: HashMap<String, Vec<&'a Card>>,
    /// Names of instances.
    pub instances: HashSet<String>,
    /// Name of the part whose cards are recorded.
    pub recording: Option<String>,
}

impl<'a> PartReader<'a> {
    /// Records the cards of an open part for its instances. Returns whether the card was recorded.
    pub fn record(&mut self, card: &'a Card) -> bool {
        let Some(part) = self.recording.clone() else { return false };
        if card.keyword.name == "END PART" {
            return false;
        }
        if matches!(card.keyword.name, "PART" | "ASSEMBLY" | "STEP" | "INSTANCE") {
            self.recording = None;
            return false;
        }
        self.cards.entry(part).or_default().push(card);
        true
    }

    pub fn open(&mut self, kind: &'static str, card: &Card) {
        self.blocks.push(OpenBlock { kind, span: card.span });
    }

    pub fn close(&mut self, context: &mut Context<'_>, kind: &'static str, card: &Card) {
        match self.blocks.last() {
            Some(block) if block.kind == kind => {
                self.blocks.pop();
            }
            // The missing *STEP has been reported at its procedure.
            None if kind == "STEP" && context.missing.has_card("DYNAMIC") => {}
            other => {
                let mut diagnostic = Diagnostic::error("M105", format!("*{} without *{kind}", card.keyword.name));
                diagnostic = diagnostic.at(card.span, "no such block is open");
                if let Some(block) = other {
                    diagnostic = diagnostic.at(block.span, format!("this *{} is open", block.kind));
                }
                context.diagnostics.push(diagnostic);
            }
        }
    }
}

/// Origin and axes of a local coordinate system in the r-z plane.
pub struct LocalSystem {
    pub origin: [f64; 2],
    pub axes: [[f64; 2]; 2],
}

/// Nodes, elements and their sets.
#[derive(Default)]
pub struct MeshReader {
    /// Card being read.
    pub current_card: Span,
    /// Placement of the instance whose cards are read.
    pub placement: Option<InstancePlacement>,
    /// Nodes that were redefined at other coordinates, and the card that did so.
    pub moved: HashMap<usize, Span>,
    /// Cards that generated existing nodes at other coordinates: first label, and number of nodes.
    pub regenerated_by_card: HashMap<Span, (i64, usize)>,
    /// Nodes generated again at other coordinates, and elements that are degenerate at their new coordinates.
    pub regenerated: HashSet<usize>,
    pub shapeless_elements: HashSet<usize>,
    /// Local system of node coordinates (`*SYSTEM`).
    pub system: Option<LocalSystem>,
    /// Nodes with transformed directions (`*TRANSFORM`).
    pub transforms: Vec<(Vec<usize>, Span)>,
    /// Node sets and surfaces that follow from groups of mesh files; a card of the deck with the name replaces them.
    pub derived_node_sets: HashSet<String>,
    pub derived_surfaces: HashSet<String>,
    /// Members of UNSORTED node sets in the given order, by set name.
    pub unsorted: HashMap<String, Vec<usize>>,
}

impl MeshReader {
    /// Records a node that was generated again at other coordinates.
    pub fn note_regenerated_node(&mut self, node: usize, label: i64, span: Span) {
        let entry = self.regenerated_by_card.entry(span).or_insert((label, 0));
        entry.1 += 1;
        self.regenerated.insert(node);
    }

    /// Converts a point of the system set by `*SYSTEM` to r and z.
    pub fn global_coordinates(&self, p: [f64; 2]) -> [f64; 2] {
        match &self.system {
            Some(LocalSystem { origin, axes: [e1, e2] }) => [0, 1].map(|i| origin[i] + p[0] * e1[i] + p[1] * e2[i]),
            None => p,
        }
    }
}

/// A request to derive cavity expansion constants.
pub struct DerivationRequest {
    /// Index of the material whose resistance is derived.
    pub material: usize,
    /// Range and form of the fit.
    pub request: FitRequest,
    /// Shape of the cavity and what the target needs in addition to its material.
    pub sizes: TargetSizes,
    /// Source position of the card.
    pub span: Span,
}

/// Materials and their resistances.
#[derive(Default)]
pub struct MaterialReader {
    /// Whether the last `*MATERIAL` or `*SURFACE INTERACTION` was a surface interaction.
    pub in_interaction: bool,
    /// Cavity expansion constants to be derived after all cards are read.
    pub derivations: Vec<DerivationRequest>,
    /// Strain energies whose constants are fitted to test data after all cards are read.
    pub rubber_fits: Vec<RubberFit>,
}

/// A section that has section controls.
#[derive(Clone, Copy, Debug)]
pub enum SectionIndex {
    Solid(usize),
    Cohesive(usize),
}

/// Sections, masses and connectors: the properties of elements.
#[derive(Default)]
pub struct SectionReader {
    /// Source position of the section, mass, spring or dashpot of each element, by kind of property.
    pub property_of: HashMap<&'static str, Vec<Option<Span>>>,
    /// Section controls by name.
    pub controls: IndexMap<String, SectionControls>,
    /// Sections that refer to section controls, which may be defined later.
    pub controls_used: Vec<(SectionIndex, Word)>,
}

impl SectionReader {
    /// Notes that a card gives elements a property, and reports elements that already have one of this kind.
    pub fn assign_property(&mut self, context: &mut Context<'_>, kind: &'static str, elements: &[usize], span: Span) {
        let mut twice: Vec<(usize, Span)> = Vec::new();
        let of_kind = self.property_of.entry(kind).or_default();
        of_kind.resize(of_kind.len().max(context.model.mesh.elements.len()), None);
        for &element in elements {
            let first = *of_kind[element].get_or_insert(span);
            if first != span {
                twice.push((element, first));
            }
        }
        let Some(&(element, first)) = twice.first() else { return };
        let name = &context.model.mesh.elements[element].name;
        let more =
            if twice.len() > 1 { format!(" and {} more already have", twice.len() - 1) } else { " already has".into() };
        let diagnostic = Diagnostic::error("M165", format!("element {name}{more} a {kind}"));
        let diagnostic = diagnostic.at(span, "second definition").at(first, "first definition");
        let help = "remove one of the definitions, or limit them to different elements";
        context.diagnostics.push(diagnostic.help(help));
    }
}

/// A `*COUPLING` card whose kind is not known yet.
pub struct PendingCoupling {
    /// Upper-case name.
    pub name: String,
    /// Index of the reference node.
    pub reference: usize,
    /// Indices of the nodes of the surface, ascending.
    pub nodes: Vec<usize>,
    /// Tributary area of each node; 1 for each node of a node-based surface.
    pub areas: Vec<f64>,
    /// Source position of the card.
    pub span: Span,
}

/// A condition on degrees of freedom above 2.
#[derive(Clone, Debug)]
pub struct RotationalCondition {
    /// Source position of the data line.
    pub span: Span,
    /// Node set as named in the deck; empty if not known.
    pub set: String,
    /// First and last degree of freedom.
    pub dofs: [u8; 2],
    /// Node indices.
    pub nodes: Vec<usize>,
    /// Intended effect, for the message: `nothing {lost} by this line`.
    pub lost: &'static str,
    /// Prescribed value; it is multiplied with the amplitude.
    pub value: f64,
}

/// Initial conditions, couplings and waves.
#[derive(Default)]
pub struct ConditionReader {
    /// Initial conditions by the number of their members and the first member.
    pub repeated_conditions: HashMap<(usize, Option<usize>), Vec<usize>>,
    /// Boundary conditions on degrees of freedom above 2 only.
    pub rotational: Vec<RotationalCondition>,
    /// The `*COUPLING` card whose `*KINEMATIC` or `*DISTRIBUTING` card follows.
    pub coupling: Option<PendingCoupling>,
    /// The `*KINEMATIC` or `*DISTRIBUTING` card of the last `*COUPLING`.
    pub coupled: Option<Span>,
    /// Blast waves.
    pub blasts: Vec<BlastProperty>,
}

/// Procedure and conditions of a step while its cards are read.
#[derive(Clone, Debug, Default)]
pub struct StepState {
    pub name: String,
    pub span: Span,
    /// Procedure of the step, set by `*DYNAMIC`.
    pub procedure: Option<Step>,
    /// Whether conditions without amplitude increase linearly over the step (`AMPLITUDE=RAMP`).
    pub ramp: bool,
    /// Linear and quadratic bulk viscosity coefficients.
    pub bulk_viscosity: Option<BulkViscosity>,
    /// Conditions of earlier steps.
    pub history: StepHistory,
    /// Boundary conditions defined in this step.
    pub boundaries: Vec<BoundaryCondition>,
    /// Loads defined in this step.
    pub loads: Vec<Load>,
    /// Field variables defined in this step.
    pub fields: Vec<PrescribedField>,
    /// Output requests of earlier steps.
    pub earlier_outputs: Vec<OutputRequest>,
    pub surface_contacts: Vec<SurfaceContact>,
    pub general_contact: Option<GeneralContact>,
    /// Initial clearances, and penalty scale factors, that this step assigns to contact pair sets.
    pub pair_clearances: Vec<(Word, PrescribedClearance)>,
    pub penalty_factors: Vec<(Word, f64)>,
    pub mass_scalings: Vec<MassScaling>,
    /// Adaptive meshes, and nodes that they do not move.
    pub adaptive: Vec<AdaptiveMesh>,
    pub adaptive_fixed: Vec<(Span, Vec<usize>)>,
    pub adaptive_regions: Vec<AdaptiveRegion>,
    /// Motions of adaptive meshes that this step prescribes, and those of earlier steps.
    pub mesh_motions: Vec<BoundaryCondition>,
    pub mesh_history: StepHistory,
    /// Sets of the domains of this step with named controls.
    pub adaptive_controls_used: Vec<(String, Word)>,
    pub energy_limit: Option<EnergyLimit>,
    pub outputs: Vec<OutputRequest>,
    pub restart: Option<RestartRequest>,
    /// Families of cards for which `OP=NEW` has removed the conditions of earlier steps.
    pub cleared: Vec<&'static str>,
    /// Values that a later definition in this step would replace, by keyword and what they apply to.
    pub given: HashMap<(&'static str, String), Span>,
    /// Whether the `*BOUNDARY` cards of this step have OP=NEW; `None` before the first one.
    pub new_boundaries: Option<bool>,
}

/// Steps and the conditions in them.
#[derive(Default)]
pub struct StepReader {
    /// The open step.
    pub current: Option<StepState>,
    /// Model data before the first step, and the state at the end of the previous step.
    pub carried: StepState,
    /// Controls of adaptive meshes by name.
    pub adaptive_controls: IndexMap<String, AdaptiveControls>,
}

impl StepReader {
    /// Returns the state that a card extends: that of the open step, or that of the model data.
    pub fn state(&mut self) -> &mut StepState {
        self.current.as_mut().unwrap_or(&mut self.carried)
    }

    /// Warns if the step has already given a value that this one replaces: a card with the same keyword for the same `target`.
    pub fn note_value(&mut self, context: &mut Context<'_>, card: &Card, target: String, span: Span) {
        let keyword = card.keyword.name;
        let message =
            format!("*{keyword} is given twice for {target} in the step; the second definition replaces the first");
        if let Some(earlier) = self.state().given.insert((keyword, target), span) {
            context.warn_replaced(message, [earlier, span]);
        }
    }

    /// Returns whether a card removes the conditions of its family from earlier steps: the first one of a step with
    /// OP=NEW.
    pub fn operation(&mut self, card: &Card, family: &'static str) -> bool {
        card.read::<bool>("OP") && self.clear_once(family)
    }

    /// Returns whether this is the first card of the step that removes the conditions of a family.
    pub fn clear_once(&mut self, family: &'static str) -> bool {
        let cleared = &mut self.state().cleared;
        let is_first = !cleared.contains(&family);
        cleared.extend(is_first.then_some(family));
        is_first
    }
}

/// Output requests.
#[derive(Default)]
pub struct OutputReader {
    /// The `*OUTPUT` card whose variables follow.
    pub request: Option<OutputRequest>,
    /// Place of this card until variables follow; `None` if it has variables itself.
    pub empty: Option<Span>,
    /// Surfaces of `*INTEGRATED OUTPUT SECTION`, by section name.
    pub integrated_sections: HashMap<String, SurfaceId>,
}

impl OutputReader {
    /// Ends the requests of an `*OUTPUT` card, which is listed as unused if it requests no variables.
    pub fn close(&mut self, context: &mut Context<'_>) {
        self.request = None;
        if let Some(span) = self.empty.take() {
            context.ignore("OUTPUT", span, "it requests no variables, and no card with variables follows");
        }
    }
}
