//! The meeting point: model in, effects out, with the ledger that says which and why. The one place that decides.
//! Never here: time stepping.

mod analytical;
mod averaging;
mod bodies;
mod bytes;
pub mod changes;
pub mod codes;
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
mod precision;
pub(crate) mod revise;
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
mod ties;
mod user;
mod user_material;
mod wall_contact;

use std::collections::HashSet;
use std::rc::Rc;

use indexmap::IndexMap;

use crate::constraint::tie::Tie;
use crate::deck::{Diagnostic, Diagnostics, Span};
use crate::kernel::amplitude::SampledAmplitude;
use crate::load::user_amplitude::UserAmplitude;
use crate::model::{
    AmplitudeId, EnergyLimit, IncrementControl, InitialCondition, InitialKind, LoadVelocity, Material, Mesh, Model,
    Precision, Shared, SurfaceContact,
};
use crate::state::EffectId;
pub use crate::state::dofs::{Dof, Dofs};
use crate::user::Routines;
pub use bodies::Body;
pub use changes::Changes;
pub use expressions::RowExpression;
pub use labels::Labels;
use ledger::{Ledger, Unused};
pub use outputs::{Column, FrameField, Outputs, Schedule, Section, Source};
pub use places::Places;
pub use solid::SolidPlaces;
pub use state::State;

/// What is to be run: every effect the deck asks for, and nothing else. It never changes: it runs as often as one likes, on
/// several threads at once, each time from a [`State`].
#[derive(Default)]
pub struct Plan {
    /// What exists and why.
    pub ledger: Ledger,
    /// Nodes and elements, for frames.
    pub mesh: Shared<Mesh>,
    /// Rigid bodies.
    pub bodies: Vec<Body>,
    /// Where nodes and elements of what deforms are in the mesh.
    pub places: SolidPlaces,
    /// Steps in order.
    pub steps: Vec<StepPlan>,
    /// Names of the history columns, the same in every step.
    pub columns: Vec<Column>,
    /// Surfaces that columns are integrals over.
    pub sections: Vec<Section>,
    /// Members of sets that columns are statistics over.
    pub sets: Vec<Vec<Source>>,
    /// Columns that follow from those before them.
    pub expressions: Vec<RowExpression>,
    /// Arrays of frames.
    pub fields: Vec<FrameField>,
    /// The user's routines, whose own memory no state of the run holds.
    pub routines: Routines,
    /// Rows of the ledger that belong to the integrator.
    pub rows: Rows,
    /// By what nodes and elements are found in frames.
    pub labels: Labels,
    /// Whether elements may give energy that no load has given them: gases, explosives, stress at the start, temperatures,
    /// moduli that change, routines of the user.
    pub stores_energy: bool,
    /// Precision that was asked for.
    pub precision: Precision,
}

/// Rows of the ledger for what no card asks for by name.
#[derive(Clone, Copy, Debug, Default)]
pub struct Rows {
    /// Central differences, the energy balance, the choice of the increment.
    pub integration: Option<EffectId>,
    /// From corners of elements to accelerations of nodes.
    pub gather: Option<EffectId>,
    /// Frames and histories.
    pub output: Option<EffectId>,
}

/// One step: how it goes, and what it changes of what is in force in the step before; the first changes nothing of the state at
/// the start.
pub struct StepPlan {
    /// Name.
    pub name: String,
    /// Length, time.
    pub duration: f64,
    /// How the increment is chosen.
    pub control: IncrementControl,
    /// Factor on an automatic increment.
    pub scale_factor: f64,
    /// What velocity loads are shown.
    pub load_velocity: LoadVelocity,
    /// What it changes.
    pub changes: Changes,
    /// Limits on energies; `None` without any.
    pub energy_limit: Option<EnergyLimit>,
    /// When to write.
    pub outputs: Outputs,
}

impl StepPlan {
    /// Whether the deck bounds the drift of ETOTAL itself.
    pub fn has_drift_limit(&self) -> bool {
        self.energy_limit.is_some_and(|limit| limit.error.is_some())
    }
}

impl Plan {
    /// Names of the history columns.
    pub fn column_names(&self) -> Vec<String> {
        self.columns.iter().map(|c| c.name.clone()).collect()
    }

    /// Name of an element by its group and its number there.
    pub fn element_name(&self, group: usize, element: usize) -> &str {
        let found = self.places.elements.iter().find(|e| *e.1 == (group, element));
        found.map_or("", |(&e, _)| &self.mesh.elements[e].name)
    }
}

/// What compilation carries along.
struct Compiler<'a> {
    model: &'a Model,
    routines: &'a Routines,
    diagnostics: Diagnostics,
    ledger: Ledger,
    causes: IndexMap<(Span, &'static str), EffectId>,
    bodies: Vec<Body>,
    body_of_node: IndexMap<usize, usize>,
    body_of_element: IndexMap<usize, usize>,
    /// Where what deforms is in the mesh.
    places: SolidPlaces,
    /// User amplitudes, and by the amplitude's index in the model which function of time each tells.
    amplitudes: Vec<UserAmplitude>,
    tellers: IndexMap<AmplitudeId, usize>,
    /// Number of functions of time that user amplitudes and motions give.
    user_amplitude_count: usize,
    /// Nodes that each rigid body carries.
    ties: Vec<Tie>,
    /// Surfaces that columns are integrals over.
    sections: Vec<Section>,
    /// Members of sets that columns are statistics over.
    sets: Vec<Vec<Source>>,
    /// Columns that follow from others.
    expressions: Vec<RowExpression>,
    /// Nodes of slave surfaces with their places on the masters.
    surface_ties: Vec<surface_ties::TiedNode>,
    /// What keeps nodes together.
    kept: links::Kept,
    /// Degrees of freedom of nodes without mass that nothing keeps.
    idle: HashSet<(usize, usize)>,
    /// Pairs of surfaces of elements that may meet in each step, and the names of all of them, as histories have them.
    pairs: Vec<Rc<Vec<SurfaceContact>>>,
    pair_names: Vec<String>,
    /// What the step planned last has in force.
    in_force: steps::InForce<'a>,
    /// Routines of the user that something calls.
    called: Vec<&'static str>,
}

/// Decides which effects a model brings to life. `routines` serve what the deck leaves to the user. Gives the plan, the state at
/// its start, and what was found; the plan may be run only where that holds no error.
pub fn compile(model: &Model, routines: &Routines) -> (Plan, State, Diagnostics) {
    compile_with(model, routines, &mut |_, _| {})
}

/// The same; `look` sees the compiler when it has made all, where it found no error.
fn compile_with(
    model: &Model,
    routines: &Routines,
    look: &mut dyn FnMut(&Compiler<'_>, &State),
) -> (Plan, State, Diagnostics) {
    let mut diagnostics = model.check();
    if diagnostics.has_errors() {
        return (Plan::default(), State::default(), diagnostics);
    }
    let surface_ties = surface_ties::find(model, &mut diagnostics);
    let adjusted = surface_ties::adjusted(model, &surface_ties);
    let model = adjusted.as_ref().unwrap_or(model);
    let mut compiler = Compiler {
        model,
        routines,
        places: SolidPlaces::default(),
        amplitudes: Vec::new(),
        tellers: IndexMap::new(),
        user_amplitude_count: 0,
        ties: Vec::new(),
        sections: Vec::new(),
        sets: Vec::new(),
        expressions: Vec::new(),
        surface_ties,
        kept: links::Kept::default(),
        idle: HashSet::new(),
        pairs: Vec::new(),
        pair_names: Vec::new(),
        in_force: steps::InForce::default(),
        called: Vec::new(),
        diagnostics: Diagnostics::default(),
        ledger: Ledger::default(),
        causes: IndexMap::new(),
        bodies: Vec::new(),
        body_of_node: IndexMap::new(),
        body_of_element: IndexMap::new(),
    };
    compiler.bodies();
    let mut state = compiler.solids();
    compiler.keep(&mut state);
    compiler.connect(&mut state);
    compiler.finish_bodies();
    state.thermal = compiler.thermal(&state);
    state.elements.fields = compiler.predefined_fields(&state);
    state.dofs.bodies = compiler.bodies_at_start();
    compiler.erosion(&mut state);
    compiler.find_pairs();
    let (columns, fields) = compiler.variables(&mut state);
    let steps = compiler.steps(&mut state);
    compiler.scale_and_estimate(&mut state);
    compiler.refuse_on_spatial_bodies();
    compiler.check_complete(!state.elements.is_empty());
    compiler.tell_overlaps();
    compiler.list_inert();
    compiler.doubts(&state);
    compiler.tell_precision(&state);
    compiler.events_row();
    compiler.note_uncalled();
    let rows = compiler.integration_rows(&state, columns.len() + fields.len());
    if !compiler.diagnostics.has_errors() {
        look(&compiler, &state);
    }
    state.user_amplitudes = vec![SampledAmplitude::default(); compiler.user_amplitude_count];
    state.amplitude_routines = compiler.amplitudes;
    let Compiler { ledger, bodies, places, sections, sets, expressions, diagnostics: found, .. } = compiler;
    let labels = Labels::of(model);
    diagnostics.append(found);
    // Notes on a plan that cannot run would only bury what is wrong with it.
    if diagnostics.has_errors() {
        diagnostics.keep_errors();
    }
    let (mesh, routines) = (model.mesh.clone(), routines.clone());
    let stores_energy = stores_energy(model);
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
        stores_energy,
        precision: model.settings.precision,
    };
    bytes::book(&mut plan, &state);
    (plan, state, diagnostics)
}

/// Whether a material or a condition at the start can release energy that was not brought in.
fn stores_energy(model: &Model) -> bool {
    let of_material = |m: &Material| {
        m.eos.is_some()
            || m.user.material.is_some()
            || m.thermal.expansion.is_some()
            || !m.elastic_table.is_empty()
            || m.user.fields.is_some()
    };
    let at_start = |c: &InitialCondition| matches!(c.kind, InitialKind::Stress(_) | InitialKind::Energy(_));
    model.materials.iter().any(of_material) || model.initial_conditions.iter().any(at_start)
}

impl Compiler<'_> {
    /// The ledger row of an effect that a span asked for; made at the first asking, so that a load that stays in force
    /// over several steps has one row.
    fn cause(
        &mut self,
        span: Span,
        effect: &'static str,
        count: usize,
        unit: &'static str,
        detail: String,
    ) -> EffectId {
        if let Some(&cause) = self.causes.get(&(span, effect)) {
            return cause;
        }
        let asked_by = self.model.origin.sources.describe(span);
        let cause = self.ledger.add(effect, count, unit, asked_by, detail);
        self.causes.insert((span, effect), cause);
        cause
    }

    /// Notes a card that brings nothing to life.
    fn unused(&mut self, span: Span, what: impl Into<String>, why: impl Into<String>) {
        let unused = Unused { what: what.into(), asked_by: self.model.origin.sources.describe(span), why: why.into() };
        if !self.ledger.unused.contains(&unused) {
            self.ledger.unused.push(unused);
        }
    }

    fn scale_and_estimate(&mut self, state: &mut State) {
        if state.elements.is_empty() {
            return;
        }
        if self.model.steps.iter().any(|s| !s.mass_scalings.is_empty()) {
            let left = self.unscaled_nodes(state.dofs.nodes.len());
            state.elements.remember_masses(&state.dofs.nodes, left);
        }
        self.highest_frequency(state);
    }

    /// Rows of what no card asks for by name; the first step's asks for all of it.
    fn integration_rows(&mut self, state: &State, shown: usize) -> Rows {
        let Some(step) = self.model.steps.first() else { return Rows::default() };
        let integration = self.causes.get(&(step.span, "central difference")).copied();
        let nodes = state.dofs.nodes.len() - self.places.rotations.len();
        let detail = "corner forces, masses and motion of nodes";
        let gather = (nodes > 0).then(|| self.cause(step.span, "nodes", nodes, "nodes", detail.into()));
        let detail = "mesh, frames, histories";
        let output = Some(self.cause(step.span, "output", shown, "variables", detail.into()));
        Rows { integration, gather, output }
    }

    fn energy_limit(&mut self, step: &crate::model::Step) -> Option<EnergyLimit> {
        let limit = step.energy_limit?;
        let part = |name: &str, value: Option<f64>| value.map(|v| format!("{name} {v:e}"));
        let parts: Vec<String> =
            [part("error", limit.error), part("artificial", limit.artificial)].into_iter().flatten().collect();
        let detail = format!("{}, {}", parts.join(", "), if limit.halts { "halt" } else { "warn" });
        self.cause(limit.span, "energy limit", 1, "step", detail);
        Some(limit)
    }

    fn check_complete(&mut self, deforms: bool) {
        if self.diagnostics.has_errors() {
            return;
        }
        if self.model.rigid_bodies.is_empty() && !deforms || self.model.steps.is_empty() {
            let missing = if self.model.steps.is_empty() { "step with *DYNAMIC, EXPLICIT" } else { "body that moves" };
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
            self.unused(inert.span, format!("*{}", inert.keyword), inert.why.clone());
        }
    }
}
