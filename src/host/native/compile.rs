//! Compiles Fortran and C files to a shared library. Nothing is written next to the files.

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Output;
use std::time::SystemTime;

use super::cache::{BuildInputs, BuiltLibrary, LibraryCache, search_environment};
use super::fortran::{self, FortranCompiler, rule_into, run};
use super::source::{HEADER, PreparedSource, candidates, included};
use super::symbols::LibrarySymbols;
use super::{MAX_BLOCK, Routines, UncallableRoutine, isolate, library, prototype};
use revolve_diagnostics::digest::hash;
use revolve_diagnostics::{Diagnostic, Diagnostics, files};

/// Flags of C. No warnings, which would hide the errors.
const C_FLAGS: &[&str] = &[
    "-c",
    "-w",
    "-fPIC",
    "-fstack-clash-protection",
    "-O2",
    "-g",
    "-fexceptions",
    "-ffp-contract=off",
    "-fdiagnostics-color=never",
];
/// Shared libraries ready to be opened.
#[derive(Debug)]
pub struct Compiled {
    /// Libraries in the order in which subroutines are searched.
    libraries: Vec<SharedLibrary>,
    /// Notes for the user.
    pub notes: Diagnostics,
    /// Whether a source reads a third coordinate; calls are then monitored for invalid operations.
    third_coordinate: bool,
    /// Subroutines that cannot be called.
    uncallable: Vec<UncallableRoutine>,
    /// The user's files, for messages.
    files: Vec<PathBuf>,
}

/// A shared library in memory, so that exactly the checked bytes are loaded.
#[derive(Debug)]
pub(super) struct SharedLibrary {
    /// Path of the source file, as shown in messages.
    pub name: PathBuf,
    /// Content of the library.
    pub bytes: Vec<u8>,
    identity: String,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum SourceLanguage {
    FixedFortran,
    FreeFortran,
    C,
    Ready,
}

impl Compiled {
    /// Returns the hashes of the libraries: of sources, compiler, flags and all files read, or of the bytes of a
    /// precompiled library.
    pub fn identity(&self) -> String {
        self.libraries.iter().map(|library| library.identity.as_str()).collect::<Vec<_>>().join(" ")
    }

    /// Returns the files as the user has given them.
    pub fn files(&self) -> &[PathBuf] {
        &self.files
    }

    /// Opens the libraries for one run. The variables of the returned subroutines are independent of other runs.
    ///
    /// # Errors
    /// If a library cannot be loaded, or defines no subroutine that can be called.
    pub fn open(&self) -> Result<Routines, Diagnostic> {
        library::open(&self.libraries, self.third_coordinate, &self.uncallable, &self.files)
    }

    /// Opens the libraries in a separate process, forked from this one, which must not have other threads yet.
    ///
    /// # Errors
    /// The errors of [`Compiled::open`]; U012 for subroutines that cannot be isolated.
    pub fn open_isolated(&self) -> Result<Routines, Diagnostic> {
        isolate::open(|| self.open())
    }

    /// Opens the libraries, if there are any.
    ///
    /// # Errors
    /// The errors of [`Compiled::open`].
    pub fn open_any(compiled: Option<&Compiled>) -> Result<Routines, Diagnostic> {
        compiled.map_or(Ok(Routines::none()), Compiled::open)
    }
}

/// Compiles Fortran and C files to one library, and reads precompiled libraries; `checked` compiles with bounds checks.
///
/// # Errors
/// All errors in the files, with the compiler's messages.
pub fn compile(files: &[PathBuf], checked: bool) -> Result<Compiled, Diagnostics> {
    let files: Vec<PathBuf> = files.iter().map(|file| escape_dash(file)).collect();
    let mut faults = Diagnostics::default();
    let mut sources = Vec::new();
    let mut libraries = Vec::new();
    for file in &files {
        match language(file).and_then(|l| readable(file, l)) {
            Ok((SourceLanguage::Ready, bytes)) => {
                let identity = hash([bytes.as_slice()]);
                libraries.push(SharedLibrary { name: file.clone(), bytes, identity });
            }
            Ok((language, _)) => sources.push((file.as_path(), language)),
            Err(message) => faults.push(Diagnostic::error("U001", message)),
        }
    }
    if faults.has_errors() {
        return Err(faults);
    }
    let mut notes = Diagnostics::default();
    remove_included_files(&mut sources, &mut notes);
    let mut uncallable = Vec::new();
    if !sources.is_empty() {
        let BuiltLibrary { bytes, identity, uncallable: found, promoted } = build(&sources, checked, &mut notes)?;
        for file in promoted {
            let message =
                format!("`{}` has reals in single precision; it was compiled in double precision", file.display());
            notes.push(Diagnostic::note("U014", message));
        }
        // Messages name the user's first file.
        libraries.insert(0, SharedLibrary { name: sources[0].0.to_owned(), bytes, identity });
        uncallable = found;
    }
    note_separate_commons(&libraries, &mut notes);
    let third_coordinate = notes.iter().any(|n| n.code == "U008");
    Ok(Compiled { libraries, notes, third_coordinate, uncallable, files })
}

/// Adds a note for each COMMON block or module variable that several libraries define: each has its own copy.
fn note_separate_commons(libraries: &[SharedLibrary], notes: &mut Diagnostics) {
    let mut owners = BTreeMap::<String, BTreeSet<&Path>>::new();
    for library in libraries.iter().filter(|_| libraries.len() > 1) {
        let symbols = LibrarySymbols::read(&library.bytes);
        for variable in symbols.variables.iter().filter(|variable| variable.is_shared_data()) {
            owners.entry(variable.plain_name()).or_default().insert(&library.name);
        }
    }
    for (variable, files) in owners.into_iter().filter(|(_, files)| files.len() > 1) {
        let files: Vec<String> = files.iter().map(|file| format!("`{}`", file.display())).collect();
        let message = format!("{variable} is in {}: each library has its own copy", files.join(" and "));
        notes.push(Diagnostic::note("U015", message).help("to share it, pass the sources in place of the libraries"));
    }
}

/// Returns the path in a form that a compiler does not mistake for an option.
fn escape_dash(file: &Path) -> PathBuf {
    if file.as_os_str().as_encoded_bytes().starts_with(b"-") { Path::new(".").join(file) } else { file.to_owned() }
}

fn language(file: &Path) -> Result<SourceLanguage, String> {
    match file.extension().and_then(|e| e.to_str()).unwrap_or("") {
        "f" | "for" | "F" | "FOR" | "ftn" => Ok(SourceLanguage::FixedFortran),
        "f90" | "F90" | "f95" | "F95" | "f03" | "f08" => Ok(SourceLanguage::FreeFortran),
        "c" => Ok(SourceLanguage::C),
        "so" => Ok(SourceLanguage::Ready),
        _ => Err(format!("`{}`: unknown file type; allowed are .f, .for, .f90, .F, .F90, .c and .so", file.display())),
    }
}

/// Checks that a file can be read; returns the bytes of a library.
fn readable(file: &Path, language: SourceLanguage) -> Result<(SourceLanguage, Vec<u8>), String> {
    let bytes =
        if language == SourceLanguage::Ready { files::read(file) } else { files::open(file).map(|_| Vec::new()) };
    let message = |e| format!("cannot read the user file `{}`: {e}", file.display());
    bytes.map(|bytes| (language, bytes)).map_err(message)
}

fn build(
    sources: &[(&Path, SourceLanguage)],
    checked: bool,
    notes: &mut Diagnostics,
) -> Result<BuiltLibrary, Diagnostics> {
    let fault = |code, message: String| {
        let mut faults = Diagnostics::default();
        faults.push(Diagnostic::error(code, message));
        faults
    };
    for (file, language) in sources {
        if *language == SourceLanguage::FixedFortran {
            let what = |count| format!("text past column 72 is read as code ({count} such lines)");
            note_lines(file, "U007", has_code_past_72, what, notes);
        }
        let what = |_| "the line reads a third coordinate; an axisymmetric model has two, r and z".to_owned();
        note_lines(file, "U008", reads_third_coordinate, what, notes);
    }
    let tools = CompilerSet::find(sources, checked).map_err(|e| fault("U002", e))?;
    let cache = LibraryCache::find().unwrap_or_else(|why| {
        let warning =
            Diagnostic::warning("U011", format!("{why}: the user subroutines are compiled again for this run"));
        notes.push(warning.help("the folder must be owned by you and not writable by others: run `chmod go-w FOLDER`"));
        LibraryCache::none()
    });
    let content = content(sources, &tools, checked);
    let key = key(sources, &content);
    if let Some(built) = cache.get(&key) {
        return Ok(built);
    }
    let io = |e: std::io::Error| fault("U001", format!("cannot write the files for the compiler: {e}"));
    let scratch = cache.scratch_folder().map_err(io)?;
    write_includes(scratch.path()).map_err(io)?;
    let mut builder = LibraryBuilder {
        tools: &tools,
        scratch: scratch.path(),
        checked,
        faults: Diagnostics::default(),
        uncallable: Vec::new(),
        promoted: Vec::new(),
        calls: CallGraph::default(),
        origin: Some(BuildInputs::of(sources.iter().map(|(file, _)| *file), SystemTime::now())),
    };
    let objects: Vec<PathBuf> =
        sources.iter().enumerate().filter_map(|(i, (file, language))| builder.object(i, file, *language)).collect();
    if builder.faults.has_errors() {
        return Err(builder.faults);
    }
    let linked = builder.link(objects)?;
    let bytes = std::fs::read(linked).map_err(io)?;
    let LibraryBuilder { uncallable, promoted, origin, .. } = builder;
    let Some(origin) = origin else {
        let identity = hash([content.as_bytes(), &bytes]);
        return Ok(BuiltLibrary { bytes, identity, uncallable, promoted });
    };
    let identity = hash(std::iter::once(content.as_bytes()).chain(origin.hashes().map(str::as_bytes)));
    let built = BuiltLibrary { bytes, identity, uncallable, promoted };
    // Libraries with undefined functions are not cached: the functions may be installed later.
    if built.uncallable.iter().all(|routine| routine.code != "U005") {
        cache.put(&key, &built, &origin);
    }
    Ok(built)
}

/// The compilers that the sources need, and their versions.
#[derive(Default)]
struct CompilerSet {
    fortran: Option<FortranCompiler>,
    c: OsString,
    version: String,
}

impl CompilerSet {
    fn find(sources: &[(&Path, SourceLanguage)], checked: bool) -> Result<Self, String> {
        let mut tools = CompilerSet::default();
        let mut find = |language, variable, name: &str, install| {
            let program = std::env::var_os(variable).unwrap_or_else(|| name.into());
            let missing = || {
                let program_path = program.display();
                format!(
                    "no {language} compiler: `{program_path}` was not found. Install {install}, or set another \
                     compiler in {variable}"
                )
            };
            let (path, version) = tool_version(&program).ok_or_else(missing)?;
            tools.version += &version;
            Ok::<_, String>((program, path))
        };
        let packages = "gfortran (Debian, Ubuntu: apt install gfortran; Fedora: dnf install gcc-gfortran)";
        if sources.iter().any(|s| s.1 != SourceLanguage::C) {
            let (program, path) = find("Fortran", "FC", "gfortran", packages)?;
            let compiler = FortranCompiler::identify(program, &path)?;
            if checked && compiler.check_flags().is_empty() {
                let shown = compiler.program().display();
                return Err(format!("`{shown}` (FC) cannot check array bounds: --check-user requires gfortran"));
            }
            tools.fortran = Some(compiler);
        }
        if sources.iter().any(|s| s.1 == SourceLanguage::C) {
            tools.c = find("C", "CC", "cc", "gcc (Debian, Ubuntu: apt install gcc)")?.0;
        }
        Ok(tools)
    }

    fn linker(&self) -> &OsString {
        self.fortran.as_ref().map_or(&self.c, FortranCompiler::program)
    }
}

/// Returns the path of a program, and its path, size and modification time, which identify its version without running
/// it; `None` if it does not exist.
fn tool_version(tool: &OsString) -> Option<(PathBuf, String)> {
    let program = |path: PathBuf| path.is_file().then_some(path);
    let path = if Path::new(tool).components().count() > 1 {
        program(PathBuf::from(tool))
    } else {
        std::env::split_paths(&std::env::var_os("PATH")?).find_map(|folder| program(folder.join(tool)))
    }?;
    let path = path.canonicalize().ok()?;
    let metadata = path.metadata().ok()?;
    let version = format!("{} {} {:?}", path.display(), metadata.len(), metadata.modified().ok()?);
    Some((path, version))
}

/// Returns the hash of the inputs known before compilation: sources, their includes, flags, compilers; independent of
/// folders.
fn content(sources: &[(&Path, SourceLanguage)], tools: &CompilerSet, checked: bool) -> String {
    let fortran_flags = tools.fortran.as_ref().map(FortranCompiler::flags);
    let flags = format!("{fortran_flags:?} {C_FLAGS:?} {checked} {:?}", includes_text());
    let mut pieces: Vec<Vec<u8>> =
        [env!("CARGO_PKG_VERSION"), &tools.version, &flags].map(|text| text.as_bytes().to_vec()).into();
    for (file, language) in sources {
        pieces.push(format!("{language:?}").into_bytes());
        add_with_includes(file, file, &mut BTreeSet::new(), &mut |bytes| pieces.push(bytes.to_vec()));
    }
    hash(pieces.iter().map(Vec::as_slice))
}

/// Returns the cache key of a library: the hash of its inputs and of the search paths of the compiler.
fn key(sources: &[(&Path, SourceLanguage)], content: &str) -> String {
    let mut pieces = vec![content.as_bytes().to_vec(), search_environment().into_bytes()];
    for (file, language) in sources {
        pieces.push(std::path::absolute(file).unwrap_or_default().into_os_string().into_encoded_bytes());
        if *language != SourceLanguage::C {
            // The prepared text contains the resolved names of includes.
            let changed = PreparedSource::read(file, &known_includes());
            pieces.extend(changed.texts().map(|text| text.as_bytes().to_vec()));
        }
    }
    hash(pieces.iter().map(Vec::as_slice))
}

fn known_includes() -> Vec<String> {
    includes_text().into_iter().map(|(name, _)| name.to_owned()).collect()
}

/// Passes the content of a file and of its includes to `add`, each once; files that cannot be read are left to the
/// compiler. `main` is the compiled file.
fn add_with_includes(main: &Path, file: &Path, seen: &mut BTreeSet<PathBuf>, add: &mut impl FnMut(&[u8])) {
    let Ok(bytes) = files::read(file) else { return };
    if !seen.insert(file.to_owned()) {
        return;
    }
    add(&bytes);
    let text = String::from_utf8_lossy(&bytes);
    for name in text.lines().filter_map(included) {
        let [main_folder, here] = [main, file].map(|f| f.parent().unwrap_or(Path::new("")));
        if let Some(there) = candidates(main_folder, here, name).into_iter().find(|path| path.is_file()) {
            add_with_includes(main, &there, seen, add);
        }
    }
}

/// Returns the include files of ABAQUS, valid in fixed and in free form (ABAQUS Analysis User's Guide, "User
/// subroutines: overview"; User Subroutines Reference, 2.1.23 "Allocatable arrays" and 2.1.22 "Ensuring thread
/// safety").
fn includes_text() -> Vec<(&'static str, String)> {
    let vaba = format!(
        "!     double precision, two words a real; points a call at most\n\
         \x20     implicit real*8 (a-h,o-z)\n\
         \x20     parameter (j_sys_Dimension = 2)\n\
         \x20     parameter (n_vec_Length = {MAX_BLOCK})\n\
         \x20     parameter (maxblk = n_vec_Length)\n"
    );
    let aba = "!     double precision\n      implicit real*8 (a-h,o-z)\n      parameter (nprecd = 2)\n".to_owned();
    vec![
        ("vaba_param.inc", vaba.clone()),
        ("vaba_param_dp.inc", vaba.clone()),
        ("vaba_param_sp.inc", vaba),
        ("aba_param.inc", aba.clone()),
        ("aba_param_dp.inc", aba),
        (HEADER, header()),
        ("SMAAspUserArrays.hdr", "!     all in SMAAspUserSubroutines.hdr\n".to_owned()),
        ("SMAAspUserUtilities.hdr", "!     all in SMAAspUserSubroutines.hdr\n".to_owned()),
        ("mpif.h", MPI.to_owned()),
    ]
}

/// Returns the interfaces of the functions for arrays and threads. Initial values of real arrays have either precision;
/// the arrays themselves have eight bytes per entry unless SP is in the name.
fn header() -> String {
    let mut text = String::from("!     arrays that outlive a call, and threads, of which there is one\n");
    let mut interface = |generic: &str, specifics: &[(String, &str)]| {
        text += &format!("      interface {generic}\n");
        for (name, value) in specifics {
            let more = if value.is_empty() { "" } else { ", x" };
            text += &format!("        integer*8 function {name}(id, n{more})\n          integer*4 id, n\n");
            if !value.is_empty() {
                text += &format!("          {value} x\n");
            }
            text += "        end function\n";
        }
        text += "      end interface\n";
    };
    for (kind, name) in ["SMAInt", "SMALocalInt"].iter().enumerate() {
        let specifics = [(format!("rvsma{kind}n"), ""), (format!("rvsma{kind}i"), "integer*4")];
        interface(&format!("{name}ArrayCreate"), &specifics);
    }
    for (i, name) in ["SMAFloat", "SMALocalFloat", "SMAReal", "SMALocalReal"].iter().enumerate() {
        let kind = i + 2;
        let specifics =
            [(format!("rvsma{kind}n"), ""), (format!("rvsma{kind}r"), "real*4"), (format!("rvsma{kind}d"), "real*8")];
        interface(&format!("{name}ArrayCreate"), &specifics);
        interface(&format!("{name}ArrayCreateSP"), &[(format!("rvsma{kind}s"), "real*4")]);
        // A different symbol: a scope may declare a function only once.
        interface(&format!("{name}ArrayCreateDP"), &[(format!("rvsma{kind}e"), "real*8")]);
    }
    for name in ["SMAInt", "SMALocalInt", "SMAFloat", "SMALocalFloat", "SMAReal", "SMALocalReal"] {
        text += &format!("      integer*8 {name}ArrayAccess\n      integer*4 {name}ArraySize\n");
        text += &format!("      external {name}ArrayAccess, {name}ArraySize, {name}ArrayDelete\n");
    }
    text + "      integer*4 getnumthreads, get_thread_id, getcommunicator\n\
            \x20     external getnumthreads, get_thread_id, getcommunicator\n"
}

/// MPI constants for one process; the last two digits of a type are its size in bytes.
const MPI: &str = "!     one process
      integer MPI_COMM_WORLD, MPI_COMM_SELF, MPI_SUCCESS
      integer MPI_STATUS_SIZE, MPI_INTEGER, MPI_INTEGER4, MPI_INTEGER8
      integer MPI_LOGICAL, MPI_REAL, MPI_REAL4, MPI_REAL8
      integer MPI_DOUBLE_PRECISION, MPI_CHARACTER, MPI_BYTE
      integer MPI_SUM, MPI_PROD, MPI_MAX, MPI_MIN, MPI_LAND, MPI_LOR
      parameter (MPI_COMM_WORLD = 0, MPI_COMM_SELF = 1)
      parameter (MPI_SUCCESS = 0, MPI_STATUS_SIZE = 6)
      parameter (MPI_INTEGER = 104, MPI_INTEGER4 = 104)
      parameter (MPI_INTEGER8 = 108, MPI_LOGICAL = 204)
      parameter (MPI_REAL = 304, MPI_REAL4 = 304, MPI_REAL8 = 308)
      parameter (MPI_DOUBLE_PRECISION = 308)
      parameter (MPI_CHARACTER = 401, MPI_BYTE = 501)
      parameter (MPI_SUM = 1, MPI_PROD = 2, MPI_MAX = 3, MPI_MIN = 4)
      parameter (MPI_LAND = 5, MPI_LOR = 6)
      real*8 mpi_wtime
      external mpi_wtime
";

fn write_includes(folder: &Path) -> std::io::Result<()> {
    for (name, text) in includes_text() {
        std::fs::write(folder.join(name), &text)?;
        std::fs::write(folder.join(name.to_ascii_uppercase()), &text)?;
    }
    Ok(())
}

/// Calls between functions, by symbol names.
#[derive(Default)]
struct CallGraph(Vec<(String, String)>);

impl CallGraph {
    /// Adds the output of `-fcallgraph-info`: lines `edge: { sourcename: "a" targetname: "b" … }`; some names are
    /// preceded by a file and a colon.
    fn read(&mut self, text: &str) {
        let name = |line: &str, key: &str| {
            let quoted = line.split(key).nth(1)?.split('"').nth(1)?;
            Some(quoted.rsplit(':').next().unwrap_or(quoted).to_owned())
        };
        let edge = |line: &str| Some((name(line, "sourcename:")?, name(line, "targetname:")?));
        self.0.extend(text.lines().filter(|l| l.starts_with("edge:")).filter_map(edge));
    }

    /// Returns whether a function calls another, directly or indirectly.
    fn reaches(&self, from: &str, to: &str) -> bool {
        let mut reached = vec![from];
        let mut next = 0;
        while let Some(at) = reached.get(next).copied() {
            next += 1;
            for (_, target) in self.0.iter().filter(|(source, _)| source == at) {
                if target == to {
                    return true;
                }
                if !reached.contains(&target.as_str()) {
                    reached.push(target);
                }
            }
        }
        false
    }
}

struct LibraryBuilder<'a> {
    tools: &'a CompilerSet,
    scratch: &'a Path,
    checked: bool,
    faults: Diagnostics,
    uncallable: Vec<UncallableRoutine>,
    promoted: Vec<PathBuf>,
    calls: CallGraph,
    /// Files that the compiler read; `None` if not all are known.
    origin: Option<BuildInputs>,
}

impl LibraryBuilder<'_> {
    /// Compiles one file; on failure records an error and returns `None`.
    fn object(&mut self, index: usize, file: &Path, language: SourceLanguage) -> Option<PathBuf> {
        let object = self.scratch.join(format!("{index}.o"));
        match language {
            SourceLanguage::C => {
                let mut arguments = self.arguments((file, file), &object, C_FLAGS);
                arguments.extend(rule_into(&object));
                let output = run(&self.tools.c, &arguments);
                let made = self.check_output(file, output);
                self.record_inputs(file, &object);
                made.then_some(object)
            }
            _ => {
                let written = PreparedSource::read(file, &known_includes())
                    .write(file, &self.scratch.join(format!("source{index}")));
                match written {
                    Ok(ready) => self.fortran((file, &ready), &object, language).then_some(object),
                    Err(error) => {
                        self.faults.push(Diagnostic::error("U001", format!("`{}`: {error}", file.display())));
                        None
                    }
                }
            }
        }
    }

    /// Records the files that the compiler read for an object.
    fn record_inputs(&mut self, file: &Path, object: &Path) {
        let recorded = |origin: &mut BuildInputs| {
            let rule = std::fs::read_to_string(object.with_extension("d")).ok()?;
            origin.add(&rule, folder_of(file), self.scratch)
        };
        if self.origin.as_mut().and_then(recorded).is_none() {
            self.origin = None;
        }
    }

    /// Returns the compiler arguments for a user file and its prepared copy.
    fn arguments(&self, (file, ready): (&Path, &Path), object: &Path, flags: &[&str]) -> Vec<OsString> {
        let mut list: Vec<OsString> = flags.iter().map(OsString::from).collect();
        for include in [folder_of(ready), folder_of(file), self.scratch] {
            list.extend(["-I".into(), include.into()]);
        }
        list.extend([ready.into(), "-o".into(), object.into()]);
        list
    }

    /// Compiles in both source forms, that of the file extension first; then checks the arguments of known subroutines.
    fn fortran(&mut self, (file, ready): (&Path, &Path), object: &Path, language: SourceLanguage) -> bool {
        let Some(compiler) = &self.tools.fortran else { return false };
        let mut forms = ["-ffixed-form", "-ffree-form"];
        if language == SourceLanguage::FreeFortran {
            forms.reverse();
        }
        let mut failures = Vec::new();
        for form in forms {
            let checks = if self.checked { compiler.check_flags() } else { &[] };
            let flags = [compiler.flags(), &[form], checks].concat();
            let mut arguments = self.arguments((file, ready), object, &flags);
            arguments.extend(["-J".into(), self.scratch.into()]);
            match compile_fortran(compiler, object, arguments) {
                Ok(compiled) => {
                    self.accept_object(file, object, &compiled);
                    return true;
                }
                Err(output) => failures.push(output),
            }
        }
        let errors = |o: &std::io::Result<Output>| {
            o.as_ref()
                .map_or(usize::MAX, |o| String::from_utf8_lossy(&o.stderr).to_lowercase().matches("error:").count())
        };
        let best = failures.into_iter().min_by_key(errors);
        best.is_some_and(|output| self.check_output(file, output))
    }

    /// Records what a compiled file calls, reads and defines.
    fn accept_object(&mut self, file: &Path, object: &Path, compiled: &CompiledFortran) {
        if compiled.promoted {
            self.promoted.push(file.to_owned());
        }
        self.calls.read(&std::fs::read_to_string(object.with_extension("ci")).unwrap_or_default());
        self.record_inputs(file, object);
        for (routine, difference) in prototype::check(&compiled.prototypes) {
            let message = format!("{}: {difference}", file.display());
            self.uncallable.push(UncallableRoutine { routine, code: "U004".into(), message });
        }
    }

    fn check_output(&mut self, file: &Path, output: std::io::Result<Output>) -> bool {
        let errors = match output {
            Ok(output) if output.status.success() => return true,
            Ok(output) => String::from_utf8_lossy(&output.stderr).trim().to_owned(),
            Err(error) => error.to_string(),
        };
        let message = format!("`{}` does not compile:\n{}", file.display(), shortened(&errors));
        self.faults.push(Diagnostic::error("U003", message));
        false
    }

    /// Links the objects, with LAPACK if a symbol is undefined without it. Calls of functions that remain undefined end
    /// the analysis, and subroutines that reach them cannot be called.
    fn link(&mut self, mut objects: Vec<PathBuf>) -> Result<PathBuf, Diagnostics> {
        let mut library = self.linked(&objects, &[])?;
        let Some(mut missing) = library::missing(&library) else { return Ok(library) };
        let sets: [&[&str]; 3] = [&["-llapack", "-lblas"], &["-lopenblas"], &["-l:liblapack.so.3", "-l:libblas.so.3"]];
        let mut more: &[&str] = &[];
        for set in sets {
            let quiet = self.link_to("lapack.so", &objects, set);
            let linked = quiet.ok().filter(|(output, _)| output.status.success());
            if let Some((_, path)) = linked
                && library::missing(&path).is_none_or(|still| still != missing)
            {
                (library, more) = (path, set);
                break;
            }
        }
        for _ in 0..100 {
            missing = match library::missing(&library) {
                Some(missing) => missing,
                None => return Ok(library),
            };
            let Some(stub) = self.stub(&missing, objects.len()) else { return Ok(library) };
            self.note_missing(&missing);
            objects.push(stub);
            library = self.linked(&objects, more)?;
        }
        Ok(library)
    }

    /// Records the subroutines that reach an undefined symbol.
    fn note_missing(&mut self, missing: &str) {
        let name = missing.trim_end_matches('_');
        for routine in super::ROUTINES {
            if self.calls.reaches(&format!("{routine}_"), missing) || self.calls.reaches(routine, missing) {
                let message = format!("{routine} calls `{name}`, which is not defined");
                self.uncallable.push(UncallableRoutine {
                    routine: (*routine).to_owned(),
                    code: "U005".into(),
                    message,
                });
            }
        }
    }

    /// Compiles a replacement of an undefined symbol that ends the analysis; `None` without a Fortran compiler.
    fn stub(&self, symbol: &str, index: usize) -> Option<PathBuf> {
        let compiler = self.tools.fortran.as_ref()?;
        let (file, object) =
            (self.scratch.join(format!("stub{index}.f90")), self.scratch.join(format!("stub{index}.o")));
        let name = symbol.trim_end_matches('_');
        let text = format!(
            "subroutine stub() bind(C, name=\"{symbol}\")\n  external rvmissing\n  call rvmissing('{name}')\nend subroutine\n"
        );
        std::fs::write(&file, text).ok()?;
        let mut arguments: Vec<OsString> = compiler.flags().iter().map(OsString::from).collect();
        arguments.extend([file.into(), "-o".into(), object.clone().into()]);
        run(compiler.program(), &arguments).ok().filter(|o| o.status.success())?;
        Some(object)
    }

    fn link_to(&self, name: &str, objects: &[PathBuf], more: &[&str]) -> std::io::Result<(Output, PathBuf)> {
        let library = self.scratch.join(name);
        // -Bsymbolic: the user's definitions take precedence over those of the program.
        let mut arguments: Vec<OsString> = vec!["-shared".into(), "-Wl,-Bsymbolic".into()];
        arguments.extend(objects.iter().map(Into::into));
        arguments.extend(more.iter().map(OsString::from));
        arguments.extend(self.tools.fortran.iter().flat_map(|compiler| compiler.link_flags()).map(OsString::from));
        arguments.extend(["-o".into(), library.clone().into()]);
        let output = run(self.tools.linker(), &arguments)?;
        Ok((output, library))
    }

    fn linked(&mut self, objects: &[PathBuf], more: &[&str]) -> Result<PathBuf, Diagnostics> {
        let name = format!("user{}.so", objects.len());
        let (output, library) = match self.link_to(&name, objects, more) {
            Ok((output, library)) => (Ok(output), library),
            Err(error) => (Err(error), PathBuf::new()),
        };
        if self.check_output(Path::new("the files together"), output) {
            return Ok(library);
        }
        Err(std::mem::take(&mut self.faults))
    }
}

/// A Fortran file that was compiled.
struct CompiledFortran {
    prototypes: String,
    /// Whether it was compiled in double precision in place of single precision.
    promoted: bool,
}

/// Compiles a Fortran file; in double precision if it mixes single precision with that of the calls.
///
/// # Errors
/// The output of the compiler, or why it cannot be started.
fn compile_fortran(
    compiler: &FortranCompiler,
    object: &Path,
    arguments: Vec<OsString>,
) -> Result<CompiledFortran, std::io::Result<Output>> {
    let output = compiler.compile(object, &arguments);
    let succeeds = |output: &std::io::Result<Output>| output.as_ref().is_ok_and(|o| o.status.success());
    let is_mixed = if succeeds(&output) {
        let interfaces = compiler.interfaces(&arguments);
        if !interfaces.mixes_precision && !prototype::has_single_precision(&interfaces.prototypes) {
            return Ok(CompiledFortran { prototypes: interfaces.prototypes, promoted: false });
        }
        true
    } else {
        output.as_ref().is_ok_and(|o| fortran::mentions_single(&String::from_utf8_lossy(&o.stderr)))
    };
    if !is_mixed {
        return Err(output);
    }
    let arguments = compiler.promoted(&arguments);
    let in_double = compiler.compile(object, &arguments);
    if !succeeds(&in_double) {
        return Err(if succeeds(&output) { in_double } else { output });
    }
    Ok(CompiledFortran { prototypes: compiler.interfaces(&arguments).prototypes, promoted: true })
}

fn folder_of(file: &Path) -> &Path {
    file.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Returns the first lines of a message.
fn shortened(text: &str) -> String {
    const LINES: usize = 30;
    let lines: Vec<&str> = text.lines().collect();
    if lines.len() <= LINES {
        return text.to_owned();
    }
    format!("{}\n… and {} more lines", lines[..LINES].join("\n"), lines.len() - LINES)
}

/// Removes files that another one includes; they are compiled with it.
fn remove_included_files(sources: &mut Vec<(&Path, SourceLanguage)>, notes: &mut Diagnostics) {
    let real = |file: &Path| file.canonicalize().unwrap_or_else(|_| file.to_owned());
    let includes = |file: &Path| {
        let mut seen = BTreeSet::new();
        add_with_includes(file, file, &mut seen, &mut |_| {});
        seen.iter().filter(|other| *other != file).map(|other| real(other)).collect::<Vec<_>>()
    };
    let included_files: Vec<(&Path, Vec<PathBuf>)> = sources.iter().map(|(file, _)| (*file, includes(file))).collect();
    sources.retain(|(file, _)| {
        let source_file = real(file);
        // Of two files that include each other, the first is kept.
        let earlier = |other: &Path| !included_files.iter().any(|(f, list)| f == file && list.contains(&real(other)));
        let Some((other, _)) =
            included_files.iter().find(|(other, list)| list.contains(&source_file) && earlier(other))
        else {
            return true;
        };
        let message = format!("`{}` is included by `{}`, and compiled with it", file.display(), other.display());
        notes.push(Diagnostic::note("U010", message));
        false
    });
}

/// Adds a note for the first line of a file with a property, with the number of such lines.
fn note_lines(
    file: &Path,
    code: &'static str,
    has: fn(&str) -> bool,
    what: fn(usize) -> String,
    notes: &mut Diagnostics,
) {
    let text = files::read(file).map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).unwrap_or_default();
    let mut lines = text.lines().zip(1..).filter(|(line, _)| has(line));
    if let Some((_, first)) = lines.next() {
        let message = format!("{}:{first}: {}", file.display(), what(1 + lines.count()));
        notes.push(Diagnostic::note(code, message));
    }
}

/// Returns whether code on a line reads `curCoords(k,3)` or `velocity(k,3)`.
fn reads_third_coordinate(line: &str) -> bool {
    if line.starts_with(['c', 'C', '*', '!']) {
        return false;
    }
    let code: String =
        line.split('!').next().unwrap_or("").chars().filter(|c| !c.is_whitespace()).collect::<String>().to_lowercase();
    ["curcoords(", "velocity("].iter().any(|name| {
        code.match_indices(name).any(|(at, _)| {
            let inside = code[at + name.len()..].split(')').next().unwrap_or("");
            inside.rsplit_once(',').is_some_and(|(_, index)| index == "3")
        })
    })
}

fn has_code_past_72(line: &str) -> bool {
    if line.starts_with(['c', 'C', 'd', 'D', '*', '!', '#']) {
        return false;
    }
    let code = line.split('!').next().unwrap_or(line);
    code.chars().skip(72).any(|c| !c.is_whitespace())
}

#[cfg(test)]
mod tests {
    use super::{CallGraph, has_code_past_72, reads_third_coordinate};

    #[test]
    fn indirect_calls_are_found() {
        let mut calls = CallGraph::default();
        calls.read("graph: { title: \"t.f\"\nedge: { sourcename: \"vumat_\" targetname: \"t.f:b\" label: \"t.f:4:72\" }\nedge: { sourcename: \"t.f:b\" targetname: \"q_\" label: \"x\" }\n");
        assert!(calls.reaches("vumat_", "q_") && calls.reaches("b", "q_") && !calls.reaches("q_", "b"));
    }

    #[test]
    fn third_coordinate_is_detected_only_in_code() {
        assert!(reads_third_coordinate("        z = CurCoords ( k , 3 )"));
        assert!(reads_third_coordinate("\tif (velocity(k,3)<0.) then"));
        assert!(!reads_third_coordinate("C       z = curCoords(k,3)"));
        assert!(!reads_third_coordinate("        z = curCoords(k,2) ! not curCoords(k,3)"));
        assert!(!reads_third_coordinate("      dimension curCoords(nblock,ndim)"));
    }

    #[test]
    fn long_comments_are_ignored() {
        let tail = "x".repeat(80);
        assert!(!has_code_past_72(&format!("C {tail}")));
        assert!(!has_code_past_72(&format!("      a = 1 ! {tail}")));
        assert!(has_code_past_72(&format!("      a = {tail}")));
    }
}
