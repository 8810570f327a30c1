//! The model: a deck with all names resolved and nothing decided. Validated data, each piece with the span that asked for it.
//! Never here: arrays for solving, decisions about effects.

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

use std::str::FromStr;
use std::sync::Arc;

use indexmap::IndexMap;

use super::shared::Shared;
use super::units::Units;
use crate::deck::{Sources, Span};
pub use crate::kernel::interaction::{Friction, GapHeat, Law, Overclosure};
pub use crate::kernel::profile::{Profile, Segment};
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

/// Everything a deck describes, or a scene composed in Rust: what is wrong with one is told when it is planned.
///
/// ```
/// use revolve::job;
/// use revolve::model::{AmplitudeId, ElementKind, Load, Model, Side, Sides, Step};
/// use revolve::user::Routines;
///
/// let mut model = Model::default();
/// let nodes = [model.node(0.0, 0.0), model.node(0.1, 0.0)];
/// let disc = model.element(ElementKind::Rax2, &nodes);
/// model.rigid_body("DISC", nodes[0], &[disc]);
/// model.mass(nodes[0], 2.0);
/// let top = Sides::new("TOP", &[(disc, Side::Positive)]);
/// model.steps.push(Step::new("push", 1e-3).with_load(Load::pressure(top.clone(), 1e4)));
/// let (outcome, _) = job::run_in_memory(&job::prepare_model(&model, &Routines::none()));
/// assert!(outcome.halt.is_none());
///
/// // There is no second amplitude.
/// model.steps[0].loads.push(Load::pressure(top, 1e4).with_amplitude(AmplitudeId::new(1)));
/// let refused = job::prepare_model(&model, &Routines::none()).diagnostics;
/// assert!(refused.iter().any(|d| d.code == "M112"));
/// ```
#[derive(Clone, Debug, Default)]
pub struct Model {
    /// Where it comes from, and what of that changes nothing.
    pub origin: Origin,
    /// Title, units, scale of temperature, precision.
    pub settings: Settings,
    /// Nodes and elements, parts and instances flattened.
    pub mesh: Shared<Mesh>,
    /// Node sets by upper-case name (qualified `INSTANCE.SET` where they belong to an instance); members ascending.
    pub node_sets: IndexMap<String, Set>,
    /// Element sets, as node sets.
    pub element_sets: IndexMap<String, Set>,
    /// Surfaces by upper-case name.
    pub surfaces: Surfaces,
    /// Materials in deck order.
    pub materials: Vec<Material>,
    /// `*SOLID SECTION` assignments.
    pub sections: Vec<SolidSection>,
    /// `*SHELL SECTION` assignments.
    pub shell_sections: Vec<ShellSection>,
    /// `*EROSION`.
    pub erosions: Vec<Erosion>,
    /// Amplitudes in deck order.
    pub amplitudes: Vec<Amplitude>,
    /// Rigid bodies in deck order.
    pub rigid_bodies: Vec<RigidBody>,
    /// `*ATTITUDE`.
    pub attitudes: Vec<Attitude>,
    /// Masses, rotary inertias, springs and dashpots.
    pub discrete: DiscreteElements,
    /// `*SURFACE INTERACTION`s.
    pub interactions: Vec<Interaction>,
    /// Equations, couplings and ties.
    pub constraints: Constraints,
    /// `*INITIAL CONDITIONS`.
    pub initial_conditions: Vec<InitialCondition>,
    /// `*TARGET` stacks.
    pub targets: Vec<Target>,
    /// Steps; each lists everything in force in it (propagation and OP=NEW already worked out).
    pub steps: Vec<Step>,
    /// What output requests of all steps refer to.
    pub output: OutputDefinitions,
}

/// Where a model comes from.
#[derive(Clone, Debug, Default)]
pub struct Origin {
    /// Where its spans lead; empty if it is composed in Rust.
    pub sources: Arc<Sources>,
    /// The last card of the deck; `None` if it is composed in Rust.
    pub last_card: Option<Span>,
    /// Whether everything that bodies are made of was read without error: messages of a plan about bodies are reliable then.
    pub bodies_read: bool,
    /// Cards that were read but change nothing in this deck.
    pub inert: Vec<Inert>,
}

/// Settings of the whole analysis.
#[derive(Clone, Debug, Default)]
pub struct Settings {
    /// The `*HEADING` text.
    pub title: String,
    /// Names of units; `None` where the deck gives none.
    pub units: Option<Units>,
    /// Absolute zero of temperature, of `*PHYSICAL CONSTANTS`; 0 if not given.
    pub absolute_zero: f64,
    /// Precision of what can be in either.
    pub precision: Precision,
}

/// Precision of the numbers of elements. Nodes, sums and energies are in double precision.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// 53 bits.
    #[default]
    Double,
    /// 24 bits, of elements that have it; faster.
    Single,
}

/// A word that names no precision.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the precision is double or single")]
pub struct UnknownPrecision;

impl FromStr for Precision {
    type Err = UnknownPrecision;

    fn from_str(text: &str) -> Result<Self, UnknownPrecision> {
        match text {
            "double" => Ok(Precision::Double),
            "single" => Ok(Precision::Single),
            _ => Err(UnknownPrecision),
        }
    }
}

impl Precision {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Precision::Double => "double",
            Precision::Single => "single",
        }
    }
}

/// A card that was read but changes nothing here.
#[derive(Clone, Debug)]
pub struct Inert {
    /// Keyword.
    pub keyword: String,
    /// The card.
    pub span: Span,
    /// Why it changes nothing.
    pub why: String,
}
