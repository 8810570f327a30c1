//! Result of a run: how it ended, energies, warnings and run time.

use crate::state::archive::Persist;
use serde::Serialize;

use super::energy::Energy;
use super::limits::IncrementLimits;
use crate::load::PenetrationOutcome;
use crate::plan::ledger::LedgerRow;
use crate::state::EffectId;
use crate::state::energies::ImpactLosses;
use crate::state::halt::HaltReason;

/// Result of a run.
#[derive(Clone, Debug, Default, Serialize, Persist)]
// Halts and results at the end do not exist yet; run times belong to this process.
#[persist(
    derived: ranges, contact_losses, new_meshes, last_rows, mesh_shape, halt, ended_by_user, energy, penetrations, impacts, unfinished,
        still_moving, exits, deleted, seconds, checkpoint_seconds, digest, lost, effect_seconds
)]
pub struct Outcome {
    /// Reason for an early end, if any.
    #[serde(skip)]
    pub halt: Option<HaltReason>,
    /// Whether a user subroutine ended the run before the end of its last step.
    pub ended_by_user: bool,
    /// Summaries of the steps that have begun.
    pub steps: Vec<StepSummary>,
    /// Energies at the end, and the largest drift of the total energy.
    pub energy: Energy,
    /// Bodies that came to rest.
    pub rests: Vec<BodyRest>,
    /// Results of bodies with six degrees of freedom in targets.
    pub penetrations: Vec<PenetrationSummary>,
    /// End of each impact of a rigid body on a target.
    #[serde(skip)]
    pub impacts: Vec<ImpactEnd>,
    /// Messages on bodies that still move in a target or have perforated it, so that no final depth exists.
    pub unfinished: Vec<String>,
    /// Number of bodies that still move in a target.
    #[serde(skip)]
    pub still_moving: usize,
    /// Bodies that have perforated their target.
    pub exits: Vec<BodyExit>,
    /// Number of deleted elements.
    pub deleted: usize,
    /// Changes of the adaptive meshes of each ledger row. During a run only those of domains that have ended.
    pub mesh_changes: Vec<MeshChanges>,
    /// Number of new meshes of each body of `*REMESH`, and of each body that has one without a card.
    pub new_meshes: Vec<MeshChanges>,
    /// Ledger rows of the plan at the end, to which indices of rows belong, if a body has had a new mesh.
    #[serde(skip)]
    pub last_rows: Option<Vec<LedgerRow>>,
    /// Shapes of the quadrilaterals and triangles at the end; `None` without any.
    pub mesh_shape: Option<MeshShape>,
    /// Shares of materials beyond the range of their constants.
    pub ranges: Vec<RangeShare>,
    /// Energy that contact has absorbed, by the kind of the impact; `None` without deleted elements.
    pub contact_losses: Option<ContactLosses>,
    /// Warnings issued during the run; each begins with its code.
    pub warnings: Vec<String>,
    /// Increments over all steps.
    pub increments: u64,
    /// Wall-clock time of the time loop, s.
    pub seconds: f64,
    /// Part of this time spent on checkpoints, s.
    pub checkpoint_seconds: f64,
    /// SHA-256 over the bits of the state at the end, hexadecimal: the same on any machine, number of threads and
    /// instruction set.
    pub digest: String,
    /// Memory of the user subroutines that the last checkpoint does not contain.
    #[serde(skip)]
    pub lost: Vec<String>,
    /// Wall-clock time of each effect, s, by row of the ledger; the sum is that of the time loop.
    #[serde(skip)]
    pub effect_seconds: Vec<f64>,
}

/// Number of changes of an adaptive mesh (NADAPT).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Persist)]
pub struct MeshChanges {
    /// Ledger row of the domain.
    pub row: EffectId,
    /// Number of changes in which nodes moved.
    pub count: u64,
    /// Number of elements that all new meshes together did not have from the mesh before them.
    pub new_elements: u64,
    /// Kinetic energy that new meshes lost, a part of ALLADV.
    pub lost_energy: f64,
    /// Mass of sheets that new meshes left out.
    pub removed_mass: f64,
}

/// Shapes of the quadrilaterals and triangles that are not deleted.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct MeshShape {
    /// Smallest angle, or smallest difference of an angle from 180 degrees, in degrees; negative at a turned corner.
    pub smallest_angle: f64,
    /// Number of elements with a corner that has turned over: an angle above 180 degrees.
    pub turned_corners: usize,
}

impl Outcome {
    /// Adds a warning with its code.
    pub(super) fn warn(&mut self, code: &'static str, text: impl AsRef<str>) {
        self.warnings.push(format!("{code}: {}", text.as_ref()));
    }

    /// Returns the messages on bodies that have no final depth, with their code, and the warnings.
    pub fn all_warnings(&self) -> Vec<String> {
        let unfinished = self.unfinished.iter().map(|text| format!("R315: {text}"));
        unfinished.chain(self.warnings.iter().cloned()).collect()
    }

    /// Returns the total time reached.
    pub fn total_time(&self) -> f64 {
        self.steps.iter().map(|step| step.time).sum()
    }
}

/// Energy that contact has absorbed normal to the surfaces, by the kind of the impact; part of `<job>.json`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ContactLosses {
    /// Ledger row of the contact.
    #[serde(skip)]
    pub row: EffectId,
    /// Description in percent of the energy put in.
    #[serde(skip)]
    pub text: String,
    /// Parts of the energy.
    #[serde(flatten)]
    pub parts: ImpactLosses,
}

/// Share of a material beyond the range of its constants, part of `<job>.json`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RangeShare {
    /// Name of the material.
    pub material: String,
    /// Quantity with a range.
    pub quantity: &'static str,
    /// Lower limit; `None` without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lower: Option<f64>,
    /// Upper limit; `None` without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub upper: Option<f64>,
    /// Share of mass times time beyond the range; for strain rates of mass times plastic strain.
    pub share: f64,
    /// Mean change of the flow stress by extrapolation, relative to the flow stress at the limit, with the same weights;
    /// `None` for quantities other than strain rate and temperature.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub change: Option<f64>,
    /// Smallest and largest value found, of elements that flow plastically for strain rates.
    pub extremes: [f64; 2],
}

/// End of a run, as far as searches and samples need it.
#[derive(Clone, Debug, Default)]
pub struct RunEnd {
    /// Reason for an early end, if any.
    pub halt: Option<HaltReason>,
    /// Total time reached.
    pub total_time: f64,
    /// End of each impact of a rigid body on a target.
    pub impacts: Vec<ImpactEnd>,
    /// Number of bodies that still move in a target.
    pub still_moving: usize,
}

impl From<Outcome> for RunEnd {
    fn from(outcome: Outcome) -> RunEnd {
        let total_time = outcome.total_time();
        RunEnd { halt: outcome.halt, total_time, impacts: outcome.impacts, still_moving: outcome.still_moving }
    }
}

/// End of the impact of a rigid body on a target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImpactEnd {
    /// Index of the body.
    pub body: usize,
    /// Outcome at the end of the run.
    pub outcome: PenetrationOutcome,
    /// Speed at the end of the run; in space, that of the centre of mass.
    pub speed: f64,
}

/// A body that has perforated its target.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BodyExit {
    /// Name of the body.
    pub body: String,
    /// Residual velocity along z at the end of the run.
    pub velocity: f64,
}

/// Time that a step reached, and its increments.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Persist)]
pub struct StepSummary {
    /// Name of the step, from `*STEP, NAME=`.
    pub name: String,
    /// Number of increments of the step.
    pub increments: u64,
    /// Time reached in the step.
    pub time: f64,
    /// Smallest time increment of the step, without those that the end of the step or the rest of a body cuts.
    pub smallest_increment: f64,
    /// Largest time increment of the step.
    pub largest_increment: f64,
    /// Element that limited the smallest increment, if one did.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limiting_element: Option<String>,
    /// Number of estimates of the highest frequency of the whole model; absent with element-by-element estimates.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub global_estimates: Option<u64>,
    /// Mass added by mass scaling at its last update; absent without mass scaling.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub added_mass: Option<f64>,
    /// Places of the added mass; absent without mass scaling.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub added_mass_at: Option<AddedMassPlaces>,
    /// Limits on the increments over time.
    #[serde(skip)]
    pub limits: IncrementLimits,
}

/// Mass added by mass scaling, by the nodes of the scaled elements that take it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Persist)]
pub struct AddedMassPlaces {
    /// Nodes without constraints, or with prescribed motions alone.
    pub free_nodes: f64,
    /// Nodes with equations or links: `*EQUATION`, `*MPC`, `*COUPLING`, `*TIE`.
    pub linked_nodes: f64,
    /// Rigid bodies, for their nodes on deformable elements.
    pub rigid_bodies: f64,
}

impl AddedMassPlaces {
    /// Returns the sum.
    pub fn total(&self) -> f64 {
        self.free_nodes + self.linked_nodes + self.rigid_bodies
    }

    /// Describes the shares of the places; empty if all mass is at nodes without constraints.
    pub fn describe(&self) -> String {
        let named = [
            (self.free_nodes, "free nodes"),
            (self.linked_nodes, "nodes with equations or links"),
            (self.rigid_bodies, "rigid bodies"),
        ];
        if self.linked_nodes == 0.0 && self.rigid_bodies == 0.0 {
            return String::new();
        }
        let parts = named.iter().filter(|part| part.0 != 0.0);
        let parts: Vec<String> = parts.map(|(mass, place)| format!("{mass:.3e} at {place}")).collect();
        format!(" (mass {})", parts.join(", "))
    }
}

/// Final state of a body with six degrees of freedom; vectors along 1, 2, 3, angles in degrees.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct PenetrationSummary {
    /// Name of the body.
    pub body: String,
    /// `at rest`, `in the target`, `through`, `ricochet` or `not met`.
    pub end: &'static str,
    /// Total time at which it left the target.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub exit_time: Option<f64>,
    /// Velocity of the centre of mass.
    pub velocity: [f64; 3],
    /// Angular velocity, radians per time.
    pub rotational_velocity: [f64; 3],
    /// Speed of the centre of mass.
    pub speed: f64,
    /// Angle between the velocity and the normal of the target, 0 to 90.
    pub obliquity: f64,
    /// Angle between the axis and the velocity, 0 to 90.
    pub yaw: f64,
    /// Angle between the axis and direction 2.
    pub tilt: f64,
}

/// A body that came to rest, with the time and the displacement.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Persist)]
pub struct BodyRest {
    /// Name of the body.
    pub body: String,
    /// Total time at which the body came to rest.
    pub time: f64,
    /// Displacement along z.
    pub displacement: f64,
}
