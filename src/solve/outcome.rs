//! How a run ended and what it cost.
//! Never here: what happens in an increment.

use serde::Serialize;

use super::energy::Energy;
use super::limits::Limits;
use crate::state::halt::Halt;

/// How a run ended and what it cost.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Outcome {
    /// Why it stopped early, if it did.
    #[serde(skip)]
    pub halt: Option<Halt>,
    /// Whether a user's routine ended it before its last step was over.
    pub ended_by_user: bool,
    /// Steps begun.
    pub steps: Vec<StepSummary>,
    /// Energies at the end, and the largest drift of their sum.
    pub energy: Energy,
    /// When bodies came to rest.
    pub rests: Vec<Rest>,
    /// What has become of bodies with six degrees of freedom in the targets that they meet.
    pub penetrations: Vec<PenetrationSummary>,
    /// Bodies that are still on their way in a target, or behind it: a depth read now is not their last.
    pub unfinished: Vec<String>,
    /// How many of these still move in it.
    #[serde(skip)]
    pub still_moving: usize,
    /// Bodies that have left their target through its back.
    pub exits: Vec<Exit>,
    /// Elements that were deleted.
    pub deleted: usize,
    /// What the run warns of.
    pub warnings: Vec<String>,
    /// Increments over all steps.
    pub increments: u64,
    /// Seconds in the time loop.
    pub seconds: f64,
    /// Of these, seconds that keeping the state took.
    pub checkpoint_seconds: f64,
    /// SHA-256 over the bits of the state at the end, hexadecimal: the same on any machine, number of threads and
    /// instruction set.
    pub digest: String,
    /// What the state that was kept last does not hold of the user's routines.
    #[serde(skip)]
    pub lost: Vec<String>,
    /// Seconds of each effect, by its row of the ledger: they add up to those of the time loop.
    #[serde(skip)]
    pub effect_seconds: Vec<f64>,
}

impl Outcome {
    /// Total time reached.
    pub fn total_time(&self) -> f64 {
        self.steps.iter().map(|step| step.time).sum()
    }
}

/// A body that has gone through its target.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Exit {
    /// The body.
    pub body: String,
    /// Its residual velocity along z, at the end of the run.
    pub velocity: f64,
}

/// What a step took.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct StepSummary {
    /// Name.
    pub name: String,
    /// Increments.
    pub increments: u64,
    /// Time reached in the step.
    pub time: f64,
    /// Smallest increment.
    pub smallest_increment: f64,
    /// Largest increment.
    pub largest_increment: f64,
    /// Element that limited the smallest increment, if one did.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limiting_element: Option<String>,
    /// How often the highest frequency of the whole was estimated; absent where increments go element by element.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub global_estimates: Option<u64>,
    /// Mass that mass scaling has added to the original one, as it was found last; absent without mass scaling.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub added_mass: Option<f64>,
    /// What limited the increments over time.
    #[serde(skip)]
    pub limits: Limits,
}

/// How a body with six degrees of freedom ended; vectors along 1, 2, 3, angles in degrees.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct PenetrationSummary {
    /// Name of the body.
    pub body: String,
    /// `at rest`, `in the target`, `through`, `ricochet` or `not met`.
    pub end: &'static str,
    /// Total time at which it had left the target.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub exit_time: Option<f64>,
    /// Velocity of the centre of mass.
    pub velocity: [f64; 3],
    /// Angular velocity, radians a time.
    pub rotational_velocity: [f64; 3],
    /// Speed of the centre of mass.
    pub speed: f64,
    /// Between the velocity and the target's normal, 0 to 90.
    pub obliquity: f64,
    /// Between the axis and the velocity, 0 to 90.
    pub yaw: f64,
    /// Between the axis and direction 2.
    pub tilt: f64,
}

/// A body came to rest.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Rest {
    /// Name of the body.
    pub body: String,
    /// Total time.
    pub time: f64,
    /// Displacement along z.
    pub displacement: f64,
}
