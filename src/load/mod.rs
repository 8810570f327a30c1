//! Loads: what pushes surfaces, nodes and bodies, one file a kind for what is rigid and what deforms alike.
//! Never here: names of other effects; deck words (an effect carries an opaque id that only the ledger reads).

pub mod cavity;
pub mod concentrated;
pub mod fields;
pub mod gravity;
pub mod pressure;
pub mod stiffness;
pub mod user_amplitude;
pub mod user_load;

use crate::kernel::topology::ElementNodes;
use crate::state::EffectId;
use crate::state::archive::Persist;
use crate::state::dofs::Dofs;
use crate::state::flight::Flight;
use crate::state::halt::Halt;
use crate::state::limit::Limit;
use crate::state::magnitude::Clock;
use crate::user::Locked;
use fields::FacetFields;
use stiffness::Stiffness;

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

/// What a load makes of velocity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VelocityUse {
    /// It does not read it.
    None,
    /// It reads it, so that an instant of rest must be met exactly.
    Reads,
    /// It opposes motion and vanishes at rest, so that it can stop a body but never push it back.
    Resists,
}

/// The scene as loads see it at an instant.
#[derive(Clone, Copy)]
pub struct View<'a> {
    /// When.
    pub clock: Clock<'a>,
    /// All that moves.
    pub dofs: &'a Dofs,
    /// Part of the increment behind over which the velocity of nodes is carried on from its middle: half of it for a
    /// second-order estimate of the velocity at the instant's own time, none for the velocity lagging behind.
    pub reach: f64,
    /// Under area weighting, by how much a force on the plane section around each node is multiplied to act on its ring.
    pub rings: Option<&'a [f64]>,
}

impl View<'_> {
    /// The velocity of a node that loads are shown.
    #[inline]
    pub fn velocity(&self, node: usize) -> [f64; 2] {
        self.dofs.nodes.velocity_after(node, self.reach)
    }
}

/// How a rigid body is at the end of a run that has not come to rest in a target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unfinished {
    /// It still moves in it.
    Moving,
    /// It has left it through its back.
    Through,
}

/// What has become of a body with six degrees of freedom in a target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum How {
    /// It lies still in it.
    AtRest,
    /// It still moves in it.
    Moving,
    /// It has left it through its back.
    Through,
    /// It has left it through its front.
    Ricochet,
    /// It has not touched it.
    NotMet,
}

impl How {
    /// In words, as results have it.
    pub fn words(self) -> &'static str {
        match self {
            How::AtRest => "at rest",
            How::Moving => "in the target",
            How::Through => "through",
            How::Ricochet => "ricochet",
            How::NotMet => "not met",
        }
    }
}

/// How the flight of a body with six degrees of freedom stands to a target.
#[derive(Clone, Copy, Debug)]
pub struct FlightEnd {
    /// Index of the flight.
    pub flight: usize,
    /// What has become of it.
    pub how: How,
    /// Total time at which it had left the target.
    pub time: Option<f64>,
    /// Angle between its velocity and the target's normal, radians, 0 to pi/2.
    pub obliquity: f64,
}

/// A load. Forces on nodes come first: those of tied nodes count among the forces on their bodies, which resistances meet.
pub trait Load: Persist + Send + Sync {
    /// Its row of the ledger.
    fn id(&self) -> EffectId;

    /// The generalised forces on rigid bodies that it will write.
    fn slots(&self) -> Vec<Slot>;

    /// Whether it acts on nodes.
    fn acts_on_nodes(&self) -> bool;

    /// Adds its forces on nodes, `[r, z]` of each.
    ///
    /// # Errors
    /// Where no finite force can be given; the run halts.
    fn on_nodes(&mut self, view: &View<'_>, user: &mut Locked<'_>, forces: &mut [[f64; 2]]) -> Result<(), Halt>;

    /// Writes its generalised forces along z on rigid bodies, in the order of its slots.
    ///
    /// # Errors
    /// Where no finite force can be given; the run halts.
    fn on_bodies(&mut self, view: &View<'_>, user: &mut Locked<'_>, out: &mut [f64]) -> Result<(), Halt>;

    /// Adds its forces and moments to those of bodies with six degrees of freedom.
    ///
    /// # Errors
    /// Where no finite force can be given; the run halts.
    fn on_flights(&mut self, _clock: &Clock<'_>, _flights: &mut [Flight]) -> Result<(), Halt> {
        Ok(())
    }

    /// Indices of the bodies with six degrees of freedom that it resists.
    fn resists(&self) -> Vec<usize> {
        Vec::new()
    }

    /// What has become of these.
    fn ends(&self, _dofs: &Dofs) -> Vec<FlightEnd> {
        Vec::new()
    }

    /// What it makes of velocity.
    fn velocity(&self) -> VelocityUse {
        VelocityUse::None
    }

    /// How far the next increment may go.
    fn limit(&self, view: &View<'_>) -> Limit;

    /// What it was found to add to the stiffness of nodes, where that has made motion grow.
    fn stiffness(&self) -> Option<&Stiffness> {
        None
    }

    /// Of the work that its forces on nodes did over the increment behind what is dissipated: by opening a cavity and by
    /// friction. Called behind [`Load::on_nodes`].
    fn dissipated(&self, _behind: &LastIncrement<'_>) -> [f64; 2] {
        [0.0; 2]
    }

    /// Rigid bodies that have not come to their end in what resists them: a depth that is read now is not their last.
    fn unfinished(&self, _dofs: &Dofs) -> Vec<(usize, Unfinished)> {
        Vec::new()
    }

    /// Elements with these boundaries are deleted: what acts on their faces ends.
    fn release(&mut self, _deleted: &[ElementNodes]) {}

    /// The masses of nodes have changed.
    fn weigh(&mut self, _mass: &[f64]) {}

    /// What it shows on a surface in a frame.
    fn fields(&self, _dofs: &Dofs) -> Option<FacetFields> {
        None
    }

    /// Names and bytes of the arrays it holds.
    fn arrays(&self) -> Vec<(&'static str, usize)>;

    /// Another one in the same state.
    fn copy(&self) -> Box<dyn Load>;
}

impl Clone for Box<dyn Load> {
    fn clone(&self) -> Self {
        self.copy()
    }
}

/// The increment behind, for the work of forces on nodes.
#[derive(Clone, Copy)]
pub struct LastIncrement<'a> {
    /// Half its length; 0 where there is none.
    half: f64,
    /// An eighth of its square, where central differences started with it; else 0.
    start: f64,
    dofs: &'a Dofs,
}

impl<'a> LastIncrement<'a> {
    /// The increment behind nodes that have moved, with accelerations as they were at its start.
    ///
    /// Where central differences start, forces act for half an increment alone and bring velocities from v to v + dt/2 a.
    /// What they give in that half is their impulse times the mean of both, v + dt/4 a, while the trapezoid over the whole
    /// increment reckons with the velocity at its end: too much by f a dt^2/8.
    pub fn new(dofs: &'a Dofs) -> Self {
        let dt = dofs.nodes.unbooked();
        let start = if dofs.nodes.half == 0.5 * dt { 0.125 * dt * dt } else { 0.0 };
        LastIncrement { half: 0.5 * dt, start, dofs }
    }

    /// Work on a node of a force now and at the start of the increment, by the trapezoid.
    pub fn work(&self, node: usize, now: [f64; 2], before: [f64; 2]) -> f64 {
        let (n, a) = (&self.dofs.nodes[node], self.dofs.nodes.acceleration[node]);
        self.half * ((now[0] + before[0]) * n.v_r + (now[1] + before[1]) * n.v_z)
            - self.start * (before[0] * a[0] + before[1] * a[1])
    }
}
