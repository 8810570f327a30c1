//! User routines: the traits that Rust plug-ins implement, with the arguments of ABAQUS's subroutines, and the door to
//! compiled Fortran and C. Never here: solver internals.

mod address;
mod cache;
mod call;
pub mod codes;
pub mod compile;
mod guard;
pub mod host;
mod isolate;
pub mod law;
pub mod library;
mod memory;
mod prototype;
mod source;
mod symbols;

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::state::Instant;
use crate::state::halt::Halt;
pub use address::show_symbols;
pub use law::{MaterialLaw, MaterialPoint, Moduli};
pub(crate) use memory::{Kept, Recall};

/// Points a routine is shown in one call at most: `maxblk` of `vaba_param.inc`. Larger surfaces come in blocks.
pub const MAX_BLOCK: usize = 512;

/// What a user load is told, for one surface and a block of points: VDLOAD's arguments, structure of arrays
/// (ABAQUS 6.6 User Subroutines Reference, 1.2.1 "VDLOAD"). Slices have one entry a point unless said otherwise.
#[derive(Debug)]
#[non_exhaustive]
pub struct LoadPoints<'a> {
    /// Surface or element-set name, upper case (`sname` of a surface load; VDLOAD gets blanks for an element load).
    pub surface: &'a str,
    /// Kind of load (`jltyp`): 0 on a surface; 20 PNU, 21 to 24 P1NU to P4NU, 1 BRNU, 2 BZNU on elements.
    pub load_type: i32,
    /// Clock, step and increment.
    pub now: Instant,
    /// Current value of the amplitude the load refers to (1 without one); the routine applies it.
    pub amplitude: f64,
    /// Magnitude on the data line (VDLOAD is not told it).
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
    /// `curCoords`: r of all points, z of all points, and behind them as many NaN for a routine that reads a third
    /// coordinate.
    pub coordinates: &'a [f64],
    /// `velocity`: slabs of velocity, displacement and acceleration, each r of all points, then z of all points. The last
    /// two hold values only if the routine asks for them ([`UserLoad::reads_motion`]).
    pub motion: &'a [f64],
    /// `dirCos`: of each point the first vector is the normal, the second the tangent (the normal turned 90 degrees
    /// counter-clockwise): slabs normal r, tangent r, normal z, tangent z, and behind
    /// them NaN where a third direction would be. As the manual has it, the normal points out of
    /// the loaded side of a surface element, and into a solid element.
    pub directions: &'a [f64],
}

/// Why a user routine gave up.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{reason}")]
pub struct LoadFailure {
    /// Index of the point in the block, where one is to blame.
    pub point: Option<usize>,
    /// In words.
    pub reason: String,
}

impl LoadFailure {
    /// Without a point.
    pub fn new(reason: impl Into<String>) -> Self {
        LoadFailure { point: None, reason: reason.into() }
    }

    /// The halt that follows; `what` names routine and place.
    pub fn halt(&self, what: &str, now: &Instant) -> Halt {
        let reason = format!(
            "{what} failed in step {}, increment {}, total time {:e}: {}",
            now.step, now.increment, now.total_time, self.reason
        );
        Halt { code: "R201", reason }
    }
}

/// A load routine of the user: gives the pressure at each point. May keep state; is called once an increment, surface
/// and block of at most [`MAX_BLOCK`] points.
///
/// ```
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
    /// Fills `pressure` (one entry a point, positive pushes against the outward normal; NaN on entry). For a body force
    /// it is the force a volume along r (BRNU) or z (BZNU).
    ///
    /// # Errors
    /// Any reason; the run halts with the last good state written.
    fn pressure(&mut self, points: &LoadPoints<'_>, pressure: &mut [f64]) -> Result<(), LoadFailure>;

    /// Whether it reads displacements and accelerations; if not, those slabs are not kept up.
    fn reads_motion(&self) -> bool {
        false
    }
}

/// A user load by a function of the points and the index of one.
struct ByPoint<F>(F);

impl<F: FnMut(&LoadPoints<'_>, usize) -> f64 + Send> UserLoad for ByPoint<F> {
    fn pressure(&mut self, points: &LoadPoints<'_>, pressure: &mut [f64]) -> Result<(), LoadFailure> {
        pressure.iter_mut().enumerate().for_each(|(i, p)| *p = (self.0)(points, i));
        Ok(())
    }
}

/// What a user amplitude is told: VUAMP's arguments (ABAQUS 6.11 User Subroutines Reference, 1.2.7 "VUAMP").
#[derive(Debug)]
#[non_exhaustive]
pub struct AmplitudeCall<'a> {
    /// Name of the amplitude, upper case.
    pub name: &'a str,
    /// Clock, step and increment: the instant at which the value is wanted.
    pub now: Instant,
    /// Whether this is the call that begins a step.
    pub begins: bool,
    /// Length of the increment that led here; 0 at the start.
    pub increment: f64,
    /// Value of the call before; 0 at the start.
    pub old: f64,
    /// Constants on the data lines (`PROPERTIES=`).
    pub properties: &'a [f64],
    /// Variables the routine may keep (`VARIABLES=`).
    pub variables: &'a mut [f64],
    /// Names of the sensors, upper case.
    pub sensor_names: &'a [String],
    /// Their values at the instant before.
    pub sensor_values: &'a [f64],
}

/// What a user amplitude answers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AmplitudeAnswer {
    /// The value.
    pub value: f64,
    /// Its derivative in time, where the routine gives one.
    pub derivative: Option<f64>,
    /// Stop the analysis (`iStopAnalysis`).
    pub stop: bool,
    /// End the step (`iConcludeStep`).
    pub conclude_step: bool,
}

/// An amplitude computed by the user (`*AMPLITUDE, DEFINITION=USER`).
pub trait UserAmplitude: Send {
    /// The value now.
    ///
    /// # Errors
    /// Any reason; the run halts.
    fn amplitude(&mut self, call: &mut AmplitudeCall<'_>) -> Result<AmplitudeAnswer, LoadFailure>;
}

/// What a prescribed motion of the user is told: VDISP's arguments for one node
/// (ABAQUS 6.11 User Subroutines Reference, 1.2.1 "VDISP").
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct MotionCall<'a> {
    /// Name of the node set (`cbname`), upper case.
    pub set: &'a str,
    /// 0 displacement, 1 velocity, 2 acceleration (`jBCType`).
    pub kind: i32,
    /// User's number of the node.
    pub node: i32,
    /// Degree of freedom, 1 for r (deformable nodes), 2 for z.
    pub dof: usize,
    /// Clock, step and increment: the instant at which the value is wanted.
    pub now: Instant,
    /// Length of the increment that led here, and of the next if it is known (else the same).
    pub increments: [f64; 2],
    /// Amplitude, 1 without one.
    pub amplitude: f64,
    /// Current coordinates `[r, z]`.
    pub coordinates: [f64; 2],
    /// Displacement, velocity, acceleration and reaction along that degree of freedom.
    pub state: [f64; 4],
    /// The same along the other axis; zero for a rigid body.
    pub across: [f64; 4],
    /// Mass of the body or node.
    pub mass: f64,
}

/// A motion prescribed by the user (`*BOUNDARY, USER`).
pub trait UserMotion: Send {
    /// The displacement, velocity or acceleration along the degree of freedom that the node shall have now.
    ///
    /// # Errors
    /// Any reason; the run halts.
    fn motion(&mut self, call: &MotionCall<'_>) -> Result<f64, LoadFailure>;
}

/// Moments at which VEXTERNALDB is called, with its `lOp` (ABAQUS 6.14 User Subroutines Reference, 1.2.5).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i32)]
#[non_exhaustive]
pub enum Moment {
    /// Before the first increment of the first step.
    StartAnalysis = 0,
    /// Before a step.
    StartStep = 1,
    /// The length of the next increment is to be chosen.
    SetupIncrement = 2,
    /// An increment begins.
    StartIncrement = 3,
    /// An increment is complete.
    EndIncrement = 4,
    /// After a step.
    EndStep = 5,
    /// After the last step.
    EndAnalysis = 6,
}

/// What a routine wants after a moment of the analysis (`i_Array(i_int_iStatus)`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Wish {
    /// Go on.
    #[default]
    Continue,
    /// End the step.
    EndStep,
    /// End the analysis.
    EndAnalysis,
}

/// A routine that is told how the analysis goes: opens and closes files of its own.
pub trait UserEvents: Send {
    /// Called at each moment, with the length of the increment.
    ///
    /// # Errors
    /// Any reason; the run halts.
    fn moment(&mut self, moment: Moment, now: &Instant, increment: f64) -> Result<Wish, LoadFailure>;

    /// Called before an [`Moment::EndIncrement`] whose state will be kept (`lWriteRestart`): the time to keep one's own.
    fn restart_follows(&mut self) {}
}

/// Material points a routine is shown in one call at most.
pub const MAX_MATERIAL_BLOCK: usize = 136;

/// What a user material is told, for a block of points: VUMAT's arguments (ABAQUS 6.14 User Subroutines Reference, 1.2.17
/// "VUMAT"). Components follow each other, each with one entry a point: of symmetric tensors rr, zz, hoop, rz (tensor
/// shear). Stresses and strains are in a frame that turns with the spin of the material, so that tensors among the state
/// variables need no rotation.
#[derive(Debug)]
#[non_exhaustive]
pub struct MaterialCall<'a> {
    /// Name of the material, upper case (`cmname`).
    pub name: &'a str,
    /// Clock, step and increment at the end of the increment; step and total time are both 0 in the first call, whose
    /// answer to small fictitious strains tells the elastic moduli.
    pub now: Instant,
    /// Length of the increment.
    pub dt: f64,
    /// Points (`nblock`).
    pub count: usize,
    /// State variables of a point (`nstatev`).
    pub variables: usize,
    /// Constants of the material (`props`).
    pub properties: &'a [f64],
    /// `coordMp`: r, z, and behind them NaN for a routine that reads a third coordinate.
    pub coordinates: &'a [f64],
    /// `charLength`: root of the element's area in the (r, z) plane, or what VUCHARLENGTH gives; length.
    pub length: &'a [f64],
    /// Mass a volume at the middle of the increment.
    pub density: &'a [f64],
    /// `strainInc`.
    pub strain: &'a [f64],
    /// `relSpinInc`: spin against the frame, zero.
    pub spin: &'a [f64],
    /// User's numbers of the elements.
    pub elements: &'a [i32],
    /// `tempOld` and `tempNew`.
    pub temperature: [&'a [f64]; 2],
    /// Field variables (`nfieldv`).
    pub fields: usize,
    /// `fieldOld` and `fieldNew`.
    pub field: [&'a [f64]; 2],
    /// `stretchOld` and `stretchNew`.
    pub stretch: [&'a [f64]; 2],
    /// `defgradOld` and `defgradNew`: rr, zz, hoop, rz, zr.
    pub gradient: [&'a [f64]; 2],
    /// `stressOld`.
    pub stress: &'a [f64],
    /// `stateOld`.
    pub state: &'a [f64],
    /// `enerInternOld`, energy a mass.
    pub internal: &'a [f64],
    /// `enerInelasOld`, energy a mass.
    pub inelastic: &'a [f64],
}

/// What a user material answers; stresses are NaN on entry, state variables and energies those before.
#[derive(Debug)]
#[non_exhaustive]
pub struct MaterialAnswer<'a> {
    /// `stressNew`.
    pub stress: &'a mut [f64],
    /// `stateNew`.
    pub state: &'a mut [f64],
    /// `enerInternNew`.
    pub internal: &'a mut [f64],
    /// `enerInelasNew`: what is booked as plastic dissipation.
    pub inelastic: &'a mut [f64],
}

/// A material of the user (`*USER MATERIAL`). May keep state of its own; is called from one thread, once an increment and
/// block of at most [`MAX_MATERIAL_BLOCK`] points.
pub trait UserMaterial: Send {
    /// Stresses and state variables at the end of the increment.
    ///
    /// # Errors
    /// Any reason; the run halts.
    fn stress(&mut self, call: &MaterialCall<'_>, answer: &mut MaterialAnswer<'_>) -> Result<(), LoadFailure>;
}

/// What a hardening of the user is told, for a block of points: VUHARD's arguments (ABAQUS 6.14 User Subroutines Reference,
/// 1.2.15 "VUHARD").
#[derive(Debug)]
#[non_exhaustive]
pub struct HardeningCall<'a> {
    /// Name of the material, upper case (`cmname`).
    pub name: &'a str,
    /// Clock, step and increment at the end of the increment.
    pub now: Instant,
    /// Length of the increment.
    pub dt: f64,
    /// Points (`nblock`).
    pub count: usize,
    /// State variables of a point (`nstatev`).
    pub variables: usize,
    /// Field variables (`nfieldv`).
    pub fields: usize,
    /// Constants of the hardening (`props`).
    pub properties: &'a [f64],
    /// User's numbers of the elements (`jElem`).
    pub elements: &'a [i32],
    /// `tempOld` and `tempNew`: both at the beginning of the increment, as laws that are built in take it.
    pub temperature: [&'a [f64]; 2],
    /// `fieldOld` and `fieldNew`.
    pub field: [&'a [f64]; 2],
    /// `stateOld`.
    pub state: &'a [f64],
    /// Equivalent plastic strain tried (`eqps`).
    pub strain: &'a [f64],
    /// Its rate, 1/time (`eqpsRate`).
    pub rate: &'a [f64],
}

/// What a hardening of the user answers; yield stresses are NaN on entry, slopes zero, state variables those before.
#[derive(Debug)]
#[non_exhaustive]
pub struct HardeningAnswer<'a> {
    /// `yield`.
    pub stress: &'a mut [f64],
    /// `dyieldDtemp`.
    pub by_temperature: &'a mut [f64],
    /// `dyieldDeqps`: derivatives by the plastic strain of all points, then by its rate.
    pub slopes: &'a mut [f64],
    /// `stateNew`.
    pub state: &'a mut [f64],
}

/// An isotropic hardening of the user (`*PLASTIC, HARDENING=USER`): yield stress over plastic strain, rate and temperature.
/// Asked several times an increment and block, first of all for points that do not flow, then for those that do until their
/// stress meets the yield stress; what the last question for a point gave as its state variables is kept.
pub trait UserHardening: Send {
    /// Yield stresses and their slopes.
    ///
    /// # Errors
    /// Any reason; the run halts.
    fn yield_stress(&mut self, call: &HardeningCall<'_>, answer: &mut HardeningAnswer<'_>) -> Result<(), LoadFailure>;
}

/// What material points hold at the beginning of an increment, by output variable: what `vgetvrm` gives.
pub trait PointValues {
    /// Gives each component of each point: its component, point and value. How many components there are; `None` if the
    /// points do not hold the variable.
    fn give(&self, variable: &str, to: &mut dyn FnMut(usize, usize, f64)) -> Option<usize>;
}

/// What a routine of user-defined fields is told, for a block of points: VUSDFLD's arguments (ABAQUS 6.14 User Subroutines
/// Reference, 1.2.20 "VUSDFLD").
#[non_exhaustive]
pub struct FieldCall<'a> {
    /// Name of the material, upper case (`cmname`).
    pub name: &'a str,
    /// Clock, step and increment at the end of the increment that begins.
    pub now: Instant,
    /// Length of the increment.
    pub dt: f64,
    /// Points (`nblock`).
    pub count: usize,
    /// State variables of a point (`nstatev`).
    pub variables: usize,
    /// Field variables (`nfieldv`).
    pub fields: usize,
    /// Constants (`props`).
    pub properties: &'a [f64],
    /// User's numbers of the elements (`jElem`).
    pub elements: &'a [i32],
    /// `coordMp`: r, z, and behind them NaN for a routine that reads a third coordinate.
    pub coordinates: &'a [f64],
    /// `charLength`: root of the element's area in the (r, z) plane, or what VUCHARLENGTH gives; length.
    pub length: &'a [f64],
    /// `stateOld`.
    pub state: &'a [f64],
    /// What the points hold (`vgetvrm`).
    pub values: &'a dyn PointValues,
}

/// What a routine of user-defined fields answers; both are those before on entry.
#[derive(Debug)]
#[non_exhaustive]
pub struct FieldAnswer<'a> {
    /// `stateNew`: what other routines are given as their old state.
    pub state: &'a mut [f64],
    /// `field`.
    pub field: &'a mut [f64],
}

/// Fields of the user (`*USER DEFINED FIELD`), asked for at the beginning of each increment.
pub trait UserFields: Send {
    /// Field and state variables.
    ///
    /// # Errors
    /// Any reason; the run halts.
    fn fields(&mut self, call: &FieldCall<'_>, answer: &mut FieldAnswer<'_>) -> Result<(), LoadFailure>;
}

/// What a routine of characteristic lengths is told, for a block of points: VUCHARLENGTH's arguments (ABAQUS 2016 User
/// Subroutines Reference, 1.2.11 "VUCHARLENGTH").
#[non_exhaustive]
pub struct LengthCall<'a> {
    /// Name of the material, upper case (`cmname`).
    pub name: &'a str,
    /// Clock, step and increment.
    pub now: Instant,
    /// Length of the increment; 0 when the analysis begins.
    pub dt: f64,
    /// Points (`nblock`).
    pub count: usize,
    /// State variables of a point (`nstatev`).
    pub variables: usize,
    /// Field variables (`nfieldv`).
    pub fields: usize,
    /// Corners of an element (`nnode`): 3 of triangles, 4 else; a triangle among quadrilaterals has its last node twice.
    pub corners: usize,
    /// Constants (`props`).
    pub properties: &'a [f64],
    /// User's numbers of the elements (`jElem`).
    pub elements: &'a [i32],
    /// `coordMp`: r, and then z, of each point.
    pub coordinates: &'a [f64],
    /// `coordNode`: r of the first corner of each element, then of the second, and so on; then z likewise.
    pub nodes: &'a [f64],
    /// `field`.
    pub field: &'a [f64],
    /// `stateOld`.
    pub state: &'a [f64],
}

/// Characteristic lengths of the user (`*CHARACTERISTIC LENGTH, DEFINITION=USER`).
pub trait UserLengths: Send {
    /// The length of each point; on entry the default, the root of the element's area in the (r, z) plane.
    ///
    /// # Errors
    /// Any reason; the run halts.
    fn lengths(&mut self, call: &LengthCall<'_>, lengths: &mut [f64]) -> Result<(), LoadFailure>;
}

/// A routine shared by all that calls it, as one VDLOAD serves a whole ABAQUS job: its state is common to them. A run holds
/// its routines from its beginning to its end; another run of the same routines waits until then.
pub struct Shared<T: ?Sized>(Arc<Mutex<T>>);

impl<T: ?Sized> Clone for Shared<T> {
    fn clone(&self) -> Self {
        Shared(Arc::clone(&self.0))
    }
}

impl<T: ?Sized> Shared<T> {
    /// Holds the routine. One that panicked in an earlier run is held as it is.
    pub fn lock(&self) -> MutexGuard<'_, T> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A user load, shared.
pub type SharedLoad = Shared<dyn UserLoad>;
/// A user amplitude, shared.
pub type SharedAmplitude = Shared<dyn UserAmplitude>;
/// A user material, shared.
pub type SharedMaterial = Shared<dyn UserMaterial>;
/// A hardening of the user, shared.
pub type SharedHardening = Shared<dyn UserHardening>;
/// Fields of the user, shared.
pub type SharedFields = Shared<dyn UserFields>;
/// Characteristic lengths of the user, shared.
pub type SharedLengths = Shared<dyn UserLengths>;
/// A user motion, shared.
pub type SharedMotion = Shared<dyn UserMotion>;
/// A routine told of events, shared.
pub type SharedEvents = Shared<dyn UserEvents>;

/// Names of the routines that can be called.
pub const ROUTINES: &[&str] =
    &["vdload", "vuamp", "vdisp", "vumat", "vuhard", "vusdfld", "vucharlength", "vexternaldb"];

/// A routine of the user's files that cannot be called as it is.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Misfit {
    /// Its name.
    pub routine: String,
    /// Code of the finding (`U…`).
    pub code: String,
    /// Why.
    pub message: String,
}

/// The routines of a job; each at most once, as in ABAQUS.
#[derive(Clone, Default)]
#[non_exhaustive]
pub struct Routines {
    /// `PNU` and its kin (VDLOAD).
    pub load: Option<SharedLoad>,
    /// `*AMPLITUDE, DEFINITION=USER` (VUAMP).
    pub amplitude: Option<SharedAmplitude>,
    /// `*BOUNDARY, USER` (VDISP).
    pub motion: Option<SharedMotion>,
    /// `*USER MATERIAL` (VUMAT).
    pub material: Option<SharedMaterial>,
    /// `*PLASTIC, HARDENING=USER` (VUHARD).
    pub hardening: Option<SharedHardening>,
    /// `*USER DEFINED FIELD` (VUSDFLD).
    pub fields: Option<SharedFields>,
    /// `*CHARACTERISTIC LENGTH, DEFINITION=USER` (VUCHARLENGTH).
    pub lengths: Option<SharedLengths>,
    /// VEXTERNALDB.
    pub events: Option<SharedEvents>,
    /// Material laws of Rust programs, by the name of their material in upper case.
    pub laws: Vec<(String, Arc<dyn MaterialLaw>)>,
    /// What the user's files hold beside these: routines that cannot be called as they are.
    pub misfits: Vec<Misfit>,
    /// What they hold beside these: routines of ABAQUS that nothing here calls.
    pub strangers: Vec<&'static str>,
    /// What compiled routines keep to themselves.
    pub(crate) memory: Option<Arc<dyn Recall>>,
}

/// The routines of a job while a run holds them.
pub struct Locked<'a> {
    /// As [`Routines::load`].
    pub load: Option<MutexGuard<'a, dyn UserLoad + 'static>>,
    /// As [`Routines::amplitude`].
    pub amplitude: Option<MutexGuard<'a, dyn UserAmplitude + 'static>>,
    /// As [`Routines::motion`].
    pub motion: Option<MutexGuard<'a, dyn UserMotion + 'static>>,
    /// As [`Routines::material`].
    pub material: Option<MutexGuard<'a, dyn UserMaterial + 'static>>,
    /// As [`Routines::hardening`].
    pub hardening: Option<MutexGuard<'a, dyn UserHardening + 'static>>,
    /// As [`Routines::fields`].
    pub fields: Option<MutexGuard<'a, dyn UserFields + 'static>>,
    /// As [`Routines::lengths`].
    pub lengths: Option<MutexGuard<'a, dyn UserLengths + 'static>>,
    /// As [`Routines::events`].
    pub events: Option<MutexGuard<'a, dyn UserEvents + 'static>>,
}

impl Locked<'_> {
    /// Those that elements ask at their points.
    pub fn at_points(&mut self) -> AtPoints<'_> {
        AtPoints {
            material: self.material.as_deref_mut(),
            hardening: self.hardening.as_deref_mut(),
            fields: self.fields.as_deref_mut(),
            lengths: self.lengths.as_deref_mut(),
        }
    }
}

/// The routines that elements ask at their points, while a run holds them.
#[derive(Default)]
pub struct AtPoints<'a> {
    /// As [`Routines::material`].
    pub material: Option<&'a mut (dyn UserMaterial + 'static)>,
    /// As [`Routines::hardening`].
    pub hardening: Option<&'a mut (dyn UserHardening + 'static)>,
    /// As [`Routines::fields`].
    pub fields: Option<&'a mut (dyn UserFields + 'static)>,
    /// As [`Routines::lengths`].
    pub lengths: Option<&'a mut (dyn UserLengths + 'static)>,
}

impl AtPoints<'_> {
    /// The same for a shorter time.
    pub fn lend(&mut self) -> AtPoints<'_> {
        AtPoints {
            material: self.material.as_deref_mut(),
            hardening: self.hardening.as_deref_mut(),
            fields: self.fields.as_deref_mut(),
            lengths: self.lengths.as_deref_mut(),
        }
    }
}

impl Routines {
    /// No routines.
    pub fn none() -> Self {
        Routines::default()
    }

    /// Holds all of them for a run.
    pub fn lock(&self) -> Locked<'_> {
        Locked {
            load: self.load.as_ref().map(Shared::lock),
            amplitude: self.amplitude.as_ref().map(Shared::lock),
            motion: self.motion.as_ref().map(Shared::lock),
            material: self.material.as_ref().map(Shared::lock),
            hardening: self.hardening.as_ref().map(Shared::lock),
            fields: self.fields.as_ref().map(Shared::lock),
            lengths: self.lengths.as_ref().map(Shared::lock),
            events: self.events.as_ref().map(Shared::lock),
        }
    }

    /// Whether there is any.
    pub fn any(&self) -> bool {
        !self.names().is_empty()
    }

    /// Names of those that there are.
    pub fn names(&self) -> Vec<&'static str> {
        let there = [
            self.load.is_some(),
            self.amplitude.is_some(),
            self.motion.is_some(),
            self.material.is_some(),
            self.hardening.is_some(),
            self.fields.is_some(),
            self.lengths.is_some(),
            self.events.is_some(),
        ];
        ROUTINES.iter().zip(there).filter(|(_, there)| *there).map(|(name, _)| *name).collect()
    }

    /// With a load.
    #[must_use]
    pub fn with_load(mut self, routine: impl UserLoad + 'static) -> Self {
        self.load = Some(Shared(Arc::new(Mutex::new(routine))));
        self
    }

    /// With a load that gives the pressure at one point after the other, by the index of the point.
    #[must_use]
    pub fn with_pressure(self, pressure: impl FnMut(&LoadPoints<'_>, usize) -> f64 + Send + 'static) -> Self {
        self.with_load(ByPoint(pressure))
    }

    /// With an amplitude.
    #[must_use]
    pub fn with_amplitude(mut self, routine: impl UserAmplitude + 'static) -> Self {
        self.amplitude = Some(Shared(Arc::new(Mutex::new(routine))));
        self
    }

    /// With a prescribed motion.
    #[must_use]
    pub fn with_motion(mut self, routine: impl UserMotion + 'static) -> Self {
        self.motion = Some(Shared(Arc::new(Mutex::new(routine))));
        self
    }

    /// With a material.
    #[must_use]
    pub fn with_material(mut self, routine: impl UserMaterial + 'static) -> Self {
        self.material = Some(Shared(Arc::new(Mutex::new(routine))));
        self
    }

    /// With a material law in Rust for the `*USER MATERIAL` of this name.
    #[must_use]
    pub fn with_law(mut self, material: &str, law: impl MaterialLaw + 'static) -> Self {
        self.laws.push((material.to_uppercase(), Arc::new(law)));
        self
    }

    /// Returns the material law in Rust of a material.
    pub fn law(&self, material: &str) -> Option<&Arc<dyn MaterialLaw>> {
        self.laws.iter().find(|(name, _)| name == material).map(|(_, law)| law)
    }

    /// With a hardening.
    #[must_use]
    pub fn with_hardening(mut self, routine: impl UserHardening + 'static) -> Self {
        self.hardening = Some(Shared(Arc::new(Mutex::new(routine))));
        self
    }

    /// With fields.
    #[must_use]
    pub fn with_fields(mut self, routine: impl UserFields + 'static) -> Self {
        self.fields = Some(Shared(Arc::new(Mutex::new(routine))));
        self
    }

    /// With characteristic lengths.
    #[must_use]
    pub fn with_lengths(mut self, routine: impl UserLengths + 'static) -> Self {
        self.lengths = Some(Shared(Arc::new(Mutex::new(routine))));
        self
    }

    /// With a routine that is told of events.
    #[must_use]
    pub fn with_events(mut self, routine: impl UserEvents + 'static) -> Self {
        self.events = Some(Shared(Arc::new(Mutex::new(routine))));
        self
    }
}
