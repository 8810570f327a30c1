//! Interface of user subroutines: the traits that Rust plug-ins implement, with the arguments of the ABAQUS
//! subroutines. Compiled Fortran and C subroutines implement the same traits (`user` in the crate of the language).

pub mod eos;
pub mod host;
pub mod law;
mod saved_memory;
mod stack;

use crate::state::archive::Persist;
use std::cell::Cell;
use std::sync::{Arc, Condvar, Mutex, PoisonError};

use crate::state::Instant;
use crate::state::halt::{HaltDetails, HaltReason};
pub use eos::{EosLaw, EosResponse};
pub use law::{ElasticModuli, MaterialLaw, MaterialPoint, PointQuantity};
pub use saved_memory::{PersistentMemory, SavedMemory};
pub use stack::{STACK, thread_failure, thread_pool};

/// Largest number of points of one call: `maxblk` of `vaba_param.inc`. Larger surfaces are divided into blocks.
pub const MAX_BLOCK: usize = 512;

/// Arguments of a user load for a block of points of one surface (ABAQUS 6.6 User Subroutines Reference, 1.2.1
/// "VDLOAD"). Slices have one entry per point unless stated otherwise.
#[derive(Debug)]
pub struct LoadPoints<'a> {
    /// Surface or element-set name, upper case (`sname` of a surface load; VDLOAD gets blanks for an element load).
    pub surface: &'a str,
    /// Kind of load (`jltyp`): 0 on a surface; 20 PNU, 21 to 24 P1NU to P4NU, 1 BRNU, 2 BZNU on elements.
    pub load_type: i32,
    /// Clock, step and increment.
    pub now: Instant,
    /// Current value of the load's amplitude (1 without one); the subroutine applies it.
    pub amplitude: f64,
    /// Magnitude on the data line (not an argument of VDLOAD).
    pub magnitude: f64,
    /// Current r of each point, length.
    pub r: &'a [f64],
    /// Current z of each point, length.
    pub z: &'a [f64],
    /// Velocity of each point, r component.
    pub velocity_r: &'a [f64],
    /// Velocity of each point, z component.
    pub velocity_z: &'a [f64],
    /// Outward unit normal of each point, r component (zero for a body force).
    pub normal_r: &'a [f64],
    /// Outward unit normal of each point, z component (zero for a body force).
    pub normal_z: &'a [f64],
    /// `curCoords`: r of all points, z of all points, then NaN in place of a third coordinate.
    pub coordinates: &'a [f64],
    /// `velocity`: velocity, displacement and acceleration, each r of all points, then z of all points. Displacement
    /// and acceleration are set only if [`UserLoad::reads_motion`].
    pub motion: &'a [f64],
    /// `dirCos`: normal r, tangent r, normal z, tangent z of all points, then NaN for a third direction. The tangent is
    /// the normal turned 90 degrees counter-clockwise; the normal points out of the loaded side of a surface element,
    /// and into a solid element.
    pub directions: &'a [f64],
    /// Memory of the points: [`UserLoad::memory`] numbers of the first point, then of the second, and so on; zero at the
    /// start. The load may change them. They belong to the state of the run, unlike fields of the load: a checkpoint
    /// contains them. A load without memory may be evaluated again for a shorter increment, one with memory is not.
    pub memory: &'a [Cell<f64>],
}

/// Failure of a user subroutine.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{reason}")]
pub struct LoadFailure {
    /// Index in the block of the point that caused it, if known.
    pub point: Option<usize>,
    /// Description of the failure.
    pub reason: String,
}

impl LoadFailure {
    /// Creates a failure that is not related to a point.
    pub fn new(reason: impl Into<String>) -> Self {
        LoadFailure { point: None, reason: reason.into() }
    }

    /// Returns the halt caused by the failure; `what` names subroutine and place.
    pub fn halt(&self, what: &str, now: &Instant) -> HaltReason {
        let reason = format!(
            "{what} failed in step {}, increment {}, total time {:e}: {}",
            now.step, now.increment, now.total_time, self.reason
        );
        HaltReason::UserRoutine(HaltDetails::at_instant(reason, *now))
    }
}

/// Returns the advice for a subroutine that wrote past an argument: gfortran checks no array that is declared with `*`.
pub fn bounds_advice(argument: &str) -> String {
    let sizes = match argument {
        "stateNew" => "nblock,nstatev",
        "stressNew" => "nblock,ndir+nshr",
        "field" => "nblock,nfieldv",
        "duDi" => "nblock,nInv",
        "d2uDiDi" => "nblock,nInv*(nInv+1)/2",
        _ => return String::new(),
    };
    format!("; if it is declared with `*`, declare {argument}({sizes}): --check-user then names the line")
}

/// A user load: the pressure at each point. What it keeps between calls is in [`LoadPoints::memory`]. It is called once per increment,
/// surface and block of at most [`MAX_BLOCK`] points.
///
/// ```
/// # std::env::set_current_dir("../..").expect("the folder of the project");
/// use revolve::job;
/// use revolve::user::{LoadFailure, LoadPoints, Routines, UserLoad};
///
/// /// A drag that grows with the square of the normal velocity.
/// struct Drag {
///     density: f64,
/// }
///
/// impl UserLoad for Drag {
///     fn pressure(&mut self, points: &LoadPoints<'_>, pressure: &mut [f64]) -> Result<(), LoadFailure> {
///         for (i, p) in pressure.iter_mut().enumerate() {
///             let v = points.velocity_r[i] * points.normal_r[i] + points.velocity_z[i] * points.normal_z[i];
///             *p = if v > 0.0 { 0.5 * self.density * v * v } else { 0.0 };
///         }
///         Ok(())
///     }
/// }
///
/// let routines = Routines::none().with_load(Drag { density: 1000.0 });
/// let prepared = job::prepare("input/ogive_user.inp".as_ref(), &[], &routines);
/// let (outcome, history) = job::run_in_memory(&prepared);
/// assert!(outcome.halt.is_none() && history.0["V2@REF"].last < 0.0);
/// ```
pub trait UserLoad: Send {
    /// Sets `pressure`: one entry per point, positive against the outward normal, NaN on entry. For a body force it is
    /// the force per volume along r (BRNU) or z (BZNU).
    ///
    /// # Errors
    /// Any failure; the run halts and writes the last good state.
    fn pressure(&mut self, points: &LoadPoints<'_>, pressure: &mut [f64]) -> Result<(), LoadFailure>;

    /// Returns whether the load reads displacements and accelerations; if not, they are not updated.
    fn reads_motion(&self) -> bool {
        false
    }

    /// Returns how many numbers of each point a run keeps for the load ([`LoadPoints::memory`]).
    fn memory(&self) -> usize {
        0
    }

    /// Returns whether the load receives the magnitude of its data line; VDLOAD does not.
    fn reads_magnitude(&self) -> bool {
        true
    }
}

/// Constant properties of a user load, as its methods return them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LoadProperties {
    /// As [`UserLoad::reads_motion`].
    pub reads_motion: bool,
    /// As [`UserLoad::reads_magnitude`].
    pub reads_magnitude: bool,
    /// As [`UserLoad::memory`].
    pub memory: usize,
}

impl LoadProperties {
    /// Returns the properties of a load.
    pub fn of(load: &dyn UserLoad) -> LoadProperties {
        LoadProperties {
            reads_motion: load.reads_motion(),
            reads_magnitude: load.reads_magnitude(),
            memory: load.memory(),
        }
    }
}

/// A user load defined by a function of the points and the index of one point.
struct PointwiseLoad<F>(F);

impl<F: FnMut(&LoadPoints<'_>, usize) -> f64 + Send> UserLoad for PointwiseLoad<F> {
    fn pressure(&mut self, points: &LoadPoints<'_>, pressure: &mut [f64]) -> Result<(), LoadFailure> {
        pressure.iter_mut().enumerate().for_each(|(i, p)| *p = (self.0)(points, i));
        Ok(())
    }
}

/// Arguments of a user amplitude (ABAQUS 6.11 User Subroutines Reference, 1.2.7 "VUAMP").
#[derive(Debug)]
pub struct AmplitudeCall<'a> {
    /// Name of the amplitude, upper case.
    pub name: &'a str,
    /// Time, step and increment of the value.
    pub now: Instant,
    /// Whether this is the first call of a step.
    pub begins: bool,
    /// Length of the previous increment; 0 at the start.
    pub increment: f64,
    /// Value of the previous call; 0 at the start.
    pub old: f64,
    /// Constants on the data lines (`PROPERTIES=`).
    pub properties: &'a [f64],
    /// State variables of the routine (`VARIABLES=`).
    pub variables: &'a mut [f64],
    /// Names of the sensors, upper case.
    pub sensor_names: &'a [String],
    /// Values of the sensors at the previous instant.
    pub sensor_values: &'a [f64],
}

/// Result of a user amplitude.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AmplitudeAnswer {
    /// Value of the amplitude.
    pub value: f64,
    /// Time derivative of the amplitude, if the subroutine sets it.
    pub derivative: Option<f64>,
    /// Whether to stop the analysis (`iStopAnalysis`).
    pub stop: bool,
    /// Whether to end the step (`iConcludeStep`).
    pub conclude_step: bool,
}

/// A user amplitude (`*AMPLITUDE, DEFINITION=USER`).
pub trait UserAmplitude: Send {
    /// Returns the current value of the amplitude.
    ///
    /// # Errors
    /// Any failure; the run halts.
    fn amplitude(&mut self, call: &mut AmplitudeCall<'_>) -> Result<AmplitudeAnswer, LoadFailure>;
}

/// Arguments of a user motion for one node (ABAQUS 6.11 User Subroutines Reference, 1.2.1 "VDISP").
#[derive(Clone, Copy, Debug)]
pub struct MotionCall<'a> {
    /// Name of the node set (`cbname`), upper case.
    pub set: &'a str,
    /// 0 displacement, 1 velocity, 2 acceleration (`jBCType`).
    pub kind: i32,
    /// Node number of the user.
    pub node: i32,
    /// Degree of freedom, 1 for r (deformable nodes), 2 for z.
    pub dof: usize,
    /// Time, step and increment of the value.
    pub now: Instant,
    /// Lengths of the previous and the next increment (equal if the next is unknown).
    pub increments: [f64; 2],
    /// Current value of the amplitude; 1 without one.
    pub amplitude: f64,
    /// Current coordinates `[r, z]`.
    pub coordinates: [f64; 2],
    /// Displacement, velocity, acceleration and reaction along that degree of freedom.
    pub state: [f64; 4],
    /// Displacement, velocity, acceleration and reaction along the other axis; zero for a rigid body.
    pub across: [f64; 4],
    /// Mass of the body or node.
    pub mass: f64,
}

/// A user motion (`*BOUNDARY, USER`).
pub trait UserMotion: Send {
    /// Returns the displacement, velocity or acceleration along the degree of freedom.
    ///
    /// # Errors
    /// Any failure; the run halts.
    fn motion(&mut self, call: &MotionCall<'_>) -> Result<f64, LoadFailure>;
}

/// Components of the motion of a node in a [`NodalFieldCall`]: translations and rotations about three axes, acoustic pressure,
/// temperature.
pub const NODAL_COMPONENTS: usize = 8;

/// Arguments of user-defined field variables at nodes (ABAQUS 2024 User Subroutines Reference, "VUFIELD"). Arrays have all
/// components of the first node, then of the second, and so on.
#[derive(Clone, Copy, Debug)]
pub struct NodalFieldCall<'a> {
    /// Name of the node set, upper case (not an argument of VUFIELD).
    pub set: &'a str,
    /// Time, step and increment of the values.
    pub now: Instant,
    /// Length of the last increment, and duration of the step.
    pub lengths: [f64; 2],
    /// Number of the first variable, from 1, and number of variables.
    pub variables: [usize; 2],
    /// Node numbers of the user.
    pub nodes: &'a [i32],
    /// Current coordinates r, z, 0 of each node.
    pub coordinates: &'a [f64],
    /// Displacement, velocity and acceleration of each node, [`NODAL_COMPONENTS`] each; components that a node does not have
    /// are zero.
    pub motion: [&'a [f64]; 3],
}

/// User-defined field variables at nodes (`*FIELD, USER`).
pub trait UserNodalFields: Send {
    /// Sets `values`: the first variable of all nodes, then the second, and so on. On entry they are the initial values.
    ///
    /// # Errors
    /// Any failure; the run halts.
    fn nodal_fields(&mut self, call: &NodalFieldCall<'_>, values: &mut [f64]) -> Result<(), LoadFailure>;
}

/// Arguments of a user friction for a block of contact points (ABAQUS 2017 User Subroutines Reference, "VFRICTION"). Arrays of
/// vectors have all three components of the first point, then of the second, and so on; global components are r, z and 0.
#[derive(Clone, Copy, Debug)]
pub struct FrictionCall<'a> {
    /// Name of the surface interaction, upper case (`surfInt`).
    pub interaction: &'a str,
    /// Time, step and increment at the end of the increment.
    pub now: Instant,
    /// Length of the increment.
    pub dt: f64,
    /// Energy dissipated by friction since the analysis began.
    pub friction_work: f64,
    /// Number of state variables of a point (`nStates`).
    pub variables: usize,
    /// Constants on the data lines (`props`).
    pub properties: &'a [f64],
    /// Node number of each point on the surface that carries the pressure; 0 for a point of an analytical surface
    /// (`jConSlvUid`).
    pub nodes: &'a [i32],
    /// Slip of the increment in local directions (`dSlipFric`), with the friction coefficients of the previous increment; for a
    /// sticking point the slip that would occur without its friction. Only the first of the three components is not 0. Length.
    pub slip: &'a [f64],
    /// Force that prevents the slip of each point (`fStickForce`). Forces are those of the whole circumference.
    pub stick: &'a [f64],
    /// Friction force of the previous increment in local directions (`fTangPrev`).
    pub previous: &'a [f64],
    /// Normal force (`fNormal`).
    pub normal: &'a [f64],
    /// Area of each point on the surface of revolution (`areaCont`); 1 for a point without a face.
    pub area: &'a [f64],
    /// Unit normal of the opposite surface, towards the point, and unit vector of the slip (`dircosN`, `dircosSl`).
    pub directions: [&'a [f64]; 2],
    /// Coordinates of each point and of the opposite surface (`coordSlv`, `coordMst`).
    pub coordinates: [&'a [f64]; 2],
    /// Velocities of each point and of the opposite surface (`velSlv`, `velMst`).
    pub velocities: [&'a [f64]; 2],
}

/// A user friction (`*FRICTION, USER`). It is called once per increment and block of at most [`MAX_BLOCK`] points under
/// pressure.
pub trait UserFriction: Send {
    /// Sets `forces`: two components per point, along the slip (between minus the force that prevents slip, and zero) and along
    /// the hoop (zero); zero on entry. `state` are the state variables of the first point, then of the second, and so on.
    ///
    /// # Errors
    /// Any failure; the run halts.
    fn friction(&mut self, call: &FrictionCall<'_>, forces: &mut [f64], state: &mut [f64]) -> Result<(), LoadFailure>;
}

/// The subroutine for the friction of an increment.
pub struct FrictionInput<'a> {
    /// The subroutine, as in [`Routines::friction`].
    pub routine: &'a mut (dyn UserFriction + 'static),
    /// Time, step and increment at the end of the increment.
    pub arrival: Instant,
}

/// Points of the analysis at which VEXTERNALDB is called, with its `lOp` (ABAQUS 6.14 User Subroutines Reference,
/// 1.2.5).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i32)]
pub enum AnalysisMoment {
    /// Before the first increment of the first step.
    StartAnalysis = 0,
    /// Before the first increment of a step.
    StartStep = 1,
    /// Before the length of the next increment is chosen.
    SetupIncrement = 2,
    /// After the length of the increment is chosen, before its forces.
    StartIncrement = 3,
    /// After an increment is completed.
    EndIncrement = 4,
    /// After the last increment of a step.
    EndStep = 5,
    /// After the last step.
    EndAnalysis = 6,
}

impl AnalysisMoment {
    /// All moments, in the order of `lOp`.
    pub const ALL: [AnalysisMoment; 7] = [
        AnalysisMoment::StartAnalysis,
        AnalysisMoment::StartStep,
        AnalysisMoment::SetupIncrement,
        AnalysisMoment::StartIncrement,
        AnalysisMoment::EndIncrement,
        AnalysisMoment::EndStep,
        AnalysisMoment::EndAnalysis,
    ];
}

/// Action of the run after a call of VEXTERNALDB (`i_Array(i_int_iStatus)`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Persist)]
pub enum RunAction {
    /// The run continues.
    #[default]
    Continue,
    /// The current step ends after this increment; the next step follows.
    EndStep,
    /// The run ends after this increment.
    EndAnalysis,
}

/// A subroutine called at fixed points of the analysis (VEXTERNALDB), for example to open and close its own files.
pub trait UserEvents: Send {
    /// Performs the actions of the subroutine at a moment of the analysis; `increment` is the length of the increment.
    ///
    /// # Errors
    /// Any failure; the run halts.
    fn moment(&mut self, moment: AnalysisMoment, now: &Instant, increment: f64) -> Result<RunAction, LoadFailure>;

    /// Announces an [`AnalysisMoment::EndIncrement`] whose state will be saved (`lWriteRestart`).
    fn restart_follows(&mut self) {}
}

/// Largest number of material points of one call.
pub const MAX_MATERIAL_BLOCK: usize = 136;

/// Declares the arguments of subroutines for a block of material points: common fields, and fields of each subroutine.
macro_rules! point_calls {
    ($($(#[$about:meta])* $call:ident { $($(#[$doc:meta])* $field:ident: $type:ty,)* })*) => {$(
        $(#[$about])*
        pub struct $call<'a> {
            /// Name of the material, upper case (`cmname`).
            pub name: &'a str,
            /// Time, step and increment at the end of the increment. In the first call of VUMAT, with small fictitious
            /// strains from which the elastic moduli are determined, step and total time are 0.
            pub now: Instant,
            /// Length of the increment; 0 for lengths when the analysis begins.
            pub dt: f64,
            /// Points (`nblock`).
            pub count: usize,
            /// Number of the integration points in their elements, from 1 (`kIntPt`; entry 2 of `jblock` of VUMAT).
            pub integration_point: usize,
            /// State variables of a point (`nstatev`).
            pub variables: usize,
            /// Field variables (`nfieldv`).
            pub fields: usize,
            /// Constants (`props`).
            pub properties: &'a [f64],
            /// Element numbers of the user (`jElem`; at the end of `jblock` of VUMAT).
            pub elements: &'a [i32],
            /// State variables at the start of the increment (`stateOld`).
            pub state: &'a [f64],
            $($(#[$doc])* pub $field: $type,)*
        }
    )*};
}

point_calls! {
    /// Arguments of a user material for a block of points (ABAQUS 6.14 User Subroutines Reference, 1.2.17 "VUMAT"). Arrays
    /// hold all points of one component, then of the next; symmetric tensors have the components rr, zz, hoop, rz (tensor
    /// shear). Stresses, strain increments and stretches are in axes that rotate by R of the polar decomposition F = R U of
    /// the deformation gradient (Green-Naghdi rate), so tensors among the state variables need no rotation. F is in global
    /// axes.
    #[derive(Debug)]
    MaterialCall {
        /// `coordMp`: r, z, then NaN in place of a third coordinate.
        coordinates: &'a [f64],
        /// `charLength`: square root of the element's area in the (r, z) plane, or the value of VUCHARLENGTH; length.
        length: &'a [f64],
        /// Mass per volume at the middle of the increment.
        density: &'a [f64],
        /// Strain increments (`strainInc`).
        strain: &'a [f64],
        /// `relSpinInc`: spin increment (zr) relative to the rotation of the axes.
        spin: &'a [f64],
        /// Temperatures at the start and at the end of the increment (`tempOld`, `tempNew`).
        temperature: [&'a [f64]; 2],
        /// Field variables at the start and at the end of the increment (`fieldOld`, `fieldNew`).
        field: [&'a [f64]; 2],
        /// Stretch tensors at the start and at the end of the increment (`stretchOld`, `stretchNew`).
        stretch: [&'a [f64]; 2],
        /// `defgradOld` and `defgradNew`, in global axes: rr, zz, hoop, rz, zr.
        gradient: [&'a [f64]; 2],
        /// Stresses at the start of the increment (`stressOld`).
        stress: &'a [f64],
        /// `enerInternOld`, energy per mass.
        internal: &'a [f64],
        /// `enerInelasOld`, energy per mass.
        inelastic: &'a [f64],
    }

    /// Arguments of a user hardening for a block of points (ABAQUS 6.14 User Subroutines Reference, 1.2.15 "VUHARD").
    #[derive(Debug)]
    HardeningCall {
        /// `tempOld` and `tempNew`: both at the beginning of the increment, as for built-in laws.
        temperature: [&'a [f64]; 2],
        /// Field variables at the start and at the end of the increment (`fieldOld`, `fieldNew`).
        field: [&'a [f64]; 2],
        /// Trial equivalent plastic strain (`eqps`).
        strain: &'a [f64],
        /// Trial equivalent plastic strain rate, 1/time (`eqpsRate`).
        rate: &'a [f64],
    }

    /// Arguments of a user strain energy for a block of points (ABAQUS 2016 User Subroutines Reference, 1.2.9
    /// "VUANISOHYPER_INV").
    #[derive(Debug)]
    EnergyCall {
        /// Families of fibres (`nFiber`).
        families: usize,
        /// Temperatures at the start and at the end of the increment (`tempOld`, `tempNew`).
        temperature: [&'a [f64]; 2],
        /// Field variables at the start and at the end of the increment (`fieldOld`, `fieldNew`).
        field: [&'a [f64]; 2],
        /// Invariants Ī1, Ī2, J, then Ī4(ij) and Ī5(ij) for i ≤ j, j varying slowest (`sInvariant`).
        invariants: &'a [f64],
        /// Cosines between the families i < j in the initial configuration, j varying slowest (`zeta`).
        cosines: &'a [f64],
    }

    /// Arguments of user-defined fields for a block of points (ABAQUS 6.14 User Subroutines Reference, 1.2.20 "VUSDFLD").
    FieldCall {
        /// `coordMp`: r, z, then NaN in place of a third coordinate.
        coordinates: &'a [f64],
        /// `charLength`: square root of the element's area in the (r, z) plane, or the value of VUCHARLENGTH; length.
        length: &'a [f64],
        /// Values of the points (`vgetvrm`).
        values: &'a dyn PointValues,
    }

    /// Arguments of user characteristic lengths for a block of points (ABAQUS 2016 User Subroutines Reference, 1.2.11
    /// "VUCHARLENGTH").
    LengthCall {
        /// Nodes of an element (`nnode`): 3, 4, or 6 for CAX6M; a triangle among quadrilaterals has its last node twice.
        corners: usize,
        /// `coordMp`: r, and then z, of each point.
        coordinates: &'a [f64],
        /// `coordNode`: r of the first node of each element, then of the second, and so on; then z.
        nodes: &'a [f64],
        /// Field variables (`field`).
        field: &'a [f64],
    }
}

/// Result of a user material. On entry, stresses are NaN, state variables and energies the previous ones.
#[derive(Debug)]
pub struct MaterialAnswer<'a> {
    /// Stresses at the end of the increment (`stressNew`).
    pub stress: &'a mut [f64],
    /// State variables at the end of the increment (`stateNew`).
    pub state: &'a mut [f64],
    /// Internal energies per mass at the end of the increment (`enerInternNew`).
    pub internal: &'a mut [f64],
    /// `enerInelasNew`: plastic dissipation.
    pub inelastic: &'a mut [f64],
}

/// A user material (`*USER MATERIAL`). It may keep its own state between calls. It is called from one thread, once per
/// increment and block of at most [`MAX_MATERIAL_BLOCK`] points.
pub trait UserMaterial: Send {
    /// Computes stresses and state variables at the end of the increment.
    ///
    /// # Errors
    /// Any failure; the run halts.
    fn stress(&mut self, call: &MaterialCall<'_>, answer: &mut MaterialAnswer<'_>) -> Result<(), LoadFailure>;
}

/// Result of a user hardening. On entry, yield stresses are NaN, slopes zero, state variables the previous ones.
#[derive(Debug)]
pub struct HardeningAnswer<'a> {
    /// Yield stresses (`yield`).
    pub stress: &'a mut [f64],
    /// Derivatives of the yield stresses by temperature (`dyieldDtemp`).
    pub by_temperature: &'a mut [f64],
    /// `dyieldDeqps`: derivatives with respect to the plastic strain of all points, then to its rate.
    pub slopes: &'a mut [f64],
    /// State variables at the end of the increment (`stateNew`).
    pub state: &'a mut [f64],
}

/// Isotropic user hardening (`*PLASTIC, HARDENING=USER`): yield stress over plastic strain, rate and temperature. It is
/// called several times per increment and block: first for all points, then for yielding points until the stress equals
/// the yield stress. The state variables of the last call for a point are kept.
pub trait UserHardening: Send {
    /// Computes yield stresses and their slopes.
    ///
    /// # Errors
    /// Any failure; the run halts.
    fn yield_stress(&mut self, call: &HardeningCall<'_>, answer: &mut HardeningAnswer<'_>) -> Result<(), LoadFailure>;
}

/// Result of a user strain energy per initial volume. On entry, derivatives are zero, state variables the previous ones.
#[derive(Debug)]
pub struct EnergyAnswer<'a> {
    /// Deviatoric part of the energy (`uDev`), which no result depends on.
    pub deviatoric: &'a mut [f64],
    /// Derivatives by the invariants (`duDi`).
    pub first: &'a mut [f64],
    /// Second derivatives by the invariants a ≤ b, b varying slowest (`d2uDiDi`). They bound the stable time increment.
    pub second: &'a mut [f64],
    /// State variables at the end of the increment (`stateNew`).
    pub state: &'a mut [f64],
}

/// User strain energy of invariants (`*ANISOTROPIC HYPERELASTIC, USER, FORMULATION=INVARIANT`), called once per increment and
/// block, and at the start of the analysis in the initial configuration.
pub trait UserEnergy: Send {
    /// Computes the derivatives of the strain energy.
    ///
    /// # Errors
    /// Any failure; the run halts.
    fn energy(&mut self, call: &EnergyCall<'_>, answer: &mut EnergyAnswer<'_>) -> Result<(), LoadFailure>;
}

/// Values of material points at the beginning of an increment, by output variable (`vgetvrm`).
pub trait PointValues {
    /// Calls `to(component, point, value)` for all components and points. Returns the number of components; `None` if
    /// the variable is not available.
    fn give(&self, variable: &str, to: &mut dyn FnMut(usize, usize, f64)) -> Option<usize>;
}

/// Result of user-defined fields; on entry the previous values.
#[derive(Debug)]
pub struct FieldAnswer<'a> {
    /// `stateNew`: the previous state of the other subroutines.
    pub state: &'a mut [f64],
    /// Field variables, which the subroutine updates (`field`).
    pub field: &'a mut [f64],
}

/// User-defined fields (`*USER DEFINED FIELD`), called at the beginning of each increment.
pub trait UserFields: Send {
    /// Computes field and state variables.
    ///
    /// # Errors
    /// Any failure; the run halts.
    fn fields(&mut self, call: &FieldCall<'_>, answer: &mut FieldAnswer<'_>) -> Result<(), LoadFailure>;
}

/// User characteristic lengths (`*CHARACTERISTIC LENGTH, DEFINITION=USER`).
pub trait UserLengths: Send {
    /// Sets the length of each point; on entry the square root of the element's area in the (r, z) plane.
    ///
    /// # Errors
    /// Any failure; the run halts.
    fn lengths(&mut self, call: &LengthCall<'_>, lengths: &mut [f64]) -> Result<(), LoadFailure>;
}

/// A user subroutine with one state for all callers, as one VDLOAD serves a whole ABAQUS job. A run locks its
/// subroutines for its whole duration; another run of the same subroutines waits.
pub struct SharedRoutine<T: ?Sized>(Arc<RoutineSlot<T>>);

/// Place of a user subroutine that no run has locked.
struct RoutineSlot<T: ?Sized> {
    routine: Mutex<Option<Box<T>>>,
    returned: Condvar,
}

impl<T: ?Sized> Clone for SharedRoutine<T> {
    fn clone(&self) -> Self {
        SharedRoutine(Arc::clone(&self.0))
    }
}

impl<T: ?Sized> SharedRoutine<T> {
    fn new(routine: Box<T>) -> Self {
        SharedRoutine(Arc::new(RoutineSlot { routine: Mutex::new(Some(routine)), returned: Condvar::new() }))
    }

    /// Locks the subroutine, even if it panicked in an earlier run.
    pub fn lock(&self) -> LockedRoutine<T> {
        let mut slot = self.0.routine.lock().unwrap_or_else(PoisonError::into_inner);
        loop {
            if let Some(routine) = slot.take() {
                return LockedRoutine { routine: Some(routine), slot: Some(Arc::clone(&self.0)) };
            }
            slot = self.0.returned.wait(slot).unwrap_or_else(PoisonError::into_inner);
        }
    }
}

/// A user subroutine that a run has locked, or none. It passes from one plan of a run to the next.
pub struct LockedRoutine<T: ?Sized> {
    routine: Option<Box<T>>,
    slot: Option<Arc<RoutineSlot<T>>>,
}

impl<T: ?Sized> Default for LockedRoutine<T> {
    fn default() -> Self {
        LockedRoutine { routine: None, slot: None }
    }
}

impl<T: ?Sized> LockedRoutine<T> {
    /// Returns whether there is a subroutine.
    pub fn is_some(&self) -> bool {
        self.routine.is_some()
    }

    /// Returns the subroutine.
    pub fn as_deref_mut(&mut self) -> Option<&mut T> {
        self.routine.as_deref_mut()
    }
}

impl<T: ?Sized> Drop for LockedRoutine<T> {
    fn drop(&mut self) {
        if let Some(slot) = &self.slot {
            *slot.routine.lock().unwrap_or_else(PoisonError::into_inner) = self.routine.take();
            slot.returned.notify_one();
        }
    }
}

/// A subroutine of the user's files that cannot be called.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct UncallableRoutine {
    /// Name of the subroutine.
    pub routine: String,
    /// Diagnostic code (`U…`).
    pub code: String,
    /// Description of the failure.
    pub message: String,
}

/// Declares the user subroutines of a job: field, trait, name in ABAQUS, and method that adds one.
macro_rules! routines {
    ($($(#[$doc:meta])* $field:ident: $routine:ident, $name:literal, $with:ident;)*) => {
        /// Names of the supported user subroutines.
        pub const ROUTINES: &[&str] = &[$($name),*];

        /// The user subroutines of a job; each at most once, as in ABAQUS.
        #[derive(Clone, Default)]
        pub struct Routines {
            $($(#[$doc])* pub $field: Option<SharedRoutine<dyn $routine>>,)*
            /// Material laws in Rust, by the upper-case name of their material.
            pub laws: Vec<(String, Arc<dyn MaterialLaw>)>,
            /// Equations of state in Rust, by the upper-case name of their material.
            pub equations_of_state: Vec<(String, Arc<dyn EosLaw>)>,
            /// Subroutines of the user's files that cannot be called.
            pub uncallable: Vec<UncallableRoutine>,
            /// ABAQUS subroutines in these files that Revolve does not support.
            pub unsupported: Vec<&'static str>,
            /// Variables of compiled subroutines.
            pub memory: Option<Arc<dyn PersistentMemory>>,
            /// Properties of the load, if a plan was compiled with it: plans of new meshes are compiled while a run has locked
            /// the load.
            pub load_properties: Option<LoadProperties>,
        }

        /// The user subroutines of a job, locked by a run; fields as in [`Routines`].
        #[allow(missing_docs)]
        #[derive(Default)]
        pub struct LockedRoutines {
            $(pub $field: LockedRoutine<dyn $routine>,)*
        }

        impl Routines {
            /// Locks all subroutines for a run.
            pub fn lock(&self) -> LockedRoutines {
                LockedRoutines { $($field: self.$field.as_ref().map(SharedRoutine::lock).unwrap_or_default(),)* }
            }

            /// Returns the names of the defined subroutines.
            pub fn names(&self) -> Vec<&'static str> {
                [$(self.$field.is_some().then_some($name)),*].into_iter().flatten().collect()
            }

            $(
                /// Adds a subroutine of this kind, or replaces it.
                #[must_use]
                pub fn $with(mut self, routine: impl $routine + 'static) -> Self {
                    self.$field = Some(SharedRoutine::new(Box::new(routine)));
                    self
                }
            )*
        }
    };
}

routines! {
    /// `PNU`, `P1NU` to `P4NU`, `BRNU`, `BZNU` (VDLOAD).
    load: UserLoad, "vdload", with_load;
    /// `*AMPLITUDE, DEFINITION=USER` (VUAMP).
    amplitude: UserAmplitude, "vuamp", with_amplitude;
    /// Subroutine VDISP of `*BOUNDARY, USER`.
    motion: UserMotion, "vdisp", with_motion;
    /// Subroutine VUMAT of `*USER MATERIAL`.
    material: UserMaterial, "vumat", with_material;
    /// `*ANISOTROPIC HYPERELASTIC, USER` (VUANISOHYPER_INV).
    energy: UserEnergy, "vuanisohyper_inv", with_energy;
    /// `*PLASTIC, HARDENING=USER` (VUHARD).
    hardening: UserHardening, "vuhard", with_hardening;
    /// `*USER DEFINED FIELD` (VUSDFLD).
    fields: UserFields, "vusdfld", with_fields;
    /// `*FIELD, USER` (VUFIELD).
    nodal_fields: UserNodalFields, "vufield", with_nodal_fields;
    /// `*FRICTION, USER` (VFRICTION).
    friction: UserFriction, "vfriction", with_friction;
    /// `*CHARACTERISTIC LENGTH, DEFINITION=USER` (VUCHARLENGTH).
    lengths: UserLengths, "vucharlength", with_lengths;
    /// Subroutine VEXTERNALDB, called at fixed moments of the analysis.
    events: UserEvents, "vexternaldb", with_events;
}

impl LockedRoutines {
    /// Returns the subroutines that elements call at their points.
    pub fn at_points(&mut self) -> PointRoutines<'_> {
        PointRoutines {
            material: self.material.as_deref_mut(),
            energy: self.energy.as_deref_mut(),
            hardening: self.hardening.as_deref_mut(),
            fields: self.fields.as_deref_mut(),
            lengths: self.lengths.as_deref_mut(),
        }
    }
}

/// The user subroutines that elements call at their points, locked by a run.
#[derive(Default)]
pub struct PointRoutines<'a> {
    /// VUMAT subroutine, as in [`Routines::material`].
    pub material: Option<&'a mut (dyn UserMaterial + 'static)>,
    /// VUANISOHYPER_INV subroutine, as in [`Routines::energy`].
    pub energy: Option<&'a mut (dyn UserEnergy + 'static)>,
    /// VUHARD subroutine, as in [`Routines::hardening`].
    pub hardening: Option<&'a mut (dyn UserHardening + 'static)>,
    /// VUSDFLD subroutine, as in [`Routines::fields`].
    pub fields: Option<&'a mut (dyn UserFields + 'static)>,
    /// VUCHARLENGTH subroutine, as in [`Routines::lengths`].
    pub lengths: Option<&'a mut (dyn UserLengths + 'static)>,
}

impl PointRoutines<'_> {
    /// Returns the same references with a shorter lifetime.
    pub fn lend(&mut self) -> PointRoutines<'_> {
        PointRoutines {
            material: self.material.as_deref_mut(),
            energy: self.energy.as_deref_mut(),
            hardening: self.hardening.as_deref_mut(),
            fields: self.fields.as_deref_mut(),
            lengths: self.lengths.as_deref_mut(),
        }
    }
}

impl Routines {
    /// Returns an empty set of user subroutines.
    pub fn none() -> Self {
        Routines::default()
    }

    /// Returns whether any subroutine is defined.
    pub fn any(&self) -> bool {
        !self.names().is_empty()
    }

    /// Adds a material law in Rust for the `*USER MATERIAL` of this name.
    #[must_use]
    pub fn with_law(mut self, material: &str, law: impl MaterialLaw + 'static) -> Self {
        self.laws.push((material.to_uppercase(), Arc::new(law)));
        self
    }

    /// Returns the material law in Rust of a material.
    pub fn law(&self, material: &str) -> Option<&Arc<dyn MaterialLaw>> {
        self.laws.iter().find(|(name, _)| name == material).map(|(_, law)| law)
    }

    /// Adds an equation of state in Rust for the `*EOS, TYPE=USER` of the material of this name.
    #[must_use]
    pub fn with_eos(mut self, material: &str, law: impl EosLaw + 'static) -> Self {
        self.equations_of_state.push((material.to_uppercase(), Arc::new(law)));
        self
    }

    /// Returns the equation of state in Rust of a material.
    pub fn equation_of_state(&self, material: &str) -> Option<&Arc<dyn EosLaw>> {
        self.equations_of_state.iter().find(|(name, _)| name == material).map(|(_, law)| law)
    }

    /// Adds a user load by a function that returns the pressure at one point, by its index.
    #[must_use]
    pub fn with_pressure(self, pressure: impl FnMut(&LoadPoints<'_>, usize) -> f64 + Send + 'static) -> Self {
        self.with_load(PointwiseLoad(pressure))
    }
}
