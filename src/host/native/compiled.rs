//! Compiled user subroutines as implementations of the traits of `user`, with checks of their arguments after each
//! call. The order of arguments is in `subroutines.rs`.
#![allow(unsafe_code)]

use std::ffi::{c_char, c_int};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use libloading::os::unix::Library;

use super::call::{self, ActiveCall};
use super::host::{self, MessageLevel};
use super::host_routines::ended;
use super::subroutines::{self, AmplitudeArrays, ArgumentKind, DOFS, FrictionArrays, MaterialArrays, NAME, interface};
use super::{
    AmplitudeAnswer, AmplitudeCall, AnalysisMoment, EnergyAnswer, EnergyCall, FieldAnswer, FieldCall, FrictionCall,
    HardeningAnswer, HardeningCall, LengthCall, LoadFailure, LoadPoints, MAX_MATERIAL_BLOCK, MaterialAnswer,
    MaterialCall, MotionCall, NodalFieldCall, RunAction, UserAmplitude, UserEnergy, UserEvents, UserFields,
    UserFriction, UserHardening, UserLengths, UserLoad, UserMaterial, UserMotion, UserNodalFields, crash, guard,
};
use revolve_numerics::state::Instant;

/// `FE_INVALID` of `fenv.h` on x86-64 and aarch64.
const FE_INVALID: c_int = 1;

unsafe extern "C" {
    fn feclearexcept(exceptions: c_int) -> c_int;
    fn fetestexcept(exceptions: c_int) -> c_int;
}

/// Guard bytes after a name, which a subroutine must not change: a dummy argument may be declared `character*256`.
const GUARD: usize = 512 - NAME;

/// Number of bytes that are checked after each call.
const WATCHED: usize = 128;

/// A name padded with blanks, followed by guard bytes that detect a subroutine which writes too far.
struct PaddedName {
    bytes: [u8; NAME + GUARD],
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

    /// Returns whether the name is unchanged; restores it if not.
    fn untouched(&mut self) -> bool {
        let same = self.bytes[..WATCHED] == self.given && self.bytes[NAME + GUARD - 1] == b' ';
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

/// A function of the user's libraries, with the work arrays of its calls.
pub struct CompiledRoutine<F, W> {
    function: F,
    name: PaddedName,
    work: W,
    _libraries: Arc<[Library]>,
}

impl<F: Copy, W> CompiledRoutine<F, W> {
    /// Wraps a function that one of `libraries` defines.
    pub fn new(function: F, work: W, libraries: Arc<[Library]>) -> Self {
        CompiledRoutine { function, name: PaddedName::default(), work, _libraries: libraries }
    }

    /// Calls the function, which must not change its name argument. A call that ends the analysis becomes a failure.
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
        guard::restore(|what| host::report_message(MessageLevel::Warning, format!("{} {what}", call.routine)));
        call::end();
        returned.map_err(|payload| ended(call, payload))?;
        if self.name.untouched() {
            return Ok(());
        }
        let argument =
            interface(call.routine).and_then(|i| i.arguments_of(ArgumentKind::Character).next()).unwrap_or_default();
        Err(LoadFailure::new(format!("{} changed its argument {argument}, which is read-only", call.routine)))
    }
}

/// Whether the run halts if the load performs an invalid floating-point operation (NaN).
pub struct WatchInvalid(pub bool);

impl UserLoad for CompiledRoutine<subroutines::Vdload, WatchInvalid> {
    fn pressure(&mut self, points: &LoadPoints<'_>, pressure: &mut [f64]) -> Result<(), LoadFailure> {
        // An element load has no surface name.
        let name = if points.load_type == 0 { points.surface } else { "" };
        if self.work.0 {
            // SAFETY: changes a flag of this thread only.
            unsafe { feclearexcept(FE_INVALID) };
        }
        self.enter(&ActiveCall::new("vdload", points.surface, points.now), name, |function, name, _| {
            // SAFETY: each slice has the length given in the manual; guards follow the name and the values.
            unsafe { subroutines::vdload(function, points, name, pressure) }
        })?;
        // SAFETY: reads a flag of this thread.
        if self.work.0 && unsafe { fetestexcept(FE_INVALID) } != 0 {
            let reason = "vdload computed with NaN, and its source reads a third coordinate: \
                          curCoords and velocity have two components, r and z";
            return Err(LoadFailure::new(reason));
        }
        Ok(())
    }

    fn reads_motion(&self) -> bool {
        true
    }

    fn reads_magnitude(&self) -> bool {
        false
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
            // SAFETY: each array has the length given by the counts.
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
            // SAFETY: all arrays are for one node with three degrees of freedom and two coordinates.
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
            // SAFETY: each array has the length given by the counts.
            unsafe { subroutines::vumat(function, call, name, arrays, answer) }
        })
    }
}

impl UserEnergy for CompiledRoutine<subroutines::VuanisohyperInv, ()> {
    fn energy(&mut self, call: &EnergyCall<'_>, answer: &mut EnergyAnswer<'_>) -> Result<(), LoadFailure> {
        let context = ActiveCall::new("vuanisohyper_inv", call.name, call.now).at(call.elements);
        self.enter(&context, call.name, |function, name, ()| {
            // SAFETY: each array has the length given by the counts.
            unsafe { subroutines::vuanisohyper_inv(function, call, name, answer) }
        })
    }
}

impl UserHardening for CompiledRoutine<subroutines::Vuhard, ()> {
    fn yield_stress(&mut self, call: &HardeningCall<'_>, answer: &mut HardeningAnswer<'_>) -> Result<(), LoadFailure> {
        let context = ActiveCall::new("vuhard", call.name, call.now).at(call.elements);
        self.enter(&context, call.name, |function, name, ()| {
            // SAFETY: each array has the length given by the counts.
            unsafe { subroutines::vuhard(function, call, name, answer) }
        })
    }
}

/// Material directions at the points of a call: identity matrices, one component of all points after the other.
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
            // SAFETY: each array has the length given by the counts.
            unsafe { subroutines::vusdfld(function, call, name, axes.of(call.count), answer) }
        })
    }
}

impl UserNodalFields for CompiledRoutine<subroutines::Vufield, ()> {
    fn nodal_fields(&mut self, call: &NodalFieldCall<'_>, values: &mut [f64]) -> Result<(), LoadFailure> {
        let context = ActiveCall::new("vufield", call.set, call.now);
        self.enter(&context, "", |function, _, ()| {
            // SAFETY: each array has the length given by the counts.
            unsafe { subroutines::vufield(function, call, values) }
        })
    }
}

impl UserFriction for CompiledRoutine<subroutines::Vfriction, FrictionArrays> {
    fn friction(&mut self, call: &FrictionCall<'_>, forces: &mut [f64], state: &mut [f64]) -> Result<(), LoadFailure> {
        let context = ActiveCall::new("vfriction", call.interaction, call.now);
        self.enter(&context, call.interaction, |function, name, arrays| {
            // SAFETY: each array has the length given by the counts.
            unsafe { subroutines::vfriction(function, call, name, arrays, forces, state) }
        })
    }
}

impl UserLengths for CompiledRoutine<subroutines::Vucharlength, MaterialAxes> {
    fn lengths(&mut self, call: &LengthCall<'_>, lengths: &mut [f64]) -> Result<(), LoadFailure> {
        let context = ActiveCall::new("vucharlength", call.name, call.now).at(call.elements);
        self.enter(&context, call.name, |function, name, axes| {
            // SAFETY: each array has the length given by the counts.
            unsafe { subroutines::vucharlength(function, call, name, axes.of(call.count), lengths) }
        })
    }
}

/// Whether the state at the end of this increment will be saved.
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
            // SAFETY: both arrays are longer than the counts passed.
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
