//! Steps: procedure, increment control, and what is in force.
//! Never here: the time loop.

use super::{Boundary, GeneralContact, Interval, Load, OutputRequest, PrescribedField, SurfaceContact};
use crate::deck::Span;
use crate::kernel::interaction::Friction;

/// One step.
#[derive(Clone, Debug)]
pub struct Step {
    /// Name (or `Step-1`, …).
    pub name: String,
    /// The `*DYNAMIC` card.
    pub span: Span,
    /// Length of the step, time.
    pub duration: f64,
    /// How the increment is chosen.
    pub increment: IncrementControl,
    /// Factor on an automatic increment.
    pub scale_factor: f64,
    /// What velocity a load is shown.
    pub load_velocity: LoadVelocity,
    /// Linear and quadratic bulk viscosity.
    pub bulk_viscosity: [f64; 2],
    /// Whether heat stays where plastic work makes it (`ADIABATIC`).
    pub adiabatic: bool,
    /// Whether temperatures of nodes are solved for (`*DYNAMIC TEMPERATURE-DISPLACEMENT`).
    pub coupled: bool,
    /// Prescribed motions in force, each with the nodes on which no later one acts.
    pub boundaries: Vec<Boundary>,
    /// Loads in force, each at the places where no later step gives another of its kind.
    pub loads: Vec<Load>,
    /// Field variables in force, each with the nodes to which no later one gives another value.
    pub fields: Vec<PrescribedField>,
    /// Contact of pairs of surfaces in force.
    pub surface_contacts: Vec<SurfaceContact>,
    /// General contact in force.
    pub general_contact: Option<GeneralContact>,
    /// Mass scaling in force, in the order of the deck.
    pub mass_scalings: Vec<MassScaling>,
    /// Limits on energies in force.
    pub energy_limit: Option<EnergyLimit>,
    /// Output requests in force.
    pub outputs: Vec<OutputRequest>,
    /// When the state is kept, if the deck asks.
    pub restart: Option<Restart>,
}

impl Step {
    /// Whether anything may meet.
    pub fn has_contact(&self) -> bool {
        !self.surface_contacts.is_empty() || self.general_contact.is_some()
    }

    /// Friction of all surfaces that may meet.
    pub fn frictions(&self) -> impl Iterator<Item = &Friction> {
        let assigned = self.general_contact.iter().flat_map(|g| &g.assigned).map(|a| &a.law);
        self.surface_contacts.iter().map(|c| &c.law).chain(assigned).map(|law| &law.friction)
    }

    /// The same, to be changed.
    pub fn frictions_mut(&mut self) -> impl Iterator<Item = &mut Friction> {
        let assigned = self.general_contact.iter_mut().flat_map(|g| &mut g.assigned).map(|a| &mut a.law);
        self.surface_contacts.iter_mut().map(|c| &mut c.law).chain(assigned).map(|law| &mut law.friction)
    }
}

/// `*RESTART, WRITE`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Restart {
    /// How often.
    pub interval: Interval,
    /// The card.
    pub span: Span,
}

/// `*ENERGY LIMIT`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnergyLimit {
    /// The card.
    pub span: Span,
    /// Of the drift of ETOTAL over the largest energy.
    pub error: Option<f64>,
    /// Of ALLAE over ALLIE.
    pub artificial: Option<f64>,
    /// Whether the run halts; otherwise it warns.
    pub halts: bool,
}

/// `*FIXED MASS SCALING` or `*VARIABLE MASS SCALING`.
#[derive(Clone, Debug, PartialEq)]
pub struct MassScaling {
    /// The card.
    pub span: Span,
    /// Elements; all if `None`.
    pub elements: Option<Vec<usize>>,
    /// Factor on the mass (1 if not given).
    pub factor: f64,
    /// Stable increment aimed at, time, and how.
    pub target: Option<(ScalingType, f64)>,
    /// When it is done again; `None` for a fixed one, which is done once.
    pub rhythm: Option<ScalingRhythm>,
}

/// `TYPE` of mass scaling.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ScalingType {
    /// Elements below the target are brought up to it.
    BelowMin,
    /// One factor for all.
    Uniform,
    /// All are brought to it.
    SetEqual,
}

/// How often `*VARIABLE MASS SCALING` is done again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ScalingRhythm {
    /// `FREQUENCY`: every so many increments.
    Increments(u64),
    /// `NUMBER INTERVAL`: so many times in the step.
    Intervals(u64),
}

/// How the increment is chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum IncrementControl {
    /// By the stability limit, or by an error estimate where nothing limits it; `accuracy` is the relative error aimed at.
    Automatic {
        /// Relative error of the motion aimed at (default 1e-4).
        accuracy: f64,
        /// `ELEMENT BY ELEMENT`.
        element_by_element: bool,
        /// Largest increment, time; infinite where the deck gives none.
        largest: f64,
    },
    /// `DIRECT USER CONTROL`: this increment.
    Fixed(f64),
}

/// What velocity a load is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LoadVelocity {
    /// A second-order estimate at the increment's own time (default).
    Predicted,
    /// The mid-increment velocity behind, as ABAQUS passes it.
    Lagged,
}
