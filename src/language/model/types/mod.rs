//! Data types of the validated model: the deck with all references resolved. Most items keep the source position of the
//! card that defines them. Solver arrays and the choice of effects are made by `plan`.

mod adaptive;
mod body;
mod condition;
mod constraint;
mod contact;
mod handle;
mod load;
mod material;
mod mesh;
mod output;
mod section;
mod step;
mod strength;

use std::path::PathBuf;
use std::sync::Arc;

use indexmap::{IndexMap, IndexSet};

use super::shared::CopyOnWrite;
use super::units::DeckUnits;
use crate::deck::{Sources, Span};
pub use crate::kernel::bulk_viscosity::BulkViscosity;
pub use crate::kernel::interaction::{
    ContactDamping, CoulombFriction, FrictionRoutine, GapHeat, InteractionLaw, PressureOverclosure,
};
pub use crate::kernel::profile::{ProfileSegment, SurfaceProfile};
pub use adaptive::*;
pub use body::*;
pub use condition::*;
pub use constraint::*;
pub use contact::*;
pub use handle::*;
pub use load::*;
pub use material::*;
pub use mesh::*;
pub use output::*;
pub use section::*;
pub use step::*;
pub use strength::*;

/// A complete model, built from a deck or composed in Rust. `job::prepare_model` reports the errors of a composed
/// model.
///
/// ```
/// use revolve::job;
/// use revolve::model::{AmplitudeId, ElementKind, ElementSide, Load, Model, SideSelection, Step};
/// use revolve::user::Routines;
///
/// let mut model = Model::default();
/// let nodes = [model.node(0.0, 0.0), model.node(0.1, 0.0)];
/// let disc = model.element(ElementKind::Rax2, &nodes);
/// model.rigid_body("DISC", nodes[0], &[disc]);
/// model.mass(nodes[0], 2.0);
/// let top = SideSelection::new("TOP", &[(disc, ElementSide::Positive)]);
/// model.steps.push(Step::new("push", 1e-3).with_load(Load::pressure(top.clone(), 1e4)));
/// let (outcome, _) = job::run_in_memory(&job::prepare_model(&model, &Routines::none()));
/// assert!(outcome.halt.is_none());
///
/// // The model has no second amplitude.
/// model.steps[0].loads.push(Load::pressure(top, 1e4).with_amplitude(AmplitudeId::new(1)));
/// let refused = job::prepare_model(&model, &Routines::none()).diagnostics;
/// assert!(refused.iter().any(|d| d.code == "M112"));
/// ```
#[derive(Clone, Debug, Default)]
pub struct Model {
    /// Source text and ignored cards.
    pub origin: ModelOrigin,
    /// Title, units and absolute zero.
    pub settings: AnalysisSettings,
    /// Nodes and elements of all part instances.
    pub mesh: CopyOnWrite<Mesh>,
    /// Node sets by upper-case name, `INSTANCE.SET` for the set of an instance; members ascend.
    pub node_sets: IndexMap<String, MemberSet>,
    /// Element sets, named and ordered as node sets.
    pub element_sets: IndexMap<String, MemberSet>,
    /// Surfaces by upper-case name.
    pub surfaces: SurfaceDefinitions,
    /// Materials in deck order.
    pub materials: Vec<MaterialDefinition>,
    /// Materials assigned to solid elements (`*SOLID SECTION`).
    pub sections: Vec<SolidSection>,
    /// Materials and thicknesses assigned to shells (`*SHELL SECTION`).
    pub shell_sections: Vec<ShellSection>,
    /// Materials and constitutive thicknesses assigned to cohesive elements (`*COHESIVE SECTION`).
    pub cohesive_sections: Vec<CohesiveSection>,
    /// Criteria for element deletion (`*EROSION`).
    pub erosions: Vec<ErosionCriteria>,
    /// Bodies that are remeshed (`*REMESH`).
    pub remeshings: Vec<Remeshing>,
    /// Elements, in ascending order, whose bodies keep their mesh even if it collapses (`*REMESH, AUTOMATIC=NO`).
    pub kept_meshes: Vec<usize>,
    /// Amplitudes in deck order.
    pub amplitudes: Vec<Amplitude>,
    /// Rigid bodies in deck order.
    pub rigid_bodies: Vec<RigidBody>,
    /// Initial rotations of rigid bodies (`*ATTITUDE`).
    pub attitudes: Vec<InitialAttitude>,
    /// Point masses, rotary inertias, springs and dashpots.
    pub discrete: DiscreteElements,
    /// Contact properties by name (`*SURFACE INTERACTION`).
    pub interactions: Vec<SurfaceInteraction>,
    /// Equations, couplings and ties.
    pub constraints: NodeConstraints,
    /// `*INITIAL CONDITIONS` data lines.
    pub initial_conditions: Vec<InitialCondition>,
    /// Targets that are not meshed (`*TARGET`).
    pub targets: Vec<TargetStack>,
    /// Steps. Each lists everything in force during the step: propagation between steps and `OP=NEW` are already
    /// resolved.
    pub steps: Vec<Step>,
    /// Output expressions and time points that the output requests of all steps refer to.
    pub output: OutputDefinitions,
}

impl Model {
    /// Returns whether the analysis is adiabatic. All steps have the same setting as the first one.
    pub fn is_adiabatic(&self) -> bool {
        self.steps.first().is_some_and(|step| step.adiabatic)
    }

    /// Returns whether the steps solve for nodal temperatures. All steps have the same setting as the first one.
    pub fn solves_for_temperatures(&self) -> bool {
        self.steps.first().is_some_and(|step| step.coupled)
    }

    /// Returns whether the elements of a section conduct heat.
    pub fn conducts_heat(&self, section: &SolidSection) -> bool {
        let is_thermal = |e: &usize| self.mesh.elements[*e].kind.is_thermal();
        self.solves_for_temperatures() && section.elements.iter().any(is_thermal)
    }

    /// Returns whether a step has mass scaling.
    pub fn scales_masses(&self) -> bool {
        self.steps.iter().any(|step| !step.mass_scalings.is_empty())
    }

    /// Returns whether a step has an adaptive mesh.
    pub fn has_adaptive_mesh(&self) -> bool {
        self.steps.iter().any(|step| !step.adaptive.is_empty())
    }

    /// Returns whether a material has an equation of state.
    pub fn has_equation_of_state(&self) -> bool {
        self.materials.iter().any(|material| material.eos.is_some())
    }

    /// Returns the names of the sensors of all steps, each once: `*OUTPUT, HISTORY, SENSOR, NAME=`.
    pub fn sensor_names(&self) -> Vec<String> {
        let names = self.steps.iter().flat_map(|step| &step.outputs).filter_map(|request| request.sensor.clone());
        names.collect::<IndexSet<String>>().into_iter().collect()
    }
}

/// Files and cards from which a model was built.
#[derive(Clone, Debug, Default)]
pub struct ModelOrigin {
    /// Text of the deck and its included files; empty for a model composed in Rust.
    pub sources: Arc<Sources>,
    /// Last card of the deck; `None` for a model composed in Rust.
    pub last_card: Option<Span>,
    /// Whether all cards that define bodies were read without error. Messages of the plan about bodies are reliable
    /// only then.
    pub bodies_read: bool,
    /// Cards that were read but have no effect in this deck.
    pub inert: Vec<IgnoredCard>,
    /// Mesh files that were read.
    pub mesh_files: Vec<PathBuf>,
}

/// Settings that hold in all steps.
#[derive(Clone, Debug, Default)]
pub struct AnalysisSettings {
    /// The `*HEADING` text.
    pub title: String,
    /// Names of the units (`*UNITS`); `None` if the deck gives none.
    pub units: Option<DeckUnits>,
    /// Absolute zero on the temperature scale of the deck (`*PHYSICAL CONSTANTS`); default 0.
    pub absolute_zero: f64,
}

/// A card that was read but has no effect in this deck.
#[derive(Clone, Debug)]
pub struct IgnoredCard {
    /// Keyword without the asterisk.
    pub keyword: String,
    /// Source position of the card.
    pub span: Span,
    /// Reason, as printed in the ledger.
    pub why: String,
}
