//! Effects of user subroutines on the calling process.
//!
//! Goal: such effects are reverted and reported with the name of the subroutine, the results are unchanged, and an
//! early end of the process does not count as success. The subroutines are in C.

use std::path::PathBuf;

use super::subroutines::{FILL, UserFolder, fortran, message_text, user_deck, vdload};

/// Writes a load of constant pressure that counts its calls and executes a statement first.
fn load(user_dir: &UserFolder, name: &str, before: &str) -> PathBuf {
    let text = format!(
        "#define _GNU_SOURCE\n#include <fenv.h>\n#include <unistd.h>\n#include <stdlib.h>\n#include <stdio.h>\n#include <pthread.h>\n#include <signal.h>\n\
         #include <sys/wait.h>\nstatic int calls;\nstatic void *forever(void *x) {{ for (;;) {{ volatile double y = calls; (void)y; }} return x; }}\n\
         static void *once(void *x) {{ return x; }}\n void start(void) {{ pthread_t t; pthread_create(&t, 0, forever, 0); }}\n\
         static void mark(void) {{ FILE *f = fopen(\"calls\", \"a\"); fputc('x', f); fclose(f); }}\n\
         void vdload_(const int *nblock, const int *ndim, const double *st, const double *tt, const double *amplitude,\n \
         const double *x, const double *v, const double *d, const int *jltyp, const char *sname, double *value, long n)\n{{\n  \
         calls++;\n  for (int k = 0; k < *nblock; k++) value[k] = 1e8 + 1e6*v[k];\n  {before}\n}}\n"
    );
    user_dir.write(&format!("{name}.c"), &text)
}

fn digest(user_dir: &UserFolder) -> String {
    user_dir.summary("ogive_user")["digest"].as_str().expect("a digest").to_owned()
}

fn run_of(user_dir: &UserFolder, name: &str, before: &str) -> std::process::Output {
    // The path is relative, as a user may give it, so that it depends on the working folder.
    let file = load(user_dir, name, before);
    let mut command = user_dir.command(&user_deck(), &[&file]);
    command.args(["--quiet"]).output().expect("the program runs")
}

#[test]
fn arithmetic_mode_and_folder_are_restored_and_reported() {
    let user_dir = UserFolder::new();
    std::fs::create_dir(user_dir.path("elsewhere")).expect("a folder");
    let plain = run_of(&user_dir, "plain", "");
    assert!(plain.status.success(), "{}", message_text(&plain));
    let expected = digest(&user_dir);
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
        let output = run_of(&user_dir, name, before);
        assert!(output.status.success(), "{name}: {}", message_text(&output));
        assert_eq!(digest(&user_dir), expected, "{name}");
        let messages = user_dir.summary("ogive_user")["messages"].to_string();
        assert!(messages.contains("vdload") && messages.contains(words), "{name}: {messages}");
    }
    assert_eq!(std::fs::read_dir(user_dir.path("elsewhere")).expect("a folder").count(), 0);
}

#[test]
fn signal_handlers_are_restored_and_reported() {
    let user_dir = UserFolder::new();
    let plain = run_of(&user_dir, "plain", "");
    assert!(plain.status.success(), "{}", message_text(&plain));
    let expected = digest(&user_dir);
    let ignore = "struct sigaction a = {0}; a.sa_handler = SIG_IGN;";
    for (name, before, signal) in [
        ("signal", "signal(SIGINT, SIG_IGN);".to_owned(), 2),
        ("sigaction", format!("{ignore} sigaction(SIGSEGV, &a, 0);"), 11),
        ("twice", "signal(SIGTERM, SIG_IGN); signal(SIGTERM, SIG_DFL);".to_owned(), 15),
    ] {
        let output = run_of(&user_dir, name, &before);
        assert!(output.status.success(), "{name}: {}", message_text(&output));
        assert_eq!(digest(&user_dir), expected, "{name}");
        let messages = user_dir.summary("ogive_user")["messages"].to_string();
        assert!(messages.contains("vdload") && messages.contains(&format!("signal {signal}:")), "{name}: {messages}");
    }
    // A handler restored by the subroutine itself is not reported.
    let balanced = format!("{ignore} struct sigaction b; sigaction(SIGINT, &a, &b); sigaction(SIGINT, &b, 0);");
    assert!(run_of(&user_dir, "balanced", &balanced).status.success());
    assert!(user_dir.summary("ogive_user").get("messages").is_none());
}

/// A handler installed by a subroutine is no longer active when the signal arrives.
#[test]
fn signals_still_end_a_run() {
    let user_dir = UserFolder::new();
    let before = "if (calls < 9) signal(SIGTERM, SIG_IGN); if (calls == 9) kill(getpid(), SIGTERM);";
    let output = run_of(&user_dir, "ignores", before);
    assert_eq!(output.status.code(), Some(143), "{}", message_text(&output));
    assert!(user_dir.path("out/ogive_user.checkpoint").exists(), "{}", message_text(&output));
}

/// The first signal ends the program within the increment; the message names the load.
#[test]
fn a_signal_ends_a_subroutine_that_never_returns() {
    let user_dir = UserFolder::new();
    let before = "if (calls == 9) { kill(getpid(), SIGTERM); for (;;) { volatile int x = calls; (void)x; } }";
    let output = run_of(&user_dir, "hangs", before);
    let message = message_text(&output);
    assert_eq!(output.status.code(), Some(143), "{message}");
    assert!(
        ["R207", "within an increment", "increment 9", "user load"].iter().all(|word| message.contains(word)),
        "{message}"
    );
}

/// After 10 s without progress a warning names the increment and the load; the run continues.
#[test]
fn a_slow_subroutine_is_named() {
    let user_dir = UserFolder::new();
    let file = load(&user_dir, "sleeps", "if (calls == 9) sleep(11);");
    let output = user_dir.command(&user_deck(), &[&file]).output().expect("the program runs");
    let message = message_text(&output);
    assert!(output.status.success() && message.contains("no progress for 10 s: increment 9"), "{message}");
}

#[test]
fn fortran_signal_handlers_are_restored() {
    if !fortran() {
        return;
    }
    let user_dir = UserFolder::new();
    let body = format!("      external late\n      call signal(15, late)\n{FILL}");
    let file = user_dir.write("catches.f", &(vdload(&body) + "      subroutine late\n      end\n"));
    let output = user_dir.run(&user_deck(), &[&file], &[]);
    assert!(output.status.success(), "{}", message_text(&output));
    let messages = user_dir.summary("ogive_user")["messages"].to_string();
    assert!(messages.contains("vdload") && messages.contains("signal 15:"), "{messages}");
}

/// The folder of results is relative to the initial working folder.
#[test]
fn changed_working_folder_does_not_move_results() {
    let user_dir = UserFolder::new();
    std::fs::create_dir(user_dir.path("elsewhere")).expect("a folder");
    let file = load(&user_dir, "moves", "chdir(\"elsewhere\");");
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_revolve"));
    command.args(["run", "--quiet", "--out", "here"]).arg(user_deck()).arg("--user").arg(file);
    let output = command.env("XDG_CACHE_HOME", user_dir.path("cache")).current_dir(user_dir.path("")).output();
    let output = output.expect("the program runs");
    assert!(output.status.success(), "{}", message_text(&output));
    assert!(user_dir.path("here/ogive_user.json").exists());
    assert_eq!(std::fs::read_dir(user_dir.path("elsewhere")).expect("a folder").count(), 0);
}

#[test]
fn early_process_exit_is_an_error() {
    for (name, before) in [("small", "if (calls == 9) _exit(0);"), ("large", "if (calls == 9) _Exit(0);")] {
        let user_dir = UserFolder::new();
        let output = run_of(&user_dir, name, before);
        let message = message_text(&output);
        assert_eq!(output.status.code(), Some(1), "{name}: {message}");
        for word in ["vdload", "NOSE", "left the process", "step 1", "increment"] {
            assert!(message.contains(word), "{name}: `{word}` in\n{message}");
        }
        assert!(!user_dir.path("out/ogive_user.json").exists(), "{name}");
    }
}

#[test]
fn forked_child_does_not_continue_the_job() {
    let count = |user_dir: &UserFolder| std::fs::read(user_dir.path("calls")).expect("marks").len();
    let user_dir = UserFolder::new();
    assert!(run_of(&user_dir, "alone", "mark();").status.success());
    let (expected, marks) = (digest(&user_dir), count(&user_dir));
    for (name, before) in [
        ("comes back", "mark(); if (calls == 9) fork();"),
        ("leaves", "mark(); if (calls == 9) { if (fork() == 0) _exit(0); wait(0); }"),
        ("exits", "mark(); if (calls == 9) { if (fork() == 0) exit(0); wait(0); }"),
    ] {
        let user_dir = UserFolder::new();
        // Waits until all copies of its pipes are closed, which includes those of the child.
        let output = run_of(&user_dir, name, before);
        assert!(output.status.success(), "{name}: {}", message_text(&output));
        assert_eq!((digest(&user_dir), count(&user_dir)), (expected.clone(), marks), "{name}");
        assert!(!message_text(&output).contains("error"), "{name}: {}", message_text(&output));
        assert_eq!(message_text(&output).contains("forked"), name == "comes back", "{name}: {}", message_text(&output));
    }
}

#[test]
fn remaining_threads_end_with_the_process() {
    let user_dir = UserFolder::new();
    let output = run_of(&user_dir, "threads", "if (calls == 3) start();");
    assert!(output.status.success(), "{:?} {}", output.status, message_text(&output));
    assert_eq!(user_dir.summary("ogive_user")["status"], "completed");
    let messages = user_dir.summary("ogive_user")["messages"].to_string();
    assert!(messages.contains("vdload started a thread that still runs"), "{messages}");
    let output = run_of(&user_dir, "more", "if (calls == 3 || calls == 5) start();");
    assert!(output.status.success(), "{:?} {}", output.status, message_text(&output));
    let messages = user_dir.summary("ogive_user")["messages"].to_string();
    assert!(messages.contains("vdload started 2 threads"), "{messages}");
    let joined = "pthread_t t; if (calls == 3) { pthread_create(&t, 0, once, 0); pthread_join(t, 0); }";
    let output = run_of(&user_dir, "joins", joined);
    assert!(output.status.success(), "{:?} {}", output.status, message_text(&output));
    assert!(user_dir.summary("ogive_user").get("messages").is_none());
}

/// A checkpoint cannot contain memory that another thread may change at any time.
#[test]
fn remaining_threads_prevent_a_resume() {
    let user_dir = UserFolder::new();
    let output = run_of(&user_dir, "threads", "if (calls == 3) start(); if (calls == 9) kill(getpid(), SIGTERM);");
    assert_eq!(output.status.code(), Some(143), "{}", message_text(&output));
    assert!(message_text(&output).contains("a thread that vdload started still runs"), "{}", message_text(&output));
    let file = user_dir.path("threads.c");
    let output = user_dir.run(&user_deck(), &[&file], &["--resume"]);
    assert_eq!(output.status.code(), Some(2), "{}", message_text(&output));
    assert!(
        message_text(&output).contains("K009") && message_text(&output).contains("a thread that vdload"),
        "{}",
        message_text(&output)
    );
}

/// Once after compilation, to find missing symbols; then once for each run.
#[test]
fn initialisers_run_once_per_run() {
    let user_dir = UserFolder::new();
    let file = load(&user_dir, "begins", "");
    let mut text = std::fs::read_to_string(&file).expect("a source");
    text += "__attribute__((constructor)) static void begin(void) { mark(); fesetround(FE_UPWARD); signal(SIGTERM, SIG_IGN); \
             chdir(\"/\"); }\n";
    std::fs::write(&file, text).expect("a source");
    for expected in [2, 3, 4] {
        let output = user_dir.run(&user_deck(), &[&file], &[]);
        assert!(output.status.success(), "{}", message_text(&output));
        assert_eq!(std::fs::read(user_dir.path("calls")).expect("marks").len(), expected);
    }
    let messages = user_dir.summary("ogive_user")["messages"].to_string();
    for word in ["initialiser of", "rounding mode", "signal 15:", "working folder"] {
        assert!(messages.contains(word), "{word}: {messages}");
    }
}
