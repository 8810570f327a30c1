//! What routines do to the process that calls them.
//!
//! Goal: the run is the one it would be without, what was set right is told with the routine's name, and nothing that ended
//! early looks like a success. In C, which has the means.

use std::path::PathBuf;

use super::subroutines::{Desk, FILL, fortran, told, user_deck, vdload};

/// A load of constant pressure that does something first, with a count of its calls.
fn load(desk: &Desk, name: &str, before: &str) -> PathBuf {
    let text = format!(
        "#define _GNU_SOURCE\n#include <fenv.h>\n#include <unistd.h>\n#include <stdlib.h>\n#include <stdio.h>\n#include <pthread.h>\n#include <signal.h>\n\
         #include <sys/wait.h>\nstatic int calls;\nstatic void *forever(void *x) {{ for (;;) {{ volatile double y = calls; (void)y; }} return x; }}\n\
         static void *once(void *x) {{ return x; }}\n void start(void) {{ pthread_t t; pthread_create(&t, 0, forever, 0); }}\n\
         static void mark(void) {{ FILE *f = fopen(\"calls\", \"a\"); fputc('x', f); fclose(f); }}\n\
         void vdload_(const int *nblock, const int *ndim, const double *st, const double *tt, const double *amplitude,\n \
         const double *x, const double *v, const double *d, const int *jltyp, const char *sname, double *value, long n)\n{{\n  \
         calls++;\n  for (int k = 0; k < *nblock; k++) value[k] = 1e8 + 1e6*v[k];\n  {before}\n}}\n"
    );
    desk.write(&format!("{name}.c"), &text)
}

fn digest(desk: &Desk) -> String {
    desk.summary("ogive_user")["digest"].as_str().expect("a digest").to_owned()
}

fn run_of(desk: &Desk, name: &str, before: &str) -> std::process::Output {
    // Relative, as a user gives it: the working folder decides where it is.
    let file = load(desk, name, before);
    let mut command = desk.command(&user_deck(), &[&file]);
    command.args(["--quiet"]).output().expect("the program runs")
}

#[test]
fn arithmetic_and_folder_are_set_back_and_told() {
    let desk = Desk::new();
    std::fs::create_dir(desk.path("elsewhere")).expect("a folder");
    let plain = run_of(&desk, "plain", "");
    assert!(plain.status.success(), "{}", told(&plain));
    let expected = digest(&desk);
    for (name, before, words) in [
        ("rounds", "fesetround(FE_UPWARD);", "rounding mode"),
        ("flushes", "__builtin_ia32_ldmxcsr(0x9fc0);", "rounding mode"),
        ("traps", "feenableexcept(FE_INEXACT);", "rounding mode"),
        ("moves", "chdir(\"elsewhere\");", "working folder"),
        ("moves once", "if (calls == 7) { chdir(\"elsewhere\"); chdir(\"/\"); }", "working folder"),
    ] {
        if name == "flushes" && cfg!(not(target_arch = "x86_64")) {
            continue;
        }
        let output = run_of(&desk, name, before);
        assert!(output.status.success(), "{name}: {}", told(&output));
        assert_eq!(digest(&desk), expected, "{name}");
        let messages = desk.summary("ogive_user")["messages"].to_string();
        assert!(messages.contains("vdload") && messages.contains(words), "{name}: {messages}");
    }
    assert_eq!(std::fs::read_dir(desk.path("elsewhere")).expect("a folder").count(), 0);
}

#[test]
fn handlers_of_signals_are_set_back_and_told() {
    let desk = Desk::new();
    let plain = run_of(&desk, "plain", "");
    assert!(plain.status.success(), "{}", told(&plain));
    let expected = digest(&desk);
    let ignore = "struct sigaction a = {0}; a.sa_handler = SIG_IGN;";
    for (name, before, signal) in [
        ("signal", "signal(SIGINT, SIG_IGN);".to_owned(), 2),
        ("sigaction", format!("{ignore} sigaction(SIGSEGV, &a, 0);"), 11),
        ("twice", "signal(SIGTERM, SIG_IGN); signal(SIGTERM, SIG_DFL);".to_owned(), 15),
    ] {
        let output = run_of(&desk, name, &before);
        assert!(output.status.success(), "{name}: {}", told(&output));
        assert_eq!(digest(&desk), expected, "{name}");
        let messages = desk.summary("ogive_user")["messages"].to_string();
        assert!(messages.contains("vdload") && messages.contains(&format!("signal {signal}:")), "{name}: {messages}");
    }
    // One that the routine sets back itself is nobody's business.
    let balanced = format!("{ignore} struct sigaction b; sigaction(SIGINT, &a, &b); sigaction(SIGINT, &b, 0);");
    assert!(run_of(&desk, "balanced", &balanced).status.success());
    assert!(desk.summary("ogive_user").get("messages").is_none());
}

/// What a routine did about a signal holds no longer when the signal comes.
#[test]
fn signals_still_end_a_run_in_order() {
    let desk = Desk::new();
    let before = "if (calls < 9) signal(SIGTERM, SIG_IGN); if (calls == 9) kill(getpid(), SIGTERM);";
    let output = run_of(&desk, "ignores", before);
    assert_eq!(output.status.code(), Some(143), "{}", told(&output));
    assert!(desk.path("out/ogive_user.checkpoint").exists(), "{}", told(&output));
}

#[test]
fn handlers_of_fortran_are_set_back() {
    if !fortran() {
        return;
    }
    let desk = Desk::new();
    let body = format!("      external late\n      call signal(15, late)\n{FILL}");
    let file = desk.write("catches.f", &(vdload(&body) + "      subroutine late\n      end\n"));
    let output = desk.run(&user_deck(), &[&file], &[]);
    assert!(output.status.success(), "{}", told(&output));
    let messages = desk.summary("ogive_user")["messages"].to_string();
    assert!(messages.contains("vdload") && messages.contains("signal 15:"), "{messages}");
}

/// Results in a folder that is given from the working folder.
#[test]
fn a_folder_changed_does_not_lead_results_astray() {
    let desk = Desk::new();
    std::fs::create_dir(desk.path("elsewhere")).expect("a folder");
    let file = load(&desk, "moves", "chdir(\"elsewhere\");");
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_revolve"));
    command.args(["run", "--quiet", "--out", "here"]).arg(user_deck()).arg("--user").arg(file);
    let output = command.env("XDG_CACHE_HOME", desk.path("cache")).current_dir(desk.path("")).output();
    let output = output.expect("the program runs");
    assert!(output.status.success(), "{}", told(&output));
    assert!(desk.path("here/ogive_user.json").exists());
    assert_eq!(std::fs::read_dir(desk.path("elsewhere")).expect("a folder").count(), 0);
}

#[test]
fn leaving_the_process_is_no_success() {
    for (name, before) in [("small", "if (calls == 9) _exit(0);"), ("large", "if (calls == 9) _Exit(0);")] {
        let desk = Desk::new();
        let output = run_of(&desk, name, before);
        let message = told(&output);
        assert_eq!(output.status.code(), Some(1), "{name}: {message}");
        for word in ["vdload", "NOSE", "left the process", "step 1", "increment"] {
            assert!(message.contains(word), "{name}: `{word}` in\n{message}");
        }
        assert!(!desk.path("out/ogive_user.json").exists(), "{name}");
    }
}

#[test]
fn a_child_of_a_routine_does_not_run_the_job_on() {
    let count = |desk: &Desk| std::fs::read(desk.path("calls")).expect("marks").len();
    let desk = Desk::new();
    assert!(run_of(&desk, "alone", "mark();").status.success());
    let (expected, marks) = (digest(&desk), count(&desk));
    for (name, before) in [
        ("comes back", "mark(); if (calls == 9) fork();"),
        ("leaves", "mark(); if (calls == 9) { if (fork() == 0) _exit(0); wait(0); }"),
        ("exits", "mark(); if (calls == 9) { if (fork() == 0) exit(0); wait(0); }"),
    ] {
        let desk = Desk::new();
        // Waits until nobody has its pipes any more: until the child, too, has gone.
        let output = run_of(&desk, name, before);
        assert!(output.status.success(), "{name}: {}", told(&output));
        assert_eq!((digest(&desk), count(&desk)), (expected.clone(), marks), "{name}");
        assert!(!told(&output).contains("error"), "{name}: {}", told(&output));
        assert_eq!(told(&output).contains("forked"), name == "comes back", "{name}: {}", told(&output));
    }
}

#[test]
fn a_thread_that_lives_on_ends_with_the_process() {
    let desk = Desk::new();
    let output = run_of(&desk, "threads", "if (calls == 3) start();");
    assert!(output.status.success(), "{:?} {}", output.status, told(&output));
    assert_eq!(desk.summary("ogive_user")["status"], "completed");
    let messages = desk.summary("ogive_user")["messages"].to_string();
    assert!(messages.contains("vdload started a thread that still runs"), "{messages}");
    let output = run_of(&desk, "more", "if (calls == 3 || calls == 5) start();");
    assert!(output.status.success(), "{:?} {}", output.status, told(&output));
    let messages = desk.summary("ogive_user")["messages"].to_string();
    assert!(messages.contains("vdload started 2 threads"), "{messages}");
    let joined = "pthread_t t; if (calls == 3) { pthread_create(&t, 0, once, 0); pthread_join(t, 0); }";
    let output = run_of(&desk, "joins", joined);
    assert!(output.status.success(), "{:?} {}", output.status, told(&output));
    assert!(desk.summary("ogive_user").get("messages").is_none());
}

/// Memory that another thread may change at any time is not what a checkpoint holds.
#[test]
fn a_thread_that_lives_on_is_no_part_of_a_checkpoint() {
    let desk = Desk::new();
    let output = run_of(&desk, "threads", "if (calls == 3) start(); if (calls == 9) kill(getpid(), SIGTERM);");
    assert_eq!(output.status.code(), Some(143), "{}", told(&output));
    assert!(told(&output).contains("a thread that vdload started still runs"), "{}", told(&output));
    let file = desk.path("threads.c");
    let output = desk.run(&user_deck(), &[&file], &["--resume"]);
    assert_eq!(output.status.code(), Some(2), "{}", told(&output));
    assert!(told(&output).contains("K009") && told(&output).contains("a thread that vdload"), "{}", told(&output));
}

/// Once when the library is built, to find what is missing; then once for the run.
#[test]
fn initialisers_run_once_for_a_run() {
    let desk = Desk::new();
    let file = load(&desk, "begins", "");
    let mut text = std::fs::read_to_string(&file).expect("a source");
    text += "__attribute__((constructor)) static void begin(void) { mark(); fesetround(FE_UPWARD); signal(SIGTERM, SIG_IGN); \
             chdir(\"/\"); }\n";
    std::fs::write(&file, text).expect("a source");
    for expected in [2, 3, 4] {
        let output = desk.run(&user_deck(), &[&file], &[]);
        assert!(output.status.success(), "{}", told(&output));
        assert_eq!(std::fs::read(desk.path("calls")).expect("marks").len(), expected);
    }
    let messages = desk.summary("ogive_user")["messages"].to_string();
    for word in ["initialiser of", "rounding mode", "signal 15:", "working folder"] {
        assert!(messages.contains(word), "{word}: {messages}");
    }
}
