//! Random changes of decks, expressions, mesh files and checkpoints. Each is read up to the plan and its diagnostics
//! are rendered; nothing may panic or use more memory than justified by the size of the text. The longest run time is
//! printed.
//!
//! The initial texts are the decks of the project. In CI each target runs for some seconds on a fixed sequence; for
//! longer `FUZZ_SECONDS=1800 FUZZ_SEED=7 cargo test --release --test program fuzz::TARGET` (docs/stability.md). A
//! failure is reduced and printed. Each target is a function from a change to a check; other readers are added the same
//! way.

use std::cell::Cell;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestCaseError, TestRng, TestRunner};
use revolve::job;
use revolve::output::checkpoint::Checkpoint;
use revolve::output::vtu::VtuWriter;
use revolve::solve::UnfitState;
use revolve::user::Routines;
use sha2::{Digest as _, Sha256};

#[path = "../fuzz/readers/mod.rs"]
mod readers;

use crate::common;
use crate::common::mesh::mesh_frame;

/// The corpus of the targets in `tests/fuzz`, which holds inputs of earlier failures.
#[test]
fn corpus_is_read_without_panic() {
    type ReadFunction = fn(&[u8]);
    let targets: [(&str, ReadFunction); 6] = [
        ("checkpoints", readers::checkpoints::read),
        ("decks", readers::decks::read),
        ("meshes", readers::meshes::read),
        ("parameters", readers::parameters::read),
        ("references", readers::references::read),
        ("results", readers::results::read),
    ];
    for (name, read) in targets {
        let entries = std::fs::read_dir(common::project("tests/fuzz/corpus").join(name)).expect("a corpus");
        let mut paths: Vec<_> = entries.map(|entry| entry.expect("an entry").path()).collect();
        paths.sort();
        assert!(!paths.is_empty(), "{name}");
        for path in paths {
            let begin = Instant::now();
            read(&std::fs::read(&path).expect("bytes"));
            println!("{}: {:.2} s", path.display(), begin.elapsed().as_secs_f64());
        }
    }
}

/// A change of a text: kind, place, replacement.
type TextChange = (u8, u32, u32);

/// Most bytes that one reader may allocate at a time: exponential growth from a short deck exceeds it on any machine.
const ROOM: u64 = 1 << 30;

/// Words that are likely to cause failures.
const NASTY: &[&str] = &[
    "",
    "0",
    "-1",
    "1",
    "1e308",
    "-1e308",
    "1e-320",
    "nan",
    "inf",
    "-0",
    "2147483648",
    "18446744073709551616",
    "1e99999",
    "0x10",
    "1.2.3",
    "1d2",
    "<",
    ">",
    "<nope>",
    "<n",
    "\"",
    "'",
    ",",
    "*",
    "**",
    "=",
    "*End Step",
    "*Step",
    "*Node",
    "*Element, type=CAX4R",
    "*Include, input=",
    "*Parameter",
    "\u{fc}",
    "\u{0}",
    "\t",
    "generate",
    "S5",
    "SNEG",
    "ALL",
];

/// Returns the run time of each target.
fn budget() -> Duration {
    let seconds = std::env::var("FUZZ_SECONDS").ok().and_then(|s| s.parse().ok()).unwrap_or(4.0);
    Duration::from_secs_f64(seconds)
}

/// Runs a check on random inputs until the time is over, and prints their number.
fn fuzz<S: Strategy>(name: &str, strategy: &S, check: impl Fn(&S::Value)) {
    let seed: u64 = std::env::var("FUZZ_SEED").ok().and_then(|s| s.parse().ok()).unwrap_or(0);
    let (begin, mut batches, worst) = (Instant::now(), 0_u64, Cell::new((Duration::ZERO, 0)));
    while begin.elapsed() < budget() {
        let mut bytes = [0; 32];
        bytes[..8].copy_from_slice(&seed.to_le_bytes());
        bytes[8..16].copy_from_slice(&batches.to_le_bytes());
        let config = Config { cases: 32, failure_persistence: None, max_shrink_iters: 400, ..Config::default() };
        let mut runner = TestRunner::new_with_rng(config, TestRng::from_seed(RngAlgorithm::ChaCha, &bytes));
        let run = runner.run(strategy, |input| {
            let begin = Instant::now();
            let held = allocation_counter::measure(|| check(&input)).bytes_max;
            worst.set((worst.get().0.max(begin.elapsed()), worst.get().1.max(held)));
            if held > ROOM { Err(TestCaseError::fail(format!("held {held} bytes"))) } else { Ok(()) }
        });
        if let Err(failure) = run {
            panic!("{name}: {failure}");
        }
        batches += 1;
    }
    let (longest, most) = worst.get();
    println!("{name}: {} inputs, at most {longest:.1?} and {most} bytes", 32 * batches);
}

/// Returns the decks of the project with short step times.
fn seeds() -> Vec<(PathBuf, String)> {
    let mut seeds = Vec::new();
    for folder in ["input", "input/gauntlet", "tests/decks/good", "tests/decks/bad"] {
        let files = std::fs::read_dir(common::project(folder)).expect("a folder");
        let mut paths: Vec<PathBuf> = files.map(|f| f.expect("a file").path()).collect();
        paths.sort();
        for path in paths.into_iter().filter(|p| p.extension().is_some_and(|e| e == "inp")) {
            let bytes = std::fs::read(&path).expect("a deck");
            seeds.push((path, String::from_utf8_lossy(&bytes).into_owned()));
        }
    }
    assert!(seeds.len() > 20);
    seeds
}

/// Returns the character boundary at or before a position, modulo the length of the text.
fn place(text: &str, at: u32) -> usize {
    let mut at = at as usize % (text.len() + 1);
    while !text.is_char_boundary(at) {
        at -= 1;
    }
    at
}

/// Returns start and end of the word at a position.
fn word(text: &str, at: u32) -> (usize, usize) {
    let middle = place(text, at);
    let cut = |c: char| ",=\n <>()+-*/".contains(c);
    let start = text[..middle].rfind(cut).map_or(0, |i| i + 1);
    let end = text[middle..].find(cut).map_or(text.len(), |i| middle + i);
    (start, end)
}

/// Applies one change to a text; `other` is a source of lines and words.
fn change(text: &mut String, other: &str, (kind, at, with): TextChange) {
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let line = at as usize % lines.len().max(1);
    match kind {
        0 if !lines.is_empty() => drop(lines.remove(line)),
        1 if !lines.is_empty() => lines.insert(with as usize % lines.len(), lines[line].clone()),
        2 if !lines.is_empty() => {
            let second = with as usize % lines.len();
            lines.swap(line, second);
        }
        3 => {
            let foreign: Vec<&str> = other.lines().collect();
            if !foreign.is_empty() {
                lines.insert(line, foreign[with as usize % foreign.len()].to_owned());
            }
        }
        4 => lines.truncate(line),
        5 => {
            let (start, end) = word(text, at);
            return text.replace_range(start..end, NASTY[with as usize % NASTY.len()]);
        }
        6 => {
            let ((start, end), (from, to)) = (word(text, at), word(other, with));
            return text.replace_range(start..end, &other[from..to]);
        }
        7 => return text.insert_str(place(text, at), NASTY[with as usize % NASTY.len()]),
        _ => {
            let (from, to) = (place(text, at), place(text, at.wrapping_add(with % 5)));
            if from < to {
                text.replace_range(from..to, "");
            }
            return;
        }
    }
    *text = lines.join("\n") + "\n";
}

/// Returns whether a text generates millions of items, which is valid up to the limit of generated items but slow.
fn is_large(text: &str) -> bool {
    let runs = text.split(|c: char| !c.is_ascii_digit());
    runs.filter_map(|run| run.parse::<u64>().ok()).any(|n| (30_000..30_000_000).contains(&n))
}

fn changes() -> impl Strategy<Value = Vec<TextChange>> {
    prop::collection::vec((0_u8..9, any::<u32>(), any::<u32>()), 1..8)
}

#[test]
fn decks() {
    let seeds = seeds();
    let input = (0..seeds.len(), 0..seeds.len(), changes());
    fuzz("decks", &input, |(seed, other, changes)| {
        let (path, mut text) = seeds[*seed].clone();
        changes.iter().for_each(|c| change(&mut text, &seeds[*other].1, *c));
        if is_large(&text) {
            return;
        }
        // After a hang the input can be inspected.
        std::fs::write(concat!(env!("CARGO_TARGET_TMPDIR"), "/fuzz_deck.inp"), &text).expect("a file");
        let prepared = job::prepare_text(&path.to_string_lossy(), &text, &[], &Routines::none());
        let rendered = prepared.diagnostics.render(&prepared.deck.sources);
        assert!(!prepared.diagnostics.has_errors() || !rendered.is_empty());
        let _ = prepared.plan.ledger.render(true);
    });
}

/// Parts of expressions.
const PARTS: &[&str] = &[
    "1", "0", "2.", "1e308", "-", "+", "*", "/", "//", "%", "**", "(", ")", ",", "sqrt", "exp", "log", "abs", "min",
    "max", "int", "pi", "a", "b", "c", "=", "#", "'", "\"", " ", "1e", ".", "<a>", "nan", "\u{e4}", "sin(", "pow(",
    "[", "]", "\n",
];

#[test]
fn parameters() {
    let part = prop::sample::select(PARTS.to_vec());
    let input = prop::collection::vec(prop::collection::vec(part, 0..20), 1..6);
    fuzz("parameters", &input, |lines| {
        let names = ["a", "b", "c", "a b", "1", ""];
        let mut text = String::from("*Parameter\n");
        for (name, line) in names.iter().zip(lines) {
            text += &format!("{name} = {}\n", line.concat());
        }
        text += "*Node\n 1, <a>, <b>\n <c>, 1., 1.\n";
        // Nested brackets, deeper than recursion may go.
        let deep = lines[0].len() * 200;
        text += &format!("*Parameter\n d = {}1{}\n", "(".repeat(deep), ")".repeat(deep));
        text += &format!("*Parameter\n e = {}1\n", "-".repeat(deep));
        let prepared = job::prepare_text("fuzz.inp", &text, &[("a".into(), "2".into())], &Routines::none());
        let _ = prepared.diagnostics.render(&prepared.deck.sources);
    });
}

#[test]
fn mesh_files() {
    let folder = tempfile::tempdir().expect("a folder");
    let deck = "*Node\n 1, 0., 0.\n 2, 1., 0.\n 3, 1., 1.\n 4, 0., 1.\n 5, 0., 2.\n*Element, type=CAX4R, elset=BODY\n 10, 1, 2, 3, 4\n\
                *Element, type=CAX3, elset=BODY\n 11, 4, 3, 5\n*Nset, nset=AXIS\n 1, 4, 5\n";
    let (parsed, _) = revolve::deck::read_text("t.inp", deck, &[]);
    let (model, _) = revolve::model::build(&parsed);
    let mut writer = VtuWriter::default();
    let vtu = writer.text(&mesh_frame(&model));
    let legacy = "# vtk DataFile Version 3.0\nmesh\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 double\n0 0 0 1 0 0 1 1 0 0 1 0\n\
                  CELLS 2 9\n3 0 1 2\n4 0 1 2 3\nCELL_TYPES 2\n5\n9\n";
    let seeds = [("mesh.vtu", vtu.as_bytes().to_vec()), ("mesh.vtk", legacy.as_bytes().to_vec())];
    let bytes = prop::collection::vec((0_u8..5, any::<u32>(), any::<u32>()), 1..6);
    fuzz("mesh files", &(0..seeds.len(), bytes), |(seed, changes)| {
        let (name, mut bytes) = seeds[*seed].clone();
        for (kind, at, with) in changes {
            let at = *at as usize % bytes.len().max(1);
            match kind {
                0 if !bytes.is_empty() => bytes[at] = *with as u8,
                1 if !bytes.is_empty() => drop(bytes.remove(at)),
                2 => bytes.truncate(at),
                3 => bytes.insert(at, *with as u8),
                _ => {
                    let mut text = String::from_utf8_lossy(&bytes).into_owned();
                    change(&mut text, legacy, (5, at as u32, *with));
                    bytes = text.into_bytes();
                }
            }
        }
        let path = folder.path().join(name);
        std::fs::write(&path, &bytes).expect("a file");
        let text = format!("*Mesh, input=\"{}\"\n", path.display());
        let prepared = job::prepare_text("fuzz.inp", &text, &[], &Routines::none());
        let _ = prepared.diagnostics.render(&prepared.deck.sources);
    });
}

/// Resumes a state in the plan of a deck and ends after one increment.
fn take_up(text: &str, state: Option<&[u8]>) -> (Result<u64, UnfitState>, Vec<u8>) {
    readers::one_increment(&common::prepared(text, &[], &Routines::none()), state)
}

/// Bytes changed at random, with a recomputed checksum: the file is rejected with a reason, or equals the original
/// except for texts. States of another length or of another deck are rejected. (Changed numbers inside a state of the
/// correct length are detected by the checksum only.)
#[test]
fn checkpoints() {
    let decks = [common::ogive(), std::fs::read_to_string(common::project("input/taylor_copper.inp")).expect("a deck")];
    let states = decks.each_ref().map(|text| take_up(text, None).1);
    assert!(states.iter().all(|s| s.len() > 100));
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("job.checkpoint");
    let whole = readers::checkpoints::whole(states[0].clone());
    whole.clone().write(&path, &states[0]).expect("a file");
    let bytes = std::fs::read(&path).expect("bytes");
    let input = (any::<bool>(), any::<u32>(), any::<u32>(), any::<u8>(), changes());
    fuzz("checkpoints", &input, |(mended, at, length, value, changes)| {
        let mut changed = bytes.clone();
        for (_, at, with) in changes {
            // Mostly in the head of the file, which contains lengths.
            let at = if at % 2 == 0 { *at as usize % 200 } else { *at as usize % changed.len() };
            changed[at] = *with as u8;
        }
        if value % 3 == 0 {
            changed.truncate(*at as usize % (changed.len() + 1));
        }
        if *mended && changed.len() > 40 {
            let sum = Sha256::digest(&changed[40..]);
            changed[8..40].copy_from_slice(&sum);
        }
        std::fs::write(&path, &changed).expect("a file");
        if let Err(refused) = Checkpoint::read(&path) {
            assert!(["K001", "K002"].contains(&refused.code), "{refused:?}");
        }
        let which = usize::from(value % 2 == 0);
        let (own, other) = (&states[which], &states[1 - which]);
        let cut = *length as usize % own.len();
        let longer = [&own[..], &other[..cut % other.len() + 1]].concat();
        for state in [&own[..cut], &longer[..], &other[..]] {
            let (taken, _) = take_up(&decks[which], Some(state));
            assert!(taken.is_err(), "a state of {} bytes where {} belong", state.len(), own.len());
        }
        assert!(take_up(&decks[which], Some(own)).0.is_ok());
    });
}
