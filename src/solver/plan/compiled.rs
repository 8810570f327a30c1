//! The compiled plan and its steps.

use crate::model::{CopyOnWrite, EnergyLimit, IncrementControl, LoadVelocity, Mesh, Model};
use crate::plan::ledger::Ledger;
use crate::plan::{
    AutomaticMeshes, ColumnSource, FrameField, FrameLabels, HistoryColumn, IntegratedSection, MeshRenewal,
    PlannedRange, PlannedRigidBody, RemeshPlan, RowExpression, SolidPlaces, StepChanges, StepOutputs,
};
use crate::remesh::interpolation::TracerPoint;
use crate::state::EffectId;
use crate::user::Routines;

/// A compiled analysis: the effects that the deck requests. A plan is immutable; it can be run many times, on several
/// threads at once, each time from its own [`State`](super::State).
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
    /// Points between solver nodes that history columns show.
    pub tracers: Vec<TracerPoint>,
    /// Members of the sets over which history columns are statistics.
    pub sets: Vec<Vec<ColumnSource>>,
    /// Expressions of columns that are computed from previous columns.
    pub expressions: Vec<RowExpression>,
    /// Columns that user amplitudes read, in the order of [`Model::sensor_names`](crate::model::Model::sensor_names).
    pub sensors: Vec<HistoryColumn>,
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
    /// Bodies without a card that have a new mesh once theirs collapses.
    pub automatic_meshes: Option<AutomaticMeshes>,
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
    /// Cards that may renew the mesh of each element group; empty in a deck with `*REMESH`.
    pub renewals: Vec<MeshRenewal>,
    /// Ranges in which the constants of materials hold.
    pub ranges: Vec<PlannedRange>,
    /// Contact pairs of two surfaces, by their names; without self-contact and general contact.
    pub contact_pairs: Vec<String>,
    /// Element groups of plastic materials, with the initial yield stress of each.
    pub yield_stresses: Vec<(usize, f64)>,
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
    pub(crate) fn of(model: &Model) -> MeshCards {
        MeshCards {
            erodes: model.erosions.iter().any(|e| e.increment.is_some() || e.distortion.is_some()),
            controls_distortion: model.sections.iter().any(|s| s.controls.distortion.is_some()),
            scales_masses: model.scales_masses(),
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
/// the first step are in the initial [`State`](super::State).
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
    /// Whether the mass of nodes whose elements are all deleted joins their body (`NODAL EROSION=MERGE`).
    pub merges_detached_nodes: bool,
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
        self.control.is_fixed()
    }
}

impl Plan {
    /// Returns the names of the history columns.
    pub fn column_names(&self) -> Vec<String> {
        self.columns.iter().map(|c| c.name.clone()).collect()
    }

    /// Sets the duration of the last step, also in the models from which plans of new meshes are compiled.
    pub fn set_last_duration(&mut self, duration: f64) {
        let Some(step) = self.steps.last_mut().filter(|step| step.duration != duration) else { return };
        step.duration = duration;
        let set = |model: &mut Model| model.steps.last_mut().into_iter().for_each(|step| step.duration = duration);
        self.remesh.iter_mut().for_each(|remesh| set(&mut remesh.model));
        self.automatic_meshes.iter_mut().for_each(|waiting| set(waiting.model_mut()));
    }

    /// Returns the name of an element, given its group and its index in the group.
    pub fn element_name(&self, group: usize, element: usize) -> &str {
        self.places.element_at((group, element)).map_or("", |e| &self.mesh.elements[e].name)
    }

    /// Returns the name of the material of an element, given its group and its index in the group; empty without one.
    pub fn material_name(&self, group: usize, element: usize) -> &str {
        self.places.element_at((group, element)).map_or("", |e| self.labels.material_name(e))
    }
}
