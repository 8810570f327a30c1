//! The state: what moves, only what the plan declared.
//! Never here: anything no effect asked for.

pub mod archive;
pub mod dofs;
pub mod energies;
pub mod flight;
pub mod halt;
pub mod limit;
pub mod magnitude;
pub mod nodes;

use archive::{Archive, Persist, persist_fields};

use crate::kernel::amplitude::Track;
use crate::kernel::lanes::Corners;
use crate::kernel::topology::{MOST_NODES, PerNode};

/// Index into the ledger: the only thing an effect knows of the deck.
pub type EffectId = usize;

/// Where the clock stands.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Instant {
    /// Time since the start of the step.
    pub step_time: f64,
    /// Time since the start of the analysis.
    pub total_time: f64,
    /// Number of the step, from 1.
    pub step: u32,
    /// Increments behind, over all steps.
    pub increment: u64,
    /// What rounding has taken from the step time (Kahan's summation): a million equal increments end on time.
    pub lost: f64,
}

/// A rigid body: an axisymmetric body moves along z only. Bodies are few and all of one is touched together, so each is
/// one piece in memory: two cache lines.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub struct BodyState {
    /// Mass.
    pub mass: f64,
    /// One over the mass: a division would be the longest link of the chain from force to velocity.
    pub inverse_mass: f64,
    /// Displacement at the increment's own time.
    pub displacement: f64,
    /// Velocity at the middle of the increment behind.
    pub velocity_half: f64,
    /// Acceleration at the increment's own time.
    pub acceleration: f64,
    /// Velocity at the increment's own time. (Not beside the displacement: the two copied as one piece would wait for the
    /// velocity's way to memory.)
    pub velocity: f64,
    /// Sum of the forces of all effects.
    pub force: f64,
    /// The velocity that loads are shown.
    pub velocity_load: f64,
    /// Sign of the motion a resistance opposes: of the velocity, or at rest of the force that would start it; 0 if none.
    pub direction: f64,
    /// The increment before.
    pub before: Before,
    /// Force that a prescribed motion adds.
    pub reaction: f64,
    /// Acceleration over the increment behind by contact on a body that moves freely; the acceleration holds it no more.
    pub contact: f64,
    /// How many force slots act on it.
    pub slots: usize,
    /// Whether it is under loads that read velocity.
    pub reads_velocity: bool,
    /// Whether its motion is prescribed.
    pub prescribed: bool,
    /// Whether it carries nodes of what deforms, whose stable increment then serves it too.
    pub tied: bool,
}

/// Where a body stood an increment ago.
#[derive(Clone, Copy, Debug, Default)]
pub struct Before {
    /// Velocity.
    pub velocity: f64,
    /// Acceleration.
    pub acceleration: f64,
    /// Displacement.
    pub displacement: f64,
}

impl BodyState {
    /// A body that flies at a velocity.
    pub fn new(mass: f64, velocity: f64) -> Self {
        BodyState { mass, inverse_mass: 1.0 / mass, velocity, ..BodyState::default() }
    }

    /// Sets the velocity that loads will see.
    #[inline]
    pub fn show(&mut self, velocity: f64) {
        self.velocity_load = velocity;
        self.direction = direction(velocity);
    }

    /// Kinetic energy. In contact the velocities before and behind the instant without the contact's next impulse make it: their
    /// mean, squared, would hold the motion that the impulse is about to stop, (F dt)^2/8M under a load F at rest.
    pub fn kinetic(&self) -> f64 {
        if self.contact == 0.0 {
            return 0.5 * self.mass * self.velocity * self.velocity;
        }
        let behind = 2.0 * self.velocity - self.velocity_half;
        (0.5 * self.mass * self.velocity_half * behind).max(0.0)
    }
}

/// 1, -1, or 0 for zero (and for what is not a number).
#[inline]
pub fn direction(value: f64) -> f64 {
    f64::from(i8::from(value > 0.0) - i8::from(value < 0.0))
}

impl<T: Persist> Persist for Corners<T> {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        self.0.persist(archive);
    }
}

impl<T: Persist + Copy + Default> Persist for PerNode<T> {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let (values, count) = self.parts_mut();
        persist_fields!(archive; values, count);
        if usize::from(*count) > MOST_NODES {
            archive.refuse(|| "an element has more nodes than any topology".into());
            *self = PerNode::default();
        }
    }
}

impl Persist for Track {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        self.points().into_iter().for_each(|point| point.persist(archive));
    }
}

impl Persist for Instant {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let Instant { step_time, total_time, step, increment, lost } = self;
        persist_fields!(archive; step_time, total_time, step, increment, lost);
    }
}

impl Persist for Before {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let Before { velocity, acceleration, displacement } = self;
        persist_fields!(archive; velocity, acceleration, displacement);
    }
}

impl Persist for BodyState {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let BodyState {
            // What the plan and the beginning of a step give.
            mass: _,
            inverse_mass: _,
            slots: _,
            reads_velocity: _,
            prescribed: _,
            tied: _,
            displacement,
            velocity_half,
            acceleration,
            velocity,
            force,
            velocity_load,
            direction,
            before,
            reaction,
            contact,
        } = self;
        persist_fields!(archive; displacement, velocity_half, acceleration, velocity, force, velocity_load);
        persist_fields!(archive; direction, before, reaction, contact);
    }
}
