//! Allocations of memory fail: from the n-th one on, or above a limit of the process.
//!
//! Goal: the program ends with a message, all files are complete, no summary says that the run is completed, and the command,
//! continued, gives the same files as an undisturbed one. A failed allocation ends a program in Rust as an abort; too large
//! requests of a deck are refused before, with the name of the limit (M125). Source: the undisturbed run. Tolerance: none.
#![cfg(target_os = "linux")]

use std::fs;
use std::os::unix::process::ExitStatusExt as _;
use std::path::{Path, PathBuf};
use std::process::{Output, Stdio};

use crate::common::revolve;
use crate::failing_writes::{preloaded, small_run};
use crate::faults::{FaultCase, results, under_limit};

/// Signals of an abort, and of the loader of the system without memory.
const ABORT: i32 = 6;
const SEGMENTATION_FAULT: i32 = 11;

/// How a run under too little memory has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum MemoryEnd {
    /// The run is completed.
    Completed,
    /// The deck is refused, or the run halted, with a message.
    Message,
    /// The program aborted.
    Abort,
}

/// Returns how a run has ended; panics if it is none of the permitted ways.
fn end_of(output: &Output, context: &str) -> MemoryEnd {
    let words = String::from_utf8_lossy(&output.stderr);
    match (output.status.code(), output.status.signal()) {
        (Some(0), _) => MemoryEnd::Completed,
        (Some(1 | 2), _) => {
            assert!(words.contains("error") || words.contains("R2"), "{context}: {words}");
            MemoryEnd::Message
        }
        (_, Some(ABORT)) => {
            // Of Rust, or of the C library, which cannot store the destructor of a variable of a thread. The standard library
            // panics, and aborts, if a new thread has no stack for the handler of its stack overflow.
            let says_why = words.contains("memory allocation of") || words.contains("out of memory");
            let has_no_stack = words.contains("failed to allocate an alternative stack");
            assert!(has_no_stack || says_why && !words.contains("panicked"), "{context}: {words}");
            MemoryEnd::Abort
        }
        // The system cannot extend the stack, and ends the program as `kill` does.
        (_, Some(SEGMENTATION_FAULT)) => MemoryEnd::Abort,
        _ => panic!("{context}: {}: {words}", output.status),
    }
}

/// Asserts that files are complete, that a run that has not ended is not called completed, and that it can be continued.
fn assert_nothing_is_lost(case: &FaultCase, folder: &Path, end: MemoryEnd, context: &str) {
    case.check(folder);
    let info = revolve(&["info", folder.to_str().expect("a name")]);
    let words = String::from_utf8_lossy(&info.stdout);
    if words.contains(": completed") {
        let found = results(folder);
        let missing = case.results.iter().find(|(name, bytes)| found.get(*name) != Some(bytes));
        assert_eq!(missing.map(|file| file.0), None, "{context}: a completed run without this file");
    } else {
        assert!(end != MemoryEnd::Completed, "{context}: {words}");
    }
    fs::create_dir_all(folder).expect("a folder");
    case.resume(folder, "2");
}

/// The library that makes allocations fail, and the file in which it counts them.
struct FailingAllocations {
    library: PathBuf,
    mark: PathBuf,
}

impl FailingAllocations {
    /// Compiles the library; `None` without a compiler.
    fn new(scratch: &Path) -> Option<FailingAllocations> {
        Some(FailingAllocations { library: preloaded(scratch, "failing_allocations")?, mark: scratch.join("mark") })
    }

    /// Runs a case in which all allocations of at least `smallest` bytes fail from number `call` on; 0: none fails. Returns the
    /// output and the text of the library.
    fn run(&self, case: &FaultCase, folder: &Path, call: u64, smallest: u64) -> (Output, String) {
        fs::remove_file(&self.mark).ok();
        let mut command = case.command(under_limit("-c 0"), folder, &["--threads", "1"]);
        command.stderr(Stdio::piped()).env("FAIL_MARK", &self.mark);
        command.env("LD_PRELOAD", &self.library).env("FAIL_CALL", call.to_string());
        let output = command.env("FAIL_SIZE", smallest.to_string()).output().expect("the program runs");
        (output, fs::read_to_string(&self.mark).unwrap_or_default())
    }

    /// Returns the number of allocations of the shell and the program.
    fn count(&self, case: &FaultCase, folder: &Path, smallest: u64) -> u64 {
        let (output, mark) = self.run(case, folder, 0, smallest);
        assert!(output.status.success(), "{output:?}");
        mark.trim().strip_prefix("counted ").and_then(|count| count.parse().ok()).expect("a number of allocations")
    }
}

#[test]
fn run_loses_nothing_if_an_allocation_fails() {
    let scratch = tempfile::tempdir().expect("a folder");
    let Some(allocations) = FailingAllocations::new(scratch.path()) else { return };
    let case = FaultCase::new("bar", &small_run(scratch.path()), &[], scratch.path());
    let folder = scratch.path().join("results");
    let mut ends = Vec::new();
    // Most allocations are small; large ones are those of the mesh, the state and the files.
    for smallest in [1, 1024] {
        let count = allocations.count(&case, &folder, smallest);
        assert!(count > 100, "{count} allocations of {smallest} bytes");
        // Even numbers over the whole run, and the last ones, which belong to the end of the run.
        let spread = (1..=24).map(|part| count * part / 24);
        let last = (1..=8).map(|number| count.saturating_sub(number * number * number));
        for call in spread.chain(last) {
            fs::remove_dir_all(&folder).ok();
            let (output, mark) = allocations.run(&case, &folder, call.max(1), smallest);
            let context = format!("allocation {call} of {count} with {smallest} bytes or more ({})", mark.trim());
            let end = end_of(&output, &context);
            assert_nothing_is_lost(&case, &folder, end, &context);
            ends.push(end);
        }
    }
    let number = |end| ends.iter().filter(|other| **other == end).count();
    let [completed, message, aborted] = [MemoryEnd::Completed, MemoryEnd::Message, MemoryEnd::Abort].map(number);
    println!("{} runs: {completed} completed, {message} with a message, {aborted} aborted", ends.len());
    assert!(aborted > 20, "{ends:?}");
}

/// Returns the smallest number for which a condition holds, by bisection to 100 and a thousandth.
fn smallest_limit(mut too_small: u64, mut enough: u64, holds: impl Fn(u64) -> bool) -> u64 {
    assert!(holds(enough));
    while enough - too_small > 100 + too_small / 1_000 {
        let middle = too_small.midpoint(enough);
        if holds(middle) { enough = middle } else { too_small = middle }
    }
    enough
}

/// The memory of the process is limited to values between that at which the deck is read and that at which the run ends.
#[test]
fn run_loses_nothing_under_any_limit_of_memory() {
    let scratch = tempfile::tempdir().expect("a folder");
    let deck = fs::read_to_string(small_run(scratch.path())).expect("a deck");
    fs::write(scratch.path().join("bar.inp"), deck.replace("nr = 2", "nr = 40").replace("nz = 6", "nz = 200"))
        .expect("a deck");
    let case = FaultCase::new("bar", &scratch.path().join("bar.inp"), &[], scratch.path());
    let folder = scratch.path().join("results");
    let run = |kilobytes: u64| {
        fs::remove_dir_all(&folder).ok();
        let limits = format!("-c 0; ulimit -v {kilobytes}");
        let mut command = case.command(under_limit(&limits), &folder, &["--threads", "1"]);
        command.stderr(Stdio::piped()).output().expect("the program runs")
    };
    // Below the first limit the loader of the system ends the program, with 127 or by a signal; below the second one the stacks
    // of the threads do not fit; above the last one the run ends.
    let starts = smallest_limit(4_000, 1_000_000, |limit| {
        let status = run(limit).status;
        status.code() != Some(127) && status.signal() != Some(SEGMENTATION_FAULT)
    });
    let has_threads = |output: &Output| !String::from_utf8_lossy(&output.stderr).contains("cannot start 1 threads");
    let runs = smallest_limit(starts, 1_000_000, |limit| has_threads(&run(limit)));
    let ends_at = smallest_limit(runs, 1_000_000, |limit| run(limit).status.success());
    let refused = String::from_utf8_lossy(&run(starts.midpoint(runs)).stderr).into_owned();
    assert!(refused.contains("the limit of the process (ulimit -v) is"), "{refused}");
    let spread = |[from, to]: [u64; 2], parts: u64| (0..=parts).map(move |part| from + (to - from) * part / parts);
    let mut ends = Vec::new();
    // The system places memory at random, so that a limit near the last one may suffice or not; the last value suffices.
    for kilobytes in spread([starts, runs], 3).chain(spread([runs, ends_at], 16)).chain([2 * ends_at]) {
        let output = run(kilobytes);
        let context = format!("{kilobytes} kB");
        let end = end_of(&output, &context);
        assert_nothing_is_lost(&case, &folder, end, &context);
        ends.push(end);
    }
    let number = |end| ends.iter().filter(|other| **other == end).count();
    let [completed, message, aborted] = [MemoryEnd::Completed, MemoryEnd::Message, MemoryEnd::Abort].map(number);
    println!(
        "{starts}, {runs} to {ends_at} kB, {} limits: {completed} completed, {message} with a message, {aborted} aborted",
        ends.len()
    );
    assert!(message + aborted > 10 && completed > 0, "{ends:?}");
}
