//! Loads: what pushes rigid and deformable bodies, one file a kind.
//! Never here: names of other effects; deck words (an effect carries an opaque id that only the ledger reads).

pub mod cavity;
pub mod concentrated;
pub mod faces;
pub mod gravity;
pub mod pressure;
pub mod user_amplitude;
pub mod user_body;
pub mod user_load;

use crate::state::archive::Persist;
use crate::state::halt::Halt;
use crate::state::limit::Limit;
use crate::state::{BodyState, EffectId, Instant};
use crate::user::Wish;

/// Which energy a force's work is booked under.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Account {
    /// Work of prescribed loads and motions (`ALLWK`).
    Work,
    /// Dissipated by friction (`ALLFD`).
    Friction,
    /// Dissipated by opening the cavity (`ALLCD` is creep in ABAQUS, so `ALLCAV`).
    Cavity,
    /// Of what deforms on a body that it is tied to: passed on within the scene, so no account of its own.
    Tie,
}

/// A generalised force of one effect on one body, and the account of its work.
#[derive(Clone, Copy, Debug)]
pub struct Slot {
    /// Body index.
    pub body: usize,
    /// Where its work is booked.
    pub account: Account,
}

/// What a surface effect shows in a frame, one entry a facet.
#[derive(Clone, Debug, Default)]
pub struct FacetFields {
    /// Element index of each facet.
    pub elements: Vec<usize>,
    /// Pressure, area mean.
    pub pressure: Vec<f64>,
    /// Velocity along the outward normal.
    pub normal_velocity: Vec<f64>,
    /// Number (from 1) of the layer that takes the largest part of the facet's area; 0 outside any.
    pub layer: Vec<f64>,
}

/// A force of the scene.
pub trait Force: Persist {
    /// What asked for it.
    fn cause(&self) -> EffectId;

    /// The generalised forces it will write.
    fn slots(&self) -> Vec<Slot>;

    /// Writes its generalised forces along z at this instant.
    ///
    /// # Errors
    /// Where no finite force can be given; the run halts.
    fn evaluate(&mut self, now: &Instant, bodies: &[BodyState], out: &mut [f64]) -> Result<(), Halt>;

    /// How far the next increment may go.
    fn limit(&self, _now: &Instant, _bodies: &[BodyState]) -> Limit {
        Limit::NONE
    }

    /// Whether it opposes motion and vanishes at rest, so that it can stop a body but never push it back.
    fn resists(&self) -> bool {
        false
    }

    /// Whether it reads velocity, so that an instant of rest must be met exactly.
    fn reads_velocity(&self) -> bool {
        false
    }

    /// What it shows on facets in a frame.
    fn facet_fields(&self, _bodies: &[BodyState]) -> Option<FacetFields> {
        None
    }

    /// Names and bytes of the arrays it holds.
    fn arrays(&self) -> Vec<(&'static str, usize)> {
        Vec::new()
    }
}

/// Something that a user's routine is asked once an increment, before the motion arrives at its end.
pub trait Asking: Persist {
    /// Asks for the value at `arrival`, an increment away (0 at the start of a step).
    ///
    /// # Errors
    /// Where the routine fails or gives no finite value; the run halts.
    fn ask(&mut self, arrival: &Instant, increment: f64, bodies: &[BodyState]) -> Result<Wish, Halt>;
}
