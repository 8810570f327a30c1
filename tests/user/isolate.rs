//! User subroutines in a separate process (`--isolate`).
//!
//! Goal: the bits are those of subroutines in the same process, and if a subroutine ends or damages its process, the
//! run ends in order with a located message. The subroutines are in C.

use std::path::{Path, PathBuf};
use std::process::Output;

use super::fields::{TWICE, sheared};
use super::subroutines::{UserFolder, fortran, message_text, pushed_and_driven, user_deck, vdload};
use crate::common::project;

/// Writes a load with internal state that executes a statement first.
fn load(user_dir: &UserFolder, name: &str, before: &str) -> PathBuf {
    let text = format!(
        "#define _GNU_SOURCE\n#include <fenv.h>\n#include <math.h>\n#include <signal.h>\n#include <stdlib.h>\n#include <stdio.h>\n\
         #include <unistd.h>\nvoid xplb_exit_(void);\nstatic int calls; static double path;\n\
         void vdload_(const int *nblock, const int *ndim, const double *st, const double *tt, const double *amplitude,\n \
         const double *x, const double *v, const double *d, const int *jltyp, const char *sname, double *value, long n)\n{{\n  \
         int count = *nblock;\n  calls++; path += 1e-6*v[count];\n  \
         for (int k = 0; k < count; k++) value[k] = 1e8 + 1e6*v[count+k] - 1e9*path*fabs(d[2*count+k]) + x[k];\n  {before}\n}}\n"
    );
    user_dir.write(&format!("{name}.c"), &text)
}

fn run(user_dir: &UserFolder, file: &Path, more: &[&str]) -> Output {
    user_dir.run(&user_deck(), &[file], &[&["--isolate"], more].concat())
}

/// Returns the results without times.
fn results(user_dir: &UserFolder) -> String {
    results_of(user_dir, "ogive_user")
}

fn results_of(user_dir: &UserFolder, job: &str) -> String {
    let mut summary = user_dir.summary(job);
    summary["timing"] = serde_json::Value::Null;
    summary["provenance"] = serde_json::Value::Null;
    for row in summary["ledger"]["effects"].as_array_mut().expect("rows") {
        row.as_object_mut().expect("a row").remove("share");
    }
    summary.to_string()
}

#[test]
fn isolated_load_has_the_same_bits() {
    let user_dir = UserFolder::new();
    let mut files = vec![load(&user_dir, "plain", ""), load(&user_dir, "rounds", "fesetround(FE_UPWARD);")];
    if fortran() {
        files.push(project("input/vdload_cavity.f"));
    }
    for file in files {
        for facets in ["n=20", "n=700"] {
            let output = user_dir.run(&user_deck(), &[&file], &["--set", facets]);
            assert!(output.status.success(), "{}", message_text(&output));
            let expected = results(&user_dir);
            let output = run(&user_dir, &file, &["--set", facets]);
            assert!(output.status.success(), "{}", message_text(&output));
            assert_eq!(results(&user_dir), expected, "{} {facets}", file.display());
        }
    }
}

/// A subroutine that ends its own process: the run writes its last frame, histories and summary.
#[test]
fn crashed_load_halts_the_run_with_results() {
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
        let user_dir = UserFolder::new();
        let output = run(&user_dir, &load(&user_dir, name, before), &[]);
        assert_eq!(output.status.code(), Some(1), "{name}: {}", message_text(&output));
        let summary = user_dir.summary("ogive_user");
        let reason = summary["reason"].as_str().expect("a reason");
        for word in ["R201", "NOSE", "step 1, increment 8", words] {
            assert!(reason.contains(word), "{name}: `{word}` in {reason}");
        }
        assert!(summary["status"] == "halted" && user_dir.path("out/ogive_user_history.csv").exists(), "{name}");
        assert!(summary["digest"].as_str().is_some_and(|digest| digest.len() == 64), "{name}");
    }
}

/// A library that ends the process while it is loaded.
#[test]
fn crashed_initialiser_is_reported() {
    let user_dir = UserFolder::new();
    let file = load(&user_dir, "begins", "");
    let mut text = std::fs::read_to_string(&file).expect("a source");
    text += "__attribute__((constructor)) static void begin(void) { if (getenv(\"GO\")) _exit(3); }\n";
    std::fs::write(&file, text).expect("a source");
    let output = run(&user_dir, &file, &[]);
    assert!(output.status.success(), "{}", message_text(&output));
    let output = user_dir.run_with(&[("GO", PathBuf::from("1"))], &user_deck(), &[&file], &["--isolate"]);
    assert!(output.status.code() == Some(2) && message_text(&output).contains("status 3"), "{}", message_text(&output));
}

/// Checkpoints contain the internal state of user subroutines in either process.
#[test]
fn checkpoints_restore_state_in_either_process() {
    let user_dir = UserFolder::new();
    let file = load(&user_dir, "remembers", "if (*tt > 1e-4 && !getenv(\"GO\")) kill(getppid(), SIGTERM);");
    let go = [("GO", PathBuf::from("1"))];
    let whole = user_dir.run_with(&go, &user_deck(), &[&file], &[]);
    assert!(whole.status.success(), "{}", message_text(&whole));
    let expected = results(&user_dir);
    assert_eq!(run(&user_dir, &file, &[]).status.code(), Some(143));
    let output = user_dir.run_with(&go, &user_deck(), &[&file], &["--isolate", "--resume"]);
    assert!(output.status.success(), "{}", message_text(&output));
    assert_eq!(results(&user_dir), expected);
    assert_eq!(run(&user_dir, &file, &[]).status.code(), Some(143));
    // The reverse: from the separate process to the same one.
    let output = user_dir.run_with(&go, &user_deck(), &[&file], &["--resume"]);
    assert!(output.status.success(), "{}", message_text(&output));
    assert_eq!(results(&user_dir), expected);
}

/// Returns a Taylor bar whose plasticity is defined by `cards`.
fn bar(cards: &str) -> String {
    let text =
        std::fs::read_to_string(project("input/taylor_vumat.inp")).expect("the deck").replace("nz = 25", "nz = 10");
    let [from, to] = ["*User Material", "*Initial Conditions"].map(|card| text.find(card).expect("the card"));
    format!("{}{cards}{}", &text[..from], &text[to..])
}

/// Amplitude, motion, events, material, hardening, lengths: identical arguments, state variables and results in both
/// processes.
#[test]
fn other_isolated_subroutines_have_the_same_bits() {
    if !fortran() {
        return;
    }
    let user_dir = UserFolder::new();
    let hardening = bar("*Elastic\n 117.e9, 0.35\n*Plastic, hardening=USER, properties=8\n \
                         90.e6, 292.e6, 0.31, 0.025, 1.09, 1., 20., 1083.\n");
    let shear = sheared("*Characteristic Length, definition=USER, properties=1\n 2.,\n");
    let runs = [
        ("two", pushed_and_driven(&user_dir)),
        ("taylor_vumat", [project("input/taylor_vumat.inp"), project("input/vumat_hardening.f90")]),
        ("hardens", [user_dir.write("hardens.inp", &hardening), project("input/vuhard_johnson_cook.f90")]),
        ("shears", [user_dir.write("shears.inp", &shear), user_dir.write("twice.f90", TWICE)]),
    ];
    for (job, [deck, file]) in &runs {
        let log = || std::fs::read_to_string(user_dir.path("log")).unwrap_or_default();
        let output = user_dir.run(deck, &[file], &[]);
        assert!(output.status.success(), "{job}: {}", message_text(&output));
        let expected = (results_of(&user_dir, job), log());
        let output = user_dir.run(deck, &[file], &["--isolate"]);
        assert!(output.status.success(), "{job}: {}", message_text(&output));
        assert_eq!((results_of(&user_dir, job), log()), expected, "{job}");
    }
}

/// A material that ends its process or writes beyond its arrays does not stop the output of the run.
#[test]
fn crashed_material_halts_the_run_with_results() {
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
        let user_dir = UserFolder::new();
        let file = user_dir.write("goes.f90", &source.replacen(first, &format!("{statement}{first}"), 1));
        let output = user_dir.run(&project("input/taylor_vumat.inp"), &[&file], &["--isolate"]);
        assert_eq!(output.status.code(), Some(1), "{}", message_text(&output));
        let reason = user_dir.summary("taylor_vumat")["reason"].to_string();
        for word in ["R201", "COPPER", "step 1", words] {
            assert!(reason.contains(word), "`{word}` in {reason}");
        }
    }
}

#[test]
fn unsupported_subroutines_are_rejected_by_name() {
    let user_dir = UserFolder::new();
    let file = load(&user_dir, "fields", "");
    let mut text = std::fs::read_to_string(&file).expect("a source");
    text += "void vusdfld_(void) {}\n";
    std::fs::write(&file, text).expect("a source");
    let output = run(&user_dir, &file, &[]);
    assert_eq!(output.status.code(), Some(2), "{}", message_text(&output));
    for word in ["U012", "vusdfld"] {
        assert!(message_text(&output).contains(word), "{}", message_text(&output));
    }
}

/// The job name, messages and output of the subroutine are passed on.
#[test]
fn messages_and_output_are_passed_on() {
    if !fortran() {
        return;
    }
    let user_dir = UserFolder::new();
    let body = "      character*80 job\n      call vgetjobname(job, length)\n      write(*,*) 'said by ', job(1:length)\n      \
                if (totalTime .eq. 0.) call xplb_abqerr(-1, 'job of %I letters', length, 0.d0, ' ')\n      \
                value(1:nblock) = 1.d8\n";
    let file = user_dir.write("tells.f", &vdload(body));
    let output = run(&user_dir, &file, &[]);
    assert!(output.status.success(), "{}", message_text(&output));
    assert!(user_dir.summary("ogive_user")["messages"].to_string().contains("job of 10 letters"));
    let rendered = String::from_utf8_lossy(&output.stdout);
    let increments = user_dir.summary("ogive_user")["timing"]["increments"].as_u64().expect("a number");
    assert_eq!(rendered.matches("said by ogive_user").count() as u64, increments + 1, "{rendered}");
}
