//! The door to compiled routines: opening shared libraries, calling what they define, and the host routines they call.
//! Never here: compiling; what a routine leaves behind in the process; what a routine's answer means.
#![allow(unsafe_code)]

use std::any::Any;
use std::ffi::{CStr, c_char, c_int};
use std::fmt::Write as _;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::Once;
use std::sync::atomic::{AtomicBool, Ordering};

use libloading::os::unix::{Library, RTLD_LOCAL, RTLD_NOW};

use super::call::{self, Call, current, last_words};
use super::compile::Ready;
use super::guard;
use super::host::{self, Level};
use super::memory::{Memory, Part, Recall, bases};
use super::{
    AmplitudeAnswer, AmplitudeCall, FieldAnswer, FieldCall, HardeningAnswer, HardeningCall, LengthCall, LoadFailure,
    LoadPoints, MAX_MATERIAL_BLOCK, MaterialAnswer, MaterialCall, Misfit, Moment, MotionCall, ROUTINES, Routines,
    UserAmplitude, UserEvents, UserFields, UserHardening, UserLengths, UserLoad, UserMaterial, UserMotion, Wish,
};
use crate::deck::{Diagnostic, files};
use crate::output::whole::Scratch;
use crate::state::Instant;

/// `subroutine vdload(nblock, ndim, stepTime, totalTime, amplitude, curCoords, velocity, dirCos, jltyp, sname, value)`.
type Vdload = unsafe extern "C-unwind" fn(
    *const i32,
    *const i32,
    *const f64,
    *const f64,
    *const f64,
    *const f64,
    *const f64,
    *const f64,
    *const i32,
    *const c_char,
    *mut f64,
    usize,
);
/// `subroutine vuamp(ampName, time, ampValueOld, dt, nprops, props, nSvars, svars, lFlagsInfo, nSensor, sensorValues,
/// sensorNames, jSensorLookUpTable, ampValueNew, lFlagsDefine, ampDerivative, ampSecDerivative, ampIncIntegral)`.
type Vuamp = unsafe extern "C-unwind" fn(
    *const c_char,
    *const f64,
    *const f64,
    *const f64,
    *const i32,
    *const f64,
    *const i32,
    *mut f64,
    *const i32,
    *const i32,
    *const f64,
    *const c_char,
    *const i32,
    *mut f64,
    *mut i32,
    *mut f64,
    *mut f64,
    *mut f64,
    usize,
    usize,
);
/// `subroutine vdisp(nblock, nDof, nCoord, kstep, kinc, stepTime, totalTime, dtNext, dt, cbname, jBCType, jDof, jNodeUid,
/// amp, coordNp, u, v, a, rf, rmass, rotaryI, rval)`.
type Vdisp = unsafe extern "C-unwind" fn(
    *const i32,
    *const i32,
    *const i32,
    *const i32,
    *const i32,
    *const f64,
    *const f64,
    *const f64,
    *const f64,
    *const c_char,
    *const i32,
    *const i32,
    *const i32,
    *const f64,
    *const f64,
    *const f64,
    *const f64,
    *const f64,
    *const f64,
    *const f64,
    *const f64,
    *mut f64,
    usize,
);
/// `subroutine vumat(jblock, ndir, nshr, nstatev, nfieldv, nprops, jInfoArray, stepTime, totalTime, dtArray, cmname, coordMp,
/// charLength, props, density, strainInc, relSpinInc, tempOld, stretchOld, defgradOld, fieldOld, stressOld, stateOld,
/// enerInternOld, enerInelasOld, tempNew, stretchNew, defgradNew, fieldNew, stressNew, stateNew, enerInternNew,
/// enerInelasNew)`.
type Vumat = unsafe extern "C-unwind" fn(
    *const i32,
    *const i32,
    *const i32,
    *const i32,
    *const i32,
    *const i32,
    *const i32,
    *const f64,
    *const f64,
    *const f64,
    *const c_char,
    *const f64,
    *const f64,
    *const f64,
    *const f64,
    *const f64,
    *const f64,
    *const f64,
    *const f64,
    *const f64,
    *const f64,
    *const f64,
    *const f64,
    *const f64,
    *const f64,
    *const f64,
    *const f64,
    *const f64,
    *const f64,
    *mut f64,
    *mut f64,
    *mut f64,
    *mut f64,
    usize,
);
/// `subroutine vuhard(nblock, jElem, kIntPt, kLayer, kSecPt, lAnneal, stepTime, totalTime, dt, cmname, nstatev, nfieldv, nprops,
/// props, tempOld, tempNew, fieldOld, fieldNew, stateOld, eqps, eqpsRate, yield, dyieldDtemp, dyieldDeqps, stateNew)`.
type Vuhard = unsafe extern "C-unwind" fn(
    *const i32,
    *const i32,
    *const i32,
    *const i32,
    *const i32,
    *const i32,
    *const f64,
    *const f64,
    *const f64,
    *const c_char,
    *const i32,
    *const i32,
    *const i32,
    *const f64,
    *const f64,
    *const f64,
    *const f64,
    *const f64,
    *const f64,
    *const f64,
    *const f64,
    *mut f64,
    *mut f64,
    *mut f64,
    *mut f64,
    usize,
);
/// `subroutine vusdfld(nblock, nstatev, nfieldv, nprops, ndir, nshr, jElem, kIntPt, kLayer, kSecPt, stepTime, totalTime, dt,
/// cmname, coordMp, direct, T, charLength, props, stateOld, stateNew, field)`.
type Vusdfld = unsafe extern "C-unwind" fn(
    *const i32,
    *const i32,
    *const i32,
    *const i32,
    *const i32,
    *const i32,
    *const i32,
    *const i32,
    *const i32,
    *const i32,
    *const f64,
    *const f64,
    *const f64,
    *const c_char,
    *const f64,
    *const f64,
    *const f64,
    *const f64,
    *const f64,
    *const f64,
    *mut f64,
    *mut f64,
    usize,
);
/// `subroutine vucharlength(nblock, nfieldv, nprops, ncomp, ndim, nnode, nstatev, kSecPt, kLayer, kIntPt, jElType, jElem,
/// totalTime, stepTime, dt, cmname, coordMp, coordNode, direct, T, props, field, stateOld, charLength)`.
type Vucharlength = unsafe extern "C-unwind" fn(
    *const i32,
    *const i32,
    *const i32,
    *const i32,
    *const i32,
    *const i32,
    *const i32,
    *const i32,
    *const i32,
    *const i32,
    *const i32,
    *const i32,
    *const f64,
    *const f64,
    *const f64,
    *const c_char,
    *const f64,
    *const f64,
    *const f64,
    *const f64,
    *const f64,
    *const f64,
    *const f64,
    *mut f64,
    usize,
);
/// `subroutine vexternaldb(lOp, i_Array, niArray, r_Array, nrArray)`.
type Vexternaldb = unsafe extern "C-unwind" fn(*const i32, *mut i32, *const i32, *mut f64, *const i32);

/// Opens libraries and binds what they define. Each call gives routines with a state of their own, so that the runs of a
/// sweep share nothing. `watch_invalid` halts a load that computes with what is no number.
///
/// # Errors
/// A library that cannot be loaded (with the loader's words), or none that defines a routine that can be called; `given` are
/// the user's own files.
pub(super) fn open(
    files: &[Ready],
    watch_invalid: bool,
    misfits: &[Misfit],
    given: &[PathBuf],
) -> Result<Routines, Diagnostic> {
    watch_the_process();
    let opened = files.iter().map(open_copy).collect::<Result<Vec<_>, _>>()?;
    let (libraries, parts): (Vec<Library>, Vec<Vec<Part>>) = opened.into_iter().unzip();
    let libraries: Arc<[Library]> = libraries.into();
    let memory: Arc<dyn Recall> = Arc::new(Memory::of(parts.into_iter().flatten().collect(), libraries.clone()));
    let strangers = STRANGERS.iter().copied().filter(|name| defines(&libraries, name)).collect();
    let mut routines = Routines { misfits: misfits.to_vec(), strangers, memory: Some(memory), ..Routines::none() };
    let mut known = false;
    let fits = |name: &str| misfits.iter().all(|m| m.routine != name);
    // SAFETY: the symbols have the types that the manual gives them; sources were checked against these at compilation.
    unsafe {
        if let Some(call) = find::<Vdload>(&libraries, "vdload").filter(|_| fits("vdload")) {
            routines = routines.with_load(CompiledLoad {
                call,
                name: Padded::default(),
                watch_invalid,
                _keep: libraries.clone(),
            });
            known = true;
        }
        if let Some(call) = find::<Vuamp>(&libraries, "vuamp").filter(|_| fits("vuamp")) {
            routines = routines.with_amplitude(CompiledAmplitude { call, _keep: libraries.clone() });
            known = true;
        }
        if let Some(call) = find::<Vdisp>(&libraries, "vdisp").filter(|_| fits("vdisp")) {
            routines = routines.with_motion(CompiledMotion { call, name: Padded::default(), _keep: libraries.clone() });
            known = true;
        }
        if let Some(call) = find::<Vumat>(&libraries, "vumat").filter(|_| fits("vumat")) {
            let material = CompiledMaterial { call, numbers: Box::<Numbers>::default(), _keep: libraries.clone() };
            routines = routines.with_material(material);
            known = true;
        }
        if let Some(call) = find::<Vuhard>(&libraries, "vuhard").filter(|_| fits("vuhard")) {
            let name = Padded::default();
            routines = routines.with_hardening(CompiledHardening { call, name, _keep: libraries.clone() });
            known = true;
        }
        if let Some(call) = find::<Vusdfld>(&libraries, "vusdfld").filter(|_| fits("vusdfld")) {
            let (name, directions) = (Padded::default(), vec![0.0; 9 * MAX_MATERIAL_BLOCK]);
            routines = routines.with_fields(CompiledFields { call, name, directions, _keep: libraries.clone() });
            known = true;
        }
        if let Some(call) = find::<Vucharlength>(&libraries, "vucharlength").filter(|_| fits("vucharlength")) {
            let (name, directions) = (Padded::default(), vec![0.0; 9 * MAX_MATERIAL_BLOCK]);
            routines = routines.with_lengths(CompiledLengths { call, name, directions, _keep: libraries.clone() });
            known = true;
        }
        if let Some(call) = find::<Vexternaldb>(&libraries, "vexternaldb").filter(|_| fits("vexternaldb")) {
            routines = routines.with_events(CompiledEvents { call, restart: false, _keep: libraries.clone() });
            known = true;
        }
    }
    if known {
        return Ok(routines);
    }
    if let Some(misfit) = misfits.first() {
        let code = if misfit.code == "U004" { "U004" } else { "U005" };
        return Err(Diagnostic::error(code, misfit.message.clone()));
    }
    Err(nothing_to_call(&routines.strangers, given))
}

/// Says what the user's files hold where nothing of it can be called.
fn nothing_to_call(strangers: &[&str], given: &[PathBuf]) -> Diagnostic {
    let held: Vec<String> = given.iter().flat_map(|file| subroutines(file)).collect();
    let names: Vec<_> = given.iter().map(|f| format!("`{}`", f.display())).collect();
    let verb = if names.len() == 1 { "defines" } else { "define" };
    let what = if held.is_empty() { String::new() } else { format!(" but {}", held.join(", ")) };
    let none = format!("{} {verb} no routine that is called here{what}", names.join(", "));
    let finding = Diagnostic::error("U006", format!("{none}; called are {}", ROUTINES.join(", ")));
    match strangers.first() {
        Some(name) => finding.help(format!("`{name}` is a routine of ABAQUS that nothing here calls")),
        None => finding,
    }
}

/// Subroutines and functions that a source defines, a few of them.
fn subroutines(file: &Path) -> Vec<String> {
    let text = files::read(file).map(|bytes| String::from_utf8_lossy(&bytes).to_lowercase()).unwrap_or_default();
    let name = |line: &str| {
        let rest = line.trim_start().strip_prefix("subroutine ")?.trim_start();
        let name: String = rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
        (!name.is_empty()).then_some(name)
    };
    text.lines().filter_map(name).take(12).collect()
}

/// Routines of ABAQUS that nothing here calls; a file that holds one is told so.
const STRANGERS: &[&str] = &[
    "vuanisohyper_inv",
    "vuanisohyper_strain",
    "vuel",
    "vuinter",
    "vuinteraction",
    "vufield",
    "vufluidexch",
    "vuflux",
    "vdflux",
    "vfilm",
    "vfric",
    "vfriction",
    "vfric_coef",
    "vfabric",
    "vhetval",
    "vumatht",
    "vumultiscale",
    "vueos",
    "vucreepnetwork",
    "vuexpan",
    "vuhyper",
    "vuviscosity",
    "vutrs",
    "vwave",
    "vuframe",
    "vudispersion",
    "umat",
    "uhard",
    "usdfld",
    "uexternaldb",
    "dload",
    "disp",
    "uamp",
    "uel",
    "dflux",
    "film",
    "fric",
    "hetval",
    "umatht",
    "uhyper",
    "uvarm",
    "sdvini",
    "sigini",
    "orient",
    "utrac",
    "utemp",
    "creep",
    "uexpan",
];

/// One of them, by its name.
pub(super) fn stranger(name: &str) -> Option<&'static str> {
    STRANGERS.iter().copied().find(|known| *known == name)
}

fn defines(libraries: &[Library], name: &str) -> bool {
    // SAFETY: the symbol is looked at, not called.
    unsafe { find::<*const ()>(libraries, name) }.is_some()
}

/// What a library calls and nothing defines, if there is such a thing.
pub fn missing(file: &Path) -> Option<String> {
    // SAFETY: the user's library runs its initialisers here, as he asked for.
    let opened = guard::opening(|| unsafe { Library::open(Some(file), RTLD_NOW | RTLD_LOCAL) });
    // What an initialiser changes is told when it runs for the run itself.
    guard::restore(|_| {});
    let error = opened.err()?;
    let words = loaders_words(&error, file, file);
    let symbol = words.split("undefined symbol: ").nth(1)?;
    Some(symbol.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect())
}

/// The loader opens a file once; each call writes another, with SAVE and COMMON of its own: the library, and its memory.
fn open_copy(library: &Ready) -> Result<(Library, Vec<Part>), Diagnostic> {
    let file = &library.name;
    let fault = |why: String| Diagnostic::error("U005", format!("`{}` cannot be loaded: {why}", file.display()));
    let scratch = Scratch::within(&std::env::temp_dir()).map_err(|e| fault(e.to_string()))?;
    let copy = scratch.path().join("user.so");
    std::fs::write(&copy, &library.bytes).map_err(|e| fault(e.to_string()))?;
    let before = bases();
    // SAFETY: the user's library runs its initialisers here, as he asked for.
    let opened = guard::opening(|| unsafe { Library::open(Some(&copy), RTLD_NOW | RTLD_LOCAL) });
    guard::restore(|what| host::tell_of_opening(format!("an initialiser of `{}` {what}", file.display())));
    let opened = opened.map_err(|e| fault(undefined(loaders_words(&e, &copy, file))))?;
    keep_runtimes();
    Ok((opened, Part::of(&copy, file, &library.bytes, &before)))
}

/// Once they are there, the runtimes of Fortran and of its threads stay: they would go and come with every run of a sweep.
fn keep_runtimes() {
    for name in ["libgfortran.so.5", "libgfortran.so.4", "libgfortran.so.3", "libgomp.so.1"] {
        // SAFETY: nothing is loaded that is not there, so no initialiser runs.
        let kept = unsafe { Library::open(Some(name), RTLD_NOW | libc::RTLD_NOLOAD | libc::RTLD_NODELETE) };
        drop(kept);
    }
}

/// The loader's words about a symbol that is not there, in plain ones.
fn undefined(words: String) -> String {
    match words.split("undefined symbol: ").nth(1) {
        Some(symbol) => {
            let symbol: String = symbol.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
            format!("it calls `{}`, which nothing defines ({words})", symbol.trim_end_matches('_'))
        }
        None => words,
    }
}

fn loaders_words(error: &libloading::Error, copy: &Path, file: &Path) -> String {
    let mut words = error.to_string();
    let mut cause: Option<&dyn std::error::Error> = std::error::Error::source(error);
    while let Some(inner) = cause {
        words = format!("{words}: {inner}");
        cause = inner.source();
    }
    words.replace(&*copy.display().to_string(), &file.display().to_string())
}

/// The routine of this name, as Fortran or as plain C spells it.
///
/// # Safety
/// `T` must be the type of the function that has the name.
unsafe fn find<T: Copy>(libraries: &[Library], name: &str) -> Option<T> {
    let spellings = [format!("{name}_"), name.to_owned(), format!("{}_", name.to_uppercase()), name.to_uppercase()];
    libraries.iter().find_map(|library| {
        // SAFETY: as this function's own.
        spellings.iter().find_map(|s| unsafe { library.get::<T>(s.as_bytes()) }.ok().map(|symbol| *symbol))
    })
}

// ---------------------------------------------------------------------------------------------- names with a guard

/// `FE_INVALID` of `fenv.h` on x86-64 and aarch64.
const FE_INVALID: c_int = 1;

unsafe extern "C" {
    fn feclearexcept(exceptions: c_int) -> c_int;
    fn fetestexcept(exceptions: c_int) -> c_int;
}

/// Length of a name in the subroutines' arguments.
const NAME: usize = 80;
/// Bytes behind it that a routine must leave alone: declared `character*256`, a name reaches that far.
const BEHIND: usize = 512 - NAME;

/// The part of that which is looked at after each call.
const WATCHED: usize = 128;

/// A name padded with blanks, and behind it bytes that betray a routine which writes too far.
struct Padded {
    bytes: [u8; NAME + BEHIND],
    given: [u8; WATCHED],
    text: String,
}

impl Default for Padded {
    fn default() -> Self {
        Padded { bytes: [b' '; NAME + BEHIND], given: [b' '; WATCHED], text: String::new() }
    }
}

impl Padded {
    fn set(&mut self, text: &str) -> *const c_char {
        if self.text != text {
            self.text = text.to_owned();
            self.bytes = pad(text);
            self.given = pad(text);
        }
        self.bytes.as_ptr().cast()
    }

    /// Whether it is as it was given; put right if not.
    fn untouched(&mut self) -> bool {
        let same = self.bytes[..WATCHED] == self.given && self.bytes[NAME + BEHIND - 1] == b' ';
        if !same {
            self.bytes = pad(&self.text);
        }
        same
    }
}

fn pad<const N: usize>(text: &str) -> [u8; N] {
    let mut bytes = [b' '; N];
    let length = text.len().min(NAME);
    bytes[..length].copy_from_slice(&text.as_bytes()[..length]);
    bytes
}

// ------------------------------------------------------------------------------------------------------- the door

/// What the routine threw to end the analysis.
struct Ended(String);

/// Calls into the library; a routine that ends the process comes back as a failure.
#[inline]
fn enter(call: &Call<'_>, body: impl FnOnce()) -> Result<(), LoadFailure> {
    CALLED.store(true, Ordering::Relaxed);
    call.begin();
    let returned = catch_unwind(AssertUnwindSafe(body));
    guard::restore(|what| host::tell(Level::Warning, format!("{} {what}", call.routine)));
    call::end();
    returned.map_err(|payload| ended(call, payload))
}

#[cold]
fn ended(call: &Call<'_>, payload: Box<dyn Any + Send>) -> LoadFailure {
    match payload.downcast::<Ended>() {
        Ok(ended) => LoadFailure::new(format!("{} ended the analysis: {}", call.routine, ended.0)),
        Err(other) => resume_unwind(other),
    }
}

fn end(why: String) -> ! {
    if !call::inside() {
        // Not inside a routine that was called from here: nobody could catch it.
        eprintln!("error: {why}");
        std::process::exit(1);
    }
    resume_unwind(Box::new(Ended(why)))
}

struct CompiledLoad {
    call: Vdload,
    name: Padded,
    watch_invalid: bool,
    _keep: Arc<[Library]>,
}

impl UserLoad for CompiledLoad {
    fn pressure(&mut self, points: &LoadPoints<'_>, pressure: &mut [f64]) -> Result<(), LoadFailure> {
        let (count, dimensions) = (points.r.len() as i32, 2_i32);
        // An element load has no surface name.
        let name = self.name.set(if points.load_type == 0 { points.surface } else { "" });
        let call = Call::new("vdload", points.surface, points.now);
        if self.watch_invalid {
            // SAFETY: changes a flag of this thread alone.
            unsafe { feclearexcept(FE_INVALID) };
        }
        enter(&call, || {
            // SAFETY: each slice holds what the manual says the routine reads; names and values have room behind.
            unsafe {
                (self.call)(
                    &count,
                    &dimensions,
                    &points.now.step_time,
                    &points.now.total_time,
                    &points.amplitude,
                    points.coordinates.as_ptr(),
                    points.motion.as_ptr(),
                    points.directions.as_ptr(),
                    &points.load_type,
                    name,
                    pressure.as_mut_ptr(),
                    NAME,
                );
            }
        })?;
        // SAFETY: reads a flag of this thread.
        if self.watch_invalid && unsafe { fetestexcept(FE_INVALID) } != 0 {
            let reason = "vdload computed with a number that is none (NaN), and its source reads a third coordinate: \
                          curCoords and velocity have two, r and z";
            return Err(LoadFailure::new(reason));
        }
        guarded(self.name.untouched(), "vdload", "sname")
    }

    fn reads_motion(&self) -> bool {
        true
    }
}

fn guarded(untouched: bool, routine: &str, argument: &str) -> Result<(), LoadFailure> {
    if untouched {
        return Ok(());
    }
    Err(LoadFailure::new(format!("{routine} wrote into its argument {argument}, which it may only read")))
}

struct CompiledAmplitude {
    call: Vuamp,
    _keep: Arc<[Library]>,
}

impl UserAmplitude for CompiledAmplitude {
    fn amplitude(&mut self, call: &mut AmplitudeCall<'_>) -> Result<AmplitudeAnswer, LoadFailure> {
        let name = pad::<{ NAME + BEHIND }>(call.name);
        let time = [call.now.step_time, call.now.total_time];
        let counts = [call.properties.len(), call.variables.len(), call.sensor_names.len()].map(|n| n as i32);
        let first = i32::from(call.now.increment == 0);
        let info = [first, 1 - i32::from(call.begins), call.now.step as i32];
        let sensors: Vec<u8> = call.sensor_names.iter().flat_map(|n| pad::<NAME>(n)).chain([b' '; NAME]).collect();
        let table = [0_i32; 4];
        let mut define = [0_i32; 8];
        let (mut value, mut derivative, mut second, mut integral) = (f64::NAN, 0.0, 0.0, 0.0);
        let context =
            Call { sensors: (call.sensor_names, call.sensor_values), ..Call::new("vuamp", call.name, call.now) };
        enter(&context, || {
            // SAFETY: each argument has the length that the counts before it say.
            unsafe {
                (self.call)(
                    name.as_ptr().cast(),
                    time.as_ptr(),
                    &call.old,
                    &call.increment,
                    &counts[0],
                    call.properties.as_ptr(),
                    &counts[1],
                    call.variables.as_mut_ptr(),
                    info.as_ptr(),
                    &counts[2],
                    call.sensor_values.as_ptr(),
                    sensors.as_ptr().cast(),
                    table.as_ptr(),
                    &mut value,
                    define.as_mut_ptr(),
                    &mut derivative,
                    &mut second,
                    &mut integral,
                    NAME,
                    NAME,
                );
            }
        })?;
        guarded(name == pad(call.name), "vuamp", "ampName")?;
        Ok(AmplitudeAnswer {
            value,
            derivative: (define[0] == 1).then_some(derivative),
            stop: define[3] == 1,
            conclude_step: define[4] == 1,
        })
    }
}

struct CompiledMotion {
    call: Vdisp,
    name: Padded,
    _keep: Arc<[Library]>,
}

/// Degrees of freedom of a node in an axisymmetric model: r, z, rotation.
const DOFS: usize = 3;

impl UserMotion for CompiledMotion {
    fn motion(&mut self, call: &MotionCall<'_>) -> Result<f64, LoadFailure> {
        let name = self.name.set(call.set);
        let (one, dofs, coordinates) = (1_i32, DOFS as i32, 2_i32);
        let (step, increment) = (call.now.step as i32, i32::try_from(call.now.increment).unwrap_or(i32::MAX));
        // jDof is above zero for what this call prescribes.
        let mut asked = [0_i32; DOFS];
        asked[call.dof - 1] = 1;
        let vector = |i: usize| {
            let (along, across) = (call.state[i], call.across[i]);
            if call.dof == 1 { [along, across, 0.0] } else { [across, along, 0.0] }
        };
        let [u, v, a, rf] = [0, 1, 2, 3].map(vector);
        let rotary = [0.0; 9];
        let mut values = [f64::NAN; DOFS];
        let context = Call::new("vdisp", call.set, call.now);
        enter(&context, || {
            // SAFETY: one node, three degrees of freedom, two coordinates; every array is of that size.
            unsafe {
                (self.call)(
                    &one,
                    &dofs,
                    &coordinates,
                    &step,
                    &increment,
                    &call.now.step_time,
                    &call.now.total_time,
                    &call.increments[1],
                    &call.increments[0],
                    name,
                    &call.kind,
                    asked.as_ptr(),
                    &call.node,
                    &call.amplitude,
                    call.coordinates.as_ptr(),
                    u.as_ptr(),
                    v.as_ptr(),
                    a.as_ptr(),
                    rf.as_ptr(),
                    &call.mass,
                    rotary.as_ptr(),
                    values.as_mut_ptr(),
                    NAME,
                );
            }
        })?;
        guarded(self.name.untouched(), "vdisp", "cbname")?;
        Ok(values[call.dof - 1])
    }
}

struct CompiledMaterial {
    call: Vumat,
    numbers: Box<Numbers>,
    _keep: Arc<[Library]>,
}

/// What a VUMAT is told in numbers of a block. ABAQUS passes arrays where older routines declare one number: `jblock` begins
/// with nblock, `jInfoArray` with lanneal, `dtArray` with dt (ABAQUS User Subroutines Reference, "VUMAT", "Variables passed in
/// for information").
struct Numbers {
    name: Padded,
    /// nblock, integration point, layer, section point, user's numbers of the elements.
    block: [i32; 4 + MAX_MATERIAL_BLOCK],
    /// Anneal flag, integration point, layer, section point, whether moduli are asked for, where the numbers of the elements
    /// begin; then they.
    info: [i32; 6 + MAX_MATERIAL_BLOCK],
    /// Length of the increment; room for moduli that nobody asks for.
    dt: [f64; 1 + 2 * MAX_MATERIAL_BLOCK],
}

impl Default for Box<Numbers> {
    fn default() -> Self {
        let (mut block, mut info) = ([0; 4 + MAX_MATERIAL_BLOCK], [0; 6 + MAX_MATERIAL_BLOCK]);
        block[1..4].fill(1);
        info[..6].copy_from_slice(&[0, 1, 1, 1, 0, 7]);
        Box::new(Numbers { name: Padded::default(), block, info, dt: [0.0; 1 + 2 * MAX_MATERIAL_BLOCK] })
    }
}

impl UserMaterial for CompiledMaterial {
    fn stress(&mut self, call: &MaterialCall<'_>, answer: &mut MaterialAnswer<'_>) -> Result<(), LoadFailure> {
        let Numbers { name, block, info, dt } = &mut *self.numbers;
        let name_given = name.set(call.name);
        let [variables, fields, properties] = [call.variables, call.fields, call.properties.len()].map(|n| n as i32);
        let (direct, shear) = (3_i32, 1_i32);
        block[0] = call.count as i32;
        block[4..4 + call.count].copy_from_slice(call.elements);
        info[6..6 + call.count].copy_from_slice(call.elements);
        dt[0] = call.dt;
        let context = Call::new("vumat", call.name, call.now).at(call.elements);
        enter(&context, || {
            // SAFETY: each argument has the length that the counts before it say.
            unsafe {
                (self.call)(
                    block.as_ptr(),
                    &direct,
                    &shear,
                    &variables,
                    &fields,
                    &properties,
                    info.as_ptr(),
                    &call.now.step_time,
                    &call.now.total_time,
                    dt.as_ptr(),
                    name_given,
                    call.coordinates.as_ptr(),
                    call.length.as_ptr(),
                    call.properties.as_ptr(),
                    call.density.as_ptr(),
                    call.strain.as_ptr(),
                    call.spin.as_ptr(),
                    call.temperature[0].as_ptr(),
                    call.stretch[0].as_ptr(),
                    call.gradient[0].as_ptr(),
                    call.field[0].as_ptr(),
                    call.stress.as_ptr(),
                    call.state.as_ptr(),
                    call.internal.as_ptr(),
                    call.inelastic.as_ptr(),
                    call.temperature[1].as_ptr(),
                    call.stretch[1].as_ptr(),
                    call.gradient[1].as_ptr(),
                    call.field[1].as_ptr(),
                    answer.stress.as_mut_ptr(),
                    answer.state.as_mut_ptr(),
                    answer.internal.as_mut_ptr(),
                    answer.inelastic.as_mut_ptr(),
                    NAME,
                );
            }
        })?;
        guarded(name.untouched(), "vumat", "cmname")
    }
}

struct CompiledHardening {
    call: Vuhard,
    name: Padded,
    _keep: Arc<[Library]>,
}

impl UserHardening for CompiledHardening {
    fn yield_stress(&mut self, call: &HardeningCall<'_>, answer: &mut HardeningAnswer<'_>) -> Result<(), LoadFailure> {
        let name = self.name.set(call.name);
        let [count, variables, fields, properties] =
            [call.count, call.variables, call.fields, call.properties.len()].map(|n| n as i32);
        let (one, anneal) = (1_i32, 0_i32);
        let context = Call::new("vuhard", call.name, call.now).at(call.elements);
        enter(&context, || {
            // SAFETY: each argument has the length that the counts before it say.
            unsafe {
                (self.call)(
                    &count,
                    call.elements.as_ptr(),
                    &one,
                    &one,
                    &one,
                    &anneal,
                    &call.now.step_time,
                    &call.now.total_time,
                    &call.dt,
                    name,
                    &variables,
                    &fields,
                    &properties,
                    call.properties.as_ptr(),
                    call.temperature[0].as_ptr(),
                    call.temperature[1].as_ptr(),
                    call.field[0].as_ptr(),
                    call.field[1].as_ptr(),
                    call.state.as_ptr(),
                    call.strain.as_ptr(),
                    call.rate.as_ptr(),
                    answer.stress.as_mut_ptr(),
                    answer.by_temperature.as_mut_ptr(),
                    answer.slopes.as_mut_ptr(),
                    answer.state.as_mut_ptr(),
                    NAME,
                );
            }
        })?;
        guarded(self.name.untouched(), "vuhard", "cmname")
    }
}

struct CompiledFields {
    call: Vusdfld,
    name: Padded,
    /// `direct` and `T`: the axes of the material are those of the model.
    directions: Vec<f64>,
    _keep: Arc<[Library]>,
}

impl UserFields for CompiledFields {
    fn fields(&mut self, call: &FieldCall<'_>, answer: &mut FieldAnswer<'_>) -> Result<(), LoadFailure> {
        let name = self.name.set(call.name);
        let [count, variables, fields, properties] =
            [call.count, call.variables, call.fields, call.properties.len()].map(|n| n as i32);
        let (direct, shear, one) = (3_i32, 1_i32, 1_i32);
        set_identities(&mut self.directions, call.count);
        let points = Some((call.count, call.values));
        let context = Call { points, ..Call::new("vusdfld", call.name, call.now).at(call.elements) };
        enter(&context, || {
            // SAFETY: each argument has the length that the counts before it say.
            unsafe {
                (self.call)(
                    &count,
                    &variables,
                    &fields,
                    &properties,
                    &direct,
                    &shear,
                    call.elements.as_ptr(),
                    &one,
                    &one,
                    &one,
                    &call.now.step_time,
                    &call.now.total_time,
                    &call.dt,
                    name,
                    call.coordinates.as_ptr(),
                    self.directions.as_ptr(),
                    self.directions.as_ptr(),
                    call.length.as_ptr(),
                    call.properties.as_ptr(),
                    call.state.as_ptr(),
                    answer.state.as_mut_ptr(),
                    answer.field.as_mut_ptr(),
                    NAME,
                );
            }
        })?;
        guarded(self.name.untouched(), "vusdfld", "cmname")
    }
}

/// Identities of so many points, components one after the other.
fn set_identities(directions: &mut [f64], count: usize) {
    for (slab, list) in directions.chunks_mut(count).take(9).enumerate() {
        list.fill(if slab % 4 == 0 { 1.0 } else { 0.0 });
    }
}

struct CompiledLengths {
    call: Vucharlength,
    name: Padded,
    /// `direct` and `T`: the axes of the material are those of the model.
    directions: Vec<f64>,
    _keep: Arc<[Library]>,
}

impl UserLengths for CompiledLengths {
    fn lengths(&mut self, call: &LengthCall<'_>, lengths: &mut [f64]) -> Result<(), LoadFailure> {
        let name = self.name.set(call.name);
        let [count, fields, properties, corners, variables] =
            [call.count, call.fields, call.properties.len(), call.corners, call.variables].map(|n| n as i32);
        let (one, dimensions) = (1_i32, 2_i32);
        // The shape: 2 is a triangle, 3 a quadrilateral.
        let kind = [corners - 1, 0, 0];
        set_identities(&mut self.directions, call.count);
        enter(&Call::new("vucharlength", call.name, call.now).at(call.elements), || {
            // SAFETY: each argument has the length that the counts before it say.
            unsafe {
                (self.call)(
                    &count,
                    &fields,
                    &properties,
                    &one,
                    &dimensions,
                    &corners,
                    &variables,
                    &one,
                    &one,
                    &one,
                    kind.as_ptr(),
                    call.elements.as_ptr(),
                    &call.now.total_time,
                    &call.now.step_time,
                    &call.dt,
                    name,
                    call.coordinates.as_ptr(),
                    call.nodes.as_ptr(),
                    self.directions.as_ptr(),
                    self.directions.as_ptr(),
                    call.properties.as_ptr(),
                    call.field.as_ptr(),
                    call.state.as_ptr(),
                    lengths.as_mut_ptr(),
                    NAME,
                );
            }
        })?;
        guarded(self.name.untouched(), "vucharlength", "cmname")
    }
}

struct CompiledEvents {
    call: Vexternaldb,
    /// Whether the state of the increment that ends will be kept.
    restart: bool,
    _keep: Arc<[Library]>,
}

impl UserEvents for CompiledEvents {
    fn moment(&mut self, moment: Moment, now: &Instant, increment: f64) -> Result<Wish, LoadFailure> {
        let operation = moment as i32;
        let (nodes, elements) = host::with_job(|j| (j.nodes.len() as i32, j.elements.len() as i32));
        let count = i32::try_from(now.increment).unwrap_or(i32::MAX);
        // i_int_nTotalNodes, nTotalElements, kStep, kInc, iStatus, lWriteRestart; room for a routine that reads further.
        let mut integers = [nodes, elements, now.step as i32, count, 0, i32::from(self.restart), 0, 0];
        self.restart = false;
        let mut reals = [now.total_time, now.step_time, increment, 0.0];
        let (integer_count, real_count) = (6_i32, 3_i32);
        let call = Call::new("vexternaldb", "", *now);
        enter(&call, || {
            // SAFETY: both arrays are longer than the counts say.
            unsafe { (self.call)(&operation, integers.as_mut_ptr(), &integer_count, reals.as_mut_ptr(), &real_count) }
        })?;
        Ok(match integers[4] {
            1 => Wish::EndStep,
            2 => Wish::EndAnalysis,
            _ => Wish::Continue,
        })
    }

    fn restart_follows(&mut self) {
        self.restart = true;
    }
}

// ------------------------------------------------------------------------------- when the process itself is at stake

/// Once in the process: a routine that calls the system's `exit`, or hurts memory, shall leave words behind.
fn watch_the_process() {
    static WATCH: Once = Once::new();
    WATCH.call_once(|| {
        guard::watch();
        // SAFETY: the handlers only read a thread's own pointer and write to standard error.
        unsafe {
            libc::atexit(at_exit);
            for signal in [libc::SIGSEGV, libc::SIGBUS, libc::SIGFPE, libc::SIGILL, libc::SIGABRT] {
                let mut action: libc::sigaction = std::mem::zeroed();
                action.sa_sigaction = on_signal as *const () as usize;
                action.sa_flags = libc::SA_ONSTACK | libc::SA_RESETHAND | libc::SA_NODEFER;
                libc::sigaction(signal, &action, std::ptr::null_mut());
            }
        }
    });
}

/// Whether a routine has been called: an array that it wrote past is noticed when its memory is given back, after the call.
static CALLED: AtomicBool = AtomicBool::new(false);

/// What is said of that.
const DAMAGED: &[u8] =
    b"error: the memory of the process is damaged, most likely by a user's routine that wrote past an array \
of its own; --check-user finds indices out of bounds\n";

/// Whether a routine may have hurt memory: what happens from now on is its doing.
static HURT: AtomicBool = AtomicBool::new(false);

/// Leaves the process at once after a routine halted the run: it may have hurt memory that others would still tidy up. What
/// Fortran keeps of its output comes first.
pub fn leave(status: u8) -> ! {
    HURT.store(true, Ordering::Relaxed);
    let _ = std::io::Write::flush(&mut std::io::stdout());
    guard::flush();
    // SAFETY: leaves; what is not tidied up is of no use to anybody.
    unsafe { guard::end(status.into()) }
}

extern "C" fn at_exit() {
    // A child that a routine made may end as it likes.
    if guard::is_own_process() && last_words("ended the process") {
        // SAFETY: leaves without running what the routine interrupted.
        unsafe { guard::end(1) }
    }
}

extern "C" fn on_signal(signal: c_int) {
    let what = match signal {
        libc::SIGSEGV | libc::SIGBUS => "touched memory that is not its own (an array index out of bounds?)",
        libc::SIGFPE => "divided an integer by zero",
        libc::SIGABRT => "aborted",
        _ => "ran into an illegal instruction",
    };
    // SAFETY: both calls are safe in a signal handler; the action is the default one again.
    unsafe {
        if last_words(what) || HURT.load(Ordering::Relaxed) {
            guard::end(1);
        }
        if CALLED.load(Ordering::Relaxed) {
            libc::write(2, DAMAGED.as_ptr().cast(), DAMAGED.len());
            guard::end(1);
        }
        libc::raise(signal);
    }
}

// ------------------------------------------------------------------------------------ host routines for the library

/// Names the dynamic linker finds: the routine's calls end here. A jump in assembly, because the symbol of a Rust function
/// is nobody's business after link-time optimisation.
#[cfg(target_arch = "x86_64")]
macro_rules! jump {
    () => {
        "jmp {f}"
    };
}
#[cfg(target_arch = "aarch64")]
macro_rules! jump {
    () => {
        "b {f}"
    };
}
macro_rules! symbols {
    ($($name:literal => $function:path),+ $(,)?) => {
        $(core::arch::global_asm!(
            concat!(".globl ", $name),
            concat!(".type ", $name, ",@function"),
            concat!($name, ":"),
            ".cfi_startproc",
            jump!(),
            ".cfi_endproc",
            concat!(".size ", $name, ", .-", $name),
            f = sym $function,
        );)+
    };
}

/// The same in a shared library, which shows what Rust functions are called and hides all other symbols.
#[cfg(feature = "shared")]
macro_rules! host_symbols {
    ($($name:literal => $function:path),+ $(,)?) => {
        $(const _: () = {
            #[unsafe(naked)]
            #[unsafe(export_name = $name)]
            extern "C" fn forward() {
                core::arch::naked_asm!(jump!(), f = sym $function)
            }
        };)+
    };
}
#[cfg(not(feature = "shared"))]
macro_rules! host_symbols {
    ($($name:literal => $function:path),+ $(,)?) => {
        symbols! { $($name => $function),+ }
    };
}

symbols! {
    "chdir" => guard::chdir,
    "fchdir" => guard::fchdir,
    "sigaction" => guard::sigaction,
    "signal" => guard::signal,
    "bsd_signal" => guard::signal,
    "sysv_signal" => guard::sysv_signal,
    "__sysv_signal" => guard::sysv_signal,
    "pthread_create" => guard::pthread_create,
    "_exit" => guard::leave,
    "_Exit" => guard::leave,
}

host_symbols! {
    "xplb_exit_" => xplb_exit,
    "xplb_abqerr_" => xplb_abqerr,
    "vgetjobname_" => vgetjobname,
    "vgetoutdir_" => vgetoutdir,
    "vgetnumcpus_" => vgetnumcpus,
    "vgetrank_" => vgetrank,
    "vgetinternal_" => vgetinternal,
    "vgetpartinfo_" => vgetpartinfo,
    "vgetvrm_" => vgetvrm,
    "vsprinc_" => vsprinc,
    "vsprind_" => vsprind,
    "ivgetsensorid_" => sensor_id,
    "igetsensorid_" => sensor_id,
    "vgetsensorvalue_" => sensor_value,
    "getsensorvalue_" => sensor_value,
    "stdb_abqerr_" => xplb_abqerr,
    "xit_" => xit,
    "rvmissing_" => missing_symbol,
    "getjobname_" => vgetjobname,
    "getoutdir_" => vgetoutdir,
    "getnumcpus_" => vgetnumcpus,
    "getrank_" => vgetrank,
    "getnumthreads_" => one,
    "get_thread_id_" => zero,
    "getcommunicator_" => zero,
    "mutexinit_" => nothing,
    "mutexlock_" => nothing,
    "mutexunlock_" => nothing,
    "mutexdestroy_" => nothing,
    "rvsma0n_" => array_of::<0>,
    "rvsma1n_" => array_of::<1>,
    "rvsma2n_" => array_of::<2>,
    "rvsma3n_" => array_of::<3>,
    "rvsma4n_" => array_of::<4>,
    "rvsma5n_" => array_of::<5>,
    "rvsma0i_" => integers_of::<0>,
    "rvsma1i_" => integers_of::<1>,
    "smaintarraycreate_" => integers_of::<0>,
    "smalocalintarraycreate_" => integers_of::<1>,
    "rvsma2r_" => reals_from_single::<2>,
    "rvsma3r_" => reals_from_single::<3>,
    "rvsma4r_" => reals_from_single::<4>,
    "rvsma5r_" => reals_from_single::<5>,
    "rvsma2d_" => reals_of::<2>,
    "rvsma3d_" => reals_of::<3>,
    "rvsma4d_" => reals_of::<4>,
    "rvsma5d_" => reals_of::<5>,
    "rvsma2e_" => reals_of::<2>,
    "rvsma3e_" => reals_of::<3>,
    "rvsma4e_" => reals_of::<4>,
    "rvsma5e_" => reals_of::<5>,
    "smafloatarraycreate_" => reals_of::<2>,
    "smalocalfloatarraycreate_" => reals_of::<3>,
    "smarealarraycreate_" => reals_of::<4>,
    "smalocalrealarraycreate_" => reals_of::<5>,
    "smafloatarraycreatedp_" => reals_of::<2>,
    "smarealarraycreatedp_" => reals_of::<4>,
    "rvsma2s_" => singles_of::<2>,
    "rvsma3s_" => singles_of::<3>,
    "rvsma4s_" => singles_of::<4>,
    "rvsma5s_" => singles_of::<5>,
    "smafloatarraycreatesp_" => singles_of::<2>,
    "smarealarraycreatesp_" => singles_of::<4>,
    "smaintarrayaccess_" => access::<0>,
    "smalocalintarrayaccess_" => access::<1>,
    "smafloatarrayaccess_" => access::<2>,
    "smalocalfloatarrayaccess_" => access::<3>,
    "smarealarrayaccess_" => access::<4>,
    "smalocalrealarrayaccess_" => access::<5>,
    "smaintarraysize_" => size::<0>,
    "smalocalintarraysize_" => size::<1>,
    "smafloatarraysize_" => size::<2>,
    "smalocalfloatarraysize_" => size::<3>,
    "smarealarraysize_" => size::<4>,
    "smalocalrealarraysize_" => size::<5>,
    "smaintarraydelete_" => delete::<0>,
    "smalocalintarraydelete_" => delete::<1>,
    "smafloatarraydelete_" => delete::<2>,
    "smalocalfloatarraydelete_" => delete::<3>,
    "smarealarraydelete_" => delete::<4>,
    "smalocalrealarraydelete_" => delete::<5>,
    "mpi_init_" => mpi_done,
    "mpi_finalize_" => mpi_done,
    "mpi_barrier_" => mpi_barrier,
    "mpi_initialized_" => mpi_initialized,
    "mpi_comm_rank_" => mpi_rank,
    "mpi_comm_size_" => mpi_size,
    "mpi_bcast_" => mpi_bcast,
    "mpi_allreduce_" => mpi_allreduce,
    "mpi_reduce_" => mpi_reduce,
    "mpi_allgather_" => mpi_allgather,
    "mpi_gather_" => mpi_gather,
    "mpi_abort_" => xit,
    "mpi_wtime_" => mpi_wtime,
    "_gfortran_stop_string" => stop_string,
    "_gfortran_error_stop_string" => error_stop_string,
    "_gfortran_stop_numeric" => stop_numeric,
    "_gfortran_error_stop_numeric" => error_stop_numeric,
    "_gfortran_exit_i4" => exit_i4,
    "_gfortran_exit_i8" => exit_i8,
    "_gfortran_abort" => fortran_abort,
    "_gfortran_runtime_error" => runtime_error,
    "_gfortran_runtime_error_at" => runtime_error_at,
    "_gfortran_os_error_at" => runtime_error_at,
}

/// Fortran text of a length, without the blanks behind.
///
/// # Safety
/// `text` is null or holds `length` bytes.
unsafe fn words(text: *const c_char, length: usize) -> String {
    if text.is_null() {
        return String::new();
    }
    // SAFETY: as this function's own.
    let bytes = unsafe { std::slice::from_raw_parts(text.cast::<u8>(), length) };
    String::from_utf8_lossy(bytes).trim_end_matches([' ', '\0']).to_owned()
}

/// Writes text into a Fortran variable, with blanks behind, and its length beside.
///
/// # Safety
/// `to` holds `room` bytes; `length` is null or holds an integer.
unsafe fn give(text: &str, to: *mut c_char, length: *mut i32, room: usize) {
    let count = text.len().min(room);
    // SAFETY: as this function's own.
    unsafe {
        let bytes = std::slice::from_raw_parts_mut(to.cast::<u8>(), room);
        bytes.fill(b' ');
        bytes[..count].copy_from_slice(&text.as_bytes()[..count]);
        if !length.is_null() {
            *length = count as i32;
        }
    }
}

/// `call xplb_exit`: ends the analysis (ABAQUS User Subroutines Reference, 2.1.15 "Terminating an analysis").
extern "C-unwind" fn xplb_exit() -> ! {
    end("it called xplb_exit".into())
}

/// `call xit`, as in ABAQUS/Standard.
extern "C-unwind" fn xit() -> ! {
    end("it called xit".into())
}

/// What stands for a routine that nothing defines.
unsafe extern "C-unwind" fn missing_symbol(name: *const c_char, length: usize) -> ! {
    // SAFETY: text of the length given.
    end(format!("it calls `{}`, which nothing defines", unsafe { words(name, length) }))
}

/// Number of threads.
extern "C-unwind" fn one() -> i32 {
    1
}

/// Number of the thread, and of the communicator.
extern "C-unwind" fn zero() -> i32 {
    0
}

/// Locks: one thread calls all routines.
extern "C-unwind" fn nothing() {}

/// Arrays that outlive a call (ABAQUS 6.14 User Subroutines Reference, 2.1.23 "Allocatable arrays"), of zeros.
unsafe extern "C-unwind" fn array_of<const KIND: u8>(id: *const i32, count: *const i32) -> i64 {
    // SAFETY: integers of the caller.
    let (id, count) = unsafe { (*id, *count) };
    let width = if KIND < 2 { 4 } else { 8 };
    host::new_array((KIND, id), count, width, &[0; 8][..width]) as i64
}

/// The same of integers.
unsafe extern "C-unwind" fn integers_of<const KIND: u8>(id: *const i32, count: *const i32, value: *const i32) -> i64 {
    // SAFETY: integers of the caller.
    let (id, count, value) = unsafe { (*id, *count, *value) };
    host::new_array((KIND, id), count, 4, &value.to_ne_bytes()) as i64
}

/// The same of reals of eight bytes.
unsafe extern "C-unwind" fn reals_of<const KIND: u8>(id: *const i32, count: *const i32, value: *const f64) -> i64 {
    // SAFETY: integers and a real of the caller.
    let (id, count, value) = unsafe { (*id, *count, *value) };
    host::new_array((KIND, id), count, 8, &value.to_ne_bytes()) as i64
}

/// The same, their first value of four.
unsafe extern "C-unwind" fn reals_from_single<const KIND: u8>(
    id: *const i32,
    count: *const i32,
    value: *const f32,
) -> i64 {
    // SAFETY: integers and a real of the caller.
    let (id, count, value) = unsafe { (*id, *count, f64::from(*value)) };
    host::new_array((KIND, id), count, 8, &value.to_ne_bytes()) as i64
}

/// The same of reals of four bytes.
unsafe extern "C-unwind" fn singles_of<const KIND: u8>(id: *const i32, count: *const i32, value: *const f32) -> i64 {
    // SAFETY: integers and a real of the caller.
    let (id, count, value) = unsafe { (*id, *count, *value) };
    host::new_array((KIND, id), count, 4, &value.to_ne_bytes()) as i64
}

/// Where an array is; a routine that asks for one that nobody made ends the analysis.
unsafe extern "C-unwind" fn access<const KIND: u8>(id: *const i32) -> i64 {
    // SAFETY: an integer of the caller.
    let id = unsafe { *id };
    match host::array((KIND, id)) {
        Some((place, _)) => place as i64,
        None => end(format!("it asked for the array {id}, which nobody has created")),
    }
}

/// How many entries an array has; 0 if it is not there.
unsafe extern "C-unwind" fn size<const KIND: u8>(id: *const i32) -> i32 {
    // SAFETY: an integer of the caller.
    host::array((KIND, unsafe { *id })).map_or(0, |array| array.1)
}

unsafe extern "C-unwind" fn delete<const KIND: u8>(id: *const i32) {
    // SAFETY: an integer of the caller.
    host::delete_array((KIND, unsafe { *id }));
}

/// `call mpi_init(ierr)`, `call mpi_finalize(ierr)`: one process, the first.
unsafe extern "C-unwind" fn mpi_done(error: *mut i32) {
    // SAFETY: an integer of the caller.
    unsafe { *error = 0 }
}

unsafe extern "C-unwind" fn mpi_barrier(_world: *const i32, error: *mut i32) {
    // SAFETY: an integer of the caller.
    unsafe { *error = 0 }
}

unsafe extern "C-unwind" fn mpi_initialized(flag: *mut i32, error: *mut i32) {
    // SAFETY: a logical and an integer of the caller.
    unsafe { (*flag, *error) = (1, 0) }
}

unsafe extern "C-unwind" fn mpi_rank(_world: *const i32, rank: *mut i32, error: *mut i32) {
    // SAFETY: integers of the caller.
    unsafe { (*rank, *error) = (0, 0) }
}

unsafe extern "C-unwind" fn mpi_size(_world: *const i32, size: *mut i32, error: *mut i32) {
    // SAFETY: integers of the caller.
    unsafe { (*size, *error) = (1, 0) }
}

unsafe extern "C-unwind" fn mpi_bcast(
    _buffer: *mut u8,
    _count: *const i32,
    _kind: *const i32,
    _root: *const i32,
    _world: *const i32,
    error: *mut i32,
) {
    // SAFETY: an integer of the caller.
    unsafe { *error = 0 }
}

/// Copies so many values of a type, whose last two digits are its bytes.
///
/// # Safety
/// Both places hold as much.
unsafe fn copy(from: *const u8, to: *mut u8, count: i32, kind: i32) {
    let bytes = usize::try_from(count).unwrap_or(0) * (kind % 100) as usize;
    // SAFETY: as this function's own; the places may be one.
    unsafe { std::ptr::copy(from, to, bytes) }
}

/// What every exchange among the processes comes to where there is one: its own values, and no error.
///
/// # Safety
/// Both places hold so many values of the type; the other pointers are to integers.
unsafe fn pass(from: *const u8, to: *mut u8, count: *const i32, kind: *const i32, error: *mut i32) {
    // SAFETY: as this function's own.
    unsafe {
        copy(from, to, *count, *kind);
        *error = 0;
    }
}

/// Any reduction over one process is its own value.
unsafe extern "C-unwind" fn mpi_allreduce(
    from: *const u8,
    to: *mut u8,
    count: *const i32,
    kind: *const i32,
    _operation: *const i32,
    _world: *const i32,
    error: *mut i32,
) {
    // SAFETY: both places of the caller hold so many values.
    unsafe { pass(from, to, count, kind, error) }
}

#[allow(clippy::too_many_arguments)] // As MPI has them.
unsafe extern "C-unwind" fn mpi_reduce(
    from: *const u8,
    to: *mut u8,
    count: *const i32,
    kind: *const i32,
    _operation: *const i32,
    _root: *const i32,
    _world: *const i32,
    error: *mut i32,
) {
    // SAFETY: both places of the caller hold so many values.
    unsafe { pass(from, to, count, kind, error) }
}

unsafe extern "C-unwind" fn mpi_allgather(
    from: *const u8,
    count: *const i32,
    kind: *const i32,
    to: *mut u8,
    _to_count: *const i32,
    _to_kind: *const i32,
    _world: *const i32,
    error: *mut i32,
) {
    // SAFETY: both places of the caller hold so many values.
    unsafe { pass(from, to, count, kind, error) }
}

#[allow(clippy::too_many_arguments)] // As MPI has them.
unsafe extern "C-unwind" fn mpi_gather(
    from: *const u8,
    count: *const i32,
    kind: *const i32,
    to: *mut u8,
    _to_count: *const i32,
    _to_kind: *const i32,
    _root: *const i32,
    _world: *const i32,
    error: *mut i32,
) {
    // SAFETY: both places of the caller hold so many values.
    unsafe { pass(from, to, count, kind, error) }
}

extern "C-unwind" fn mpi_wtime() -> f64 {
    std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).map_or(0.0, |since| since.as_secs_f64())
}

/// `call xplb_abqerr(lop, string, intv, realv, charv)` (ABAQUS User Subroutines Reference, "Printing messages to the
/// message or status file").
unsafe extern "C-unwind" fn xplb_abqerr(
    lop: *const i32,
    text: *const c_char,
    integers: *const i32,
    reals: *const f64,
    strings: *const c_char,
    text_length: usize,
    _string_length: usize,
) {
    // SAFETY: the caller gives as many values as its text asks for, each string of 8 characters.
    let (operation, text) = unsafe {
        let value = |i: usize| (!integers.is_null()).then(|| *integers.add(i));
        let real = |i: usize| (!reals.is_null()).then(|| *reals.add(i));
        let word = |i: usize| (!strings.is_null()).then(|| words(strings.add(8 * i), 8));
        (*lop, host::fill_in(&words(text, text_length), value, real, word))
    };
    let level = match operation {
        1 => Level::Note,
        -1 => Level::Warning,
        _ => Level::Error,
    };
    host::tell(level, text.clone());
    if operation == -3 {
        end(text);
    }
}

/// `call vgetjobname(jobname, lenjobname)`.
unsafe extern "C-unwind" fn vgetjobname(name: *mut c_char, length: *mut i32, room: usize) {
    // SAFETY: the compiler of the caller gives the variable's length.
    host::with_job(|job| unsafe { give(&job.name, name, length, room) });
}

/// `call vgetoutdir(outdir, lenoutdir)`.
unsafe extern "C-unwind" fn vgetoutdir(folder: *mut c_char, length: *mut i32, room: usize) {
    // SAFETY: the compiler of the caller gives the variable's length.
    host::with_job(|job| unsafe { give(&job.folder, folder, length, room) });
}

/// `call vgetnumcpus(numprocesses)`: one process.
unsafe extern "C-unwind" fn vgetnumcpus(count: *mut i32) {
    // SAFETY: an integer of the caller.
    unsafe { *count = 1 }
}

/// `call vgetrank(kprocessnum)`: the first.
unsafe extern "C-unwind" fn vgetrank(rank: *mut i32) {
    // SAFETY: an integer of the caller.
    unsafe { *rank = 0 }
}

/// `call vgetinternal(cpname, locnum, jtyp, intnum, jrcd)`: jtyp 0 nodes, 1 elements; jrcd 0 if found.
unsafe extern "C-unwind" fn vgetinternal(
    part: *const c_char,
    local: *const i32,
    kind: *const i32,
    internal: *mut i32,
    code: *mut i32,
    length: usize,
) {
    // SAFETY: integers of the caller, and a name of the length that its compiler gives.
    unsafe {
        let part = words(part, length);
        let number = host::with_job(|job| {
            let names = if *kind == 0 { &job.nodes } else { &job.elements };
            host::internal_number(names, &part, *local)
        });
        *internal = number;
        *code = i32::from(number == 0);
    }
}

/// `call vgetpartinfo(intnum, jtyp, cpname, locnum, jrcd)`.
unsafe extern "C-unwind" fn vgetpartinfo(
    internal: *const i32,
    kind: *const i32,
    part: *mut c_char,
    local: *mut i32,
    code: *mut i32,
    room: usize,
) {
    host::with_job(|job| {
        // SAFETY: integers of the caller, and a name of the length that its compiler gives.
        unsafe {
            let names = if *kind == 0 { &job.nodes } else { &job.elements };
            let found = host::part_of(names, *internal);
            *code = i32::from(found.is_none());
            if let Some((name, number)) = found {
                give(name, part, std::ptr::null_mut(), room);
                *local = number;
            }
        }
    });
}

/// `call vgetvrm(var, rData, jData, cData, jStatus)`: what the points of a VUSDFLD hold at the beginning of the increment
/// (ABAQUS User Subroutines Reference, 2.1.7 "Obtaining material point information in an Abaqus/Explicit analysis"): components
/// one after the other, each with one value a point; jStatus is 0 if the variable is there.
unsafe extern "C-unwind" fn vgetvrm(
    variable: *const c_char,
    reals: *mut f64,
    integers: *mut i32,
    flags: *mut c_char,
    status: *mut i32,
    length: usize,
    flag: usize,
) {
    // SAFETY: a name of the length that the caller's compiler gives.
    let variable = unsafe { words(variable, length) }.to_uppercase();
    let given = current(|call| {
        let (count, values) = call?.points?;
        values.give(&variable, &mut |component, point, value| {
            let at = component * count + point;
            // SAFETY: the caller's arrays have room for every component of every point of its block.
            unsafe {
                *reals.add(at) = value;
                if !integers.is_null() {
                    *integers.add(at) = 0;
                }
                if !flags.is_null() && flag > 0 {
                    std::slice::from_raw_parts_mut(flags.add(flag * at).cast::<u8>(), flag).fill(b' ');
                    let word = &b"YES"[..flag.min(3)];
                    std::ptr::copy_nonoverlapping(word.as_ptr(), flags.add(flag * at).cast::<u8>(), word.len());
                }
            }
        })
    });
    // SAFETY: an integer of the caller.
    unsafe { *status = i32::from(given.is_none()) }
    if given.is_none() {
        let known = "S, LE, PE, ER, PEEQ, TEMP and SDV are";
        host::tell(Level::Warning, format!("vgetvrm: `{variable}` is not there; {known}, where the material has them"));
    }
}

/// `call vsprinc(nblock, s, ps, ndi, nshr)`: principal values (ABAQUS User Subroutines Reference, 2.1.11 "Obtaining principal
/// stress values and directions in an Abaqus/Explicit analysis").
unsafe extern "C-unwind" fn vsprinc(
    count: *const i32,
    tensors: *const f64,
    values: *mut f64,
    direct: *const i32,
    shear: *const i32,
) {
    // SAFETY: passed on as they came; no directions are wanted.
    unsafe { vsprind(count, tensors, values, std::ptr::null_mut(), direct, shear) }
}

/// `call vsprind(nblock, s, ps, an, ndi, nshr)`: with their directions, `an(k, i, :)` of the i-th.
unsafe extern "C-unwind" fn vsprind(
    count: *const i32,
    tensors: *const f64,
    values: *mut f64,
    directions: *mut f64,
    direct: *const i32,
    shear: *const i32,
) {
    // SAFETY: the caller's arrays have the lengths that its counts say.
    unsafe {
        let (n, direct, shear) = (*count as usize, *direct as usize, *shear as usize);
        for k in 0..n {
            let component = |c: usize| *tensors.add(c * n + k);
            let part = |c: usize| if c < direct { component(c) } else { 0.0 };
            let sheared = |c: usize| if c < shear { component(direct + c) } else { 0.0 };
            let (list, axes) = host::principal([part(0), part(1), part(2)], [sheared(0), sheared(1), sheared(2)]);
            for (i, (value, axis)) in list.into_iter().zip(axes).enumerate() {
                *values.add(i * n + k) = value;
                if !directions.is_null() {
                    axis.into_iter().enumerate().for_each(|(j, x)| *directions.add((j * 3 + i) * n + k) = x);
                }
            }
        }
    }
}

/// `ivGetSensorID(sensorName, jSensorLookUpTable)`: place of the sensor from 1, 0 if there is none.
unsafe extern "C-unwind" fn sensor_id(name: *const c_char, _table: *const i32, length: usize) -> i32 {
    // SAFETY: a name of the length that the caller's compiler gives.
    let name = unsafe { words(name, length) };
    current(|call| {
        let names = call.map_or(&[][..], |c| c.sensors.0);
        names.iter().position(|n| n.eq_ignore_ascii_case(&name)).map_or(0, |i| i as i32 + 1)
    })
}

/// `vGetSensorValue(sensorName, jSensorLookUpTable, sensorValues)`.
unsafe extern "C-unwind" fn sensor_value(
    name: *const c_char,
    table: *const i32,
    _values: *const f64,
    length: usize,
) -> f64 {
    // SAFETY: passed on as they came.
    let id = unsafe { sensor_id(name, table, length) };
    if id == 0 {
        // SAFETY: a name of the length that the caller's compiler gives.
        end(format!("it asked for the sensor `{}`, which the deck does not have", unsafe { words(name, length) }));
    }
    current(|call| call.map_or(f64::NAN, |c| c.sensors.1[id as usize - 1]))
}

unsafe extern "C-unwind" fn stop_string(text: *const c_char, length: usize, _quiet: bool) -> ! {
    // SAFETY: text of the length given.
    end(format!("it ran into STOP {}", unsafe { words(text, length) }).trim_end().to_owned())
}

unsafe extern "C-unwind" fn error_stop_string(text: *const c_char, length: usize, _quiet: bool) -> ! {
    // SAFETY: text of the length given.
    end(format!("it ran into ERROR STOP {}", unsafe { words(text, length) }).trim_end().to_owned())
}

extern "C-unwind" fn stop_numeric(code: c_int, _quiet: bool) -> ! {
    end(format!("it ran into STOP {code}"))
}

extern "C-unwind" fn error_stop_numeric(code: c_int, _quiet: bool) -> ! {
    end(format!("it ran into ERROR STOP {code}"))
}

unsafe extern "C-unwind" fn exit_i4(status: *const i32) -> ! {
    // SAFETY: null or an integer of the caller.
    let status = unsafe { status.as_ref() }.copied().unwrap_or(0);
    end(format!("it called exit({status})"))
}

unsafe extern "C-unwind" fn exit_i8(status: *const i64) -> ! {
    // SAFETY: null or an integer of the caller.
    let status = unsafe { status.as_ref() }.copied().unwrap_or(0);
    end(format!("it called exit({status})"))
}

extern "C-unwind" fn fortran_abort() -> ! {
    end("it called abort".into())
}

/// Checks of the Fortran runtime. These functions take values as C's `printf` does; the first few come in registers.
unsafe extern "C-unwind" fn runtime_error(format: *const c_char, a: usize, b: usize, c: usize, d: usize) -> ! {
    // SAFETY: the runtime's own format, and the values that it asks for.
    end(unsafe { printed(format, [a, b, c, d]) })
}

unsafe extern "C-unwind" fn runtime_error_at(
    place: *const c_char,
    format: *const c_char,
    a: usize,
    b: usize,
    c: usize,
    d: usize,
) -> ! {
    // SAFETY: text that ends with zero, the runtime's own format, and the values that it asks for.
    end(unsafe { format!("{}: {}", CStr::from_ptr(place).to_string_lossy(), printed(format, [a, b, c, d])) })
}

/// The few formats that the Fortran runtime uses: integers and text.
///
/// # Safety
/// `format` ends with zero and asks for `values` alone, of which `%s` are text that ends with zero.
unsafe fn printed(format: *const c_char, values: [usize; 4]) -> String {
    // SAFETY: as this function's own.
    let format = unsafe { CStr::from_ptr(format) }.to_string_lossy().into_owned();
    let mut values = values.into_iter();
    let mut text = String::new();
    let mut rest = format.as_str();
    while let Some(at) = rest.find('%') {
        text += &rest[..at];
        let tail = &rest[at + 1..];
        let Some(end) = tail.find(|c: char| c.is_alphabetic() && c != 'l' && c != 'z' || c == '%') else { break };
        match (tail.as_bytes()[end], values.next()) {
            // SAFETY: as this function's own.
            (b's', Some(value)) => text += &unsafe { CStr::from_ptr(value as *const c_char) }.to_string_lossy(),
            (b'd' | b'i' | b'u', Some(value)) => {
                let wide = tail[..end].contains(['l', 'z']);
                let _ = write!(text, "{}", if wide { value as i64 } else { i64::from(value as i32) });
            }
            _ => text.push('%'),
        }
        rest = &tail[end + 1..];
    }
    text + rest
}
