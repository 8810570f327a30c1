//! Fortran and C files to a shared library, kept in a cache by what went into it. Nothing is written beside the files.
//! Never here: opening the library, calling it.

use std::collections::BTreeSet;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use hmac_sha256::Hash;

use super::{MAX_BLOCK, Routines, library, prototype};
use crate::deck::{Diagnostic, Diagnostics};
use crate::output::whole::Scratch;

/// Flags as ABAQUS's own compile command sets them for its compilers: long lines, no complaint about old Fortran, local
/// arrays on the stack. No contraction, so that the same arithmetic gives the same bits as in Rust.
const FORTRAN_FLAGS: &[&str] = &[
    "-c",
    "-fPIC",
    "-cpp",
    "-std=legacy",
    "-fallow-argument-mismatch",
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
    /// Files, in the order in which they are searched for routines.
    pub libraries: Vec<PathBuf>,
    /// What the user should know.
    pub notes: Diagnostics,
    /// Whether a source reads a third coordinate: calls are then watched for invalid operations.
    third_coordinate: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Language {
    FixedFortran,
    FreeFortran,
    C,
    Ready,
}

impl Compiled {
    /// What decides on the routines: of sources the key of the cache (texts, flags, compiler), of ready libraries a hash of
    /// their bytes.
    pub fn identity(&self) -> String {
        let folder = cache_folder();
        let one = |library: &PathBuf| {
            if library.parent() == Some(folder.as_path()) {
                return library.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            }
            // A file that cannot be read cannot be opened either, and is refused there.
            crate::output::checkpoint::hash([std::fs::read(library).unwrap_or_default().as_slice()])
        };
        self.libraries.iter().map(one).collect::<Vec<_>>().join(" ")
    }

    /// Opens the libraries: routines with a state of their own, for one run.
    ///
    /// # Errors
    /// As [`library::open`].
    pub fn open(&self) -> Result<Routines, Diagnostic> {
        library::open(&self.libraries, self.third_coordinate)
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
    let mut faults = Diagnostics::default();
    let mut sources = Vec::new();
    let mut libraries = Vec::new();
    for file in files {
        match language(file).and_then(|l| readable(file).map(|()| l)) {
            Ok(Language::Ready) => libraries.push(file.clone()),
            Ok(language) => sources.push((file.as_path(), language)),
            Err(message) => faults.push(Diagnostic::error("U001", message)),
        }
    }
    if faults.has_errors() {
        return Err(faults);
    }
    let mut notes = Diagnostics::default();
    if !sources.is_empty() {
        libraries.insert(0, build(&sources, checked, &mut notes)?);
    }
    let third_coordinate = notes.iter().any(|n| n.code == "U008");
    Ok(Compiled { libraries, notes, third_coordinate })
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

fn readable(file: &Path) -> Result<(), String> {
    std::fs::File::open(file).map(|_| ()).map_err(|e| format!("cannot read the user file `{}`: {e}", file.display()))
}

fn build(sources: &[(&Path, Language)], checked: bool, notes: &mut Diagnostics) -> Result<PathBuf, Diagnostics> {
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
    let folder = cache_folder();
    let io = |e: std::io::Error| fault("U001", format!("cannot write into the cache {}: {e}", folder.display()));
    std::fs::create_dir_all(&folder).map_err(io)?;
    let library = folder.join(format!("{}.so", key(sources, &tools, checked)));
    if library.exists() {
        return Ok(library);
    }
    let scratch = Scratch::within(&folder).map_err(io)?;
    write_includes(scratch.path()).map_err(io)?;
    let mut builder = Builder { tools: &tools, scratch: scratch.path(), checked, faults: Diagnostics::default() };
    let objects: Vec<PathBuf> =
        sources.iter().enumerate().filter_map(|(i, (file, language))| builder.object(i, file, *language)).collect();
    if builder.faults.has_errors() {
        return Err(builder.faults);
    }
    let linked = builder.link(&objects)?;
    std::fs::rename(linked, &library).map_err(io)?;
    Ok(library)
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

fn cache_folder() -> PathBuf {
    let under = |name: &str| std::env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
    let home = under("XDG_CACHE_HOME").or_else(|| under("HOME").map(|h| h.join(".cache")));
    home.unwrap_or_else(std::env::temp_dir).join("revolve").join("user")
}

/// Hash of all that decides what the library is: sources, what they include, flags, compilers.
fn key(sources: &[(&Path, Language)], tools: &Tools, checked: bool) -> String {
    let mut hash = Hash::new();
    let mut add = |bytes: &[u8]| {
        hash.update((bytes.len() as u64).to_le_bytes());
        hash.update(bytes);
    };
    add(env!("CARGO_PKG_VERSION").as_bytes());
    add(tools.version.as_bytes());
    add(format!("{FORTRAN_FLAGS:?} {C_FLAGS:?} {checked} {:?}", includes_text()).as_bytes());
    for (file, language) in sources {
        add(format!("{language:?}").as_bytes());
        let mut seen = BTreeSet::new();
        add_with_includes(file, &mut seen, &mut add);
    }
    hash.finalize().iter().map(|b| format!("{b:02x}")).collect()
}

/// A file and those it includes, each once; what cannot be read is the compiler's to tell.
fn add_with_includes(file: &Path, seen: &mut BTreeSet<PathBuf>, add: &mut impl FnMut(&[u8])) {
    let Ok(bytes) = std::fs::read(file) else { return };
    if !seen.insert(file.to_owned()) {
        return;
    }
    add(&bytes);
    let text = String::from_utf8_lossy(&bytes);
    for name in text.lines().filter_map(included) {
        add_with_includes(&file.parent().unwrap_or(Path::new("")).join(name), seen, add);
    }
}

/// The file that an `include 'name'` or `#include "name"` line names.
fn included(line: &str) -> Option<&str> {
    let line = line.trim().trim_start_matches('#').trim_start();
    let rest = line.get(..7).filter(|w| w.eq_ignore_ascii_case("include")).map(|_| line[7..].trim_start())?;
    let quote = rest.chars().next().filter(|c| matches!(c, '\'' | '"' | '<'))?;
    let end = if quote == '<' { '>' } else { quote };
    rest[1..].split(end).next()
}

/// `vaba_param.inc` and `aba_param.inc`, valid in fixed and in free form. (What they must define is in the ABAQUS Analysis
/// User's Guide, "User subroutines: overview": double precision, and the block length.)
fn includes_text() -> [(&'static str, String); 2] {
    let vaba = format!(
        "!     double precision, two words a real; points a call at most\n\
         \x20     implicit real*8 (a-h,o-z)\n\
         \x20     parameter (j_sys_Dimension = 2)\n\
         \x20     parameter (n_vec_Length = {MAX_BLOCK})\n\
         \x20     parameter (maxblk = n_vec_Length)\n"
    );
    let aba = "!     double precision\n      implicit real*8 (a-h,o-z)\n      parameter (nprecd = 2)\n".to_owned();
    [("vaba_param.inc", vaba), ("aba_param.inc", aba)]
}

fn write_includes(folder: &Path) -> std::io::Result<()> {
    for (name, text) in includes_text() {
        std::fs::write(folder.join(name), &text)?;
        std::fs::write(folder.join(name.to_ascii_uppercase()), &text)?;
    }
    Ok(())
}

struct Builder<'a> {
    tools: &'a Tools,
    scratch: &'a Path,
    checked: bool,
    faults: Diagnostics,
}

impl Builder<'_> {
    /// Compiles one file; `None` if that failed (told).
    fn object(&mut self, index: usize, file: &Path, language: Language) -> Option<PathBuf> {
        let object = self.scratch.join(format!("{index}.o"));
        match language {
            Language::C => {
                let output = run(&self.tools.c, &self.arguments(file, &object, C_FLAGS, None));
                self.judge(file, output).then_some(object)
            }
            _ => self.fortran(file, &object, language).then_some(object),
        }
    }

    fn arguments(&self, file: &Path, object: &Path, flags: &[&str], form: Option<&str>) -> Vec<OsString> {
        let mut list: Vec<OsString> = flags.iter().map(OsString::from).collect();
        list.extend(form.map(OsString::from));
        let folder = file.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        for include in [folder, self.scratch] {
            list.push("-I".into());
            list.push(include.into());
        }
        if form.is_some() {
            list.extend(["-J".into(), self.scratch.into()]);
            if self.checked {
                list.extend(CHECK_FLAGS.iter().map(OsString::from));
            }
        }
        list.extend([file.into(), "-o".into(), object.into()]);
        list
    }

    /// Tries both forms, the one that the ending stands for first; then checks the arguments of known routines.
    fn fortran(&mut self, file: &Path, object: &Path, language: Language) -> bool {
        let Some(compiler) = &self.tools.fortran else { return false };
        let mut forms = ["-ffixed-form", "-ffree-form"];
        if language == Language::FreeFortran {
            forms.reverse();
        }
        let mut failures = Vec::new();
        for form in forms {
            let output = run(compiler, &self.arguments(file, object, FORTRAN_FLAGS, Some(form)));
            if output.as_ref().is_ok_and(|o| o.status.success()) {
                let arguments = self.arguments(file, object, FORTRAN_FLAGS, Some(form));
                let mut arguments: Vec<OsString> = arguments.into_iter().filter(|a| a != "-c").collect();
                arguments.extend(["-fsyntax-only".into(), "-fc-prototypes-external".into()]);
                let prototypes = run(compiler, &arguments).map(|o| o.stdout).unwrap_or_default();
                for told in prototype::check(&String::from_utf8_lossy(&prototypes)) {
                    self.faults.push(Diagnostic::error("U004", format!("{}: {told}", file.display())));
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

    fn link(&mut self, objects: &[PathBuf]) -> Result<PathBuf, Diagnostics> {
        let library = self.scratch.join("user.so");
        let mut arguments: Vec<OsString> = vec!["-shared".into()];
        arguments.extend(objects.iter().map(Into::into));
        arguments.extend(["-o".into(), library.clone().into()]);
        let output = run(self.tools.fortran.as_ref().unwrap_or(&self.tools.c), &arguments);
        if self.judge(Path::new("the files together"), output) {
            return Ok(library);
        }
        Err(std::mem::take(&mut self.faults))
    }
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

fn note_long_lines(file: &Path, notes: &mut Diagnostics) {
    let Ok(bytes) = std::fs::read(file) else { return };
    let text = String::from_utf8_lossy(&bytes);
    let long: Vec<usize> = text.lines().enumerate().filter(|(_, l)| has_code_past_72(l)).map(|(i, _)| i + 1).collect();
    if let Some(first) = long.first() {
        let message =
            format!("{}:{first}: text past column 72 is read as code ({} such lines)", file.display(), long.len());
        notes.push(Diagnostic::note("U007", message));
    }
}

fn note_third_coordinate(file: &Path, notes: &mut Diagnostics) {
    let Ok(bytes) = std::fs::read(file) else { return };
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
    use super::{has_code_past_72, included, reads_third_coordinate};

    #[test]
    fn a_third_coordinate_is_seen_in_code_alone() {
        assert!(reads_third_coordinate("        z = CurCoords ( k , 3 )"));
        assert!(reads_third_coordinate("\tif (velocity(k,3)<0.) then"));
        assert!(!reads_third_coordinate("C       z = curCoords(k,3)"));
        assert!(!reads_third_coordinate("        z = curCoords(k,2) ! not curCoords(k,3)"));
        assert!(!reads_third_coordinate("      dimension curCoords(nblock,ndim)"));
    }

    #[test]
    fn includes_are_found_in_both_styles() {
        assert_eq!(included("      include 'vaba_param.inc'"), Some("vaba_param.inc"));
        assert_eq!(included("#include \"law.h\""), Some("law.h"));
        assert_eq!(included("      INCLUDE \"Law.Inc\" ! x"), Some("Law.Inc"));
        assert_eq!(included("      includes = 1"), None);
    }

    #[test]
    fn comments_may_be_long() {
        let tail = "x".repeat(80);
        assert!(!has_code_past_72(&format!("C {tail}")));
        assert!(!has_code_past_72(&format!("      a = 1 ! {tail}")));
        assert!(has_code_past_72(&format!("      a = {tail}")));
    }
}
