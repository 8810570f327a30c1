//! Loads: what pushes surfaces, nodes and bodies, one file a kind for what is rigid and what deforms alike.
//! Never here: names of other effects; deck words (an effect carries an opaque id that only the ledger reads).

pub mod cavity;
pub mod concentrated;
pub mod fields;
pub mod gravity;
pub mod pressure;
pub mod stations;
pub mod stiffness;
pub mod user_amplitude;
pub mod user_load;

use std::any::Any;

use crate::kernel::attitude::Vector;
use crate::kernel::topology::ElementNodes;
use crate::state::EffectId;
use crate::state::archive::{Archive, Persist, persist_fields, persist_struct};
use crate::state::dofs::Dofs;
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
pub struct GeneralizedForce {
    pub body: usize,
    /// Along (0 to 2) or about (3 to 5) 1, 2, 3; of a body along z always 1.
    pub coordinate: u32,
    /// Where its work is booked.
    pub account: Account,
}

impl GeneralizedForce {
    pub fn along_z(body: usize, account: Account) -> Self {
        GeneralizedForce { body, coordinate: 1, account }
    }

    /// Forces along 1, 2, 3 and moments about the centre of mass of a body in space.
    pub fn in_space(body: usize, account: Account) -> impl Iterator<Item = Self> {
        (0..6).map(move |coordinate| GeneralizedForce { body, coordinate, account })
    }
}

/// The degrees of freedom on which a load acts.
#[derive(Clone, Debug, Default)]
pub struct Targets {
    /// Generalised forces on rigid bodies.
    pub bodies: Vec<GeneralizedForce>,
    /// Whether it acts on nodes.
    pub nodes: bool,
}

/// Where a load puts its forces: first those on nodes are asked for, because forces of tied nodes count among those on their bodies,
/// which resistances see; then those on rigid bodies.
pub enum Forces<'a> {
    /// Forces on nodes, `[r, z]` of each: it adds to them.
    OnNodes(&'a mut [[f64; 2]]),
    /// Generalised forces on rigid bodies in the order of its [`Targets`]: it writes them.
    OnBodies(&'a mut [f64]),
}

/// Part of the work of forces on nodes over the previous increment that is dissipated in a target.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Dissipation {
    /// By opening a cavity.
    pub cavity: f64,
    /// By friction.
    pub friction: f64,
}

impl Dissipation {
    pub fn add(&mut self, other: Dissipation) {
        self.cavity += other.cavity;
        self.friction += other.friction;
    }
}

/// A change of the scene that loads follow.
pub enum SceneChange<'a> {
    /// Elements with these boundaries have been deleted: loads on their faces end.
    DeletedElements(&'a [ElementNodes]),
    /// The masses of all nodes, which have changed.
    Masses(&'a [f64]),
}

/// What a load makes of velocity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VelocityUse {
    None,
    /// It reads it, so that an instant of rest must be met exactly.
    Reads,
    /// It opposes motion and vanishes at rest, so that it can stop a body but never push it back.
    Resists,
}

/// The scene as loads see it at an instant.
#[derive(Clone, Copy)]
pub struct SceneView<'a> {
    /// When.
    pub clock: Clock<'a>,
    /// All that moves.
    pub dofs: &'a Dofs,
    /// Part of the previous increment over which the velocity of nodes is extrapolated from its middle: half of it for a
    /// second-order estimate of the velocity at the instant's own time, none for the lagged velocity.
    pub velocity_extrapolation: f64,
    /// Under area weighting, by how much a force on the plane section around each node is multiplied to act on its ring.
    pub rings: Option<&'a [f64]>,
}

impl SceneView<'_> {
    /// The velocity of a node that loads are shown.
    #[inline]
    pub fn velocity(&self, node: usize) -> [f64; 2] {
        self.dofs.nodes.velocity_after(node, self.velocity_extrapolation)
    }
}

/// What has become of a rigid body in a target.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PenetrationOutcome {
    /// It is at rest in it.
    AtRest,
    Moving,
    /// It has left it through its back.
    Through,
    /// It has left it through its front.
    Ricochet,
    #[default]
    NotMet,
}

impl PenetrationOutcome {
    /// In words, as results have it.
    pub fn words(self) -> &'static str {
        match self {
            PenetrationOutcome::AtRest => "at rest",
            PenetrationOutcome::Moving => "in the target",
            PenetrationOutcome::Through => "through",
            PenetrationOutcome::Ricochet => "ricochet",
            PenetrationOutcome::NotMet => "not met",
        }
    }
}

/// A rigid body and a target.
#[derive(Clone, Copy, Debug, Default)]
pub struct Penetration {
    pub body: usize,
    /// What has become of it.
    pub outcome: PenetrationOutcome,
    pub in_space: Option<MotionAtEnd>,
}

/// How a body in space moves at the end; angles in degrees.
#[derive(Clone, Copy, Debug, Default)]
pub struct MotionAtEnd {
    /// Total time at which it had left the target.
    pub exit_time: Option<f64>,
    /// Velocity of the centre of mass.
    pub velocity: Vector,
    /// Angular velocity.
    pub rotational_velocity: Vector,
    /// Speed of the centre of mass.
    pub speed: f64,
    /// Between the velocity and the target's normal, 0 to 90.
    pub obliquity: f64,
    /// Between the axis and the velocity, 0 to 90.
    pub yaw: f64,
    /// Between the axis and direction 2.
    pub tilt: f64,
}

/// A load in force: forces on nodes or on rigid bodies, computed once an increment.
pub trait Load: LoadOutput + CopyLoad + Persist + Send + Sync {
    /// Row of the ledger that its run time and memory belong to.
    fn effect(&self) -> EffectId;

    /// The nodes and generalised forces that [`Load::apply`] writes.
    fn targets(&self) -> Targets;

    /// How its forces depend on velocity: it decides their order, and how the increment meets an instant of rest.
    fn velocity_use(&self) -> VelocityUse {
        VelocityUse::None
    }

    /// Puts its forces on nodes or on bodies. Returns what those on nodes dissipated over the previous increment; of bodies each
    /// generalised force has its account.
    ///
    /// # Errors
    /// Where no finite force can be given; the run halts.
    fn apply(
        &mut self,
        scene: &SceneView<'_>,
        user: &mut Locked<'_>,
        forces: &mut Forces<'_>,
    ) -> Result<Dissipation, Halt>;

    /// How far the next increment may go.
    fn max_increment(&self, _scene: &SceneView<'_>) -> Limit {
        Limit::NONE
    }

    /// Follows a change of the scene.
    fn scene_changed(&mut self, _change: &SceneChange<'_>) {}
}

/// Output, memory and continuation of a load.
pub trait LoadOutput: Any {
    /// Names and bytes of the arrays it holds.
    fn arrays(&self) -> Vec<(&'static str, usize)>;

    /// What it shows on a surface in a frame.
    fn fields(&self, _dofs: &Dofs) -> Option<FacetFields> {
        None
    }

    /// Takes over the memory of a load that it replaces.
    fn continue_from(&mut self, _previous: &dyn Load) {}

    /// What has become of the rigid bodies that it resists.
    fn penetrations(&self, _dofs: &Dofs) -> Vec<Penetration> {
        Vec::new()
    }

    /// What it was found to add to the stiffness of nodes, where that has made motion grow.
    fn stiffness(&self) -> Option<&Stiffness> {
        None
    }
}

/// Copies a load with its state.
pub trait CopyLoad {
    /// Another one in the same state.
    fn copy(&self) -> Box<dyn Load>;
}

impl<T: Load + Clone + 'static> CopyLoad for T {
    fn copy(&self) -> Box<dyn Load> {
        Box::new(self.clone())
    }
}

impl Clone for Box<dyn Load> {
    fn clone(&self) -> Self {
        (**self).copy()
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

persist_struct!(MotionAtEnd { exit_time, velocity, rotational_velocity, speed, obliquity, yaw, tilt });

impl Persist for Penetration {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let Penetration { body, outcome, in_space } = self;
        let mut number = *outcome as u8;
        persist_fields!(archive; body, &mut number, in_space);
        use PenetrationOutcome::{AtRest, Moving, NotMet, Ricochet, Through};
        let found = [AtRest, Moving, Through, Ricochet, NotMet].into_iter().find(|o| *o as u8 == number);
        *outcome = found.unwrap_or_default();
    }
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
