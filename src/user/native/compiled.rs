//! CompiledRoutine routines as the run calls them: the arguments of the traits passed to the user's functions, and what a function
//! must leave alone.
//! Never here: opening libraries, the order of arguments (`subroutines.rs`).
#![allow(unsafe_code)]

use std::ffi::{c_char, c_int};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use libloading::os::unix::Library;

use super::call::{self, ActiveCall};
use super::host::{self, Level};
use super::host_routines::ended;
use super::subroutines::{self, AmplitudeArrays, DOFS, Kind, MaterialArrays, NAME, interface};
use super::{
    AmplitudeAnswer, AmplitudeCall, AnalysisMoment, FieldAnswer, FieldCall, HardeningAnswer, HardeningCall, LengthCall,
    LoadFailure, LoadPoints, MAX_MATERIAL_BLOCK, MaterialAnswer, MaterialCall, MotionCall, RunAction, UserAmplitude,
    UserEvents, UserFields, UserHardening, UserLengths, UserLoad, UserMaterial, UserMotion, crash, guard,
};
use crate::state::Instant;

/// `FE_INVALID` of `fenv.h` on x86-64 and aarch64.
const FE_INVALID: c_int = 1;

unsafe extern "C" {
    fn feclearexcept(exceptions: c_int) -> c_int;
    fn fetestexcept(exceptions: c_int) -> c_int;
}

/// Bytes behind a name that a routine must leave alone: declared `character*256`, a name reaches that far.
const BEHIND: usize = 512 - NAME;

/// The part of that which is looked at after each call.
const WATCHED: usize = 128;

/// A name padded with blanks, and behind it bytes that betray a routine which writes too far.
struct PaddedName {
    bytes: [u8; NAME + BEHIND],
    given: [u8; WATCHED],
    text: String,
}

impl Default for PaddedName {
    fn default() -> Self {
        PaddedName { bytes: pad(""), given: pad(""), text: String::new() }
    }
}

impl PaddedName {
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

/// A function of the user's libraries, with what its calls work with.
pub struct CompiledRoutine<F, W> {
    function: F,
    name: PaddedName,
    work: W,
    _libraries: Arc<[Library]>,
}

impl<F: Copy, W> CompiledRoutine<F, W> {
    /// A function of these libraries.
    pub fn new(function: F, work: W, libraries: Arc<[Library]>) -> Self {
        CompiledRoutine { function, name: PaddedName::default(), work, _libraries: libraries }
    }

    /// Calls the function, which may only read the name that it is given; one that ends the process comes back as a failure.
    #[inline]
    fn enter(
        &mut self,
        call: &ActiveCall<'_>,
        name: &str,
        body: impl FnOnce(F, *const c_char, &mut W),
    ) -> Result<(), LoadFailure> {
        let text = self.name.set(name);
        crash::note_call();
        call.begin();
        let returned = catch_unwind(AssertUnwindSafe(|| body(self.function, text, &mut self.work)));
        guard::restore(|what| host::tell(Level::Warning, format!("{} {what}", call.routine)));
        call::end();
        returned.map_err(|payload| ended(call, payload))?;
        if self.name.untouched() {
            return Ok(());
        }
        let argument = interface(call.routine).and_then(|i| i.arguments_of(Kind::Character).next()).unwrap_or_default();
        Err(LoadFailure::new(format!("{} wrote into its argument {argument}, which it may only read", call.routine)))
    }
}

/// Whether a load is halted that computes with what is no number.
pub struct WatchInvalid(pub bool);

impl UserLoad for CompiledRoutine<subroutines::Vdload, WatchInvalid> {
    fn pressure(&mut self, points: &LoadPoints<'_>, pressure: &mut [f64]) -> Result<(), LoadFailure> {
        // An element load has no surface name.
        let name = if points.load_type == 0 { points.surface } else { "" };
        if self.work.0 {
            // SAFETY: changes a flag of this thread alone.
            unsafe { feclearexcept(FE_INVALID) };
        }
        self.enter(&ActiveCall::new("vdload", points.surface, points.now), name, |function, name, _| {
            // SAFETY: each slice holds what the manual says the routine reads; names and values have room behind.
            unsafe { subroutines::vdload(function, points, name, pressure) }
        })?;
        // SAFETY: reads a flag of this thread.
        if self.work.0 && unsafe { fetestexcept(FE_INVALID) } != 0 {
            let reason = "vdload computed with a number that is none (NaN), and its source reads a third coordinate: \
                          curCoords and velocity have two, r and z";
            return Err(LoadFailure::new(reason));
        }
        Ok(())
    }

    fn reads_motion(&self) -> bool {
        true
    }
}

impl UserAmplitude for CompiledRoutine<subroutines::Vuamp, ()> {
    fn amplitude(&mut self, call: &mut AmplitudeCall<'_>) -> Result<AmplitudeAnswer, LoadFailure> {
        let (name, now) = (call.name, call.now);
        let mut arrays = AmplitudeArrays {
            info: [i32::from(now.increment == 0), 1 - i32::from(call.begins), now.step as i32],
            sensors: call.sensor_names.iter().flat_map(|n| pad::<NAME>(n)).chain([b' '; NAME]).collect(),
            value: f64::NAN,
            define: [0; 8],
            derivative: 0.0,
        };
        let context =
            ActiveCall { sensors: (call.sensor_names, call.sensor_values), ..ActiveCall::new("vuamp", name, now) };
        self.enter(&context, name, |function, name, ()| {
            // SAFETY: each argument has the length that the counts before it say.
            unsafe { subroutines::vuamp(function, call, name, &mut arrays) }
        })?;
        let AmplitudeArrays { value, define, derivative, .. } = arrays;
        let derivative = (define[0] == 1).then_some(derivative);
        Ok(AmplitudeAnswer { value, derivative, stop: define[3] == 1, conclude_step: define[4] == 1 })
    }
}

impl UserMotion for CompiledRoutine<subroutines::Vdisp, ()> {
    fn motion(&mut self, call: &MotionCall<'_>) -> Result<f64, LoadFailure> {
        let mut values = [f64::NAN; DOFS];
        self.enter(&ActiveCall::new("vdisp", call.set, call.now), call.set, |function, name, ()| {
            // SAFETY: one node, three degrees of freedom, two coordinates; every array is of that size.
            unsafe { subroutines::vdisp(function, call, name, &mut values) }
        })?;
        Ok(values[call.dof - 1])
    }
}

impl UserMaterial for CompiledRoutine<subroutines::Vumat, MaterialArrays> {
    fn stress(&mut self, call: &MaterialCall<'_>, answer: &mut MaterialAnswer<'_>) -> Result<(), LoadFailure> {
        self.work.set(call);
        let context = ActiveCall::new("vumat", call.name, call.now).at(call.elements);
        self.enter(&context, call.name, |function, name, arrays| {
            // SAFETY: each argument has the length that the counts before it say.
            unsafe { subroutines::vumat(function, call, name, arrays, answer) }
        })
    }
}

impl UserHardening for CompiledRoutine<subroutines::Vuhard, ()> {
    fn yield_stress(&mut self, call: &HardeningCall<'_>, answer: &mut HardeningAnswer<'_>) -> Result<(), LoadFailure> {
        let context = ActiveCall::new("vuhard", call.name, call.now).at(call.elements);
        self.enter(&context, call.name, |function, name, ()| {
            // SAFETY: each argument has the length that the counts before it say.
            unsafe { subroutines::vuhard(function, call, name, answer) }
        })
    }
}

/// Directions of the material at the points of a call: identities, components one after the other.
pub struct MaterialAxes(Vec<f64>);

impl Default for MaterialAxes {
    fn default() -> Self {
        MaterialAxes(vec![0.0; 9 * MAX_MATERIAL_BLOCK])
    }
}

impl MaterialAxes {
    fn of(&mut self, count: usize) -> *const f64 {
        for (slab, list) in self.0.chunks_mut(count).take(9).enumerate() {
            list.fill(if slab % 4 == 0 { 1.0 } else { 0.0 });
        }
        self.0.as_ptr()
    }
}

impl UserFields for CompiledRoutine<subroutines::Vusdfld, MaterialAxes> {
    fn fields(&mut self, call: &FieldCall<'_>, answer: &mut FieldAnswer<'_>) -> Result<(), LoadFailure> {
        let points = Some((call.count, call.values));
        let context = ActiveCall { points, ..ActiveCall::new("vusdfld", call.name, call.now).at(call.elements) };
        self.enter(&context, call.name, |function, name, axes| {
            // SAFETY: each argument has the length that the counts before it say.
            unsafe { subroutines::vusdfld(function, call, name, axes.of(call.count), answer) }
        })
    }
}

impl UserLengths for CompiledRoutine<subroutines::Vucharlength, MaterialAxes> {
    fn lengths(&mut self, call: &LengthCall<'_>, lengths: &mut [f64]) -> Result<(), LoadFailure> {
        let context = ActiveCall::new("vucharlength", call.name, call.now).at(call.elements);
        self.enter(&context, call.name, |function, name, axes| {
            // SAFETY: each argument has the length that the counts before it say.
            unsafe { subroutines::vucharlength(function, call, name, axes.of(call.count), lengths) }
        })
    }
}

/// Whether the state of the increment that ends will be kept.
#[derive(Default)]
pub struct RestartFollows(bool);

impl UserEvents for CompiledRoutine<subroutines::Vexternaldb, RestartFollows> {
    fn moment(&mut self, moment: AnalysisMoment, now: &Instant, increment: f64) -> Result<RunAction, LoadFailure> {
        let (nodes, elements) = host::with_job(|j| (j.nodes.len() as i32, j.elements.len() as i32));
        let count = i32::try_from(now.increment).unwrap_or(i32::MAX);
        // i_int_nTotalNodes, nTotalElements, kStep, kInc, iStatus, lWriteRestart.
        let restart = i32::from(std::mem::take(&mut self.work.0));
        let mut integers = [nodes, elements, now.step as i32, count, 0, restart, 0, 0];
        let mut reals = [now.total_time, now.step_time, increment, 0.0];
        self.enter(&ActiveCall::new("vexternaldb", "", *now), "", |function, _, _| {
            // SAFETY: both arrays are longer than the counts say.
            unsafe { subroutines::vexternaldb(function, moment as i32, &mut integers, &mut reals) }
        })?;
        Ok(match integers[4] {
            1 => RunAction::EndStep,
            2 => RunAction::EndAnalysis,
            _ => RunAction::Continue,
        })
    }

    fn restart_follows(&mut self) {
        self.work.0 = true;
    }
}
