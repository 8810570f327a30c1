//! User subroutines: the traits that Rust plug-ins implement, with the arguments of ABAQUS's subroutines, and compiled
//! Fortran and C behind the same traits. Never here: solver internals.

mod address;
pub mod codes;
#[cfg_attr(not(compiled_routines), allow(dead_code))]
pub mod host;
pub mod law;
#[cfg_attr(not(compiled_routines), path = "native/unavailable.rs")]
mod native;
mod saved_memory;

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::state::Instant;
use crate::state::halt::Halt;
pub use law::{MaterialLaw, MaterialPoint, Moduli};
pub use native::{compile, crash, show_symbols};
pub(crate) use saved_memory::{PersistentMemory, SavedMemory};

/// Largest number of points of one call: `maxblk` of `vaba_param.inc`. Larger surfaces are divided into blocks.
pub const MAX_BLOCK: usize = 512;

/// Arguments of a user load for a block of points of one surface (ABAQUS 6.6 User Subroutines Reference, 1.2.1 "VDLOAD").
/// Slices have one entry per point unless stated otherwise.
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
    /// `curCoords`: r of all points, z of all points, then as many NaN for a routine that reads a third coordinate.
    pub coordinates: &'a [f64],
    /// `velocity`: velocity, displacement and acceleration, each r of all points, then z of all points. The last two hold
    /// values only if [`UserLoad::reads_motion`].
    pub motion: &'a [f64],
    /// `dirCos`: normal r, tangent r, normal z, tangent z of all points, then NaN for a third direction. The tangent is the
    /// normal turned 90 degrees counter-clockwise; the normal points out of the loaded side of a surface element, and into
    /// a solid element.
    pub directions: &'a [f64],
}

/// Failure of a user routine.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{reason}")]
pub struct LoadFailure {
    /// Index in the block of the point that caused it, if known.
    pub point: Option<usize>,
    /// Description.
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

/// A user load: the pressure at each point. It may keep state; it is called once per increment, surface and block of at most
/// [`MAX_BLOCK`] points.
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

    /// Whether it reads displacements and accelerations; if not, they are not updated.
    fn reads_motion(&self) -> bool {
        false
    }
}

/// A user load given as a function of the points and the index of one.
struct ByPoint<F>(F);

impl<F: FnMut(&LoadPoints<'_>, usize) -> f64 + Send> UserLoad for ByPoint<F> {
    fn pressure(&mut self, points: &LoadPoints<'_>, pressure: &mut [f64]) -> Result<(), LoadFailure> {
        pressure.iter_mut().enumerate().for_each(|(i, p)| *p = (self.0)(points, i));
        Ok(())
    }
}

/// Arguments of a user amplitude (ABAQUS 6.11 User Subroutines Reference, 1.2.7 "VUAMP").
#[derive(Debug)]
#[non_exhaustive]
pub struct AmplitudeCall<'a> {
    /// Name of the amplitude, upper case.
    pub name: &'a str,
    /// The instant of the value.
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
    /// Their values at the previous instant.
    pub sensor_values: &'a [f64],
}

/// Answer of a user amplitude.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AmplitudeAnswer {
    /// The value.
    pub value: f64,
    /// Its time derivative, if the routine sets it.
    pub derivative: Option<f64>,
    /// Stop the analysis (`iStopAnalysis`).
    pub stop: bool,
    /// End the step (`iConcludeStep`).
    pub conclude_step: bool,
}

/// A user amplitude (`*AMPLITUDE, DEFINITION=USER`).
pub trait UserAmplitude: Send {
    /// The value now.
    ///
    /// # Errors
    /// Any reason; the run halts.
    fn amplitude(&mut self, call: &mut AmplitudeCall<'_>) -> Result<AmplitudeAnswer, LoadFailure>;
}

/// Arguments of a user motion for one node (ABAQUS 6.11 User Subroutines Reference, 1.2.1 "VDISP").
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
    /// The instant of the value.
    pub now: Instant,
    /// Lengths of the previous increment and of the next (the same if unknown).
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

/// A user motion (`*BOUNDARY, USER`).
pub trait UserMotion: Send {
    /// The displacement, velocity or acceleration along the degree of freedom.
    ///
    /// # Errors
    /// Any reason; the run halts.
    fn motion(&mut self, call: &MotionCall<'_>) -> Result<f64, LoadFailure>;
}

/// Moments at which VEXTERNALDB is called, with its `lOp` (ABAQUS 6.14 User Subroutines Reference, 1.2.5).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i32)]
#[non_exhaustive]
pub enum AnalysisMoment {
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

impl AnalysisMoment {
    /// All of them, in the order of `lOp`.
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

/// What the run does after a call of VEXTERNALDB (`i_Array(i_int_iStatus)`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum RunAction {
    /// Continue.
    #[default]
    Continue,
    /// End the step.
    EndStep,
    /// End the analysis.
    EndAnalysis,
}

/// A routine called at the moments of the analysis, for example to open and close files of its own.
pub trait UserEvents: Send {
    /// Called at each moment, with the length of the increment.
    ///
    /// # Errors
    /// Any reason; the run halts.
    fn moment(&mut self, moment: AnalysisMoment, now: &Instant, increment: f64) -> Result<RunAction, LoadFailure>;

    /// Called before an [`AnalysisMoment::EndIncrement`] whose state will be saved (`lWriteRestart`).
    fn restart_follows(&mut self) {}
}

/// Largest number of material points of one call.
pub const MAX_MATERIAL_BLOCK: usize = 136;

/// Arguments of a user material for a block of points (ABAQUS 6.14 User Subroutines Reference, 1.2.17 "VUMAT"). Arrays hold
/// one component of all points after the other: of symmetric tensors rr, zz, hoop, rz (tensor shear). Stresses and strains
/// are in a frame that rotates with the material spin, so tensors among the state variables need no rotation.
#[derive(Debug)]
#[non_exhaustive]
pub struct MaterialCall<'a> {
    /// Name of the material, upper case (`cmname`).
    pub name: &'a str,
    /// End of the increment; step and total time are both 0 in the first call, with small fictitious strains, from which the
    /// elastic moduli are found.
    pub now: Instant,
    /// Length of the increment.
    pub dt: f64,
    /// Points (`nblock`).
    pub count: usize,
    /// State variables of a point (`nstatev`).
    pub variables: usize,
    /// Constants of the material (`props`).
    pub properties: &'a [f64],
    /// `coordMp`: r, z, then NaN for a routine that reads a third coordinate.
    pub coordinates: &'a [f64],
    /// `charLength`: square root of the element's area in the (r, z) plane, or the value of VUCHARLENGTH; length.
    pub length: &'a [f64],
    /// Mass per volume at the middle of the increment.
    pub density: &'a [f64],
    /// `strainInc`.
    pub strain: &'a [f64],
    /// `relSpinInc`: spin relative to the frame, zero.
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
    /// `enerInternOld`, energy per mass.
    pub internal: &'a [f64],
    /// `enerInelasOld`, energy per mass.
    pub inelastic: &'a [f64],
}

/// Answer of a user material; stresses are NaN on entry, state variables and energies the previous ones.
#[derive(Debug)]
#[non_exhaustive]
pub struct MaterialAnswer<'a> {
    /// `stressNew`.
    pub stress: &'a mut [f64],
    /// `stateNew`.
    pub state: &'a mut [f64],
    /// `enerInternNew`.
    pub internal: &'a mut [f64],
    /// `enerInelasNew`: plastic dissipation.
    pub inelastic: &'a mut [f64],
}

/// A user material (`*USER MATERIAL`). It may keep state of its own; it is called from one thread, once per increment and
/// block of at most [`MAX_MATERIAL_BLOCK`] points.
pub trait UserMaterial: Send {
    /// Stresses and state variables at the end of the increment.
    ///
    /// # Errors
    /// Any reason; the run halts.
    fn stress(&mut self, call: &MaterialCall<'_>, answer: &mut MaterialAnswer<'_>) -> Result<(), LoadFailure>;
}

/// Arguments of a user hardening for a block of points (ABAQUS 6.14 User Subroutines Reference, 1.2.15 "VUHARD").
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
    /// `tempOld` and `tempNew`: both at the beginning of the increment, as for built-in laws.
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

/// Answer of a user hardening; yield stresses are NaN on entry, slopes zero, state variables the previous ones.
#[derive(Debug)]
#[non_exhaustive]
pub struct HardeningAnswer<'a> {
    /// `yield`.
    pub stress: &'a mut [f64],
    /// `dyieldDtemp`.
    pub by_temperature: &'a mut [f64],
    /// `dyieldDeqps`: derivatives with respect to the plastic strain of all points, then to its rate.
    pub slopes: &'a mut [f64],
    /// `stateNew`.
    pub state: &'a mut [f64],
}

/// An isotropic user hardening (`*PLASTIC, HARDENING=USER`): yield stress over plastic strain, rate and temperature. It is
/// called several times per increment and block: first for all points, then for those that yield until their stress equals
/// the yield stress. The state variables of the last call for a point are kept.
pub trait UserHardening: Send {
    /// Yield stresses and their slopes.
    ///
    /// # Errors
    /// Any reason; the run halts.
    fn yield_stress(&mut self, call: &HardeningCall<'_>, answer: &mut HardeningAnswer<'_>) -> Result<(), LoadFailure>;
}

/// Values of material points at the beginning of an increment, by output variable (`vgetvrm`).
pub trait PointValues {
    /// Passes component, point and value of each component of each point on; returns the number of components, `None` if the
    /// points do not have the variable.
    fn give(&self, variable: &str, to: &mut dyn FnMut(usize, usize, f64)) -> Option<usize>;
}

/// Arguments of user-defined fields for a block of points (ABAQUS 6.14 User Subroutines Reference, 1.2.20 "VUSDFLD").
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
    /// `coordMp`: r, z, then NaN for a routine that reads a third coordinate.
    pub coordinates: &'a [f64],
    /// `charLength`: square root of the element's area in the (r, z) plane, or the value of VUCHARLENGTH; length.
    pub length: &'a [f64],
    /// `stateOld`.
    pub state: &'a [f64],
    /// Values of the points (`vgetvrm`).
    pub values: &'a dyn PointValues,
}

/// Answer of user-defined fields; both are the previous ones on entry.
#[derive(Debug)]
#[non_exhaustive]
pub struct FieldAnswer<'a> {
    /// `stateNew`: the old state of the other routines.
    pub state: &'a mut [f64],
    /// `field`.
    pub field: &'a mut [f64],
}

/// User-defined fields (`*USER DEFINED FIELD`), called at the beginning of each increment.
pub trait UserFields: Send {
    /// Field and state variables.
    ///
    /// # Errors
    /// Any reason; the run halts.
    fn fields(&mut self, call: &FieldCall<'_>, answer: &mut FieldAnswer<'_>) -> Result<(), LoadFailure>;
}

/// Arguments of user characteristic lengths for a block of points (ABAQUS 2016 User Subroutines Reference, 1.2.11
/// "VUCHARLENGTH").
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
    /// Corners of an element (`nnode`): 3 or 4; a triangle among quadrilaterals has its last node twice.
    pub corners: usize,
    /// Constants (`props`).
    pub properties: &'a [f64],
    /// User's numbers of the elements (`jElem`).
    pub elements: &'a [i32],
    /// `coordMp`: r, and then z, of each point.
    pub coordinates: &'a [f64],
    /// `coordNode`: r of the first corner of each element, then of the second, and so on; then z.
    pub nodes: &'a [f64],
    /// `field`.
    pub field: &'a [f64],
    /// `stateOld`.
    pub state: &'a [f64],
}

/// User characteristic lengths (`*CHARACTERISTIC LENGTH, DEFINITION=USER`).
pub trait UserLengths: Send {
    /// Sets the length of each point; on entry the square root of the element's area in the (r, z) plane.
    ///
    /// # Errors
    /// Any reason; the run halts.
    fn lengths(&mut self, call: &LengthCall<'_>, lengths: &mut [f64]) -> Result<(), LoadFailure>;
}

/// A routine with one state for all its callers, as one VDLOAD serves a whole ABAQUS job. A run locks its routines from its
/// beginning to its end; another run of the same routines waits.
pub struct SharedRoutine<T: ?Sized>(Arc<Mutex<T>>);

impl<T: ?Sized> Clone for SharedRoutine<T> {
    fn clone(&self) -> Self {
        SharedRoutine(Arc::clone(&self.0))
    }
}

impl<T: ?Sized> SharedRoutine<T> {
    /// Locks the routine, also one that panicked in an earlier run.
    pub fn lock(&self) -> MutexGuard<'_, T> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A routine of the user's files that cannot be called.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct UncallableRoutine {
    /// Its name.
    pub routine: String,
    /// Code of the finding (`U…`).
    pub code: String,
    /// Why.
    pub message: String,
}

/// Declares the routines of a job: field, trait, name in ABAQUS and the method that adds one.
macro_rules! routines {
    ($($(#[$doc:meta])* $field:ident: $routine:ident, $name:literal, $with:ident;)*) => {
        /// Names of the routines that can be called.
        pub const ROUTINES: &[&str] = &[$($name),*];

        /// The routines of a job; each at most once, as in ABAQUS.
        #[derive(Clone, Default)]
        #[non_exhaustive]
        pub struct Routines {
            $($(#[$doc])* pub $field: Option<SharedRoutine<dyn $routine>>,)*
            /// Material laws of Rust programs, by the name of their material in upper case.
            pub laws: Vec<(String, Arc<dyn MaterialLaw>)>,
            /// Routines of the user's files that cannot be called as they are.
            pub uncallable: Vec<UncallableRoutine>,
            /// Routines of ABAQUS in these files that nothing here calls.
            pub unsupported: Vec<&'static str>,
            /// What compiled routines keep to themselves.
            pub(crate) memory: Option<Arc<dyn PersistentMemory>>,
        }

        /// The routines of a job while a run holds them; fields as in [`Routines`].
        #[allow(missing_docs)]
        pub struct Locked<'a> {
            $(pub $field: Option<MutexGuard<'a, dyn $routine + 'static>>,)*
        }

        impl Routines {
            /// Holds all of them for a run.
            pub fn lock(&self) -> Locked<'_> {
                Locked { $($field: self.$field.as_ref().map(SharedRoutine::lock),)* }
            }

            /// Names of those that there are.
            pub fn names(&self) -> Vec<&'static str> {
                [$(self.$field.is_some().then_some($name)),*].into_iter().flatten().collect()
            }

            $(
                /// With a routine of this kind in place of another.
                #[must_use]
                pub fn $with(mut self, routine: impl $routine + 'static) -> Self {
                    self.$field = Some(SharedRoutine(Arc::new(Mutex::new(routine))));
                    self
                }
            )*
        }
    };
}

routines! {
    /// `PNU` and its kin (VDLOAD).
    load: UserLoad, "vdload", with_load;
    /// `*AMPLITUDE, DEFINITION=USER` (VUAMP).
    amplitude: UserAmplitude, "vuamp", with_amplitude;
    /// `*BOUNDARY, USER` (VDISP).
    motion: UserMotion, "vdisp", with_motion;
    /// `*USER MATERIAL` (VUMAT).
    material: UserMaterial, "vumat", with_material;
    /// `*PLASTIC, HARDENING=USER` (VUHARD).
    hardening: UserHardening, "vuhard", with_hardening;
    /// `*USER DEFINED FIELD` (VUSDFLD).
    fields: UserFields, "vusdfld", with_fields;
    /// `*CHARACTERISTIC LENGTH, DEFINITION=USER` (VUCHARLENGTH).
    lengths: UserLengths, "vucharlength", with_lengths;
    /// VEXTERNALDB.
    events: UserEvents, "vexternaldb", with_events;
}

impl Locked<'_> {
    /// Those that elements call at their points.
    pub fn at_points(&mut self) -> AtPoints<'_> {
        AtPoints {
            material: self.material.as_deref_mut(),
            hardening: self.hardening.as_deref_mut(),
            fields: self.fields.as_deref_mut(),
            lengths: self.lengths.as_deref_mut(),
        }
    }
}

/// The routines that elements call at their points, while a run holds them.
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
    /// The same with a shorter lifetime.
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

    /// Whether there is any.
    pub fn any(&self) -> bool {
        !self.names().is_empty()
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

    /// With a load that gives the pressure at one point after the other, by the index of the point.
    #[must_use]
    pub fn with_pressure(self, pressure: impl FnMut(&LoadPoints<'_>, usize) -> f64 + Send + 'static) -> Self {
        self.with_load(ByPoint(pressure))
    }
}
