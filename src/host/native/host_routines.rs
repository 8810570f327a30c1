//! Host routines: functions of the program that user subroutines call, under the symbol names that the dynamic linker
//! searches. Their implementation is in `host.rs`.
#![allow(unsafe_code)]

use std::any::Any;
use std::ffi::{CStr, c_char, c_int};
use std::fmt::Write as _;
use std::panic::resume_unwind;

use super::call::{self, ActiveCall, current};
use super::host::{self, MessageLevel};
use super::{LoadFailure, guard};

/// Payload of the panic with which a subroutine ends the analysis.
struct AnalysisEnded(String);

/// Returns the failure of a call that ended the analysis; other panics are resumed.
#[cold]
#[inline(never)] // A reference from another file keeps the symbols of this file in the executable.
pub fn ended(call: &ActiveCall<'_>, payload: Box<dyn Any + Send>) -> LoadFailure {
    match payload.downcast::<AnalysisEnded>() {
        Ok(ended) => LoadFailure::new(format!("{} ended the analysis: {}", call.routine, ended.0)),
        Err(other) => resume_unwind(other),
    }
}

/// Ends the analysis from inside a subroutine.
fn end(why: String) -> ! {
    if !call::inside() {
        // Outside a call, nobody would catch the panic.
        eprintln!("error: {why}");
        std::process::exit(1);
    }
    resume_unwind(Box::new(AnalysisEnded(why)))
}

/// A jump in assembly, because link-time optimisation would hide the symbol of a Rust function.
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
    ($($name:expr => $function:path),+ $(,)?) => {
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

/// Defines symbols like `symbols`, but as Rust functions, the only functions that shared libraries export.
macro_rules! host_symbols {
    ($($name:expr => $function:path),+ $(,)?) => {
        $(const _: () = {
            #[unsafe(naked)]
            #[unsafe(export_name = $name)]
            extern "C" fn forward() {
                core::arch::naked_asm!(jump!(), f = sym $function)
            }
        };)+
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

/// Returns a Fortran text of a given length without trailing blanks.
///
/// # Safety
/// `text` is null or holds `length` bytes.
unsafe fn words(text: *const c_char, length: usize) -> String {
    if text.is_null() {
        return String::new();
    }
    // SAFETY: guaranteed by the caller.
    let bytes = unsafe { std::slice::from_raw_parts(text.cast::<u8>(), length) };
    String::from_utf8_lossy(bytes).trim_end_matches([' ', '\0']).to_owned()
}

/// Writes text into a Fortran variable, padded with blanks, and its length to `length`.
///
/// # Safety
/// `to` has `capacity` bytes; `length` is null or points to an integer.
unsafe fn write_text(text: &str, to: *mut c_char, length: *mut i32, capacity: usize) {
    let count = text.len().min(capacity);
    // SAFETY: guaranteed by the caller.
    unsafe {
        let bytes = std::slice::from_raw_parts_mut(to.cast::<u8>(), capacity);
        bytes.fill(b' ');
        bytes[..count].copy_from_slice(&text.as_bytes()[..count]);
        if !length.is_null() {
            *length = count as i32;
        }
    }
}

/// Declares host routines: symbols, arguments and bodies.
macro_rules! host_routines {
    ($($(#[$doc:meta])* $($symbol:literal),+ => fn $name:ident($($argument:ident: $type:ty),*) $(-> $result:ty)? $body:block)*) => {$(
        $(#[$doc])*
        #[allow(unused_unsafe, clippy::too_many_arguments)] // Signatures of the manual and of MPI.
        unsafe extern "C-unwind" fn $name($($argument: $type),*) $(-> $result)? {
            // SAFETY: the caller passes what the manual declares: pointers to numbers, arrays of the given counts,
            // texts of the lengths that its compiler adds, and null for omitted arguments.
            unsafe { $body }
        }
        host_symbols! { $($symbol => $name),+ }
    )*};
}

host_routines! {
    /// `call xplb_exit`: ends the analysis (ABAQUS User Subroutines Reference, 2.1.15 "Terminating an analysis").
    "xplb_exit_" => fn xplb_exit() -> ! { end("it called xplb_exit".into()) }

    /// `call xit` of ABAQUS/Standard.
    "xit_", "mpi_abort_" => fn xit() -> ! { end("it called xit".into()) }

    /// Replacement of an undefined function.
    "rvmissing_" => fn missing_symbol(name: *const c_char, length: usize) -> ! {
        end(format!("it calls `{}`, which is not defined", words(name, length)))
    }

    /// Number of threads: 1.
    "getnumthreads_" => fn thread_count() -> i32 { 1 }

    /// Number of the thread and of the communicator: 0.
    "get_thread_id_", "getcommunicator_" => fn zero() -> i32 { 0 }

    /// Mutexes have no effect: one thread calls all subroutines.
    "mutexinit_", "mutexlock_", "mutexunlock_", "mutexdestroy_" => fn nothing() {}

    /// `call mpi_init(ierr)`, `call mpi_finalize(ierr)`: one process with rank 0.
    "mpi_init_", "mpi_finalize_" => fn mpi_init(error: *mut i32) { *error = 0 }

    "mpi_barrier_" => fn mpi_barrier(_world: *const i32, error: *mut i32) { *error = 0 }

    "mpi_initialized_" => fn mpi_initialized(flag: *mut i32, error: *mut i32) { (*flag, *error) = (1, 0) }

    "mpi_comm_rank_" => fn mpi_rank(_world: *const i32, rank: *mut i32, error: *mut i32) { (*rank, *error) = (0, 0) }

    "mpi_comm_size_" => fn mpi_size(_world: *const i32, size: *mut i32, error: *mut i32) { (*size, *error) = (1, 0) }

    "mpi_bcast_" => fn mpi_bcast(
        _buffer: *mut u8, _count: *const i32, _kind: *const i32, _root: *const i32, _world: *const i32, error: *mut i32
    ) { *error = 0 }

    /// A reduction over one process returns its own values.
    "mpi_allreduce_" => fn mpi_allreduce(
        from: *const u8, to: *mut u8, count: *const i32, kind: *const i32, _operation: *const i32, _world: *const i32,
        error: *mut i32
    ) { copy_values(from, to, count, kind, error) }

    "mpi_reduce_" => fn mpi_reduce(
        from: *const u8, to: *mut u8, count: *const i32, kind: *const i32, _operation: *const i32, _root: *const i32,
        _world: *const i32, error: *mut i32
    ) { copy_values(from, to, count, kind, error) }

    "mpi_allgather_" => fn mpi_allgather(
        from: *const u8, count: *const i32, kind: *const i32, to: *mut u8, _to_count: *const i32, _to_kind: *const i32,
        _world: *const i32, error: *mut i32
    ) { copy_values(from, to, count, kind, error) }

    "mpi_gather_" => fn mpi_gather(
        from: *const u8, count: *const i32, kind: *const i32, to: *mut u8, _to_count: *const i32, _to_kind: *const i32,
        _root: *const i32, _world: *const i32, error: *mut i32
    ) { copy_values(from, to, count, kind, error) }

    "mpi_wtime_" => fn mpi_wtime() -> f64 {
        std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).map_or(0.0, |since| since.as_secs_f64())
    }

    /// `call xplb_abqerr(lop, string, intv, realv, charv)` (ABAQUS User Subroutines Reference, "Printing messages to
    /// the message or status file"): as many values as the text has placeholders; each string has 8 characters.
    "xplb_abqerr_", "stdb_abqerr_" => fn xplb_abqerr(
        lop: *const i32, text: *const c_char, integers: *const i32, reals: *const f64, strings: *const c_char,
        text_length: usize, _string_length: usize
    ) {
        let value = |i: usize| (!integers.is_null()).then(|| *integers.add(i));
        let real = |i: usize| (!reals.is_null()).then(|| *reals.add(i));
        let word = |i: usize| (!strings.is_null()).then(|| words(strings.add(8 * i), 8));
        let text = host::fill_in(&words(text, text_length), value, real, word);
        let level = match *lop {
            1 => MessageLevel::Note,
            -1 => MessageLevel::Warning,
            _ => MessageLevel::Error,
        };
        host::report_message(level, text.clone());
        if *lop == -3 {
            end(text);
        }
    }

    /// Returns the name of the job: `call vgetjobname(jobname, lenjobname)`.
    "vgetjobname_", "getjobname_" => fn vgetjobname(name: *mut c_char, length: *mut i32, capacity: usize) {
        host::with_job(|job| write_text(&job.name, name, length, capacity));
    }

    /// Returns the folder of the deck: `call vgetoutdir(outdir, lenoutdir)`.
    "vgetoutdir_", "getoutdir_" => fn vgetoutdir(folder: *mut c_char, length: *mut i32, capacity: usize) {
        host::with_job(|job| write_text(&job.folder, folder, length, capacity));
    }

    /// `call vgetnumcpus(numprocesses)`: one process.
    "vgetnumcpus_", "getnumcpus_" => fn vgetnumcpus(count: *mut i32) { *count = 1 }

    /// `call vgetrank(kprocessnum)`: rank 0.
    "vgetrank_", "getrank_" => fn vgetrank(rank: *mut i32) { *rank = 0 }

    /// `call vgetinternal(cpname, locnum, jtyp, intnum, jrcd)`: jtyp 0 nodes, 1 elements; jrcd 0 if found.
    "vgetinternal_" => fn vgetinternal(
        part: *const c_char, local: *const i32, kind: *const i32, internal: *mut i32, code: *mut i32, length: usize
    ) {
        *internal = host::with_job(|job| host::internal_number(job.names(*kind), &words(part, length), *local));
        *code = i32::from(*internal == 0);
    }

    /// Returns the instance and local number of a node or element: `call vgetpartinfo(intnum, jtyp, cpname, locnum,
    /// jrcd)`.
    "vgetpartinfo_" => fn vgetpartinfo(
        internal: *const i32, kind: *const i32, part: *mut c_char, local: *mut i32, code: *mut i32, capacity: usize
    ) {
        host::with_job(|job| {
            let name_in_part = host::part_of(job.names(*kind), *internal);
            *code = i32::from(name_in_part.is_none());
            if let Some((name, number)) = name_in_part {
                write_text(name, part, std::ptr::null_mut(), capacity);
                *local = number;
            }
        });
    }

    /// `call vgetvrm(var, rData, jData, cData, jStatus)`: values at the points of a VUSDFLD at the beginning of the
    /// increment (ABAQUS User Subroutines Reference, 2.1.7 "Obtaining material point information in an Abaqus/Explicit
    /// analysis"): all points of one component, then of the next; jStatus is 0 if the variable is available.
    "vgetvrm_" => fn vgetvrm(
        variable: *const c_char, reals: *mut f64, integers: *mut i32, flags: *mut c_char, status: *mut i32, length: usize,
        flag: usize
    ) {
        let variable = words(variable, length).to_uppercase();
        let components = current(|call| {
            let (count, values) = call?.points?;
            values.give(&variable, &mut |component, point, value| {
                let index = component * count + point;
                *reals.add(index) = value;
                if !integers.is_null() {
                    *integers.add(index) = 0;
                }
                if !flags.is_null() {
                    write_text("YES", flags.add(flag * index), std::ptr::null_mut(), flag);
                }
            })
        });
        *status = i32::from(components.is_none());
        if components.is_none() {
            let known = "S, LE, PE, ER, PEEQ, TEMP and SDV";
            let text = format!("vgetvrm: `{variable}` is not available; supported are {known}, if the material has them");
            host::report_message(MessageLevel::Warning, text);
        }
    }

    /// `call vsprinc(nblock, s, ps, ndi, nshr)`: principal values (ABAQUS User Subroutines Reference, 2.1.11 "Obtaining
    /// principal stress values and directions in an Abaqus/Explicit analysis").
    "vsprinc_" => fn vsprinc(
        count: *const i32, tensors: *const f64, values: *mut f64, direct: *const i32, shear: *const i32
    ) {
        vsprind(count, tensors, values, std::ptr::null_mut(), direct, shear);
    }

    /// `call vsprind(nblock, s, ps, an, ndi, nshr)`: principal values and directions, `an(k, i, :)` for the i-th.
    "vsprind_" => fn vsprind(
        count: *const i32, tensors: *const f64, values: *mut f64, directions: *mut f64, direct: *const i32,
        shear: *const i32
    ) {
        let (n, direct, shear) = (*count as usize, *direct as usize, *shear as usize);
        for k in 0..n {
            let component = |c: usize| *tensors.add(c * n + k);
            let part = |c: usize| if c < direct { component(c) } else { 0.0 };
            let sheared = |c: usize| if c < shear { component(direct + c) } else { 0.0 };
            let (list, axes) = host::principal([0, 1, 2].map(part), [0, 1, 2].map(sheared));
            for (i, (value, axis)) in list.into_iter().zip(axes).enumerate() {
                *values.add(i * n + k) = value;
                if !directions.is_null() {
                    axis.into_iter().enumerate().for_each(|(j, x)| *directions.add((j * 3 + i) * n + k) = x);
                }
            }
        }
    }

    /// `ivGetSensorID(sensorName, jSensorLookUpTable)`: index of the sensor from 1; 0 if there is none.
    "ivgetsensorid_", "igetsensorid_" => fn sensor_id(name: *const c_char, _table: *const i32, length: usize) -> i32 {
        let name = words(name, length);
        current(|call| {
            let names = call.map_or(&[][..], |c| c.sensors.0);
            names.iter().position(|n| n.eq_ignore_ascii_case(&name)).map_or(0, |i| i as i32 + 1)
        })
    }

    /// Returns the value of a sensor: `vGetSensorValue(sensorName, jSensorLookUpTable, sensorValues)`.
    "vgetsensorvalue_", "getsensorvalue_" => fn sensor_value(
        name: *const c_char, table: *const i32, _values: *const f64, length: usize
    ) -> f64 {
        let id = sensor_id(name, table, length);
        if id == 0 {
            end(format!("it requested the sensor `{}`, which the deck does not define", words(name, length)));
        }
        current(|call| call.map_or(f64::NAN, |c| c.sensors.1[id as usize - 1]))
    }

    "_gfortran_stop_string" => fn stop_string(text: *const c_char, length: usize, _quiet: bool) -> ! {
        end(format!("it executed STOP {}", words(text, length)).trim_end().to_owned())
    }

    "_gfortran_error_stop_string" => fn error_stop_string(text: *const c_char, length: usize, _quiet: bool) -> ! {
        end(format!("it executed ERROR STOP {}", words(text, length)).trim_end().to_owned())
    }

    "_gfortran_stop_numeric" => fn stop_numeric(code: c_int, _quiet: bool) -> ! {
        end(format!("it executed STOP {code}"))
    }

    "_gfortran_error_stop_numeric" => fn error_stop_numeric(code: c_int, _quiet: bool) -> ! {
        end(format!("it executed ERROR STOP {code}"))
    }

    "_gfortran_exit_i4" => fn exit_i4(status: *const i32) -> ! {
        end(format!("it called exit({})", status.as_ref().copied().unwrap_or(0)))
    }

    "_gfortran_exit_i8" => fn exit_i8(status: *const i64) -> ! {
        end(format!("it called exit({})", status.as_ref().copied().unwrap_or(0)))
    }

    "_gfortran_abort", "__wrap__FortranAAbort" => fn fortran_abort() -> ! { end("it called abort".into()) }

    /// `STOP` and `ERROR STOP` of Flang, whose codes are 0 and 1 if none is given.
    "__wrap__FortranAStopStatement" => fn flang_stop(code: c_int, is_error: bool, _quiet: bool) -> ! {
        let code_text = if code == c_int::from(is_error) { String::new() } else { format!(" {code}") };
        end(format!("it executed {}STOP{code_text}", if is_error { "ERROR " } else { "" }))
    }

    "__wrap__FortranAStopStatementText" => fn flang_stop_text(
        text: *const c_char, length: usize, is_error: bool, _quiet: bool
    ) -> ! {
        end(format!("it executed {}STOP {}", if is_error { "ERROR " } else { "" }, words(text, length)))
    }

    "__wrap__FortranAExit" => fn flang_exit(status: c_int) -> ! { end(format!("it called exit({status})")) }

    /// Checks of the Fortran runtime. These functions take values like C's `printf`; the first few are passed in
    /// registers.
    "_gfortran_runtime_error" => fn runtime_error(format: *const c_char, a: usize, b: usize, c: usize, d: usize) -> ! {
        end(printed(format, [a, b, c, d]))
    }

    "_gfortran_runtime_error_at", "_gfortran_os_error_at" => fn runtime_error_at(
        place: *const c_char, format: *const c_char, a: usize, b: usize, c: usize, d: usize
    ) -> ! {
        end(format!("{}: {}", CStr::from_ptr(place).to_string_lossy(), printed(format, [a, b, c, d])))
    }
}

/// Replaces communication between processes, of which there is one: copies its values to the result. The last two
/// digits of a type are its size in bytes.
///
/// # Safety
/// `from` and `to` hold `count` values of the type and may be equal; the other pointers are to integers.
unsafe fn copy_values(from: *const u8, to: *mut u8, count: *const i32, kind: *const i32, error: *mut i32) {
    // SAFETY: guaranteed by the caller.
    unsafe {
        let bytes = usize::try_from(*count).unwrap_or(0) * (*kind % 100) as usize;
        std::ptr::copy(from, to, bytes);
        *error = 0;
    }
}

/// Defines functions that create an array of a kind filled with one value.
macro_rules! array_constructors {
    ($($name:ident($value:ident: $type:ty) => $bytes:expr,)*) => {$(
        unsafe extern "C-unwind" fn $name<const KIND: u8>(id: *const i32, count: *const i32, value: *const $type) -> i64 {
            // SAFETY: the caller passes pointers to numbers.
            let (id, count, $value) = unsafe { (*id, *count, *value) };
            let bytes = $bytes.to_ne_bytes();
            host::new_array((KIND, id), count, bytes.len(), &bytes) as i64
        }
    )*};
}

array_constructors! {
    new_integers(value: i32) => value,
    new_singles(value: f32) => value,
    new_reals(value: f64) => value,
    new_reals_from_single(value: f32) => f64::from(value),
}

/// Creates an array of zeros that outlives the call (ABAQUS 6.14 User Subroutines Reference, 2.1.23 "Allocatable
/// arrays").
unsafe extern "C-unwind" fn new_zeros<const KIND: u8>(id: *const i32, count: *const i32) -> i64 {
    // SAFETY: the caller passes pointers to integers.
    let (id, count) = unsafe { (*id, *count) };
    let width = if KIND < 2 { 4 } else { 8 };
    host::new_array((KIND, id), count, width, &[0; 8][..width]) as i64
}

/// Returns the address of an array; a missing array ends the analysis.
unsafe extern "C-unwind" fn array_place<const KIND: u8>(id: *const i32) -> i64 {
    // SAFETY: the caller passes a pointer to an integer.
    let id = unsafe { *id };
    match host::array((KIND, id)) {
        Some((place, _)) => place as i64,
        None => end(format!("it requested the array {id}, which has not been created")),
    }
}

/// Returns the number of entries of an array; 0 if it does not exist.
unsafe extern "C-unwind" fn array_size<const KIND: u8>(id: *const i32) -> i32 {
    // SAFETY: the caller passes a pointer to an integer.
    host::array((KIND, unsafe { *id })).map_or(0, |array| array.1)
}

unsafe extern "C-unwind" fn delete_array<const KIND: u8>(id: *const i32) {
    // SAFETY: the caller passes a pointer to an integer.
    host::delete_array((KIND, unsafe { *id }));
}

/// Defines the symbols of the arrays of each kind: those in the header of `compile.rs`, and those for C.
macro_rules! array_symbols {
    ($($create:ident: $($kind:literal $name:literal),+;)+) => {$($(
        host_symbols! {
            concat!("rvsma", $kind, "n_") => new_zeros::<$kind>,
            concat!($name, "arrayaccess_") => array_place::<$kind>,
            concat!($name, "arraysize_") => array_size::<$kind>,
            concat!($name, "arraydelete_") => delete_array::<$kind>,
            concat!($name, "arraycreate_") => $create::<$kind>,
        }
    )+)+};
}
macro_rules! real_array_symbols {
    ($($kind:literal $name:literal),+) => {$(
        host_symbols! {
            concat!("rvsma", $kind, "r_") => new_reals_from_single::<$kind>,
            concat!("rvsma", $kind, "d_") => new_reals::<$kind>,
            concat!("rvsma", $kind, "e_") => new_reals::<$kind>,
            concat!("rvsma", $kind, "s_") => new_singles::<$kind>,
            concat!($name, "arraycreatedp_") => new_reals::<$kind>,
            concat!($name, "arraycreatesp_") => new_singles::<$kind>,
        }
    )+};
}

array_symbols! {
    new_integers: 0 "smaint", 1 "smalocalint";
    new_reals: 2 "smafloat", 3 "smalocalfloat", 4 "smareal", 5 "smalocalreal";
}
real_array_symbols! { 2 "smafloat", 3 "smalocalfloat", 4 "smareal", 5 "smalocalreal" }
host_symbols! { "rvsma0i_" => new_integers::<0>, "rvsma1i_" => new_integers::<1> }

/// Formats a message of the Fortran runtime, which uses integers and text only.
///
/// # Safety
/// `format` is null-terminated and refers to `values` only; values of `%s` are null-terminated texts.
unsafe fn printed(format: *const c_char, values: [usize; 4]) -> String {
    // SAFETY: guaranteed by the caller.
    let format = unsafe { CStr::from_ptr(format) }.to_string_lossy().into_owned();
    let mut values = values.into_iter();
    let mut text = String::new();
    let mut remaining = format.as_str();
    while let Some(at) = remaining.find('%') {
        text += &remaining[..at];
        let tail = &remaining[at + 1..];
        let Some(end) = tail.find(|c: char| c.is_alphabetic() && c != 'l' && c != 'z' || c == '%') else { break };
        match (tail.as_bytes()[end], values.next()) {
            // SAFETY: guaranteed by the caller.
            (b's', Some(value)) => text += &unsafe { CStr::from_ptr(value as *const c_char) }.to_string_lossy(),
            (b'd' | b'i' | b'u', Some(value)) => {
                let wide = tail[..end].contains(['l', 'z']);
                let _ = write!(text, "{}", if wide { value as i64 } else { i64::from(value as i32) });
            }
            _ => text.push('%'),
        }
        remaining = &tail[end + 1..];
    }
    text + remaining
}
