//! Compilation of a model to a plan: decides which effects the run contains, creates them, and lists them in the
//! ledger. Time integration is in `solve`.

mod bodies;
mod bytes;
pub mod changes;
mod checks;
pub mod codes;
mod compiled;
mod constraints;
mod contact;
mod heat;
pub mod ledger;
mod loads;
mod meshes;
mod output;
mod queries;
mod report;
pub mod revise;
mod scene;
mod solids;
mod state;
mod steps;

use std::sync::Arc;

use crate::deck::Diagnostics;
use crate::kernel::amplitude::SampledAmplitude;
use crate::model::remesh::placed_for_ties;
use crate::model::{MaterialDefinition, Model};
pub use crate::state::dofs::{Dof, Dofs};
use crate::user::Routines;
pub(crate) use bodies::rigid_body::Bodies;
pub use bodies::rigid_body::PlannedRigidBody;
pub use changes::StepChanges;
pub use checks::plausibility::unit_warning;
pub use compiled::{GeneralLedgerRows, MeshCards, Plan, StepPlan};
pub(crate) use constraints::link_set::Links;
pub use meshes::automatic::{AutomaticMeshes, FirstMesh};
pub use meshes::labels::FrameLabels;
pub use meshes::pieces::pieces;
pub use meshes::places::{MeshIndexMap, SolidPlaces};
pub use meshes::remesh::{RemeshPlan, RemeshedBody};
pub use meshes::renewal::MeshRenewal;
pub(crate) use output::Columns;
pub use output::expressions::RowExpression;
pub use output::{
    ColumnSource, ElementCorner, FrameField, HistoryColumn, IntegratedSection, StepOutputs, WriteSchedule,
};
pub(crate) use report::{LedgerRows, Report};
pub(crate) use scene::{GroupInput, Pairs, Scene, Shared, StepInput};
pub use solids::ranges::PlannedRange;
pub use state::State;
use steps::PlannedSteps;

/// A plan, its initial state, and the products that a revision of the plan needs.
#[derive(Default)]
struct Compilation {
    plan: Plan,
    state: State,
    diagnostics: Diagnostics,
    /// Rigid bodies without their list, which is in the plan.
    bodies: Bodies,
    shared: Shared,
    ledger_rows: LedgerRows,
    has_contact: bool,
}

/// A plan, its initial state, and the diagnostics. The plan may be run only if there is no error.
#[derive(Default)]
pub struct CompiledModel {
    /// What does not change in a run.
    pub plan: Plan,
    /// The initial state.
    pub state: State,
    /// Errors, warnings and notes.
    pub diagnostics: Diagnostics,
}

/// Compiles a model. `routines` are the user subroutines that the deck may call.
pub fn compile(model: &Model, routines: &Routines) -> CompiledModel {
    let Compilation { plan, state, diagnostics, .. } = compile_with_products(model, None, routines);
    CompiledModel { plan, state, diagnostics }
}

/// Compiles a model as [`compile`] does. The plan shares the model, where a copy would need memory.
pub fn compile_shared(model: &Arc<Model>, routines: &Routines) -> CompiledModel {
    let Compilation { plan, state, diagnostics, .. } = compile_with_products(model, Some(model), routines);
    CompiledModel { plan, state, diagnostics }
}

/// Compiles a model: each pass is a function of the products that it needs, and returns its own.
fn compile_with_products(model: &Model, shared_model: Option<&Arc<Model>>, routines: &Routines) -> Compilation {
    let mut diagnostics = model.check();
    if diagnostics.has_errors() {
        return Compilation { diagnostics, ..Compilation::default() };
    }
    let placed = placed_for_ties(model);
    let attached = constraints::surface_ties::find_attached_nodes(placed.as_ref().unwrap_or(model), &mut diagnostics);
    let adjusted = constraints::surface_ties::adjusted(model, &attached);
    let model = adjusted.as_ref().unwrap_or(model);
    let surface_ties = constraints::tie_equations::tie_equations(placed.as_ref().unwrap_or(model), &attached);
    let mut report = Report::new(model, routines);
    let mut bodies = bodies::plan(model, &surface_ties, &mut report);
    let solids::Solids { places, ties, state: mut solid_state } =
        solids::plan(model, &mut bodies, &surface_ties, &mut report);
    let scene = Scene { model, bodies: &bodies, places: &places };
    let links = constraints::plan(scene, Links::of_ties(surface_ties, ties), &mut solid_state, &mut report);
    let velocities = bodies::start(scene, &mut report);
    let thermal = heat::plan(scene, &links, &solid_state, &mut report);
    solid_state.elements.fields = heat::fields::plan(scene, &solid_state, &mut report);
    let body_states = bodies::rigid_bodies_3d::initial_states(scene, &velocities, &mut report);
    let eroding = solids::erosion::plan(scene, State::new(solid_state, body_states, thermal), &mut report);
    let pairs = contact::general::find_pairs(scene, &mut report);
    let (columns, recording) = output::plan(scene, &pairs, eroding, &mut report);
    let PlannedSteps { list: steps, fronts, mut state } = steps::plan(scene, &links, &pairs, recording, &mut report);
    solids::scale_and_estimate(scene, &links, &mut state, &mut report);
    bodies::rigid_bodies_3d::refuse_on_spatial_bodies(scene, &links, &mut report);
    let remesh = meshes::remesh::plan(scene, (&links, &pairs), &fronts, &mut state, &mut report);
    let shared_model = shared_model.filter(|_| adjusted.is_none());
    let renewals = MeshRenewal::plan(scene, (&links, &pairs), &mut state, &report);
    let automatic_meshes =
        AutomaticMeshes::plan(scene, shared_model, (&pairs, &renewals), &fronts, &mut state, &report);
    checks::check_plan(scene, &links, &pairs, &state, &mut report);
    let rows = steps::integration_rows(scene, &state, columns.list.len() + columns.fields.len(), &mut report);
    let has_contact = pairs.by_step.iter().any(|pairs| !pairs.is_empty());
    state.user_amplitudes = vec![SampledAmplitude::default(); report.shared.amplitude_count];
    state.amplitude_routines = std::mem::take(&mut report.shared.amplitudes);
    let corners = columns.sections.iter().flat_map(|section| &section.corners);
    state.elements.tile(corners.map(|corner| (corner.group, corner.element)));
    let ranges = solids::ranges::plan(scene, &mut report);
    let yield_stresses = checks::expected_action::yield_stresses(scene);
    let Report { ledger, ledger_rows, diagnostics: plan_diagnostics, shared, .. } = report;
    let list = bodies.take_list(&velocities);
    diagnostics.append(plan_diagnostics);
    // If there are errors, warnings and notes would only hide them.
    if diagnostics.has_errors() {
        diagnostics.keep_errors();
    }
    let mut plan = Plan {
        ledger,
        mesh: model.mesh.clone(),
        bodies: list,
        places,
        steps,
        columns: columns.list,
        sections: columns.sections,
        tracers: columns.tracers,
        sets: columns.sets.into_iter().collect(),
        expressions: columns.expressions,
        sensors: columns.sensors.into_values().collect(),
        fields: columns.fields,
        routines: Routines { load_properties: shared.load_properties, ..routines.clone() },
        rows,
        labels: FrameLabels::of(model),
        remesh,
        automatic_meshes,
        mesh_cards: MeshCards::of(model),
        renewals,
        stiffening: stiffening(model),
        returns_heat: model.materials.iter().any(|m| m.is_ideal_gas() || m.is_explosive()),
        has_equation_of_state: model.has_equation_of_state(),
        has_user_stress: model.materials.iter().any(|m| m.user.material.is_some()),
        ranges,
        contact_pairs: checks::expected_action::names_of_pairs(model),
        yield_stresses,
        expects_dissipation: expects_dissipation(model),
    };
    bytes::record_bytes(&mut plan, &state);
    Compilation { plan, state, diagnostics, bodies, shared, ledger_rows, has_contact }
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
    let is_damped = |m: &MaterialDefinition| m.damping.is_some();
    model.has_equation_of_state() || model.materials.iter().any(is_damped) || !model.discrete.connectors.is_empty()
}
