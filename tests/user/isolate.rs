//! Routines in a process of their own (`--isolate`).
//!
//! Goal: the bits are those of routines in the process of the run, and whatever a routine does to its process the run ends in
//! order, with words that say where. In C, which has the means.

use std::path::{Path, PathBuf};
use std::process::Output;

use super::fields::{TWICE, sheared};
use super::subroutines::{Desk, fortran, pushed_and_driven, told, user_deck, vdload};
use crate::common::project;

/// A load that remembers and does something first.
fn load(desk: &Desk, name: &str, before: &str) -> PathBuf {
    let text = format!(
        "#define _GNU_SOURCE\n#include <fenv.h>\n#include <math.h>\n#include <signal.h>\n#include <stdlib.h>\n#include <stdio.h>\n\
         #include <unistd.h>\nvoid xplb_exit_(void);\nstatic int calls; static double path;\n\
         void vdload_(const int *nblock, const int *ndim, const double *st, const double *tt, const double *amplitude,\n \
         const double *x, const double *v, const double *d, const int *jltyp, const char *sname, double *value, long n)\n{{\n  \
         int count = *nblock;\n  calls++; path += 1e-6*v[count];\n  \
         for (int k = 0; k < count; k++) value[k] = 1e8 + 1e6*v[count+k] - 1e9*path*fabs(d[2*count+k]) + x[k];\n  {before}\n}}\n"
    );
    desk.write(&format!("{name}.c"), &text)
}

fn run(desk: &Desk, file: &Path, more: &[&str]) -> Output {
    desk.run(&user_deck(), &[file], &[&["--isolate"], more].concat())
}

/// The results but for times and shares of them.
fn results(desk: &Desk) -> String {
    results_of(desk, "ogive_user")
}

fn results_of(desk: &Desk, job: &str) -> String {
    let mut summary = desk.summary(job);
    summary["timing"] = serde_json::Value::Null;
    for row in summary["ledger"]["effects"].as_array_mut().expect("rows") {
        row.as_object_mut().expect("a row").remove("share");
    }
    summary.to_string()
}

#[test]
fn the_bits_are_those_of_the_same_process() {
    let desk = Desk::new();
    let mut files = vec![load(&desk, "plain", ""), load(&desk, "rounds", "fesetround(FE_UPWARD);")];
    if fortran() {
        files.push(project("input/vdload_cavity.f"));
    }
    for file in files {
        for facets in ["n=20", "n=700"] {
            let output = desk.run(&user_deck(), &[&file], &["--set", facets]);
            assert!(output.status.success(), "{}", told(&output));
            let expected = results(&desk);
            let output = run(&desk, &file, &["--set", facets]);
            assert!(output.status.success(), "{}", told(&output));
            assert_eq!(results(&desk), expected, "{} {facets}", file.display());
        }
    }
}

/// What a routine does to its own process costs that process: the run has its last frame, histories and summary.
#[test]
fn a_routine_that_goes_leaves_the_run() {
    for (name, before, words) in [
        ("wild", "if (calls == 9) { volatile int *p = 0; *p = 1; }", "accessed invalid memory"),
        ("tramples", "if (calls == 9) for (long k = 0; ; k++) value[k] = 1e30;", "accessed invalid memory"),
        ("divides", "if (calls == 9) raise(SIGFPE);", "divided an integer by zero"),
        ("aborts", "if (calls == 9) abort();", "aborted"),
        ("leaves", "if (calls == 9) _exit(0);", "left the process without a word"),
        ("ends", "if (calls == 9) exit(0);", "ended the process"),
        ("killed", "if (calls == 9) kill(getpid(), SIGKILL);", "signal 9 ended its process"),
        ("stops", "if (calls == 9) xplb_exit_();", "called xplb_exit"),
        ("writes past", "if (calls == 9) value[count] = 1;", "wrote past the end of its argument value"),
        ("leaves out", "if (calls == 9) value[3] = NAN;", "at point 4"),
    ] {
        let desk = Desk::new();
        let output = run(&desk, &load(&desk, name, before), &[]);
        assert_eq!(output.status.code(), Some(1), "{name}: {}", told(&output));
        let summary = desk.summary("ogive_user");
        let reason = summary["reason"].as_str().expect("a reason");
        for word in ["R201", "NOSE", "step 1, increment 8", words] {
            assert!(reason.contains(word), "{name}: `{word}` in {reason}");
        }
        assert!(summary["status"] == "halted" && desk.path("out/ogive_user_history.csv").exists(), "{name}");
        assert!(summary["digest"].as_str().is_some_and(|digest| digest.len() == 64), "{name}");
    }
}

/// A library that goes while it is opened.
#[test]
fn an_initialiser_that_goes_is_told() {
    let desk = Desk::new();
    let file = load(&desk, "begins", "");
    let mut text = std::fs::read_to_string(&file).expect("a source");
    text += "__attribute__((constructor)) static void begin(void) { if (getenv(\"GO\")) _exit(3); }\n";
    std::fs::write(&file, text).expect("a source");
    let output = run(&desk, &file, &[]);
    assert!(output.status.success(), "{}", told(&output));
    let output = desk.run_with(&[("GO", PathBuf::from("1"))], &user_deck(), &[&file], &["--isolate"]);
    assert!(output.status.code() == Some(2) && told(&output).contains("status 3"), "{}", told(&output));
}

/// Checkpoints hold what the routine keeps to itself, over there as here.
#[test]
fn a_run_goes_on_with_the_memory_of_the_other_process() {
    let desk = Desk::new();
    let file = load(&desk, "remembers", "if (*tt > 1e-4 && !getenv(\"GO\")) kill(getppid(), SIGTERM);");
    let go = [("GO", PathBuf::from("1"))];
    let whole = desk.run_with(&go, &user_deck(), &[&file], &[]);
    assert!(whole.status.success(), "{}", told(&whole));
    let expected = results(&desk);
    assert_eq!(run(&desk, &file, &[]).status.code(), Some(143));
    let output = desk.run_with(&go, &user_deck(), &[&file], &["--isolate", "--resume"]);
    assert!(output.status.success(), "{}", told(&output));
    assert_eq!(results(&desk), expected);
    assert_eq!(run(&desk, &file, &[]).status.code(), Some(143));
    // The other way round: from there to here.
    let output = desk.run_with(&go, &user_deck(), &[&file], &["--resume"]);
    assert!(output.status.success(), "{}", told(&output));
    assert_eq!(results(&desk), expected);
}

/// A Taylor bar whose flow is in a file of the user.
fn bar(cards: &str) -> String {
    let text =
        std::fs::read_to_string(project("input/taylor_vumat.inp")).expect("the deck").replace("nz = 25", "nz = 10");
    let [from, to] = ["*User Material", "*Initial Conditions"].map(|card| text.find(card).expect("the card"));
    format!("{}{cards}{}", &text[..from], &text[to..])
}

/// Amplitude, motion, events, material, hardening, lengths: arguments are the same over there, state variables and answers too.
#[test]
fn other_routines_have_the_same_bits() {
    if !fortran() {
        return;
    }
    let desk = Desk::new();
    let hardening = bar("*Elastic\n 117.e9, 0.35\n*Plastic, hardening=USER, properties=8\n \
                         90.e6, 292.e6, 0.31, 0.025, 1.09, 1., 20., 1083.\n");
    let shear = sheared("*Characteristic Length, definition=USER, properties=1\n 2.,\n");
    let runs = [
        ("two", pushed_and_driven(&desk)),
        ("taylor_vumat", [project("input/taylor_vumat.inp"), project("input/vumat_hardening.f90")]),
        ("hardens", [desk.write("hardens.inp", &hardening), project("input/vuhard_johnson_cook.f90")]),
        ("shears", [desk.write("shears.inp", &shear), desk.write("twice.f90", TWICE)]),
    ];
    for (job, [deck, file]) in &runs {
        let log = || std::fs::read_to_string(desk.path("out/log")).unwrap_or_default();
        let output = desk.run(deck, &[file], &[]);
        assert!(output.status.success(), "{job}: {}", told(&output));
        let expected = (results_of(&desk, job), log());
        let output = desk.run(deck, &[file], &["--isolate"]);
        assert!(output.status.success(), "{job}: {}", told(&output));
        assert_eq!((results_of(&desk, job), log()), expected, "{job}");
    }
}

/// A material that goes, or writes past what it was given, leaves the run.
#[test]
fn a_material_that_goes_leaves_the_run() {
    if !fortran() {
        return;
    }
    let source = std::fs::read_to_string(project("input/vumat_hardening.f90")).expect("the example");
    let first = "  twog = props(1)";
    assert!(source.contains(first));
    for (statement, words) in [
        ("  if (totalTime .gt. 1.d-6) call kill(getpid(), 9)\n", "signal 9 ended its process"),
        (
            "  if (totalTime .gt. 1.d-6) stateNew(nblock*nstatev + 1, 1) = 1.d0\n",
            "past the end of its argument stateNew",
        ),
    ] {
        let desk = Desk::new();
        let file = desk.write("goes.f90", &source.replacen(first, &format!("{statement}{first}"), 1));
        let output = desk.run(&project("input/taylor_vumat.inp"), &[&file], &["--isolate"]);
        assert_eq!(output.status.code(), Some(1), "{}", told(&output));
        let reason = desk.summary("taylor_vumat")["reason"].to_string();
        for word in ["R201", "COPPER", "step 1", words] {
            assert!(reason.contains(word), "`{word}` in {reason}");
        }
    }
}

#[test]
fn what_is_not_covered_is_refused_by_its_name() {
    let desk = Desk::new();
    let file = load(&desk, "fields", "");
    let mut text = std::fs::read_to_string(&file).expect("a source");
    text += "void vusdfld_(void) {}\n";
    std::fs::write(&file, text).expect("a source");
    let output = run(&desk, &file, &[]);
    assert_eq!(output.status.code(), Some(2), "{}", told(&output));
    for word in ["U012", "vusdfld"] {
        assert!(told(&output).contains(word), "{}", told(&output));
    }
}

/// The job's name, messages and output of the routine arrive.
#[test]
fn messages_and_output_arrive() {
    if !fortran() {
        return;
    }
    let desk = Desk::new();
    let body = "      character*80 job\n      call vgetjobname(job, length)\n      write(*,*) 'said by ', job(1:length)\n      \
                if (totalTime .eq. 0.) call xplb_abqerr(-1, 'job of %I letters', length, 0.d0, ' ')\n      \
                value(1:nblock) = 1.d8\n";
    let file = desk.write("tells.f", &vdload(body));
    let output = run(&desk, &file, &[]);
    assert!(output.status.success(), "{}", told(&output));
    assert!(desk.summary("ogive_user")["messages"].to_string().contains("job of 10 letters"));
    let said = String::from_utf8_lossy(&output.stdout);
    let increments = desk.summary("ogive_user")["timing"]["increments"].as_u64().expect("a number");
    assert_eq!(said.matches("said by ogive_user").count() as u64, increments + 1, "{said}");
}
