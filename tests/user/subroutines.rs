//! User subroutines in Fortran and C as a user runs them.
//!
//! Goal: a VDLOAD file written for ABAQUS/Explicit runs unchanged; errors in a file give a located message. Needs
//! gfortran and cc; without gfortran the tests are left out, except in CI.

#[path = "../../examples/rust_and_fortran.rs"]
mod rust_and_fortran;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use revolve::user::Routines;
use revolve::user::compile::compile;

use crate::common;
use crate::common::routines::CavityResistance;

pub fn fortran() -> bool {
    common::fortran("user subroutines in Fortran")
}

/// A folder with the user's files and the cache of compiled libraries.
pub struct UserFolder(tempfile::TempDir);

impl UserFolder {
    pub fn new() -> Self {
        UserFolder(tempfile::tempdir().expect("a folder"))
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn write(&self, name: &str, text: &str) -> PathBuf {
        std::fs::write(self.path(name), text).expect("a file");
        self.path(name)
    }

    /// Runs `revolve run` on a deck with user files.
    pub fn run(&self, deck: &Path, files: &[&Path], more: &[&str]) -> Output {
        self.run_with(&[], deck, files, more)
    }

    /// Runs `revolve run` with environment variables.
    pub fn run_with(&self, variables: &[(&str, PathBuf)], deck: &Path, files: &[&Path], more: &[&str]) -> Output {
        let mut command = self.command(deck, files);
        command.arg("--quiet").args(more).envs(variables.iter().map(|(name, value)| (*name, value)));
        command.output().expect("the program runs")
    }

    /// Returns the command, which prints its notes.
    pub fn command(&self, deck: &Path, files: &[&Path]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_revolve"));
        command.arg("run").arg(deck).arg("--out").arg(self.path("out"));
        for file in files {
            command.arg("--user").arg(file);
        }
        command.env("XDG_CACHE_HOME", self.path("cache")).current_dir(self.0.path());
        command
    }

    pub fn summary(&self, job: &str) -> serde_json::Value {
        let text = std::fs::read_to_string(self.path("out").join(format!("{job}.json"))).expect("a summary");
        serde_json::from_str(&text).expect("JSON")
    }

    pub fn depth(&self, job: &str) -> f64 {
        self.summary(job)["history"]["U2@REF"]["final"].as_f64().expect("a depth")
    }
}

pub fn message_text(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

pub fn user_deck() -> PathBuf {
    common::project("input/ogive_user.inp")
}

/// Returns a VDLOAD in fixed form with these statements, which assign `value`.
pub fn vdload(statements: &str) -> String {
    format!(
        "      subroutine vdload(nblock, ndim, stepTime, totalTime, amplitude,\n     1 curCoords, velocity, dirCos, jltyp, \
         sname, value)\n      include 'vaba_param.inc'\n      dimension curCoords(nblock,ndim), velocity(nblock,ndim),\n     \
         1 dirCos(nblock,ndim,ndim), value(nblock)\n      character*80 sname\n{statements}\n      return\n      end\n"
    )
}

pub const FILL: &str = "      do k = 1, nblock\n        value(k) = 1.d8\n      end do\n";

#[test]
fn fortran_load_matches_built_in_depths() {
    if !fortran() {
        return;
    }
    let user_dir = UserFolder::new();
    let routine = common::project("input/vdload_cavity.f");
    for v in ["569", "570", "679", "821", "966", "1147"] {
        let speed = format!("V={v}");
        let settings = ["--set", &speed, "--set", "n=200"];
        let output = user_dir.run(&user_deck(), &[&routine], &settings);
        assert!(output.status.success(), "{}", message_text(&output));
        let inside: Vec<&str> = settings.into_iter().chain(["--set", "front=0.1"]).collect();
        let output = user_dir.run(&common::project("input/ogive.inp"), &[], &inside);
        assert!(output.status.success(), "{}", message_text(&output));
        let ratio = user_dir.depth("ogive_user") / user_dir.depth("ogive");
        assert!((ratio - 1.0).abs() < 1e-12, "V = {v}: {ratio}");
    }
}

/// A nested include is searched in the folder of the including file and in that of the compiled file, in any letter
/// case, and may itself be converted.
#[test]
fn nested_includes_are_found_in_both_folders() {
    if !fortran() {
        return;
    }
    for (name, line) in [
        ("from the file's folder", "      include 'inc/two.inc'\n"),
        ("from the include's folder", "      include 'two.inc'\n"),
        ("in another case", "      include 'INC/Two.Inc'\n"),
        ("by the preprocessor", "#include 'inc/two.inc'\n"),
        ("same folder, by the preprocessor", "#include \"two.inc\"\n"),
        ("by its last part", "      include 'C:\\work\\TWO.INC'\n"),
    ] {
        for two in [
            "      parameter (p0 = 1.d8)\n",
            "      parameter (p0 = 1.d8)\n      logical is\n      is = .true. == .true.\n",
        ] {
            let user_dir = UserFolder::new();
            std::fs::create_dir(user_dir.path("inc")).expect("a folder");
            user_dir.write("inc/one.inc", line);
            user_dir.write("inc/two.inc", two);
            let file = user_dir.write("load.f", &vdload("      include 'inc/one.inc'\n      value = p0"));
            let output = user_dir.run(&user_deck(), &[&file], &[]);
            assert!(output.status.success(), "{name}: {}", message_text(&output));
        }
    }
}

#[test]
fn source_folder_is_unchanged_and_builds_are_reused() {
    if !fortran() {
        return;
    }
    let user_dir = UserFolder::new();
    user_dir.write("law.inc", "      parameter (p0 = 1.d8)\n");
    let file = user_dir.write("load.f", &vdload("      include 'law.inc'\n      value = p0"));
    let built = || {
        let output = user_dir.run(&user_deck(), &[&file], &[]);
        assert!(output.status.success(), "{}", message_text(&output));
        let files = std::fs::read_dir(user_dir.path("cache/revolve/user")).expect("a cache").filter_map(Result::ok);
        files.filter(|entry| entry.path().extension().is_some_and(|e| e == "so")).count()
    };
    assert_eq!((built(), built()), (1, 1));
    let first = user_dir.depth("ogive_user");
    user_dir.write("law.inc", "      parameter (p0 = 2.d8)\n");
    assert_eq!(built(), 2, "a changed include gives another library");
    let slowed = |u: f64| u + 569e-3;
    assert!((slowed(user_dir.depth("ogive_user")) / slowed(first) - 2.0).abs() < 1e-6, "twice the deceleration");
    let mut names: Vec<_> =
        std::fs::read_dir(user_dir.0.path()).expect("a folder").map(|e| e.expect("an entry").file_name()).collect();
    names.sort();
    assert_eq!(names, ["cache", "law.inc", "load.f", "out"]);
}

/// Errors found before the run: exit status 2, and each of the words in the message.
#[test]
fn errors_in_the_source_are_reported_before_the_run() {
    if !fortran() {
        return;
    }
    let good = vdload(FILL);
    let cases: &[(&str, String, &[&str])] = &[
        (
            "ten arguments",
            good.replace("dirCos, jltyp, sname", "dirCos, sname"),
            &["U004", "10 arguments", "missing: jltyp"],
        ),
        ("an undefined helper", vdload("      call helper(value)"), &["U005", "helper", "is not defined"]),
        ("a syntax error", vdload("      value(1 = 2"), &["U003", "load.f:", "Error"]),
        ("no known routine", "      subroutine other\n      end\n".into(), &["U006", "vdload"]),
    ];
    for (name, source, words) in cases {
        let user_dir = UserFolder::new();
        let file = user_dir.write("load.f", source);
        let output = user_dir.run(&user_deck(), &[&file], &[]);
        let message = message_text(&output);
        assert_eq!(output.status.code(), Some(2), "{name}: {message}");
        for word in *words {
            assert!(message.contains(word), "{name}: `{word}` in\n{message}");
        }
        assert!(!user_dir.path("out").exists(), "{name}: nothing ran");
    }
    let user_dir = UserFolder::new();
    let output = user_dir.run(&user_deck(), &[&user_dir.path("absent.f"), Path::new("load.txt")], &[]);
    assert_eq!(output.status.code(), Some(2));
    assert!(
        message_text(&output).contains("absent.f") && message_text(&output).contains("load.txt"),
        "{}",
        message_text(&output)
    );
}

/// Errors during the run: exit status 1, a located message, and the last state on disk.
#[test]
fn errors_in_the_run_are_located() {
    if !fortran() {
        return;
    }
    let later = |what: &str| format!("{FILL}      if (totalTime .gt. 1.d-5) then\n        {what}\n      end if");
    let cases: &[(&str, String, &[&str])] = &[
        (
            "a third coordinate",
            "      do k = 1, nblock\n        value(k) = 1.d8*curCoords(k,3)\n      end do".into(),
            &["third coordinate", "two components, r and z"],
        ),
        (
            "a third coordinate in a comparison",
            format!("{FILL}      if (curCoords(1,3) .lt. 0.d0) value = 0.d0"),
            &["third coordinate", "two components, r and z"],
        ),
        (
            "a third direction",
            "      do k = 1, nblock\n        value(k) = 1.d8*dirCos(k,3,3)\n      end do".into(),
            &["NaN", "direction"],
        ),
        ("STOP", later("stop 'table exhausted'"), &["STOP table exhausted", "increment"]),
        ("STOP with a number", later("stop 7"), &["STOP 7"]),
        ("ERROR STOP", later("error stop"), &["ERROR STOP"]),
        ("exit", later("call exit(3)"), &["exit(3)"]),
        ("a NaN", later("value(4) = sqrt(-1.d0*totalTime)"), &["point 4", "NaN", "r = "]),
        ("an infinity", later("value(2) = 1.d0/(totalTime - totalTime)"), &["point 2", "inf"]),
        ("no value set", "      dummy = stepTime".into(), &["point 1", "NaN", "left out"]),
        ("a value left out", "      value(1) = 1.d0".into(), &["point 2", "left out"]),
        (
            "past the end",
            "      do k = 1, nblock + 1\n        value(k) = 1.d8\n      end do".into(),
            &["past the nblock = 20"],
        ),
        ("sname written", format!("{FILL}      sname = 'OTHER'"), &["sname", "read"]),
        ("sname longer than it is", later("call long(sname)"), &["sname", "read"]),
        ("xplb_exit", later("call xplb_exit"), &["xplb_exit"]),
        (
            "xplb_abqerr",
            later("call xplb_abqerr(-3, 'pressure %R of point %I', 12, 3.5d0, ' ')"),
            &["pressure 3.5e0 of point 12"],
        ),
    ];
    let helper = "      subroutine long(s)\n      character*256 s\n      s(1:90) = 'OTHER'\n      end\n";
    for (name, statements, words) in cases {
        let user_dir = UserFolder::new();
        let file = user_dir.write("load.f", &(vdload(statements) + helper));
        let output = user_dir.run(&user_deck(), &[&file], &[]);
        let message = message_text(&output);
        assert_eq!(output.status.code(), Some(1), "{name}: {message}");
        for word in words.iter().chain(&["NOSE", "step 1", "increment", "last valid state"]) {
            assert!(message.contains(word), "{name}: `{word}` in\n{message}");
        }
        assert_eq!(user_dir.summary("ogive_user")["status"], "halted", "{name}");
        assert!(
            user_dir.path("out/ogive_user.pvd").exists() && user_dir.path("out/ogive_user_history.csv").exists(),
            "{name}"
        );
    }
}

/// Faults that end the whole process: a message, and no results that appear complete.
#[test]
fn crashes_are_reported_with_a_message() {
    if !fortran() {
        return;
    }
    let cases: &[(&str, &str, &[&str])] = &[
        ("wild index", "      i = 100000000 + nblock\n      value(i) = 1.d0", &["memory", "--check-user"]),
        ("read error", "      open(101, file='absent.txt', status='old')", &["ended the process"]),
        ("wild division", "      value = 7/jltyp", &["divided an integer by zero"]),
    ];
    for (name, statements, words) in cases {
        let user_dir = UserFolder::new();
        let file = user_dir.write("load.f", &vdload(statements));
        let output = user_dir.run(&user_deck(), &[&file], &[]);
        let message = message_text(&output);
        assert_eq!(output.status.code(), Some(1), "{name}: {message}");
        for word in words.iter().chain(&["vdload", "NOSE", "step 1", "increment"]) {
            assert!(message.contains(word), "{name}: `{word}` in\n{message}");
        }
        assert!(!user_dir.path("out/ogive_user.json").exists(), "{name}");
    }
}

#[test]
fn a_checked_build_names_the_index() {
    if !fortran() {
        return;
    }
    let user_dir = UserFolder::new();
    let file = user_dir.write("load.f", &vdload(&format!("{FILL}      j = nblock + 1\n      value(j) = 0.d0")));
    let output = user_dir.run(&user_deck(), &[&file], &["--check-user"]);
    let message = message_text(&output);
    assert_eq!(output.status.code(), Some(1), "{message}");
    for word in ["load.f", "Index '21'", "'value'", "NOSE"] {
        assert!(message.contains(word), "`{word}` in\n{message}");
    }
}

/// Code beyond column 72 is compiled, as with the compile command of ABAQUS; the user is informed.
#[test]
fn code_beyond_column_72_is_compiled_and_reported() {
    if !fortran() {
        return;
    }
    let wide = format!("{:<71}*100.d0\n", "        value(k) = 1.d6");
    let user_dir = UserFolder::new();
    let file = user_dir.write("load.f", &vdload(&format!("      do k = 1, nblock\n{wide}      end do")));
    let plain = user_dir.write("plain.f", &vdload(FILL));
    let output = user_dir.run(&user_deck(), &[&plain], &[]);
    assert!(output.status.success(), "{}", message_text(&output));
    let expected = user_dir.depth("ogive_user");
    let output = Command::new(env!("CARGO_BIN_EXE_revolve"))
        .arg("run")
        .arg(user_deck())
        .arg("--user")
        .arg(&file)
        .arg("--out")
        .arg(user_dir.path("out"))
        .env("XDG_CACHE_HOME", user_dir.path("cache"))
        .output()
        .expect("the program runs");
    assert!(
        message_text(&output).contains("U007") && message_text(&output).contains("load.f:8"),
        "{}",
        message_text(&output)
    );
    assert_eq!(user_dir.depth("ogive_user"), expected);
}

#[test]
fn routines_of_all_styles_compile_and_run() {
    if !fortran() {
        return;
    }
    let tabs = vdload(FILL)
        .replace("      do", "\tdo")
        .replace("        value", "\t  value")
        .replace("      end do", "\tend do");
    let sum: String = (0..400).map(|i| format!("     {} + 2.5d5\n", char::from(b'1' + (i % 9) as u8))).collect();
    let long = vdload(&format!("      do k = 1, nblock\n        value(k) = 0.d0\n{sum}      end do"));
    let upper = vdload(FILL).to_uppercase();
    let free = "subroutine vdload(nblock, ndim, stepTime, totalTime, amplitude, curCoords, velocity, &\n  dirCos, jltyp, sname, \
                value)\n  use law\n  implicit none\n  integer, intent(in) :: nblock, ndim, jltyp\n  real*8, intent(in) :: stepTime, \
                totalTime, amplitude, curCoords(nblock,ndim), velocity(nblock,ndim), dirCos(nblock,ndim,ndim)\n  \
                character(len=80), intent(in) :: sname\n  real*8, intent(out) :: value(nblock)\n  if (trim(sname) == 'NOSE' .and. \
                jltyp == 0) value = pressure()\nend subroutine\n";
    let module =
        "module law\ncontains\n  real*8 function pressure()\n    pressure = 1.d8\n  end function\nend module\n";
    let c = "void vdload_(const int *nblock, const int *ndim, const double *st, const double *tt, const double *amplitude,\n \
             const double *x, const double *v, const double *d, const int *jltyp, const char *sname, double *value, long n)\n{\n  \
             for (int k = 0; k < *nblock; k++) value[k] = 1e8;\n}\n";
    let state = vdload(
        "      save first\n      logical first\n      data first /.true./\n      common /law/ p\n      if (first) then\n        \
                        p = 1.d8\n        first = .false.\n      end if\n      value = p",
    );
    let bare = vdload(FILL).replace("include 'vaba_param.inc'", "INCLUDE 'VABA_PARAM.INC'");
    let cases: &[(&str, Vec<(&str, String)>)] = &[
        ("fixed form", vec![("a.f", vdload(FILL))]),
        (
            "a guarded third coordinate",
            vec![("a.f", vdload(&format!("      z = 0.d0\n      if (ndim .gt. 2) z = curCoords(1,3)\n{FILL}")))],
        ),
        ("tabs", vec![("a.for", tabs)]),
        ("400 continuation lines", vec![("a.f", long)]),
        ("upper case", vec![("A.F", upper)]),
        ("upper-case include", vec![("a.f", bare)]),
        ("free form with a module", vec![("law.f90", module.into()), ("a.f90", free.into())]),
        ("free form that is called .f", vec![("a.f", format!("{module}{free}"))]),
        ("C", vec![("a.c", c.into())]),
        ("SAVE, DATA and COMMON", vec![("a.f", state)]),
    ];
    let mut depths = Vec::new();
    for (name, files) in cases {
        let user_dir = UserFolder::new();
        let paths: Vec<PathBuf> = files.iter().map(|(file, text)| user_dir.write(file, text)).collect();
        let paths: Vec<&Path> = paths.iter().map(PathBuf::as_path).collect();
        let output = user_dir.run(&user_deck(), &paths, &[]);
        assert!(output.status.success(), "{name}: {}", message_text(&output));
        depths.push(user_dir.depth("ogive_user"));
    }
    assert!(depths.iter().all(|d| *d == depths[0]), "{depths:?}");
}

#[test]
fn compiled_library_is_loaded() {
    if !fortran() {
        return;
    }
    let user_dir = UserFolder::new();
    let source = user_dir.write(
        "a.c",
        "void vdload_(int *n, int *a, double *b, double *c, double *d, double *e, double *f, double *g, int *h,\n \
                             char *s, double *value, long l)\n{ for (int k = 0; k < *n; k++) value[k] = 1e8; }\n",
    );
    let library = user_dir.path("a.so");
    let built = Command::new("cc").args(["-shared", "-fPIC", "-o"]).arg(&library).arg(&source).status();
    assert!(built.is_ok_and(|s| s.success()));
    let output = user_dir.run(&user_deck(), &[&library], &[]);
    assert!(output.status.success(), "{}", message_text(&output));
    let deck = user_dir.write("no_library.so", "not a library");
    let output = user_dir.run(&user_deck(), &[&deck], &[]);
    assert_eq!(output.status.code(), Some(2));
    assert!(message_text(&output).contains("U005"), "{}", message_text(&output));
}

/// Host routines that existing files call, and files of the subroutine in the folder of the deck.
#[test]
fn host_routines_are_available() {
    if !fortran() {
        return;
    }
    let statements = "      character*256 job, dir\n      character*80 part\n      save first\n      logical first\n      data first /.true./\n      \
        value = 1.d8\n      if (first) then\n        first = .false.\n        call vgetjobname(job, lj)\n        call vgetoutdir(dir, ld)\n        \
        call vgetnumcpus(ncpu)\n        call vgetrank(nrank)\n        part = ' '\n        call vgetinternal(part, 9999, 0, nint, nrc)\n        \
        call vgetpartinfo(nint, 0, part, nloc, nrc2)\n        open(unit=101, file=dir(1:ld)//'/'//job(1:lj)//'.own')\n        \
        write(101,'(A,6I6)') sname(1:4), ncpu, nrank, nrc, nloc, nrc2, jltyp\n        close(101)\n        \
        call xplb_abqerr(1, 'surface %S of %I points', nblock, 0.d0, 'NOSE    ')\n        call xplb_abqerr(-1, 'mind this', 0, 0.d0, ' ')\n      end if";
    let user_dir = UserFolder::new();
    let file = user_dir.write("load.f", &vdload(statements));
    let deck = user_dir.write("ogive_user.inp", &std::fs::read_to_string(user_deck()).expect("a deck"));
    let output = user_dir.run(&deck, &[&file], &[]);
    assert!(output.status.success(), "{}", message_text(&output));
    let own = std::fs::read_to_string(user_dir.path("ogive_user.own")).expect("the subroutine's own file");
    let words: Vec<&str> = own.split_whitespace().collect();
    assert_eq!(words, ["NOSE", "1", "0", "0", "9999", "0", "0"]);
    let messages = &user_dir.summary("ogive_user")["messages"];
    assert_eq!(messages[0]["text"], "surface NOSE of 20 points");
    assert_eq!((&messages[0]["level"], &messages[1]["level"]), (&"note".into(), &"warning".into()));
}

/// Writes two bodies, one loaded with a user amplitude, one with a user motion; and the subroutines, which write a log.
pub fn pushed_and_driven(user_dir: &UserFolder) -> [PathBuf; 2] {
    let source = "      subroutine vuamp(ampName, time, ampValueOld, dt, nprops, props, nSvars, svars, lFlagsInfo, nSensor,\n     \
        1 sensorValues, sensorNames, jSensorLookUpTable, ampValueNew, lFlagsDefine, ampDerivative, ampSecDerivative, ampIncIntegral)\n      \
        include 'vaba_param.inc'\n      dimension time(2), props(nprops), svars(nSvars), lFlagsInfo(*), sensorValues(nSensor), lFlagsDefine(*)\n      \
        character*80 sensorNames(nSensor), ampName\n      svars(1) = svars(1) + 1.d0\n      \
        ampValueNew = props(1)*time(2)\n      i = ivGetSensorID('SPEED', jSensorLookUpTable)\n      v = vGetSensorValue('SPEED', jSensorLookUpTable, sensorValues)\n      \
        if (ampName .ne. 'RISE' .or. sensorValues(i) .ne. v) call xplb_exit\n      \
        if (v .gt. 3.d0) lFlagsDefine(5) = 1\n      end\n      \
        subroutine vdisp(nblock, nDof, nCoord, kstep, kinc, stepTime, totalTime, dtNext, dt, cbname, jBCType, jDof, jNodeUid, amp,\n     \
        1 coordNp, u, v, a, rf, rmass, rotaryI, rval)\n      include 'vaba_param.inc'\n      character*80 cbname\n      \
        dimension jDof(nDof), jNodeUid(nblock), amp(nblock), coordNp(nCoord,nblock), rval(nDof,nblock)\n      \
        do k = 1, nblock\n        if (jDof(2) .gt. 0 .and. cbname .eq. 'DRIVEN') rval(2,k) = 3.d0*totalTime**2\n      end do\n      end\n      \
        subroutine vexternaldb(lOp, i_Array, niArray, r_Array, nrArray)\n      include 'vaba_param.inc'\n      dimension i_Array(niArray), r_Array(nrArray)\n      \
        character*256 dir\n      if (lOp .eq. 0) then\n        call vgetoutdir(dir, ld)\n        open(unit=101, file=dir(1:ld)//'/log')\n      end if\n      \
        if (lOp .ne. 2 .and. lOp .ne. 3 .and. lOp .ne. 4) write(101,*) lOp, i_Array(3)\n      if (lOp .eq. 6) close(101)\n      end\n";
    let deck = "*Heading\n two bodies\n*Node, nset=ALL\n 1, 0., 0.\n 2, 0., 1.\n*Nset, nset=FREE\n 1\n*Nset, nset=DRIVEN\n 2\n\
        *Element, type=MASS, elset=A\n 1, 1\n*Element, type=MASS, elset=B\n 2, 2\n*Mass, elset=A\n 2.,\n*Mass, elset=B\n 1.,\n\
        *Rigid Body, ref node=1, elset=A\n*Rigid Body, ref node=2, elset=B\n\
        *Amplitude, name=RISE, definition=USER, properties=1, variables=1\n 6.,\n\
        *Step, name=First\n*Dynamic, Explicit\n , 4.\n*Cload, amplitude=RISE\n FREE, 2, 1.\n*Boundary, user, type=VELOCITY\n DRIVEN, 2\n\
        *Output, history, sensor, name=SPEED, number interval=50\n*Node Output, nset=FREE\n V2\n\
        *Output, history, op=ADD, number interval=50\n*Node Output, nset=FREE\n U2, V2\n*Node Output, nset=DRIVEN\n U2, V2\n*End Step\n";
    [user_dir.write("two.inp", deck), user_dir.write("all.f", source)]
}

/// Amplitude, prescribed motion and events in one file; the motion equals the closed form.
#[test]
fn vuamp_vdisp_and_vexternaldb_match_closed_forms() {
    if !fortran() {
        return;
    }
    let user_dir = UserFolder::new();
    let [deck, file] = pushed_and_driven(&user_dir);
    let output = user_dir.run(&deck, &[&file], &[]);
    assert!(output.status.success(), "{}", message_text(&output));
    let summary = user_dir.summary("two");
    let last = |name: &str| summary["history"][name]["final"].as_f64().expect("a value");
    // F = 6 t on a mass of 2: v = 1.5 t^2 reaches 3 at t = sqrt(2), when the subroutine ends the step.
    let end = summary["steps"][0]["time"].as_f64().expect("a time");
    assert!((end - 2f64.sqrt()).abs() < 0.05, "{end}");
    assert!((last("V2@FREE") / (1.5 * end * end) - 1.0).abs() < 1e-3, "{}", last("V2@FREE"));
    assert!((last("U2@FREE") / (0.5 * end.powi(3)) - 1.0).abs() < 1e-3);
    assert!((last("V2@DRIVEN") / (3.0 * end * end) - 1.0).abs() < 1e-9);
    assert!((last("U2@DRIVEN") / end.powi(3) - 1.0).abs() < 1e-3);
    let log = std::fs::read_to_string(user_dir.path("log")).expect("the subroutine's own file");
    let words: Vec<&str> = log.split_whitespace().collect();
    assert_eq!(words, ["0", "1", "1", "1", "5", "1", "6", "1"]);
}

/// Sensors of coordinates, reactions, elements and energies: bodies that move with the velocity of a sensor have, one
/// increment later, the value of its history.
#[test]
fn sensors_have_the_values_of_histories() {
    if !fortran() {
        return;
    }
    let source = "      subroutine vuamp(ampName, time, ampValueOld, dt, nprops, props, nSvars, svars, lFlagsInfo, nSensor,\n     \
        1 sensorValues, sensorNames, jSensorLookUpTable, ampValueNew, lFlagsDefine, ampDerivative, ampSecDerivative, ampIncIntegral)\n      \
        include 'vaba_param.inc'\n      dimension time(2), props(nprops), svars(nSvars), lFlagsInfo(*), sensorValues(nSensor), lFlagsDefine(*)\n      \
        character*80 sensorNames(nSensor), ampName\n      \
        ampValueNew = vGetSensorValue(ampName, jSensorLookUpTable, sensorValues)\n      end\n";
    let sensors = [
        ("PLACE", "Node Output, nset=TOP", "COOR2@TOP"),
        ("FORCE", "Node Output, nset=FOOT", "RF2@FOOT"),
        ("STRESS", "Element Output, elset=E", "S22@E"),
        ("ENERGY", "Energy Output", "ALLIE"),
    ];
    let mut deck = String::from(
        "*Heading\n sensors\n*Node, nset=ALL\n 1, 0., 0.\n 2, 1., 0.\n 3, 1., 1.\n 4, 0., 1.\n 11, 5., 0.\n 12, 6., 0.\n 13, 7., 0.\n 14, 8., 0.\n\
         *Nset, nset=TOP\n 4\n*Nset, nset=FOOT\n 1\n*Nset, nset=UPPER\n 3, 4\n\
         *Element, type=CAX4R, elset=E\n 1, 1, 2, 3, 4\n*Solid Section, elset=E, material=M\n*Material, name=M\n*Density\n 1000.,\n*Elastic\n 1e9, 0.\n\
         *Initial Conditions, type=VELOCITY\n UPPER, 2, 10.\n",
    );
    let mut step = String::from(
        "*Step\n*Dynamic, Explicit, direct user control\n 1.e-5, 1.e-3\n*Boundary\n 1, 1, 2\n 2, 2\n 4, 1\n",
    );
    let mut outputs = String::from("*Output, history, op=ADD, time interval=1.e-5\n");
    // A sensor that is not written.
    step += "*Output, history, sensor, name=SILENT, frequency=0\n*Node Output, nset=TOP\n V2\n";
    for (i, (name, region, column)) in sensors.iter().enumerate() {
        let node = 11 + i;
        deck += &format!(
            "*Element, type=MASS, elset=B{node}\n {node}, {node}\n*Mass, elset=B{node}\n 1.,\n*Nset, nset=N{node}\n {node}\n\
             *Rigid Body, ref node={node}, elset=B{node}\n*Amplitude, name={name}, definition=USER\n"
        );
        let variable = column.split('@').next().expect("a variable");
        step += &format!("*Boundary, type=VELOCITY, amplitude={name}\n {node}, 2, 2, 1.\n");
        outputs += &format!("*{region}\n {variable}\n*Node Output, nset=N{node}\n V2\n");
        step += &format!("*Output, history, sensor, name={name}\n*{region}\n {variable}\n");
    }
    let user_dir = UserFolder::new();
    let file = user_dir.write("pick.f", source);
    let path = user_dir.write("sensors.inp", &(deck + &step + &outputs + "*End Step\n"));
    let output = user_dir.run(&path, &[&file], &[]);
    assert!(output.status.success(), "{}", message_text(&output));
    let history = std::fs::read_to_string(user_dir.path("out/sensors_history.csv")).expect("a history");
    let mut lines = history.lines().filter(|line| !line.starts_with('#'));
    let names: Vec<&str> = lines.next().expect("names").split(',').collect();
    let rows: Vec<Vec<f64>> =
        lines.map(|line| line.split(',').map(|value| value.parse().unwrap_or(f64::NAN)).collect()).collect();
    let column = |name: &str| {
        let index = names.iter().position(|known| *known == name).unwrap_or_else(|| panic!("{name} in {names:?}"));
        rows.iter().map(|row| row[index]).collect::<Vec<f64>>()
    };
    for (i, (_, _, name)) in sensors.iter().enumerate() {
        let (sensed, velocity) = (column(name), column(&format!("V2@N{}", 11 + i)));
        let largest = sensed.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
        assert!(largest > 0.0 && sensed.len() > 90, "{name}: {largest}");
        // A history of a reaction is the mean since the last row, a sensor is that of the last increment.
        let tolerance = if name.starts_with("RF") { 0.02 } else { 1e-6 };
        for (k, (value, next)) in sensed.iter().zip(&velocity[1..]).enumerate().skip(2) {
            assert!((value - next).abs() < tolerance * largest, "{name}, row {k}: {value} and {next}");
        }
    }
}

#[test]
fn sweep_gives_each_run_its_own_subroutine_state() {
    if !fortran() {
        return;
    }
    let user_dir = UserFolder::new();
    // The pressure grows with every call, so that a state shared between runs would be detected.
    let file = user_dir.write(
        "load.f",
        &vdload("      save n\n      data n /0/\n      n = n + 1\n      value = 1.d8*(1.d0 + 1.d-3*n)"),
    );
    let sweep = |threads: &str| {
        let output = Command::new(env!("CARGO_BIN_EXE_revolve"))
            .args([
                "sweep",
                "--set",
                "V=569,569,569,569,569,569",
                "--quantity",
                "-1000*final(U2@REF)",
                "--threads",
                threads,
            ])
            .arg("--user")
            .arg(&file)
            .arg("--out")
            .arg(user_dir.path("out"))
            .arg(user_deck())
            .env("XDG_CACHE_HOME", user_dir.path("cache"))
            .output()
            .expect("the program runs");
        assert!(output.status.success(), "{}", message_text(&output));
        let csv = std::fs::read_dir(user_dir.path("out")).expect("files").filter_map(Result::ok);
        let csv = csv.map(|e| e.path()).find(|p| p.extension().is_some_and(|e| e == "csv")).expect("a table");
        std::fs::read_to_string(csv).expect("a table")
    };
    let (one, two) = (sweep("1"), sweep("2"));
    assert_eq!(one, two);
    let rows: Vec<&str> = one.lines().skip(1).collect();
    assert!(rows.len() == 6 && rows.iter().all(|r| *r == rows[0]), "{one}");
}

/// The examples in both languages have the same arithmetic and give the same bits.
#[test]
fn rust_and_fortran_give_the_same_bits() {
    if !fortran() {
        return;
    }
    for twin in &rust_and_fortran::TWINS {
        let rust = twin.fly(&(twin.in_rust)()).expect("a run in Rust");
        let fortran = twin.in_fortran().and_then(|routines| twin.fly(&routines)).expect("a run in Fortran");
        let name = twin.name;
        assert_eq!(rust.map(f64::to_bits), fortran.map(f64::to_bits), "{name}: {rust:?} against {fortran:?}");
        assert!(rust[0] < -1e-3, "{name} moves: {rust:?}");
    }
}

/// The impulse of the blast by quadrature, independent of increments: v = -I / (rho t pi R^2).
#[test]
fn blast_impulse_matches_its_integral() {
    let [twin, ..] = &rust_and_fortran::TWINS;
    let load = twin.in_rust;
    let [_, velocity] = twin.fly(&load()).expect("a run");
    // Every point receives the same impulse: the integral of peak (1 - s) exp(-decay s) duration over s from 0 to 1.
    let n = 20_000;
    let sum: f64 = (0..n).map(|i| (f64::from(i) + 0.5) / f64::from(n)).map(|s| (1.0 - s) * (-1.5 * s).exp()).sum();
    let expected = -2e6 * 1e-3 * sum / f64::from(n) / (7850.0 * 0.02);
    assert!((velocity / expected - 1.0).abs() < 2e-3, "{velocity} against {expected}");
    // The wave arrives within one of the long increments of a body at rest. At this accuracy the next 500 increments are
    // so short that the drift of the first one remains large relative to the energy.
    let deck = std::fs::read_to_string(common::project("input/blast_disk.inp")).expect("the deck");
    let deck = deck.replace("*Dynamic, Explicit\n", "*Dynamic, Explicit, accuracy=1e-7\n");
    let (outcome, memory) = common::run(&deck, &[], &load());
    assert_eq!(outcome.halt, None);
    let fine = memory.rows.last().expect("rows").1[1];
    assert!((fine / expected - 1.0).abs() < 2e-3, "{fine} against {expected}");
}

/// The resistance of `input/vdload_cavity.f`.
#[test]
fn cavity_resistance_has_the_same_bits_in_rust_and_fortran() {
    if !fortran() {
        return;
    }
    let deck = std::fs::read_to_string(user_deck()).expect("the deck");
    let run = |routines: &Routines| {
        let (outcome, _) = common::run(&deck, &[], routines);
        (outcome.increments, outcome.rests[0].displacement.to_bits())
    };
    let compiled = compile(&[common::project("input/vdload_cavity.f")], false).expect("a library");
    assert_eq!(run(&Routines::none().with_load(CavityResistance)), run(&compiled.open().expect("routines")));
}
