//! Fortran compilers: their options, and the interfaces that they report.

use std::ffi::{OsStr, OsString};
use std::path::Path;
use std::process::{Command, Output};

use revolve_diagnostics::lists;

/// Flags similar to those of the ABAQUS compile command: long lines, legacy Fortran and DEC extensions (Cray pointers,
/// structures, D comment lines) are allowed, local arrays are on the stack. No contraction to fused multiply-add, so
/// that results have the same bits as in Rust. No warnings, which would hide the errors. A stack overflow is an access of
/// the guard page.
const GNU_FLAGS: &[&str] = &[
    "-c",
    "-w",
    "-fPIC",
    "-cpp",
    "-std=legacy",
    "-fallow-argument-mismatch",
    "-fdec",
    "-frecursive",
    "-fstack-clash-protection",
    "-O2",
    "-g",
    "-fbacktrace",
    "-fexceptions",
    "-ffp-contract=off",
    "-ffixed-line-length-none",
    "-ffree-line-length-none",
    "-fdiagnostics-color=never",
];
/// The same for LLVM Flang, which accepts legacy Fortran without flags.
const FLANG_FLAGS: &[&str] = &[
    "-c",
    "-w",
    "-fPIC",
    "-cpp",
    "-O2",
    "-g",
    "-ffp-contract=off",
    "-ffixed-line-length=none",
    "-fno-color-diagnostics",
];
/// Functions of the run-time library of Flang that end the process; Revolve replaces them. The library is part of the
/// user's library, so that the linker must redirect the calls.
const FLANG_LINK_FLAGS: &[&str] = &[
    "-Wl,--wrap=_FortranAStopStatement",
    "-Wl,--wrap=_FortranAStopStatementText",
    "-Wl,--wrap=_FortranAExit",
    "-Wl,--wrap=_FortranAAbort",
];

/// Compilers with the same options.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum CompilerFamily {
    Gnu,
    Flang,
}

/// A Fortran compiler whose options are known.
#[derive(Debug)]
pub struct FortranCompiler {
    program: OsString,
    family: CompilerFamily,
}

/// Interfaces of the subroutines of a file.
pub struct Interfaces {
    /// C prototypes, one a line.
    pub prototypes: String,
    /// Whether a subroutine of the file takes or returns single precision where its caller has double precision.
    pub mixes_precision: bool,
}

impl FortranCompiler {
    /// Identifies a compiler by the name of its file, or by its version text.
    ///
    /// # Errors
    /// If its options are not known, with the way to use it.
    pub fn identify(program: OsString, file: &Path) -> Result<FortranCompiler, String> {
        let name = file.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
        let family = family(&name).or_else(|| {
            let version = run(&program, [OsStr::new("--version")]).ok()?;
            family(&String::from_utf8_lossy(&version.stdout).to_lowercase())
        });
        let shown = program.display();
        let unknown = format!(
            "the options of the Fortran compiler `{shown}` (FC) are not known: set FC to gfortran or flang, or make a shared \
             library, for example `{shown} -shared -fPIC -o user.so FILE`, and pass `--user user.so`"
        );
        family.map(|family| FortranCompiler { program, family }).ok_or(unknown)
    }

    /// Returns the program, which is also the linker.
    pub fn program(&self) -> &OsString {
        &self.program
    }

    pub fn flags(&self) -> &'static [&'static str] {
        if self.is_gnu() { GNU_FLAGS } else { FLANG_FLAGS }
    }

    pub fn link_flags(&self) -> &'static [&'static str] {
        if self.is_gnu() { &[] } else { FLANG_LINK_FLAGS }
    }

    /// Returns the flags of `--check-user`; empty if the compiler cannot check bounds.
    pub fn check_flags(&self) -> &'static [&'static str] {
        if self.is_gnu() { &["-fcheck=bounds,do,mem,pointer"] } else { &[] }
    }

    /// Returns the flags that replace single by double precision. Those of Flang exclude `real*4`.
    fn promotion_flags(&self) -> &'static [&'static str] {
        if self.is_gnu() { &["-freal-4-real-8"] } else { &["-fdefault-real-8", "-fdefault-double-8"] }
    }

    fn is_gnu(&self) -> bool {
        self.family == CompilerFamily::Gnu
    }

    /// Returns the arguments with those that replace single by double precision.
    pub fn promoted(&self, arguments: &[OsString]) -> Vec<OsString> {
        self.promotion_flags().iter().map(OsString::from).chain(arguments.iter().cloned()).collect()
    }

    /// Compiles a file to an object. gfortran also writes its call graph and the list of files read.
    ///
    /// # Errors
    /// If the compiler cannot be started.
    pub fn compile(&self, object: &Path, arguments: &[OsString]) -> std::io::Result<Output> {
        let reports = ["-fcallgraph-info".into()].into_iter().chain(rule_into(object));
        run(&self.program, arguments.iter().cloned().chain(reports.filter(|_| self.is_gnu())))
    }

    /// Returns the interfaces of the subroutines of a file, without compiling it.
    pub fn interfaces(&self, arguments: &[OsString]) -> Interfaces {
        if self.is_gnu() { self.gnu_interfaces(arguments) } else { self.flang_interfaces(arguments) }
    }

    fn gnu_interfaces(&self, arguments: &[OsString]) -> Interfaces {
        let kept = arguments.iter().filter(|a| *a != "-c" && *a != "-w").cloned();
        let output = run(&self.program, kept.chain(["-fsyntax-only".into(), "-fc-prototypes-external".into()])).ok();
        let [prototypes, warnings] = output.map_or_else(Default::default, |output| {
            [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned())
        });
        let mixes_precision = mentions_single(&warnings);
        Interfaces { prototypes, mixes_precision }
    }

    fn flang_interfaces(&self, arguments: &[OsString]) -> Interfaces {
        let mut kept: Vec<OsString> = ["-fc1", "-fdebug-dump-symbols"].map(Into::into).into();
        let mut rest = arguments.iter();
        while let Some(argument) = rest.next() {
            let text = argument.to_string_lossy();
            if ["-I", "-J"].contains(&&*text) {
                kept.extend([argument.clone(), rest.next().cloned().unwrap_or_default()]);
            } else if text == "-o" {
                rest.next();
            } else if !text.starts_with('-') || ["-cpp", "-ff", "-fdefault"].iter().any(|kind| text.starts_with(kind)) {
                kept.push(argument.clone());
            }
        }
        kept.retain(|argument| argument != "-ffp-contract=off");
        let symbols = run(&self.program, kept).map(|output| output.stdout).unwrap_or_default();
        let (mut prototypes, mut mixes_precision) = (String::new(), false);
        for line in String::from_utf8_lossy(&symbols).lines() {
            if let Some((prototype, has_single)) = flang_prototype(line) {
                prototypes += &prototype;
                mixes_precision |= has_single;
            }
        }
        Interfaces { prototypes, mixes_precision }
    }
}

fn family(text: &str) -> Option<CompilerFamily> {
    if text.contains("flang") {
        Some(CompilerFamily::Flang)
    } else {
        (text.contains("gfortran") || text.contains("gnu fortran")).then_some(CompilerFamily::Gnu)
    }
}

/// Returns whether messages of gfortran mention arguments or results in single precision where double precision is used.
pub fn mentions_single(messages: &str) -> bool {
    ["passed REAL(8) to REAL(4)", "passed REAL(4) to REAL(8)", "(REAL(8)/REAL(4))", "(REAL(4)/REAL(8))"]
        .iter()
        .any(|words| messages.contains(words))
}

/// Returns the C prototype of a subprogram in the symbols of Flang, `  name (Subroutine): Subprogram (REAL(8) x, ...)`,
/// and whether it has single precision.
fn flang_prototype(line: &str) -> Option<(String, bool)> {
    let declaration = line.strip_prefix("  ").filter(|l| !l.starts_with(' '))?;
    let (head, tail) = declaration.split_once(": Subprogram ")?;
    let name = head.split([' ', ',']).next()?;
    let list = if tail.starts_with("result:") { tail.split_once(" (")?.1 } else { tail.strip_prefix('(')? };
    let arguments: Vec<String> = lists::split(list.strip_suffix(')')?).into_iter().map(c_argument).collect();
    Some((format!("void {name}_ ({});\n", arguments.join(", ")), tail.contains("REAL(4)")))
}

/// Returns a C argument, `double *x` for `REAL(8) x`.
fn c_argument(argument: &str) -> String {
    let (kind, name) = argument.trim().rsplit_once(' ').unwrap_or(("", argument));
    let c_type = match kind {
        "INTEGER(4)" => "int",
        "INTEGER(8)" => "long",
        "REAL(4)" => "float",
        "REAL(8)" => "double",
        _ if kind.starts_with("CHARACTER") => "char",
        _ => "void",
    };
    format!("{c_type} *{name}")
}

/// Returns the arguments with which a compiler of GNU writes the list of files that it reads.
pub fn rule_into(object: &Path) -> [OsString; 3] {
    ["-MD".into(), "-MF".into(), object.with_extension("d").into()]
}

/// Runs a compiler.
///
/// # Errors
/// If it cannot be started.
pub fn run(tool: &OsString, arguments: impl IntoIterator<Item = impl AsRef<OsStr>>) -> std::io::Result<Output> {
    // Compiler messages are quoted, so they are requested in English.
    Command::new(tool).args(arguments).env("LC_ALL", "C").output()
}

#[cfg(test)]
mod tests {
    use super::{CompilerFamily, family, flang_prototype};

    #[test]
    fn symbols_of_flang_become_prototypes() {
        let line = "  vdload (Subroutine): Subprogram (INTEGER(4) nblock,REAL(8) curcoords,CHARACTER(80_8,1) sname)";
        let expected = "void vdload_ (int *nblock, double *curcoords, char *sname);\n";
        assert_eq!(flang_prototype(line), Some((expected.into(), false)));
        let line = "  g (Function): Subprogram result:REAL(4) g (REAL(8) x)";
        assert_eq!(flang_prototype(line), Some(("void g_ (double *x);\n".into(), true)));
        assert_eq!(flang_prototype("    g (Function): Subprogram (REAL(8) x)"), None);
        assert_eq!(flang_prototype("  x size=8 offset=0: ObjectEntity type: REAL(8)"), None);
    }

    #[test]
    fn compilers_are_known_by_name_or_version() {
        assert_eq!(family("x86_64-linux-gnu-gfortran-12"), Some(CompilerFamily::Gnu));
        assert_eq!(family("gnu fortran (debian 12.2.0) 12.2.0"), Some(CompilerFamily::Gnu));
        assert_eq!(family("flang-new"), Some(CompilerFamily::Flang));
        assert_eq!(family("ifx (ifx) 2024.2.0"), None);
    }
}
