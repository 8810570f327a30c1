#!/usr/bin/env python3
"""Mutation testing of numerics and solver: tests/mutants.py COUNT SEED [JOBS], or tests/mutants.py --like REGEX [JOBS]

Compiles COUNT random mutants of cargo-mutants, or those whose names match, into one build: a function has its original body and
the mutated ones, and the environment variable REVOLVE_MUTANT selects one. Each test runs once without mutant, which measures its
time and records the mutants whose function it calls. Then each mutant runs these tests, the shortest first, until one fails. A
mutant that does not compile is not judged. Needs cargo-mutants (`cargo install cargo-mutants --version 27.1.0 --locked`). All files
are in target/mutants; results_*.txt have the result of each mutant and are continued after an interruption.
"""

import json
import os
import random
import re
import shutil
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
WORK = ROOT / "target/mutants"
TREE = WORK / "tree"
# Quick builds with the same results as those of the release profile.
BUILD = {
    "CARGO_PROFILE_RELEASE_INCREMENTAL": "true",
    "CARGO_PROFILE_RELEASE_CODEGEN_UNITS": "64",
    "CARGO_PROFILE_RELEASE_OPT_LEVEL": "1",
    "CARGO_PROFILE_RELEASE_DEBUG": "0",
    "CARGO_PROFILE_RELEASE_PACKAGE_REVOLVE_ANALYSIS_CODEGEN_UNITS": "64",
    "RUSTC_WRAPPER": str(TREE / "tests/rustc.sh"),
    "CARGO_TARGET_DIR": str(WORK / "build"),
}
TESTS = "cargo test --release --no-run --locked --workspace --exclude revolve-python --features parquet".split()
TESTS += "--lib --test deck --test user --test verification --message-format json".split()
PROGRAMS = ["revolve_numerics", "revolve_solver", "deck", "user", "verification"]
SWITCH = """
/// Returns whether mutant `index` is selected, and records that a test has reached it.
pub fn is_mutated(index: usize) -> bool {
    use std::io::Write;
    use std::sync::LazyLock;
    use std::sync::atomic::{AtomicBool, Ordering};
    static SELECTED: LazyLock<Option<usize>> = LazyLock::new(|| std::env::var("REVOLVE_MUTANT").ok()?.parse().ok());
    static REACHED: [AtomicBool; %d] = [const { AtomicBool::new(false) }; %d];
    if !REACHED[index].load(Ordering::Relaxed) && !REACHED[index].swap(true, Ordering::Relaxed) {
        if let Some(path) = std::env::var_os("REVOLVE_REACHED") {
            let mut file = std::fs::OpenOptions::new().create(true).append(true).open(path).unwrap();
            file.write_all(format!("{index}\\n").as_bytes()).unwrap();
        }
    }
    *SELECTED == Some(index)
}
"""
TOKEN = re.compile(r'//[^\n]*|/\*.*?\*/|r(#*)".*?"\1|"(?:\\.|[^"\\])*"|\'(?:\\.|[^\'\\])\'|[{}]', re.S)


def offset(lines, position):
    """Returns the offset of a line and column, which begin at 1."""
    return sum(len(line) for line in lines[: position["line"] - 1]) + position["column"] - 1


def body(text):
    """Returns the start of the last block of the text of a function, which is its body."""
    depth, start = 0, None
    for token in TOKEN.finditer(text):
        if token[0] == "{":
            start = token.start() if depth == 0 else start
            depth += 1
        elif token[0] == "}":
            depth -= 1
    return start


def functions(mutants):
    """Returns for each file the bodies that have mutants: (start, end, [(number, mutated body)])."""
    files = {}
    for number, mutant in mutants.items():
        text = (ROOT / mutant["file"]).read_text()
        lines = text.splitlines(keepends=True)
        first, end = (offset(lines, mutant["function"]["span"][side]) for side in ("start", "end"))
        start = first + body(text[first:end])
        changed = [offset(lines, mutant["span"][side]) for side in ("start", "end")]
        mutated = text[start : changed[0]] + mutant["replacement"] + text[changed[1] : end]
        bodies = files.setdefault(mutant["file"], {})
        # A constant function cannot read which mutant is selected; a body within another one would be changed twice.
        if "const fn" not in text[first:start] and all((start, end) == other or end <= other[0] or other[1] <= start for other in bodies):
            bodies.setdefault((start, end), []).append((number, mutated))
    return files


def write_tree(mutants, count):
    """Writes the sources with all mutants; an unchanged file keeps its time."""
    files = functions(mutants)
    for name in subprocess.check_output(["git", "ls-files"], cwd=ROOT, text=True).splitlines():
        if not (ROOT / name).is_file():
            continue
        text = (ROOT / name).read_bytes()
        if name in files or name == "src/numerics/lib.rs":
            text = text.decode()
            for (start, end), bodies in sorted(files.get(name, {}).items(), reverse=True):
                branches = "".join(f"if revolve_numerics::is_mutated({number})\n{mutated} else " for number, mutated in bodies)
                text = f"{text[:start]}{{\n{branches}{text[start:end]}\n}}{text[end:]}"
            text = (text + SWITCH % (count, count) if name == "src/numerics/lib.rs" else text).encode()
        target = TREE / name
        if not target.exists() or target.read_bytes() != text:
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(text)
            shutil.copymode(ROOT / name, target)


def build(mutants, count):
    """Builds the tests and removes mutants that do not compile; returns the test programs."""
    while True:
        write_tree(mutants, count)
        process = subprocess.run(TESTS, cwd=TREE, env=os.environ | BUILD, stdout=subprocess.PIPE, text=True)
        messages = [json.loads(line) for line in process.stdout.splitlines() if line.startswith("{")]
        if process.returncode == 0:
            built = [m for m in messages if m.get("executable") and m["target"]["name"] in PROGRAMS]
            return [(m["executable"], Path(m["manifest_path"]).parent) for m in built]
        wrong = set()
        for message in (m["message"] for m in messages if m["reason"] == "compiler-message"):
            for span in message["spans"] if message["level"] == "error" else []:
                lines = (TREE / span["file_name"]).read_text().splitlines()[: span["line_start"]]
                numbers = re.findall(r"is_mutated\((\d+)\)", "\n".join(lines))
                wrong.update(int(number) for number in numbers[-1:] if int(number) in mutants)
        if not wrong:
            sys.exit("\n".join(m["message"]["rendered"] for m in messages if m["reason"] == "compiler-message"))
        for number in wrong:
            print(f"does not compile: {mutants.pop(number)['name']}", flush=True)


def run(test, environment, timeout):
    """Runs one test; returns whether it passed."""
    program, folder, name = test
    try:
        command = [program, "--exact", name]
        return subprocess.run(command, cwd=folder, env=os.environ | environment, timeout=timeout, capture_output=True).returncode == 0
    except subprocess.TimeoutExpired:
        return False


def measure(test):
    """Returns the time of a test, the mutants that it reaches, and whether it passes without mutant.

    The results for an unchanged program are kept.
    """
    path = WORK / "reached" / re.sub(r"\W", "_", f"{Path(test[0]).name}_{test[2]}")
    known = path.with_suffix(".json")
    if not known.exists() or known.stat().st_mtime < Path(test[0]).stat().st_mtime:
        path.unlink(missing_ok=True)
        start = time.monotonic()
        passed = run(test, {"REVOLVE_REACHED": str(path)}, 1800)
        reached = sorted({int(number) for number in path.read_text().split()}) if path.exists() else []
        known.write_text(json.dumps([time.monotonic() - start, reached, passed]))
    seconds, reached, passed = json.loads(known.read_text())
    return seconds, set(reached), passed, test


def judge(number, mutant, measured, results):
    """Writes which test catches a mutant."""
    result = "missed"
    tests = sorted((entry for entry in measured if number in entry[1]), key=lambda entry: entry[0])
    for seconds, _, _, test in tests:
        if not run(test, {"REVOLVE_MUTANT": str(number)}, 60 + 10 * seconds):
            result = f"caught by {test[2]}"
            break
    line = f"{number}\t{mutant['name']}\t{result}\t{len(tests)} tests"
    print(line, flush=True)
    with results.open("a") as file:
        file.write(f"{line}\n")


def select(places, arguments):
    """Returns the mutants by number, and the name of the file of results."""
    if arguments[0] == "--like":
        found = [place for place in places if re.search(arguments[1], place["name"])]
        return dict(enumerate(found)), "results_" + re.sub(r"\W+", "_", arguments[1])[:80] + ".txt"
    count, seed = int(arguments[0]), int(arguments[1])
    return dict(enumerate(random.Random(seed).sample(places, count))), f"results_{count}_{seed}.txt"


def read_results(results, mutants):
    """Returns the lines of results of these mutants by number."""
    lines = results.read_text().splitlines() if results.exists() else []
    of_number = {int(line.split("\t")[0]): line for line in lines}
    return {number: line for number, line in of_number.items() if number in mutants and mutants[number]["name"] == line.split("\t")[1]}


def main():
    jobs = int((sys.argv[3:] or [os.cpu_count()])[0])
    (WORK / "reached").mkdir(parents=True, exist_ok=True)
    listed = WORK / "list.json"
    sources = [path for folder in ("numerics", "solver") for path in (ROOT / "src" / folder).rglob("*.rs")]
    if not listed.exists() or listed.stat().st_mtime < max(path.stat().st_mtime for path in sources):
        command = "cargo mutants --list --json --package revolve-numerics --package revolve-solver".split()
        listed.write_bytes(subprocess.check_output(command, cwd=ROOT))
    places = [mutant for mutant in json.loads(listed.read_text()) if mutant["function"]]
    mutants, name = select(places, sys.argv[1:])
    programs = build(mutants, len(mutants))
    tests = []
    for program, folder in programs:
        names = subprocess.check_output([program, "--list"], cwd=folder, text=True).splitlines()
        tests += [(program, folder, name[: -len(": test")]) for name in names if name.endswith(": test")]
    with ThreadPoolExecutor(jobs) as pool:
        measured = list(pool.map(measure, tests))
    for seconds, _, passed, test in measured:
        if not passed:
            print(f"fails without mutant, left out: {test[2]}")
    measured = [entry for entry in measured if entry[2] and entry[1]]
    print(f"{len(mutants)} mutants, {len(measured)} of {len(tests)} tests reach one", flush=True)
    results = WORK / name
    known = read_results(results, mutants)
    with ThreadPoolExecutor(jobs) as pool:
        list(pool.map(lambda number: number in known or judge(number, mutants[number], measured, results), mutants))
    lines = read_results(results, mutants).values()
    missed = [line for line in lines if "\tmissed\t" in line]
    print("missed:", *missed, sep="\n")
    print(f"{name}: caught {len(lines) - len(missed)}, missed {len(missed)} of {len(lines)} mutants that compile")
    sys.exit(10 * len(missed) > len(lines))


if __name__ == "__main__":
    main()
