//! Compilation of a model to a plan: decides which effects the run contains, creates them, and lists them in the
//! ledger. Time integration is in `solve`.

mod adaptive;
mod analytical;
mod averaging;
mod bodies;
mod bytes;
pub mod changes;
pub mod codes;
mod cohesive;
mod cohesive_contact;
mod connectors;
mod contact;
mod contact_curves;
mod contact_doubts;
mod doubts;
mod equations;
mod erosion;
mod expressions;
mod fields;
mod general_contact;
mod heat;
mod heat_ties;
mod implausible;
mod labels;
pub mod ledger;
mod links;
mod loads;
mod mass_scaling;
mod motions;
mod numbering;
mod outputs;
mod overlaps;
mod penalty;
mod pieces;
mod places;
mod remesh;
pub mod revise;
mod rigid_bodies_3d;
mod shells;
mod soft_material;
mod solid;
mod solid_material;
mod state;
mod steps;
mod surface_ties;
mod surfaces;
mod targets;
mod tie_equations;
mod tie_integration;
mod ties;
mod user;
mod user_material;
mod wall_contact;

use std::collections::HashSet;
use std::rc::Rc;

use indexmap::{IndexMap, IndexSet};

use crate::constraint::tie::TiedNodes;
use crate::deck::{Diagnostic, Diagnostics, Span};
use crate::kernel::amplitude::SampledAmplitude;
use crate::load::user_amplitude::SubroutineAmplitude;
use crate::mesh::surface::SurfaceGeometry;
use crate::model::{
    AmplitudeId, AnalyticalFront, CopyOnWrite, EnergyLimit, EosKind, IncrementControl, LoadVelocity,
    MaterialDefinition, Mesh, Model, SurfaceContact,
};
use crate::state::EffectId;
pub use crate::state::dofs::{Dof, Dofs};
use crate::user::Routines;
use crate::variables::Variable;
pub use bodies::PlannedRigidBody;
pub use changes::StepChanges;
pub use doubts::unit_warning;
pub use expressions::RowExpression;
pub use labels::FrameLabels;
use ledger::{Ledger, UnusedCard};
pub use outputs::{ColumnSource, FrameField, HistoryColumn, IntegratedSection, StepOutputs, WriteSchedule};
pub use places::MeshIndexMap;
pub use remesh::{RemeshPlan, RemeshedBody};
pub use solid::SolidPlaces;
pub use state::State;

/// A compiled analysis: the effects that the deck requests. A plan is immutable; it can be run many times, on several
/// threads at once, each time from its own [`State`].
#[derive(Default)]
pub struct Plan {
    /// Effects of the analysis and the cards that request them.
    pub ledger: Ledger,
    /// Mesh of the model, for frames.
    pub mesh: CopyOnWrite<Mesh>,
    /// Rigid bodies, in the order of the model.
    pub bodies: Vec<PlannedRigidBody>,
    /// Solver indices of the deformable nodes and elements of the mesh.
    pub places: SolidPlaces,
    /// Steps in the order of the analysis.
    pub steps: Vec<StepPlan>,
    /// History columns, the same in every step.
    pub columns: Vec<HistoryColumn>,
    /// Surfaces over which history columns are integrated.
    pub sections: Vec<IntegratedSection>,
    /// Members of the sets over which history columns are statistics.
    pub sets: Vec<Vec<ColumnSource>>,
    /// Expressions of columns that are computed from previous columns.
    pub expressions: Vec<RowExpression>,
    /// Output arrays of frames.
    pub fields: Vec<FrameField>,
    /// User subroutines. Their own static memory is not part of the state.
    pub routines: Routines,
    /// Ledger rows of time integration, nodal assembly and output.
    pub rows: GeneralLedgerRows,
    /// Numbers, materials and sets of nodes and elements, for frames.
    pub labels: FrameLabels,
    /// Bodies that are remeshed; `None` without `*REMESH`.
    pub remesh: Option<Box<RemeshPlan>>,
    /// Largest increase of the elastic moduli of a material over temperature and fields, as a fraction.
    pub stiffening: f64,
    /// Whether a material is a gas or an explosive, whose viscous heat does work again.
    pub returns_heat: bool,
    /// Whether a material has an equation of state. It expands after a shock with the heat of plastic work and bulk
    /// viscosity, and pays for its hourglass control.
    pub has_equation_of_state: bool,
    /// Whether a user subroutine computes the stress of a material.
    pub has_user_stress: bool,
    /// Cards of the deck against small increments.
    pub mesh_cards: MeshCards,
    /// Whether the variables of an element group can move from element to element, as in adaptive and new meshes.
    pub movable_groups: Vec<bool>,
    /// Whether nodes without elements leave the contact (`NODAL EROSION=YES`).
    pub excludes_detached_nodes: bool,
    /// Whether viscous dissipation is expected: shocks in materials with an equation of state, requested damping.
    pub expects_dissipation: bool,
}

/// Cards of a deck against elements that reduce the time increment.
#[derive(Clone, Copy, Debug, Default)]
pub struct MeshCards {
    /// `*EROSION` with a limit of the increment or of distortion.
    pub erodes: bool,
    /// DISTORTION CONTROL=YES in a section.
    pub controls_distortion: bool,
    /// Mass scaling in a step.
    pub scales_masses: bool,
}

impl MeshCards {
    fn of(model: &Model) -> MeshCards {
        MeshCards {
            erodes: model.erosions.iter().any(|e| e.increment.is_some() || e.distortion.is_some()),
            controls_distortion: model.sections.iter().any(|s| s.controls.distortion.is_some()),
            scales_masses: model.steps.iter().any(|s| !s.mass_scalings.is_empty()),
        }
    }
}

/// Ledger rows of effects that every analysis has.
#[derive(Clone, Copy, Debug, Default)]
pub struct GeneralLedgerRows {
    /// Central differences, energy balance, choice of the time increment.
    pub integration: Option<EffectId>,
    /// Assembly of nodal forces and nodal motion.
    pub gather: Option<EffectId>,
    /// Frames and histories.
    pub output: Option<EffectId>,
}

/// A step of the plan: its increment control and the changes to the active effects of the previous step. The effects of
/// the first step are in the initial [`State`].
pub struct StepPlan {
    /// Name of the step, from `*STEP, NAME=`.
    pub name: String,
    /// Duration of the step, time.
    pub duration: f64,
    /// Method that determines the time increment.
    pub control: IncrementControl,
    /// Factor on an automatic time increment.
    pub scale_factor: f64,
    /// Velocity that is passed to loads.
    pub load_velocity: LoadVelocity,
    /// Changes to the active effects.
    pub changes: StepChanges,
    /// Limits of the energy balance; `None` without `*ENERGY LIMIT`.
    pub energy_limit: Option<EnergyLimit>,
    /// Schedules of frames, histories and restart files.
    pub outputs: StepOutputs,
}

impl StepPlan {
    /// Returns whether the deck limits the drift of ETOTAL (`*ENERGY LIMIT, ERROR`).
    pub fn has_drift_limit(&self) -> bool {
        self.energy_limit.is_some_and(|limit| limit.error.is_some())
    }

    /// Returns whether the deck fixes the increments.
    #[inline]
    pub fn is_fixed(&self) -> bool {
        matches!(self.control, IncrementControl::Fixed(_))
    }
}

impl Plan {
    /// Returns the names of the history columns.
    pub fn column_names(&self) -> Vec<String> {
        self.columns.iter().map(|c| c.name.clone()).collect()
    }

    /// Returns the name of an element, given its group and its index in the group.
    pub fn element_name(&self, group: usize, element: usize) -> &str {
        self.mesh_element(group, element).map_or("", |e| &self.mesh.elements[e].name)
    }

    /// Returns the name of the material of an element, given its group and its index in the group; empty without one.
    pub fn material_name(&self, group: usize, element: usize) -> &str {
        self.mesh_element(group, element).map_or("", |e| self.labels.material_name(e))
    }

    fn mesh_element(&self, group: usize, element: usize) -> Option<usize> {
        self.places.elements.iter().find(|e| *e.1 == (group, element)).map(|e| e.0)
    }
}

/// State of the compilation of a model.
struct Compiler<'a> {
    model: &'a Model,
    routines: &'a Routines,
    diagnostics: Diagnostics,
    ledger: Ledger,
    ledger_rows: IndexMap<(Span, &'static str), EffectId>,
    bodies: Vec<PlannedRigidBody>,
    body_of_node: IndexMap<usize, usize>,
    body_of_element: IndexMap<usize, usize>,
    /// Solver indices of deformable nodes and elements.
    places: SolidPlaces,
    /// Surfaces of loads in models without deformable elements, by the line of the load; revisions use them again.
    rigid_surfaces: IndexMap<Span, SurfaceGeometry>,
    /// User amplitudes; and, by amplitude of the model, the index of the value in the state's list.
    amplitudes: Vec<SubroutineAmplitude>,
    user_amplitude_index: IndexMap<AmplitudeId, usize>,
    /// Number of values that user amplitudes and user motions compute.
    user_amplitude_count: usize,
    /// Deformable nodes that are tied to rigid bodies.
    ties: Vec<TiedNodes>,
    /// Surfaces over which history columns are integrated.
    sections: Vec<IntegratedSection>,
    /// Members of the sets over which history columns are statistics.
    sets: IndexSet<Vec<ColumnSource>>,
    /// Variables of the whole model that histories can show.
    model_variables: Vec<Variable>,
    /// Expressions of history columns.
    expressions: Vec<RowExpression>,
    /// Equations of each tie of the model.
    surface_ties: Vec<tie_equations::TieEquations>,
    /// Equations and nodes that move together.
    links: links::LinkSet,
    /// Degrees of freedom (node, axis) of massless nodes without any constraint.
    unresisted_dofs: HashSet<(usize, usize)>,
    /// Contact pairs of each step, and the names of all pairs for histories.
    pairs: Vec<Rc<Vec<SurfaceContact>>>,
    pair_names: IndexSet<String>,
    /// Fronts of the analytical surfaces of these pairs.
    fronts: Vec<AnalyticalFront>,
    /// Active effects of the last compiled step.
    in_force: steps::ActiveEffects<'a>,
    /// Names of the user subroutines that are called.
    called_routines: Vec<&'static str>,
}

/// Compiles a model. `routines` are the user subroutines that the deck may call. Returns the plan, its initial state
/// and the diagnostics. The plan may be run only if there is no error.
pub fn compile(model: &Model, routines: &Routines) -> (Plan, State, Diagnostics) {
    compile_with(model, routines, &mut |_, _| {})
}

/// Compiles a model as [`compile`] does. Without errors, `look` is called with the complete compiler and the initial
/// state.
fn compile_with(
    model: &Model,
    routines: &Routines,
    look: &mut dyn FnMut(&Compiler<'_>, &State),
) -> (Plan, State, Diagnostics) {
    let mut diagnostics = model.check();
    if diagnostics.has_errors() {
        return (Plan::default(), State::default(), diagnostics);
    }
    let attached = surface_ties::find_attached_nodes(model, &mut diagnostics);
    let adjusted = surface_ties::adjusted(model, &attached);
    let model = adjusted.as_ref().unwrap_or(model);
    let surface_ties = tie_equations::tie_equations(model, &attached);
    let mut compiler = Compiler {
        model,
        routines,
        places: SolidPlaces::default(),
        rigid_surfaces: IndexMap::new(),
        amplitudes: Vec::new(),
        user_amplitude_index: IndexMap::new(),
        user_amplitude_count: 0,
        ties: Vec::new(),
        sections: Vec::new(),
        sets: IndexSet::new(),
        model_variables: Vec::new(),
        expressions: Vec::new(),
        surface_ties,
        links: links::LinkSet::default(),
        unresisted_dofs: HashSet::new(),
        pairs: Vec::new(),
        pair_names: IndexSet::new(),
        fronts: Vec::new(),
        in_force: steps::ActiveEffects::default(),
        called_routines: Vec::new(),
        diagnostics: Diagnostics::default(),
        ledger: Ledger::default(),
        ledger_rows: IndexMap::new(),
        bodies: Vec::new(),
        body_of_node: IndexMap::new(),
        body_of_element: IndexMap::new(),
    };
    compiler.bodies();
    let mut state = compiler.solids();
    compiler.collect_links(&mut state);
    compiler.connect(&mut state);
    compiler.bound_cohesive_elements(&mut state);
    compiler.start_and_check_bodies();
    state.thermal = compiler.thermal(&state);
    state.elements.fields = compiler.predefined_fields(&state);
    state.dofs.bodies = compiler.bodies_at_start();
    compiler.erosion(&mut state);
    compiler.find_pairs();
    let (columns, fields) = compiler.variables(&mut state);
    let steps = compiler.steps(&mut state);
    compiler.scale_and_estimate(&mut state);
    compiler.refuse_on_spatial_bodies();
    let remesh = compiler.remeshing(&mut state);
    compiler.check_complete(!state.elements.is_empty());
    compiler.report_overlaps();
    compiler.list_inert();
    compiler.check_plausibility(&state);
    compiler.events_row();
    compiler.note_uncalled();
    let rows = compiler.integration_rows(&state, columns.len() + fields.len());
    if !compiler.diagnostics.has_errors() {
        look(&compiler, &state);
    }
    state.user_amplitudes = vec![SampledAmplitude::default(); compiler.user_amplitude_count];
    state.amplitude_routines = compiler.amplitudes;
    let read = compiler.sections.iter().flat_map(|section| &section.corners);
    state.elements.tile(read.map(|&(group, element, _)| (group, element)));
    let Compiler { ledger, bodies, places, sections, sets, expressions, diagnostics: found, .. } = compiler;
    let (labels, sets) = (FrameLabels::of(model), sets.into_iter().collect());
    diagnostics.append(found);
    // If there are errors, warnings and notes would only hide them.
    if diagnostics.has_errors() {
        diagnostics.keep_errors();
    }
    let (mesh, routines) = (model.mesh.clone(), routines.clone());
    let movable = state.elements.groups.iter_mut().map(|group| group.extensions().transfer().is_some());
    let movable_groups = movable.collect();
    let general_contacts = model.steps.iter().filter_map(|s| s.general_contact.as_ref());
    let excludes_detached_nodes = general_contacts.into_iter().any(|g| g.excludes_detached_nodes);
    let (stiffening, expects_dissipation) = (stiffening(model), expects_dissipation(model));
    let is_gas = |eos: &EosKind| matches!(eos, EosKind::IdealGas(_) | EosKind::Jwl(_));
    let returns_heat = model.materials.iter().any(|m| m.eos.as_ref().is_some_and(|eos| is_gas(&eos.kind)));
    let has_equation_of_state = model.materials.iter().any(|m| m.eos.is_some());
    let has_user_stress = model.materials.iter().any(|m| m.user.material.is_some());
    let mut plan = Plan {
        ledger,
        mesh,
        bodies,
        places,
        steps,
        columns,
        sections,
        sets,
        expressions,
        fields,
        routines,
        rows,
        labels,
        remesh,
        mesh_cards: MeshCards::of(model),
        movable_groups,
        excludes_detached_nodes,
        stiffening,
        returns_heat,
        has_equation_of_state,
        has_user_stress,
        expects_dissipation,
    };
    bytes::record_bytes(&mut plan, &state);
    (plan, state, diagnostics)
}

/// Returns the largest increase of a bulk or shear modulus over the tables of elastic moduli, as a fraction.
fn stiffening(model: &Model) -> f64 {
    let increase = |moduli: &mut dyn Iterator<Item = f64>| {
        let [low, high] = moduli.fold([f64::INFINITY, 0.0], |[low, high], e| [e.min(low), e.max(high)]);
        if low > 0.0 && low < high { high / low - 1.0 } else { 0.0 }
    };
    let of_material = |m: &MaterialDefinition| {
        let rows = || m.elastic_table.iter().filter(|row| row.len() > 1);
        let bulk = increase(&mut rows().map(|row| row[0] / (1.0 - 2.0 * row[1])));
        bulk.max(increase(&mut rows().map(|row| row[0] / (1.0 + row[1]))))
    };
    model.materials.iter().map(of_material).fold(0.0, f64::max)
}

/// Returns whether viscous dissipation is part of the model: shocks in materials with an equation of state, or damping.
fn expects_dissipation(model: &Model) -> bool {
    let of_material = |m: &MaterialDefinition| m.eos.is_some() || m.damping.is_some();
    model.materials.iter().any(of_material) || !model.discrete.connectors.is_empty()
}

impl Compiler<'_> {
    /// Returns the ledger row of an effect of the card at `span`. The row is created at the first call, so that a load
    /// that is active in several steps has one row.
    fn ledger_row(
        &mut self,
        span: Span,
        effect: &'static str,
        count: usize,
        unit: &'static str,
        detail: String,
    ) -> EffectId {
        if let Some(&cause) = self.ledger_rows.get(&(span, effect)) {
            return cause;
        }
        let asked_by = self.model.origin.sources.describe(span);
        let cause = self.ledger.add(effect, count, unit, asked_by, detail);
        self.ledger_rows.insert((span, effect), cause);
        cause
    }

    /// Lists a card without effect in the ledger.
    fn add_unused_card(&mut self, span: Span, what: impl Into<String>, why: impl Into<String>) {
        let unused =
            UnusedCard { what: what.into(), asked_by: self.model.origin.sources.describe(span), why: why.into() };
        self.ledger.unused.insert(unused);
    }

    fn scale_and_estimate(&mut self, state: &mut State) {
        if state.elements.is_empty() {
            return;
        }
        if self.model.steps.iter().any(|s| !s.mass_scalings.is_empty()) {
            let linked = self.marked_nodes(state.dofs.nodes.len(), self.nodes_of_links());
            state.elements.store_unscaled_masses(&state.dofs.nodes, linked);
        }
        self.highest_frequency(state);
    }

    /// Creates the ledger rows that every analysis has, attributed to the first step.
    fn integration_rows(&mut self, state: &State, shown: usize) -> GeneralLedgerRows {
        let Some(step) = self.model.steps.first() else { return GeneralLedgerRows::default() };
        let integration = self.ledger_rows.get(&(step.span, "central difference")).copied();
        let nodes = state.dofs.nodes.len() - self.places.rotations.len();
        let detail = "nodal forces, masses and motion";
        let gather = (nodes > 0).then(|| self.ledger_row(step.span, "nodes", nodes, "nodes", detail.into()));
        let detail = "mesh, frames, histories";
        let output = Some(self.ledger_row(step.span, "output", shown, "variables", detail.into()));
        GeneralLedgerRows { integration, gather, output }
    }

    fn energy_limit(&mut self, step: &crate::model::Step) -> Option<EnergyLimit> {
        let limit = step.energy_limit?;
        let part = |name: &str, value: Option<f64>| value.map(|v| format!("{name} {v:e}"));
        let parts: Vec<String> =
            [part("error", limit.error), part("artificial", limit.artificial)].into_iter().flatten().collect();
        let detail = format!("{}, {}", parts.join(", "), if limit.halts { "halt" } else { "warn" });
        self.ledger_row(limit.span, "energy limit", 1, "step", detail);
        Some(limit)
    }

    fn check_complete(&mut self, deforms: bool) {
        if self.diagnostics.has_errors() {
            return;
        }
        if self.model.rigid_bodies.is_empty() && !deforms || self.model.steps.is_empty() {
            let missing =
                if self.model.steps.is_empty() { "step with *DYNAMIC, EXPLICIT" } else { "rigid or deformable body" };
            let what = if self.model.origin.last_card.is_some() { "deck" } else { "model" };
            let mut finding = Diagnostic::error("P006", format!("nothing to simulate: the {what} has no {missing}"));
            if let Some(card) = self.model.origin.last_card {
                finding = finding.at(card, "the deck ends after this card");
            }
            self.diagnostics.push(
                finding.help("a run needs a *RIGID BODY or a *SOLID SECTION, and a *STEP with *DYNAMIC, EXPLICIT"),
            );
        }
    }

    fn list_inert(&mut self) {
        for inert in &self.model.origin.inert {
            self.add_unused_card(inert.span, format!("*{}", inert.keyword), inert.why.clone());
        }
    }
}
