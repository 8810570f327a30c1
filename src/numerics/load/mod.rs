//! Loads on surfaces, nodes and bodies, one file per kind. Each kind handles both rigid and deformable bodies. A load
//! knows neither other effects nor keywords; it carries an opaque id, which only the ledger resolves.

pub mod blast;
pub mod body_force;
pub mod cavity;
pub mod concentrated;
pub mod fields;
pub mod gravity;
pub mod prescribed;
pub mod pressure;
pub mod stations;
pub mod stiffness;
pub mod traction;
pub mod user_amplitude;
pub mod user_load;

use std::any::Any;

use crate::kernel::attitude::SpatialVector;
use crate::kernel::topology::ElementNodes;
use crate::mesh::surface::{RigidFacets, SurfaceGeometry};
use crate::routines::LockedRoutines;
use crate::state::EffectId;
use crate::state::archive::Persist;
use crate::state::dofs::Dofs;
use crate::state::halt::HaltReason;
use crate::state::limit::IncrementLimit;
use crate::state::magnitude::AmplitudeClock;
use fields::FacetFields;
use stiffness::LoadStiffness;

/// Energy account to which the work of a force is added.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EnergyAccount {
    /// Work of prescribed loads and motions (`ALLWK`).
    Work,
    /// Dissipated by friction (`ALLFD`).
    Friction,
    /// Dissipated by opening the cavity (`ALLCD` is creep in ABAQUS, so `ALLCAV`).
    Cavity,
    /// Force of a deformable body on a rigid body to which it is tied. Its work is exchanged inside the model and has
    /// no account.
    Tie,
}

/// Generalised force of one effect on one rigid body, with the account of its work.
#[derive(Clone, Copy, Debug)]
pub struct GeneralizedForce {
    pub body: usize,
    /// Force along (0 to 2) or moment about (3 to 5) axis 1, 2, 3. Always 1 for a body that moves along z only.
    pub coordinate: u32,
    /// Energy account that receives the work of the load.
    pub account: EnergyAccount,
}

impl GeneralizedForce {
    pub fn along_z(body: usize, account: EnergyAccount) -> Self {
        GeneralizedForce { body, coordinate: 1, account }
    }

    /// Returns forces along axes 1, 2, 3 and moments about the centre of mass, for a body with six degrees of freedom.
    pub fn in_space(body: usize, account: EnergyAccount) -> impl Iterator<Item = Self> {
        (0..6).map(move |coordinate| GeneralizedForce { body, coordinate, account })
    }
}

/// The degrees of freedom on which a load acts.
#[derive(Clone, Debug, Default)]
pub struct LoadTargets {
    /// Generalised forces on rigid bodies.
    pub bodies: Vec<GeneralizedForce>,
    /// Whether the load acts on nodes.
    pub nodes: bool,
}

impl LoadTargets {
    /// Returns the targets of a load on a surface of rigid bodies that move along z and of deformable bodies.
    fn along_z(surface: &SurfaceGeometry) -> LoadTargets {
        let force = |patch: &RigidFacets| GeneralizedForce::along_z(patch.body, EnergyAccount::Work);
        LoadTargets { bodies: surface.patches.iter().map(force).collect(), nodes: surface.skin.max_faces() > 0 }
    }
}

/// Destination of the forces of a load. Loads are called first with the nodes, then with the rigid bodies: the forces
/// on tied nodes contribute to the forces on their rigid bodies, which resistance loads read.
pub enum LoadForces<'a> {
    /// Forces on nodes, `[r, z]`; the load adds to them.
    OnNodes(&'a mut [[f64; 2]]),
    /// Generalised forces on rigid bodies, in the order of the load's [`LoadTargets`]; the load overwrites them.
    OnBodies(&'a mut [f64]),
}

/// Energy dissipated in a target: the work of the nodal forces over the previous increment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TargetDissipation {
    /// Energy dissipated by cavity expansion.
    pub cavity: f64,
    /// Energy dissipated by friction.
    pub friction: f64,
}

impl TargetDissipation {
    pub fn add(&mut self, other: TargetDissipation) {
        self.cavity += other.cavity;
        self.friction += other.friction;
    }
}

/// Change of the model that loads must take into account.
pub enum SceneChange<'a> {
    /// Boundary nodes of the elements that were deleted; loads on their faces end.
    DeletedElements(&'a [ElementNodes]),
    /// New masses of nodes and bodies.
    Masses(&'a Dofs),
}

impl SceneChange<'_> {
    /// Removes the faces of deleted elements from a surface.
    fn remove_faces(&self, surface: &mut SurfaceGeometry) {
        if let SceneChange::DeletedElements(deleted) = self {
            surface.skin.remove_elements(deleted);
        }
    }
}

/// Dependence of a load on velocity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VelocityUse {
    None,
    /// The load reads velocities; an instant at which a body comes to rest is resolved exactly.
    Reads,
    /// The load opposes motion and vanishes at rest; it can stop a body but not reverse its motion.
    Resists,
}

/// State of the model at an instant, as passed to loads.
#[derive(Clone, Copy)]
pub struct SceneView<'a> {
    /// Step time, total time and amplitudes.
    pub clock: AmplitudeClock<'a>,
    /// Degrees of freedom of nodes and rigid bodies.
    pub dofs: &'a Dofs,
    /// Fraction of the previous increment over which nodal velocities are extrapolated from its middle: 0.5 for a
    /// second-order estimate at the current time, 0 for the lagged velocity.
    pub velocity_extrapolation: f64,
    /// Factor per node from a force on the plane section to the force on the node's ring; only with area weighting.
    pub rings: Option<&'a [f64]>,
    /// Returns the sum of the element forces on a node, `[r, z]`; `None` for loads on rigid bodies.
    pub element_force: Option<&'a dyn Fn(usize) -> [f64; 2]>,
}

impl SceneView<'_> {
    /// Returns the velocity `[v_r, v_z]` of a node for the evaluation of loads.
    #[inline]
    pub fn velocity(&self, node: usize) -> [f64; 2] {
        self.dofs.nodes.velocity_after(node, self.velocity_extrapolation)
    }
}

/// Outcome of a rigid body's impact on a target.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Persist)]
pub enum PenetrationOutcome {
    /// The body has come to rest in the target.
    AtRest,
    Moving,
    /// Left the target through the rear face.
    Through,
    /// Left the target through the front face.
    Ricochet,
    #[default]
    NotMet,
}

impl PenetrationOutcome {
    /// Returns the text used in result files.
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

/// Result of a rigid body's impact on a target.
#[derive(Clone, Copy, Debug, Default, Persist)]
pub struct PenetrationRecord {
    pub body: usize,
    /// Outcome at the current time.
    pub outcome: PenetrationOutcome,
    pub in_space: Option<FinalMotion>,
}

/// Motion of a rigid body with six degrees of freedom at the end of the run; angles in degrees.
#[derive(Clone, Copy, Debug, Default, Persist)]
pub struct FinalMotion {
    /// Total time at which the body left the target, if it did.
    pub exit_time: Option<f64>,
    /// Velocity of the centre of mass.
    pub velocity: SpatialVector,
    /// Angular velocity of the body in the global frame, 1/time.
    pub rotational_velocity: SpatialVector,
    /// Speed of the centre of mass.
    pub speed: f64,
    /// Angle between the velocity and the target's normal, 0 to 90.
    pub obliquity: f64,
    /// Angle between the body's axis and the velocity, 0 to 90.
    pub yaw: f64,
    /// Angle between the body's axis and direction 2.
    pub tilt: f64,
}

/// An active load: forces on nodes or on rigid bodies, computed once per increment.
pub trait Load: LoadOutput + CopyLoad + Persist + Send + Sync {
    /// Returns the ledger row to which the load's run time and memory are assigned.
    fn effect(&self) -> EffectId;

    /// Returns the nodes and generalised forces that [`Load::apply`] writes.
    fn targets(&self) -> LoadTargets;

    /// Returns how the forces depend on velocity. This determines the order in which loads are applied and whether an
    /// instant of rest is resolved.
    fn velocity_use(&self) -> VelocityUse {
        VelocityUse::None
    }

    /// Returns whether the forces on rigid bodies can jump from zero at an instant that [`Load::max_increment`] does not
    /// report.
    fn may_begin_suddenly(&self) -> bool {
        false
    }

    /// Applies the load to nodes or to rigid bodies. Returns the energy that the nodal forces dissipated over the
    /// previous increment; forces on rigid bodies have their own accounts.
    ///
    /// # Errors
    /// If a force is not finite; the run halts.
    fn apply(
        &mut self,
        scene: &SceneView<'_>,
        user: &mut LockedRoutines,
        forces: &mut LoadForces<'_>,
    ) -> Result<TargetDissipation, HaltReason>;

    /// Returns the limit on the next time increment.
    fn max_increment(&self, _scene: &SceneView<'_>) -> IncrementLimit {
        IncrementLimit::NONE
    }

    /// Updates the load after a change of the model.
    fn scene_changed(&mut self, _change: &SceneChange<'_>) {}
}

/// Output, memory use and restart of a load.
pub trait LoadOutput: Any {
    /// Returns the names and sizes (bytes) of the load's arrays.
    fn arrays(&self) -> Vec<(&'static str, usize)>;

    /// Returns the facet output of the load, if it acts on a surface.
    fn fields(&self, _dofs: &Dofs) -> Option<FacetFields> {
        None
    }

    /// Copies the history of the load that this one replaces at the start of a step.
    fn continue_from(&mut self, _previous: &dyn Load) {}

    /// Takes the history of the same load of a model in which bodies had other meshes. `dofs` are those of both models.
    fn follow_new_mesh(&mut self, _previous: &dyn Load, _dofs: [&Dofs; 2]) {}

    /// Returns the outcome for each rigid body that the load resists.
    fn penetrations(&self, _dofs: &Dofs) -> Vec<PenetrationRecord> {
        Vec::new()
    }

    /// Returns an upper bound of the rate at which the load damps the motion of nodes, 1/time.
    fn damping(&self) -> f64 {
        0.0
    }

    /// Returns the stiffness that the load adds to nodes, if it was measured because the motion grew.
    fn stiffness(&self) -> Option<&LoadStiffness> {
        None
    }
}

/// Copies a load with its state.
pub trait CopyLoad {
    /// Returns a copy in the same state.
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

/// The previous increment, used to integrate the work of nodal forces.
#[derive(Clone, Copy)]
pub struct LastIncrement<'a> {
    /// Half the increment; 0 before the first increment.
    half: f64,
    /// dt²/8 for the increment with which central differences start, else 0.
    start: f64,
    dofs: &'a Dofs,
}

impl<'a> LastIncrement<'a> {
    /// Returns the previous increment of nodes that have been moved; their accelerations are those at its start.
    ///
    /// In the first increment of central differences, forces act over half an increment and change the velocity from v
    /// to v + a dt/2. The work is the impulse times the mean velocity v + a dt/4. The trapezoidal rule over the whole
    /// increment uses the velocity at its end, and overestimates the work by f a dt²/8.
    pub fn new(dofs: &'a Dofs) -> Self {
        let dt = dofs.nodes.unaccounted_dt();
        let start = if dofs.nodes.half == 0.5 * dt { 0.125 * dt * dt } else { 0.0 };
        LastIncrement { half: 0.5 * dt, start, dofs }
    }

    /// Returns the work of a force on a node over the increment by the trapezoidal rule, from its current and previous
    /// values. Equation (14.3).
    pub fn work(&self, node: usize, now: [f64; 2], before: [f64; 2]) -> f64 {
        let (n, a) = (&self.dofs.nodes[node], self.dofs.nodes.acceleration[node]);
        self.half * ((now[0] + before[0]) * n.v_r + (now[1] + before[1]) * n.v_z)
            - self.start * (before[0] * a[0] + before[1] * a[1])
    }
}
