//! Shared libraries of the user: opens them and finds the subroutines that they define.
#![allow(unsafe_code)]

use std::path::{Path, PathBuf};
use std::sync::Arc;

use libloading::os::unix::{Library, RTLD_LOCAL, RTLD_NOW};

use super::compile::SharedLibrary;
use super::compiled::{CompiledRoutine, MaterialAxes, RestartFollows, WatchInvalid};
use super::memory::{LibraryMemory, RoutineMemory, bases};
use super::subroutines::{
    FrictionArrays, MaterialArrays, Vdisp, Vdload, Vexternaldb, Vfriction, Vuamp, VuanisohyperInv, Vucharlength,
    Vufield, Vuhard, Vumat, Vusdfld,
};
use super::{PersistentMemory, ROUTINES, Routines, UncallableRoutine, crash, guard, host};
use revolve_diagnostics::whole::ScratchFolder;
use revolve_diagnostics::{Diagnostic, files};

/// Opens libraries and binds the subroutines that they define. Each call returns subroutines with separate variables,
/// so the runs of a sweep share no state. With `watch_invalid` a load that computes with NaN halts the run.
///
/// # Errors
/// If a library cannot be loaded (with the loader's message), or if no subroutine can be called; `given` are the user's
/// files.
pub(super) fn open(
    files: &[SharedLibrary],
    watch_invalid: bool,
    uncallable: &[UncallableRoutine],
    given: &[PathBuf],
) -> Result<Routines, Diagnostic> {
    crash::watch();
    let opened = files.iter().map(open_copy).collect::<Result<Vec<_>, _>>()?;
    let (libraries, parts): (Vec<Library>, Vec<Vec<LibraryMemory>>) = opened.into_iter().unzip();
    let libraries: Arc<[Library]> = libraries.into();
    let memory: Arc<dyn PersistentMemory> =
        Arc::new(RoutineMemory::of(parts.into_iter().flatten().collect(), libraries.clone()));
    let unsupported = UNSUPPORTED.iter().copied().filter(|name| defines(&libraries, name)).collect();
    let mut routines =
        Routines { uncallable: uncallable.to_vec(), unsupported, memory: Some(memory), ..Routines::none() };
    macro_rules! bind {
        ($($name:literal: $function:ty, $work:expr => $with:ident;)*) => {$(
            if uncallable.iter().all(|routine| routine.routine != $name)
                // SAFETY: the symbol has the type given in the manual; sources were checked against it at compilation.
                && let Some(function) = unsafe { find::<$function>(&libraries, $name) }
            {
                routines = routines.$with(CompiledRoutine::new(function, $work, libraries.clone()));
            }
        )*};
    }
    bind! {
        "vdload": Vdload, WatchInvalid(watch_invalid) => with_load;
        "vuamp": Vuamp, () => with_amplitude;
        "vdisp": Vdisp, () => with_motion;
        "vumat": Vumat, MaterialArrays::default() => with_material;
        "vuanisohyper_inv": VuanisohyperInv, () => with_energy;
        "vuhard": Vuhard, () => with_hardening;
        "vusdfld": Vusdfld, MaterialAxes::default() => with_fields;
        "vufield": Vufield, () => with_nodal_fields;
        "vfriction": Vfriction, FrictionArrays::default() => with_friction;
        "vucharlength": Vucharlength, MaterialAxes::default() => with_lengths;
        "vexternaldb": Vexternaldb, RestartFollows::default() => with_events;
    }
    if routines.any() {
        return Ok(routines);
    }
    if let Some(routine) = uncallable.first() {
        let code = if routine.code == "U004" { "U004" } else { "U005" };
        return Err(Diagnostic::error(code, routine.message.clone()));
    }
    Err(nothing_to_call(&routines.unsupported, given))
}

/// Returns the error for files that define no supported subroutine.
fn nothing_to_call(unsupported: &[&str], given: &[PathBuf]) -> Diagnostic {
    let defined: Vec<String> = given.iter().flat_map(|file| subroutines(file)).collect();
    let names: Vec<_> = given.iter().map(|f| format!("`{}`", f.display())).collect();
    let verb = if names.len() == 1 { "defines" } else { "define" };
    let what = if defined.is_empty() { String::new() } else { format!(" but {}", defined.join(", ")) };
    let none = format!("{} {verb} no supported user subroutine{what}", names.join(", "));
    let finding = Diagnostic::error("U006", format!("{none}; supported are {}", ROUTINES.join(", ")));
    match unsupported.first() {
        Some(name) => finding.help(format!("the ABAQUS subroutine `{name}` is not supported")),
        None => finding,
    }
}

/// Returns the names of the first subroutines that a source defines.
fn subroutines(file: &Path) -> Vec<String> {
    let text = files::read(file).map(|bytes| String::from_utf8_lossy(&bytes).to_lowercase()).unwrap_or_default();
    let name = |line: &str| {
        let declaration = line.trim_start().strip_prefix("subroutine ")?.trim_start();
        let name: String = declaration.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
        (!name.is_empty()).then_some(name)
    };
    text.lines().filter_map(name).take(12).collect()
}

/// ABAQUS subroutines that are not supported; files that define one get a note.
const UNSUPPORTED: &[&str] = &[
    "vuanisohyper_strain",
    "vuel",
    "vuinter",
    "vuinteraction",
    "vufluidexch",
    "vuflux",
    "vdflux",
    "vfilm",
    "vfric",
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

/// Returns the unsupported subroutine of this name.
pub(super) fn unsupported(name: &str) -> Option<&'static str> {
    UNSUPPORTED.iter().copied().find(|known| *known == name)
}

fn defines(libraries: &[Library], name: &str) -> bool {
    // SAFETY: the symbol is only looked up, not called.
    unsafe { find::<*const ()>(libraries, name) }.is_some()
}

/// Returns an undefined symbol of a library, if there is one.
pub fn missing(file: &Path) -> Option<String> {
    // SAFETY: the initialisers of the user's library run here, as requested by the user.
    let opened = guard::opening(|| unsafe { Library::open(Some(file), RTLD_NOW | RTLD_LOCAL) });
    // Changes by initialisers are reported when the library is opened for the run.
    guard::restore(|_| {});
    let error = opened.err()?;
    let words = loader_message(&error, file, file);
    let symbol = words.split("undefined symbol: ").nth(1)?;
    Some(symbol.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect())
}

/// Opens a copy of a library with its own SAVE and COMMON variables: the loader opens each file only once.
fn open_copy(library: &SharedLibrary) -> Result<(Library, Vec<LibraryMemory>), Diagnostic> {
    let file = &library.name;
    let fault = |why: String| Diagnostic::error("U005", format!("`{}` cannot be loaded: {why}", file.display()));
    let scratch = ScratchFolder::within(&std::env::temp_dir()).map_err(|e| fault(e.to_string()))?;
    let copy = scratch.path().join("user.so");
    std::fs::write(&copy, &library.bytes).map_err(|e| fault(e.to_string()))?;
    let bases_before = bases();
    // SAFETY: the initialisers of the user's library run here, as requested by the user.
    let opened = guard::opening(|| unsafe { Library::open(Some(&copy), RTLD_NOW | RTLD_LOCAL) });
    guard::restore(|what| host::report_opening(format!("an initialiser of `{}` {what}", file.display())));
    let opened = opened.map_err(|e| fault(undefined(loader_message(&e, &copy, file))))?;
    keep_runtimes();
    Ok((opened, LibraryMemory::of(&copy, file, &library.bytes, &bases_before)))
}

/// Keeps the Fortran and OpenMP runtimes loaded; otherwise every run of a sweep would load them again.
fn keep_runtimes() {
    for name in guard::FORTRAN_RUNTIMES.into_iter().chain([c"libgomp.so.1"]) {
        // SAFETY: RTLD_NOLOAD only affects loaded libraries, so no initialiser runs. The handle is not closed.
        unsafe { libc::dlopen(name.as_ptr(), RTLD_NOW | libc::RTLD_NOLOAD | libc::RTLD_NODELETE) };
    }
}

/// Returns the loader's message, preceded by the name of an undefined symbol.
fn undefined(words: String) -> String {
    match words.split("undefined symbol: ").nth(1) {
        Some(symbol) => {
            let symbol: String = symbol.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
            format!("it calls `{}`, which is not defined ({words})", symbol.trim_end_matches('_'))
        }
        None => words,
    }
}

fn loader_message(error: &libloading::Error, copy: &Path, file: &Path) -> String {
    let mut words = error.to_string();
    let mut source: Option<&dyn std::error::Error> = std::error::Error::source(error);
    while let Some(inner) = source {
        words = format!("{words}: {inner}");
        source = inner.source();
    }
    words.replace(&*copy.display().to_string(), &file.display().to_string())
}

/// Returns the function of this name, in the spelling of Fortran or C.
///
/// # Safety
/// `T` must be the type of the function that has the name.
unsafe fn find<T: Copy>(libraries: &[Library], name: &str) -> Option<T> {
    let spellings = [format!("{name}_"), name.to_owned(), format!("{}_", name.to_uppercase()), name.to_uppercase()];
    libraries.iter().find_map(|library| {
        // SAFETY: guaranteed by the caller.
        spellings.iter().find_map(|s| unsafe { library.get::<T>(s.as_bytes()) }.ok().map(|symbol| *symbol))
    })
}
