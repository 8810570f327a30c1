//! Analysis steps: procedure, increment control, and the conditions in force.

use super::{
    AdaptiveMesh, AdaptiveRegion, BoundaryCondition, DetachedNodes, GeneralContact, Load, OutputInterval,
    OutputRequest, PrescribedField, SurfaceContact,
};
use crate::deck::Span;
use crate::kernel::bulk_viscosity::BulkViscosity;
use crate::kernel::interaction::{CoulombFriction, InteractionLaw};

/// An analysis step, with its loads, contacts and output requests. [`Step::new`] sets what is not zero by default.
#[derive(Clone, Debug, Default)]
pub struct Step {
    /// Name; `Step-1`, `Step-2`, … if the deck gives none.
    pub name: String,
    /// Source position of the `*DYNAMIC` card.
    pub span: Span,
    /// Step duration, time.
    pub duration: f64,
    /// Choice of the time increment.
    pub increment: IncrementControl,
    /// Scale factor of automatic time increments.
    pub scale_factor: f64,
    /// Velocity passed to loads.
    pub load_velocity: LoadVelocity,
    /// Bulk viscosity.
    pub bulk_viscosity: BulkViscosity,
    /// Whether heat conduction is neglected and plastic work heats the material locally (`ADIABATIC`).
    pub adiabatic: bool,
    /// Whether nodal temperatures are solved for (`*DYNAMIC TEMPERATURE-DISPLACEMENT`).
    pub coupled: bool,
    /// Whether heat rates of conduction are evaluated in each increment (`CONDUCTION=CURRENT`), not held over several ones.
    pub current_conduction: bool,
    /// Prescribed motions in force, each with the nodes that no later condition overrides.
    pub boundaries: Vec<BoundaryCondition>,
    /// Loads in force, each in the region that no load of a later step replaces.
    pub loads: Vec<Load>,
    /// Prescribed temperatures and field variables in force, each with the nodes that no later value overrides.
    pub fields: Vec<PrescribedField>,
    /// Contact pairs in force.
    pub surface_contacts: Vec<SurfaceContact>,
    /// General contact in force.
    pub general_contact: Option<GeneralContact>,
    /// Mass scaling in force, in deck order.
    pub mass_scalings: Vec<MassScaling>,
    /// Adaptive meshes in force.
    pub adaptive: Vec<AdaptiveMesh>,
    /// Nodes that adaptive meshes do not move, by card.
    pub adaptive_fixed: Vec<(Span, Vec<usize>)>,
    /// Parts of the boundaries of adaptive meshes with another region type than the default.
    pub adaptive_regions: Vec<AdaptiveRegion>,
    /// Motions of adaptive meshes that are prescribed in space.
    pub mesh_motions: Vec<BoundaryCondition>,
    /// Energy limits in force.
    pub energy_limit: Option<EnergyLimit>,
    /// Output requests in force.
    pub outputs: Vec<OutputRequest>,
    /// Restart output; `None` if not requested.
    pub restart: Option<RestartRequest>,
}

impl Step {
    /// Returns whether contact is defined in the step.
    pub fn has_contact(&self) -> bool {
        !self.surface_contacts.is_empty() || self.general_contact.is_some()
    }

    /// Returns whether nodes without elements are taken out of contact.
    pub fn excludes_detached_nodes(&self) -> bool {
        self.general_contact.as_ref().is_some_and(GeneralContact::excludes_detached_nodes)
    }

    /// Returns whether the mass of nodes without elements joins their bodies.
    pub fn merges_detached_nodes(&self) -> bool {
        self.general_contact.as_ref().is_some_and(|general| general.detached_nodes == DetachedNodes::Merged)
    }

    /// Iterates over the friction laws of all contact definitions.
    pub fn frictions(&self) -> impl Iterator<Item = &CoulombFriction> {
        let assigned = self.general_contact.iter().flat_map(|g| &g.assigned).map(|a| &a.law);
        self.surface_contacts.iter().map(|c| &c.law).chain(assigned).map(|law| &law.friction)
    }

    /// Iterates over the laws of all contact definitions, mutably.
    pub fn contact_laws_mut(&mut self) -> impl Iterator<Item = &mut InteractionLaw> {
        let assigned = self.general_contact.iter_mut().flat_map(|g| &mut g.assigned).map(|a| &mut a.law);
        self.surface_contacts.iter_mut().map(|c| &mut c.law).chain(assigned)
    }
}

/// Restart output request (`*RESTART, WRITE`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RestartRequest {
    /// Times or increments at which restart files are written.
    pub interval: OutputInterval,
    /// Source position of the keyword line.
    pub span: Span,
}

/// Limits of energy errors (`*ENERGY LIMIT`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnergyLimit {
    /// Source position of the keyword line.
    pub span: Span,
    /// Limit of the drift of ETOTAL, relative to the energy put in.
    pub error: Option<f64>,
    /// Limit of the ratio ALLAE / ALLIE.
    pub artificial: Option<f64>,
    /// Whether the run is stopped when a limit is exceeded; otherwise a warning is issued.
    pub halts: bool,
}

/// Mass scaling (`*FIXED MASS SCALING`, `*VARIABLE MASS SCALING`).
#[derive(Clone, Debug, PartialEq)]
pub struct MassScaling {
    /// Source position of the keyword line.
    pub span: Span,
    /// Element indices; `None` selects all elements.
    pub elements: Option<Vec<usize>>,
    /// Scale factor of the mass (default 1).
    pub factor: f64,
    /// Scaling type and target stable time increment.
    pub target: Option<(ScalingType, f64)>,
    /// Largest mass that a target adds, as a fraction of the mass of the elements without it; `None` without a limit.
    pub budget: Option<f64>,
    /// Repetition during the step; `None` for fixed mass scaling.
    pub schedule: Option<ScalingSchedule>,
}

/// `TYPE` of mass scaling towards a target stable time increment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ScalingType {
    /// Elements below the target are scaled up to it.
    BelowMin,
    /// All elements are scaled by one factor.
    Uniform,
    /// All elements are scaled to the target.
    SetEqual,
}

/// Repetition of `*VARIABLE MASS SCALING`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ScalingSchedule {
    /// `FREQUENCY`: number of increments between scalings.
    Increments(u64),
    /// `NUMBER INTERVAL`: number of scalings in the step.
    Intervals(u64),
}

/// Choice of the time increment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum IncrementControl {
    /// By the stability limit; by error control if no element or contact limits the time increment.
    Automatic {
        /// Target relative error of error control (default 1e-4).
        accuracy: f64,
        /// Whether the limit is that of single elements (`ELEMENT BY ELEMENT`) instead of the global estimate.
        element_by_element: bool,
        /// Largest time increment; infinite if not given.
        largest: f64,
    },
    /// Fixed time increment (`DIRECT USER CONTROL`).
    Fixed(f64),
}

impl IncrementControl {
    /// Returns whether the time increment is fixed.
    pub fn is_fixed(&self) -> bool {
        matches!(self, IncrementControl::Fixed(_))
    }

    /// Returns the fraction of the size of a target or wall that a body may travel in an increment: the root of the accuracy,
    /// and 1 for fixed increments.
    pub fn travel(&self) -> f64 {
        match self {
            IncrementControl::Automatic { accuracy, .. } => accuracy.sqrt(),
            IncrementControl::Fixed(_) => 1.0,
        }
    }
}

/// Velocity passed to loads.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LoadVelocity {
    /// Second-order estimate at the time of the increment (default).
    #[default]
    Predicted,
    /// Mid-increment velocity of the previous increment, as in ABAQUS.
    Lagged,
}
