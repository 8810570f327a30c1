//! Fortran and C files to a shared library. Nothing is written beside the files.
//! Never here: where libraries are kept, opening a library, calling it.

use std::collections::BTreeSet;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::SystemTime;

use super::cache::{Built, Cache, Origin, surroundings};
use super::source::{HEADER, Source, candidates, included};
use super::{MAX_BLOCK, Misfit, Routines, isolate, library, prototype};
use crate::deck::{Diagnostic, Diagnostics, files};
use crate::output::checkpoint::hash;

/// Flags as ABAQUS's own compile command sets them for its compilers: long lines, no complaint about old Fortran nor
/// about DEC's (Cray pointers, structures, lines with D as comments), local arrays on the stack. No contraction, so that the same arithmetic gives the same bits as in Rust.
const FORTRAN_FLAGS: &[&str] = &[
    "-c",
    "-fPIC",
    "-cpp",
    "-std=legacy",
    "-fallow-argument-mismatch",
    "-fdec",
    "-frecursive",
    "-O2",
    "-g",
    "-fbacktrace",
    "-fexceptions",
    "-ffp-contract=off",
    "-ffixed-line-length-none",
    "-ffree-line-length-none",
    "-fdiagnostics-color=never",
];
const C_FLAGS: &[&str] =
    &["-c", "-fPIC", "-O2", "-g", "-fexceptions", "-ffp-contract=off", "-fdiagnostics-color=never"];
/// `--check-user`.
const CHECK_FLAGS: &[&str] = &["-fcheck=bounds,do,mem,pointer"];

/// Shared libraries ready to be opened.
#[derive(Debug)]
pub struct Compiled {
    /// In the order in which they are searched for routines.
    libraries: Vec<Ready>,
    /// What the user should know.
    pub notes: Diagnostics,
    /// Whether a source reads a third coordinate: calls are then watched for invalid operations.
    third_coordinate: bool,
    /// Routines that cannot be called as they are.
    misfits: Vec<Misfit>,
    /// The user's files, for messages.
    files: Vec<PathBuf>,
}

/// A shared library in memory: what was looked at is what is loaded, whatever becomes of the file.
#[derive(Debug)]
pub(super) struct Ready {
    /// What messages call it.
    pub name: PathBuf,
    /// The library itself.
    pub bytes: Vec<u8>,
    identity: String,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Language {
    FixedFortran,
    FreeFortran,
    C,
    Ready,
}

impl Compiled {
    /// What decides on the routines: of sources a hash of all that they were made of (texts, flags, compiler, files that it
    /// read), of ready libraries one of their bytes.
    pub fn identity(&self) -> String {
        self.libraries.iter().map(|library| library.identity.as_str()).collect::<Vec<_>>().join(" ")
    }

    /// Opens the libraries: routines with a state of their own, for one run.
    ///
    /// # Errors
    /// Where a library cannot be loaded, or a routine in it cannot be called.
    pub fn open(&self) -> Result<Routines, Diagnostic> {
        library::open(&self.libraries, self.third_coordinate, &self.misfits, &self.files)
    }

    /// The same in a process of their own, made of this one, which must have no other threads yet.
    ///
    /// # Errors
    /// As [`Compiled::open`]; routines that cannot be called over there are refused (U012).
    pub fn open_isolated(&self) -> Result<Routines, Diagnostic> {
        isolate::open(|| self.open())
    }

    /// The same where there may be no files: then there are no routines.
    ///
    /// # Errors
    /// As [`Compiled::open`].
    pub fn open_any(compiled: Option<&Compiled>) -> Result<Routines, Diagnostic> {
        compiled.map_or(Ok(Routines::none()), Compiled::open)
    }
}

/// Makes libraries of user files; `checked` builds with bounds checks.
///
/// # Errors
/// All that is wrong with the files, in the compiler's words where they are the best.
pub fn compile(files: &[PathBuf], checked: bool) -> Result<Compiled, Diagnostics> {
    let files: Vec<PathBuf> = files.iter().map(|file| no_option(file)).collect();
    let mut faults = Diagnostics::default();
    let mut sources = Vec::new();
    let mut libraries = Vec::new();
    for file in &files {
        match language(file).and_then(|l| readable(file, l)) {
            Ok((Language::Ready, bytes)) => {
                let identity = hash([bytes.as_slice()]);
                libraries.push(Ready { name: file.clone(), bytes, identity });
            }
            Ok((language, _)) => sources.push((file.as_path(), language)),
            Err(message) => faults.push(Diagnostic::error("U001", message)),
        }
    }
    if faults.has_errors() {
        return Err(faults);
    }
    let mut notes = Diagnostics::default();
    leave_to_includes(&mut sources, &mut notes);
    let mut misfits = Vec::new();
    if !sources.is_empty() {
        let Built { bytes, identity, misfits: found } = build(&sources, checked, &mut notes)?;
        // Messages speak of the user's own file.
        libraries.insert(0, Ready { name: sources[0].0.to_owned(), bytes, identity });
        misfits = found;
    }
    let third_coordinate = notes.iter().any(|n| n.code == "U008");
    Ok(Compiled { libraries, notes, third_coordinate, misfits, files })
}

/// A name that no compiler takes for an option.
fn no_option(file: &Path) -> PathBuf {
    if file.as_os_str().as_encoded_bytes().starts_with(b"-") { Path::new(".").join(file) } else { file.to_owned() }
}

fn language(file: &Path) -> Result<Language, String> {
    match file.extension().and_then(|e| e.to_str()).unwrap_or("") {
        "f" | "for" | "F" | "FOR" | "ftn" => Ok(Language::FixedFortran),
        "f90" | "F90" | "f95" | "F95" | "f03" | "f08" => Ok(Language::FreeFortran),
        "c" => Ok(Language::C),
        "so" => Ok(Language::Ready),
        _ => Err(format!("`{}`: .f, .for, .f90, .F, .F90, .c and .so are taken", file.display())),
    }
}

/// The bytes of a library, nothing of a source.
fn readable(file: &Path, language: Language) -> Result<(Language, Vec<u8>), String> {
    let bytes = if language == Language::Ready { files::read(file) } else { files::open(file).map(|_| Vec::new()) };
    let told = |e| format!("cannot read the user file `{}`: {e}", file.display());
    bytes.map(|bytes| (language, bytes)).map_err(told)
}

fn build(sources: &[(&Path, Language)], checked: bool, notes: &mut Diagnostics) -> Result<Built, Diagnostics> {
    let fault = |code, message: String| {
        let mut faults = Diagnostics::default();
        faults.push(Diagnostic::error(code, message));
        faults
    };
    for (file, language) in sources {
        if *language == Language::FixedFortran {
            note_long_lines(file, notes);
        }
        note_third_coordinate(file, notes);
    }
    let tools = Tools::find(sources).map_err(|e| fault("U002", e))?;
    let cache = Cache::find().unwrap_or_else(|why| {
        let warning = Diagnostic::warning("U011", format!("{why}: the routines are compiled anew for this run"));
        notes.push(warning.help("let it belong to you, and take the right to write from others: chmod go-w"));
        Cache::none()
    });
    let content = content(sources, &tools, checked);
    let key = key(sources, &content);
    if let Some(built) = cache.get(&key) {
        return Ok(built);
    }
    let io = |e: std::io::Error| fault("U001", format!("cannot write what the compiler needs: {e}"));
    let scratch = cache.workshop().map_err(io)?;
    write_includes(scratch.path()).map_err(io)?;
    let mut builder = Builder {
        tools: &tools,
        scratch: scratch.path(),
        checked,
        faults: Diagnostics::default(),
        misfits: Vec::new(),
        calls: Calls::default(),
        origin: Some(Origin::of(sources.iter().map(|(file, _)| *file), SystemTime::now())),
    };
    let objects: Vec<PathBuf> =
        sources.iter().enumerate().filter_map(|(i, (file, language))| builder.object(i, file, *language)).collect();
    if builder.faults.has_errors() {
        return Err(builder.faults);
    }
    let linked = builder.link(objects)?;
    let bytes = std::fs::read(linked).map_err(io)?;
    let Builder { misfits, origin, .. } = builder;
    let Some(origin) = origin else {
        let identity = hash([content.as_bytes(), &bytes]);
        return Ok(Built { bytes, identity, misfits });
    };
    let identity = hash(std::iter::once(content.as_bytes()).chain(origin.hashes().map(str::as_bytes)));
    let built = Built { bytes, identity, misfits };
    // What was missing may be installed tomorrow.
    if built.misfits.iter().all(|misfit| misfit.code != "U005") {
        cache.put(&key, &built, &origin);
    }
    Ok(built)
}

/// The compilers, and what they call themselves.
struct Tools {
    fortran: Option<OsString>,
    c: OsString,
    version: String,
}

impl Tools {
    fn find(sources: &[(&Path, Language)]) -> Result<Self, String> {
        let named = |variable: &str, default: &str| std::env::var_os(variable).unwrap_or_else(|| default.into());
        let (fortran, c) = (named("FC", "gfortran"), named("CC", "cc"));
        let mut version = String::new();
        let wants_fortran = sources.iter().any(|s| s.1 != Language::C);
        if wants_fortran {
            version += &tool_version(&fortran).ok_or_else(|| {
                format!(
                    "no Fortran compiler: `{}` does not run. Install gfortran (Debian, Ubuntu: apt install gfortran; \
                     Fedora: dnf install gcc-gfortran), or name another in FC",
                    fortran.display()
                )
            })?;
        }
        if sources.iter().any(|s| s.1 == Language::C) {
            version += &tool_version(&c).ok_or_else(|| {
                format!(
                    "no C compiler: `{}` does not run. Install gcc (Debian, Ubuntu: apt install gcc), or name another in CC",
                    c.display()
                )
            })?;
        }
        Ok(Tools { fortran: wants_fortran.then_some(fortran), c, version })
    }
}

/// Which program a name stands for, and which build of it: asking a compiler for its version would take longer than the
/// rest of a small job. `None` if there is none.
fn tool_version(tool: &OsString) -> Option<String> {
    let program = |path: PathBuf| path.is_file().then_some(path);
    let found = if Path::new(tool).components().count() > 1 {
        program(PathBuf::from(tool))
    } else {
        std::env::split_paths(&std::env::var_os("PATH")?).find_map(|folder| program(folder.join(tool)))
    }?;
    let found = found.canonicalize().ok()?;
    let metadata = found.metadata().ok()?;
    Some(format!("{} {} {:?}", found.display(), metadata.len(), metadata.modified().ok()?))
}

/// Hash of what the library is made of as far as it is known before the compiler ran: sources, what their lines include,
/// flags, compilers. Where they are does not matter.
fn content(sources: &[(&Path, Language)], tools: &Tools, checked: bool) -> String {
    let flags = format!("{FORTRAN_FLAGS:?} {C_FLAGS:?} {checked} {:?}", includes_text());
    let mut pieces: Vec<Vec<u8>> =
        [env!("CARGO_PKG_VERSION"), &tools.version, &flags].map(|text| text.as_bytes().to_vec()).into();
    for (file, language) in sources {
        pieces.push(format!("{language:?}").into_bytes());
        add_with_includes(file, file, &mut BTreeSet::new(), &mut |bytes| pieces.push(bytes.to_vec()));
    }
    hash(pieces.iter().map(Vec::as_slice))
}

/// Under which a library is kept: its content, and where the compiler looks for the rest of it.
fn key(sources: &[(&Path, Language)], content: &str) -> String {
    let mut pieces = vec![content.as_bytes().to_vec(), surroundings().into_bytes()];
    for (file, language) in sources {
        pieces.push(std::path::absolute(file).unwrap_or_default().into_os_string().into_encoded_bytes());
        if *language != Language::C {
            // Includes that are found in another case, or in another folder, stand in it.
            let changed = Source::read(file, &known_includes());
            pieces.extend(changed.texts().map(|text| text.as_bytes().to_vec()));
        }
    }
    hash(pieces.iter().map(Vec::as_slice))
}

fn known_includes() -> Vec<String> {
    includes_text().into_iter().map(|(name, _)| name.to_owned()).collect()
}

/// A file and those it includes, each once; what cannot be read is the compiler's to tell. `main` is what is compiled.
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

/// The files that ABAQUS's compile command finds, valid in fixed and in free form. (What the parameters must define is in the
/// ABAQUS Analysis User's Guide, "User subroutines: overview": double precision, and the block length. The functions of arrays
/// and threads are those of the User Subroutines Reference, 2.1.23 "Allocatable arrays" and 2.1.22 "Ensuring thread safety".)
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
        ("mpif.h", mpi()),
    ]
}

/// Interfaces of the functions of arrays and threads; reals begin with a number of either precision, and have eight bytes
/// unless SP is asked for.
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
        // Of another name: a scope may describe a function once.
        interface(&format!("{name}ArrayCreateDP"), &[(format!("rvsma{kind}e"), "real*8")]);
    }
    for name in ["SMAInt", "SMALocalInt", "SMAFloat", "SMALocalFloat", "SMAReal", "SMALocalReal"] {
        text += &format!("      integer*8 {name}ArrayAccess\n      integer*4 {name}ArraySize\n");
        text += &format!("      external {name}ArrayAccess, {name}ArraySize, {name}ArrayDelete\n");
    }
    text + "      integer*4 getnumthreads, get_thread_id, getcommunicator\n\
            \x20     external getnumthreads, get_thread_id, getcommunicator\n"
}

/// What a program of one process needs of MPI; the last two digits of a type are its bytes.
fn mpi() -> String {
    let numbers = [
        ("MPI_COMM_WORLD", 0),
        ("MPI_COMM_SELF", 1),
        ("MPI_SUCCESS", 0),
        ("MPI_STATUS_SIZE", 6),
        ("MPI_INTEGER", 104),
        ("MPI_INTEGER4", 104),
        ("MPI_INTEGER8", 108),
        ("MPI_LOGICAL", 204),
        ("MPI_REAL", 304),
        ("MPI_REAL4", 304),
        ("MPI_REAL8", 308),
        ("MPI_DOUBLE_PRECISION", 308),
        ("MPI_CHARACTER", 401),
        ("MPI_BYTE", 501),
        ("MPI_SUM", 1),
        ("MPI_PROD", 2),
        ("MPI_MAX", 3),
        ("MPI_MIN", 4),
        ("MPI_LAND", 5),
        ("MPI_LOR", 6),
    ];
    let number = |(name, value): (&str, i32)| format!("      integer {name}\n      parameter ({name} = {value})\n");
    let numbers: String = numbers.into_iter().map(number).collect();
    format!("!     one process\n{numbers}      real*8 mpi_wtime\n      external mpi_wtime\n")
}

fn write_includes(folder: &Path) -> std::io::Result<()> {
    for (name, text) in includes_text() {
        std::fs::write(folder.join(name), &text)?;
        std::fs::write(folder.join(name.to_ascii_uppercase()), &text)?;
    }
    Ok(())
}

/// Which function calls which, by the names of their symbols.
#[derive(Default)]
struct Calls(Vec<(String, String)>);

impl Calls {
    /// Reads what `-fcallgraph-info` writes: lines `edge: { sourcename: "a" targetname: "b" … }`, some names with a file
    /// before a colon.
    fn read(&mut self, text: &str) {
        let name = |line: &str, key: &str| {
            let quoted = line.split(key).nth(1)?.split('"').nth(1)?;
            Some(quoted.rsplit(':').next().unwrap_or(quoted).to_owned())
        };
        let edge = |line: &str| Some((name(line, "sourcename:")?, name(line, "targetname:")?));
        self.0.extend(text.lines().filter(|l| l.starts_with("edge:")).filter_map(edge));
    }

    /// Whether a function leads to another.
    fn lead(&self, from: &str, to: &str) -> bool {
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

struct Builder<'a> {
    tools: &'a Tools,
    scratch: &'a Path,
    checked: bool,
    faults: Diagnostics,
    misfits: Vec<Misfit>,
    calls: Calls,
    /// What the compiler read; `None` once that cannot be followed.
    origin: Option<Origin>,
}

impl Builder<'_> {
    /// Compiles one file; `None` if that failed (told).
    fn object(&mut self, index: usize, file: &Path, language: Language) -> Option<PathBuf> {
        let object = self.scratch.join(format!("{index}.o"));
        match language {
            Language::C => {
                let mut arguments = self.arguments((file, file), &object, C_FLAGS, None);
                arguments.extend(rule_into(&object));
                let output = run(&self.tools.c, &arguments);
                let made = self.judge(file, output);
                self.follow(file, &object);
                made.then_some(object)
            }
            _ => {
                let written =
                    Source::read(file, &known_includes()).write(file, &self.scratch.join(format!("source{index}")));
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

    /// Keeps account of what the compiler read for an object.
    fn follow(&mut self, file: &Path, object: &Path) {
        let followed = |origin: &mut Origin| {
            let rule = std::fs::read_to_string(object.with_extension("d")).ok()?;
            origin.add(&rule, folder_of(file), self.scratch)
        };
        if self.origin.as_mut().and_then(followed).is_none() {
            self.origin = None;
        }
    }

    /// Arguments for a file of the user, which stands ready in the second.
    fn arguments(
        &self,
        (file, ready): (&Path, &Path),
        object: &Path,
        flags: &[&str],
        form: Option<&str>,
    ) -> Vec<OsString> {
        let mut list: Vec<OsString> = flags.iter().map(OsString::from).collect();
        list.extend(form.map(OsString::from));
        for include in [folder_of(ready), folder_of(file), self.scratch] {
            list.push("-I".into());
            list.push(include.into());
        }
        if form.is_some() {
            list.extend(["-J".into(), self.scratch.into()]);
            if self.checked {
                list.extend(CHECK_FLAGS.iter().map(OsString::from));
            }
        }
        list.extend([ready.into(), "-o".into(), object.into()]);
        list
    }

    /// Tries both forms, the one that the ending stands for first; then checks the arguments of known routines.
    fn fortran(&mut self, (file, ready): (&Path, &Path), object: &Path, language: Language) -> bool {
        let Some(compiler) = &self.tools.fortran else { return false };
        let mut forms = ["-ffixed-form", "-ffree-form"];
        if language == Language::FreeFortran {
            forms.reverse();
        }
        let mut failures = Vec::new();
        for form in forms {
            let mut arguments = self.arguments((file, ready), object, FORTRAN_FLAGS, Some(form));
            arguments.push("-fcallgraph-info".into());
            arguments.extend(rule_into(object));
            let output = run(compiler, &arguments);
            if output.as_ref().is_ok_and(|o| o.status.success()) {
                self.calls.read(&std::fs::read_to_string(object.with_extension("ci")).unwrap_or_default());
                self.follow(file, object);
                let arguments = self.arguments((file, ready), object, FORTRAN_FLAGS, Some(form));
                let mut arguments: Vec<OsString> = arguments.into_iter().filter(|a| a != "-c").collect();
                arguments.extend(["-fsyntax-only".into(), "-fc-prototypes-external".into()]);
                let prototypes = run(compiler, &arguments).map(|o| o.stdout).unwrap_or_default();
                for (routine, told) in prototype::check(&String::from_utf8_lossy(&prototypes)) {
                    let message = format!("{}: {told}", file.display());
                    self.misfits.push(Misfit { routine, code: "U004".into(), message });
                }
                return true;
            }
            failures.push(output);
        }
        let errors = |o: &std::io::Result<Output>| {
            o.as_ref().map_or(usize::MAX, |o| String::from_utf8_lossy(&o.stderr).matches("Error:").count())
        };
        let best = failures.into_iter().min_by_key(errors);
        best.is_some_and(|output| self.judge(file, output))
    }

    fn judge(&mut self, file: &Path, output: std::io::Result<Output>) -> bool {
        let told = match output {
            Ok(output) if output.status.success() => return true,
            Ok(output) => String::from_utf8_lossy(&output.stderr).trim().to_owned(),
            Err(error) => error.to_string(),
        };
        let message = format!("`{}` does not compile:\n{}", file.display(), shortened(&told));
        self.faults.push(Diagnostic::error("U003", message));
        false
    }

    /// Links the objects; what they call and nothing defines becomes a call that ends the analysis, and a misfit of each
    /// routine that leads there. LAPACK is taken where the machine has it and something is missing without it.
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

    /// Each known routine that leads to what is missing cannot be called.
    fn note_missing(&mut self, missing: &str) {
        let plain = missing.trim_end_matches('_');
        for routine in super::ROUTINES {
            if self.calls.lead(&format!("{routine}_"), missing) || self.calls.lead(routine, missing) {
                let message = format!("{routine} calls `{plain}`, which nothing defines");
                self.misfits.push(Misfit { routine: (*routine).to_owned(), code: "U005".into(), message });
            }
        }
    }

    /// An object that defines a symbol as a call which ends the analysis; `None` without a Fortran compiler.
    fn stub(&self, symbol: &str, index: usize) -> Option<PathBuf> {
        let compiler = self.tools.fortran.as_ref()?;
        let (file, object) =
            (self.scratch.join(format!("stub{index}.f90")), self.scratch.join(format!("stub{index}.o")));
        let plain = symbol.trim_end_matches('_');
        let text = format!(
            "subroutine stub() bind(C, name=\"{symbol}\")\n  external rvmissing\n  call rvmissing('{plain}')\nend subroutine\n"
        );
        std::fs::write(&file, text).ok()?;
        let arguments: Vec<OsString> =
            vec!["-c".into(), "-fPIC".into(), "-fexceptions".into(), file.into(), "-o".into(), object.clone().into()];
        run(compiler, &arguments).ok().filter(|o| o.status.success())?;
        Some(object)
    }

    fn link_to(&self, name: &str, objects: &[PathBuf], more: &[&str]) -> std::io::Result<(Output, PathBuf)> {
        let library = self.scratch.join(name);
        // What the files define is theirs, whatever the program defines by the same name.
        let mut arguments: Vec<OsString> = vec!["-shared".into(), "-Wl,-Bsymbolic".into()];
        arguments.extend(objects.iter().map(Into::into));
        arguments.extend(more.iter().map(OsString::from));
        arguments.extend(["-o".into(), library.clone().into()]);
        let output = run(self.tools.fortran.as_ref().unwrap_or(&self.tools.c), &arguments)?;
        Ok((output, library))
    }

    fn linked(&mut self, objects: &[PathBuf], more: &[&str]) -> Result<PathBuf, Diagnostics> {
        let name = format!("user{}.so", objects.len());
        let (output, library) = match self.link_to(&name, objects, more) {
            Ok((output, library)) => (Ok(output), library),
            Err(error) => (Err(error), PathBuf::new()),
        };
        if self.judge(Path::new("the files together"), output) {
            return Ok(library);
        }
        Err(std::mem::take(&mut self.faults))
    }
}

fn folder_of(file: &Path) -> &Path {
    file.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Has the compiler write which files it reads beside the object.
fn rule_into(object: &Path) -> [OsString; 3] {
    ["-MD".into(), "-MF".into(), object.with_extension("d").into()]
}

fn run(tool: &OsString, arguments: &[OsString]) -> std::io::Result<Output> {
    // The compiler's words are quoted, so they are asked for in the language of these messages.
    Command::new(tool).args(arguments).env("LC_ALL", "C").output()
}

/// A compiler may say the same a hundred times.
fn shortened(text: &str) -> String {
    const LINES: usize = 30;
    let lines: Vec<&str> = text.lines().collect();
    if lines.len() <= LINES {
        return text.to_owned();
    }
    format!("{}\n… and {} more lines", lines[..LINES].join("\n"), lines.len() - LINES)
}

/// Leaves out files that another one includes: their routines are compiled with that.
fn leave_to_includes(sources: &mut Vec<(&Path, Language)>, notes: &mut Diagnostics) {
    let real = |file: &Path| file.canonicalize().unwrap_or_else(|_| file.to_owned());
    let includes = |file: &Path| {
        let mut seen = BTreeSet::new();
        add_with_includes(file, file, &mut seen, &mut |_| {});
        seen.iter().filter(|other| *other != file).map(|other| real(other)).collect::<Vec<_>>()
    };
    let all: Vec<(&Path, Vec<PathBuf>)> = sources.iter().map(|(file, _)| (*file, includes(file))).collect();
    sources.retain(|(file, _)| {
        let own = real(file);
        // Of two that include each other the first stays.
        let earlier = |other: &Path| !all.iter().any(|(f, list)| f == file && list.contains(&real(other)));
        let Some((other, _)) = all.iter().find(|(other, list)| list.contains(&own) && earlier(other)) else {
            return true;
        };
        let message = format!("`{}` is included by `{}`, and compiled with it", file.display(), other.display());
        notes.push(Diagnostic::note("U010", message));
        false
    });
}

fn note_long_lines(file: &Path, notes: &mut Diagnostics) {
    let Ok(bytes) = files::read(file) else { return };
    let text = String::from_utf8_lossy(&bytes);
    let long: Vec<usize> = text.lines().enumerate().filter(|(_, l)| has_code_past_72(l)).map(|(i, _)| i + 1).collect();
    if let Some(first) = long.first() {
        let message =
            format!("{}:{first}: text past column 72 is read as code ({} such lines)", file.display(), long.len());
        notes.push(Diagnostic::note("U007", message));
    }
}

fn note_third_coordinate(file: &Path, notes: &mut Diagnostics) {
    let Ok(bytes) = files::read(file) else { return };
    let text = String::from_utf8_lossy(&bytes);
    if let Some(line) = text.lines().position(reads_third_coordinate) {
        let message = format!("{}:{}: this reads a third coordinate; there are two, r and z", file.display(), line + 1);
        notes.push(Diagnostic::note("U008", message));
    }
}

/// `curCoords(k,3)` or `velocity(k,3)`, in code.
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
    use super::{Calls, has_code_past_72, reads_third_coordinate};

    #[test]
    fn calls_lead_through_others() {
        let mut calls = Calls::default();
        calls.read("graph: { title: \"t.f\"\nedge: { sourcename: \"vumat_\" targetname: \"t.f:b\" label: \"t.f:4:72\" }\nedge: { sourcename: \"t.f:b\" targetname: \"q_\" label: \"x\" }\n");
        assert!(calls.lead("vumat_", "q_") && calls.lead("b", "q_") && !calls.lead("q_", "b"));
    }

    #[test]
    fn a_third_coordinate_is_seen_in_code_alone() {
        assert!(reads_third_coordinate("        z = CurCoords ( k , 3 )"));
        assert!(reads_third_coordinate("\tif (velocity(k,3)<0.) then"));
        assert!(!reads_third_coordinate("C       z = curCoords(k,3)"));
        assert!(!reads_third_coordinate("        z = curCoords(k,2) ! not curCoords(k,3)"));
        assert!(!reads_third_coordinate("      dimension curCoords(nblock,ndim)"));
    }

    #[test]
    fn comments_may_be_long() {
        let tail = "x".repeat(80);
        assert!(!has_code_past_72(&format!("C {tail}")));
        assert!(!has_code_past_72(&format!("      a = 1 ! {tail}")));
        assert!(has_code_past_72(&format!("      a = {tail}")));
    }
}
