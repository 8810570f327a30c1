//! Limits of user subroutines: stack size, and ends of arrays that are declared with `*`.
//!
//! Goal: all commands and threads have the same stack, and an overflow or a write past an array is named.

use std::io::Read as _;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::Duration;

use super::subroutines::{UserFolder, fortran, message_text};
use crate::common::project;

const DECK: &str = "input/taylor_vumat.inp";

/// Returns the example VUMAT with a declaration and a statement that is executed in each call.
fn hardening(declared: &str, executed: &str) -> String {
    let text = std::fs::read_to_string(project("input/vumat_hardening.f90")).expect("the example");
    let changed = text.replacen("  twog =", &format!("  {executed}\n  twog ="), 1);
    changed.replacen("  dimension s(6)\n", &format!("  dimension s(6)\n  {declared}\n"), 1)
}

fn run(user_dir: &UserFolder, text: &str, more: &[&str]) -> Output {
    user_dir.run(&project(DECK), &[&user_dir.write("law.f90", text)], more)
}

/// Adds the arguments of a sweep of two shots on two threads.
fn add_sweep<'c>(command: &'c mut Command, user_dir: &UserFolder, file: &Path) -> &'c mut Command {
    command.args(["sweep", "--set", "speed=100,227", "--quantity", "final(U2@TIP)", "--threads", "2"]);
    command.arg("--user").arg(file).arg("--out").arg(user_dir.path("out")).arg(project(DECK));
    command.env("XDG_CACHE_HOME", user_dir.path("cache"))
}

fn sweep(user_dir: &UserFolder, file: &Path) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_revolve"));
    add_sweep(&mut command, user_dir, file).output().expect("the program runs")
}

/// A call that uses a local array of so many numbers; `-frecursive` places it on the stack.
fn with_array(numbers: usize, attribute: &str) -> String {
    let fill =
        format!("large(1:{numbers}:4096) = totalTime; if (sum(large(1:{numbers}:4096)) .lt. 0.d0) print *, large(1)");
    if attribute == "allocatable" {
        return hardening("real(8), allocatable :: large(:)", &format!("allocate(large({numbers})); {fill}"));
    }
    hardening(&format!("real(8){attribute} :: large({numbers})"), &fill)
}

#[test]
fn large_local_arrays_run_in_all_commands() {
    if !fortran() {
        return;
    }
    let user_dir = UserFolder::new();
    let text = with_array(6_000_000, "");
    let short = std::fs::read_to_string(project(DECK)).expect("the deck").replace(" , 80.e-6", " , 1.e-6");
    let deck = user_dir.write("short.inp", &short);
    for more in [&["--threads", "1"][..], &["--threads", "2", "--set", "nr=60", "--set", "nz=100"], &["--isolate"]] {
        let output = user_dir.run(&deck, &[&user_dir.write("law.f90", &text)], more);
        assert!(output.status.success(), "{more:?}: {}", message_text(&output));
    }
    let output = sweep(&user_dir, &user_dir.path("law.f90"));
    assert!(output.status.success(), "{}", message_text(&output));
}

/// Two threads overflow while nothing reads standard error, a full pipe: the message of the first one is complete.
#[test]
fn threads_that_overflow_together_are_reported() {
    if !fortran() {
        return;
    }
    let user_dir = UserFolder::new();
    let file = user_dir.write("law.f90", &with_array(20_000_000, ""));
    let mut command = Command::new("sh");
    command.args(["-c", "head -c 65536 /dev/zero >&2; exec \"$@\"", "sh", env!("CARGO_BIN_EXE_revolve")]);
    let mut child = add_sweep(&mut command, &user_dir, &file)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program runs");
    std::thread::sleep(Duration::from_secs(2));
    let mut message = String::new();
    child.stderr.take().expect("a pipe").read_to_string(&mut message).expect("text");
    let status = child.wait().expect("a status");
    let message = message.trim_start_matches('\0');
    assert!(status.code() == Some(1) && message.contains("64 MB of its stack"), "{status}: {message}");
}

#[test]
fn stack_overflow_is_named() {
    if !fortran() {
        return;
    }
    let numbers = 20_000_000;
    let user_dir = UserFolder::new();
    let output = run(&user_dir, &with_array(numbers, ""), &[]);
    let words = ["vumat for COPPER", "needs more than the 64 MB of its stack", "ALLOCATABLE or SAVE", "step 1"];
    let message = message_text(&output);
    assert!(output.status.code() == Some(1) && words.iter().all(|word| message.contains(word)), "{message}");
    let output = sweep(&user_dir, &user_dir.path("law.f90"));
    let message = message_text(&output);
    assert!(!output.status.success() && words.iter().all(|word| message.contains(word)), "{message}");
    let output = run(&user_dir, &with_array(numbers, ""), &["--isolate"]);
    assert!(message_text(&output).contains(words[1]), "{}", message_text(&output));
    assert_eq!(user_dir.summary("taylor_vumat")["status"], "halted");
    // The advice of the message.
    for attribute in ["allocatable", ", save"] {
        let output = run(&user_dir, &with_array(numbers, attribute), &["--set", "nr=1", "--set", "nz=5"]);
        assert!(output.status.success(), "{attribute}: {}", message_text(&output));
    }
}

/// gfortran cannot check `(nblock,*)`; the message names the declaration with which it can.
#[test]
fn components_that_do_not_exist_are_named() {
    if !fortran() {
        return;
    }
    for (component, statement) in [
        (3, "stateNew(1:nblock,3) = 1.d0"),
        (17, "stateNew(1:nblock,17) = 1.d0"),
        (3, "stateNew(5,3) = 1.d0"),
        (2, "stateNew(1:nblock,2:9) = 1.d0"),
    ] {
        let late = format!("if (totalTime .gt. 20.d-6) {statement}");
        let text = hardening("", &late).replace("stateNew(nblock,nstatev)", "stateNew(nblock,*)");
        for isolate in [&[][..], &["--isolate"]] {
            let user_dir = UserFolder::new();
            let output = run(&user_dir, &text, isolate);
            let message = message_text(&output);
            assert_eq!(output.status.code(), Some(1), "{statement}: {message}");
            for word in ["R201", "argument stateNew", "declare stateNew(nblock,nstatev)", "--check-user"] {
                assert!(message.contains(word), "{statement} {isolate:?}: `{word}` in\n{message}");
            }
            if isolate.is_empty() {
                assert!(message.contains(&format!(",{component}); *DEPVAR defines nstatev = 1")), "{message}");
            }
            assert_eq!(user_dir.summary("taylor_vumat")["status"], "halted", "{statement}");
        }
        // The advice of the message.
        let user_dir = UserFolder::new();
        let output = run(&user_dir, &hardening("", &late), &["--check-user"]);
        assert!(message_text(&output).contains("At line 23 of file"), "{}", message_text(&output));
    }
    let text =
        hardening("", "stressNew(1:nblock,9) = 1.d0").replace("stressNew(nblock,ndir+nshr)", "stressNew(nblock,*)");
    let user_dir = UserFolder::new();
    let message = message_text(&run(&user_dir, &text, &[]));
    assert!(message.contains("stressNew(1,9)") && message.contains("declare stressNew(nblock,ndir+nshr)"), "{message}");
}
