"""Runs a scene with the program and judges it by exit status, messages, energy balance and each of its terms."""

import contextlib
import csv
import json
import math
import os
import re
import signal
import subprocess
import time
from dataclasses import dataclass, field

# Largest part of the largest energy by which an energy may violate a rule without a warning.
BOUND = 0.01
# Increments for which a violation may last without a warning: a sudden release causes a few.
BRIEF = 10
# Documented exit status: complete, halted, invalid input, signals.
COMPLETE, HALTED, INVALID = 0, 1, 2
INTERRUPTED = (130, 143)

# Energies that are never negative, and the warnings that report a negative value. Energies joined by + are added.
NEVER_NEGATIVE = {
    "ALLKE": ("R303",),
    "ALLIE": ("R303",),
    "ALLSE": ("R303",),
    "ALLPD": ("R303",),
    "ALLDMD": ("R303",),
    "ALLVD": ("R303",),
    "ALLFD": ("R303", "R304"),
    "ALLAE": ("R302", "R303"),
    "ALLDC": ("R303",),
    "ALLCAV": ("R303",),
    "ALLCW+ALLPW": ("P111", "R304"),
}
# Dissipated energies, which never decrease.
NEVER_DECREASING = {
    "ALLPD+ALLDMD": ("R303",),
    "ALLVD": ("R303",),
    "ALLFD": ("R303", "R304"),
    "ALLCAV": ("R303",),
}
# Energies that a material with stored energy may release; the work of its hourglass control comes from its own energy.
RELEASED = ("ALLIE", "ALLSE", "ALLAE")


@dataclass
class Run:
    """A finished run of the program."""

    code: int
    messages: str
    summary: dict | None
    rows: dict
    seconds: float
    timed_out: bool

    @property
    def digest(self):
        return (self.summary or {}).get("digest")

    @property
    def status(self):
        return (self.summary or {}).get("status", "")


@dataclass
class Verdict:
    """Result of a scene: its class and the failures."""

    kind: str
    failures: list = field(default_factory=list)
    drift: float = 0.0
    increments: int = 0
    seconds: float = 0.0
    warnings: tuple = ()


def wait(process, limit):
    """Waits for a process; sends SIGTERM at the limit and SIGKILL 10 s later. Returns messages and whether it was late."""
    try:
        return process.communicate(timeout=limit)[1], False
    except subprocess.TimeoutExpired:
        process.terminate()
    try:
        return process.communicate(timeout=10)[1], True
    except subprocess.TimeoutExpired:
        process.kill()
        return process.communicate()[1] + "\nnot ended 10 s after SIGTERM\n", True


def start(program, deck, folder, arguments=()):
    command = [program, "run", deck, "--out", folder, *arguments]
    return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, errors="replace")


def run(program, deck, folder, limit, arguments=()):
    """Runs a deck and reads its results."""
    begin = time.monotonic()
    messages, late = wait(process := start(program, deck, folder, arguments), limit)
    seconds = time.monotonic() - begin
    stem = os.path.join(folder, os.path.splitext(os.path.basename(deck))[0])
    summary, rows = None, {}
    with contextlib.suppress(OSError, ValueError), open(f"{stem}.json", encoding="utf-8") as file:
        summary = json.load(file)
    with contextlib.suppress(OSError), open(f"{stem}_history.csv", newline="", encoding="utf-8") as file:
        table = list(csv.reader(file))
        rows = {name: [float(row[i]) for row in table[1:]] for i, name in enumerate(table[0])}
    return Run(process.returncode, messages, summary, rows, seconds, late)


def codes_of(done):
    """Returns the codes of the warnings of a run and of its deck."""
    of_deck = re.findall(r"^warning\[(\w+)\]", done.messages, re.MULTILINE)
    return {*of_deck, *(warning.split(":")[0] for warning in (done.summary or {}).get("warnings", []))}


def column(rows, name):
    parts = [rows[part] for part in name.split("+") if part in rows]
    return [sum(values) for values in zip(*parts, strict=True)]


def largest_energy(rows):
    """Returns the largest energy up to each row: kinetic, internal, or work of loads."""
    largest, values = 0.0, []
    names = [name for name in ("ALLKE", "ALLIE", "ALLWK") if name in rows]
    for row in zip(*(rows[name] for name in names), strict=True):
        largest = max(largest, *(abs(value) for value in row))
        values.append(largest)
    return values


def violations(rows, scene):
    """Returns pairs of a violated rule and the warnings that report it; with the number of rows that violate it."""
    largest = largest_energy(rows)
    if not largest or largest[-1] == 0.0:
        return []
    bound = BOUND * largest[-1]
    found = []
    for name, warnings in NEVER_NEGATIVE.items():
        if scene.stores and name in RELEASED:
            continue
        # An exponential pressure-overclosure relationship stores energy at zero clearance, which contact may release.
        if name == "ALLCW+ALLPW" and any("exponential" in feature for feature in scene.features):
            continue
        values = column(rows, name)
        below = sum(value < -bound for value in values)
        if below:
            share = 100 * min(values) / largest[-1]
            found.append(
                (f"{name} is negative: {share:.2f} % of the largest energy", warnings, below, values[-1] < -bound)
            )
    for name, warnings in NEVER_DECREASING.items():
        # The work of back stress is returned on reverse flow.
        if name.startswith("ALLPD") and "material: kinematic" in scene.features:
            continue
        values, highest, fallen, most = column(rows, name), 0.0, 0, 0.0
        for value in values:
            highest = max(highest, value)
            most = max(most, highest - value)
            fallen += highest - value > bound
        if fallen:
            found.append(
                (
                    f"{name} decreases by {100 * most / largest[-1]:.2f} % of the largest energy",
                    warnings,
                    fallen,
                    highest - values[-1] > bound,
                )
            )
    work = rows.get("ALLWK", [])
    if not scene.loaded and work:
        most = max(abs(value) for value in work)
        if most > bound:
            found.append(
                (f"ALLWK without loads: {100 * most / largest[-1]:.2f} % of the largest energy", (), len(work), True)
            )
    return found


def judge(done, scene, confirm):
    """Returns the verdict of a run. `confirm` runs the scene again with a history row in each increment."""
    summary = done.summary or {}
    drift = summary.get("energy", {}).get("drift", 0.0)
    increments = sum(step.get("increments", 0) for step in summary.get("steps", []))
    codes = codes_of(done)
    verdict = Verdict("closed", drift=drift, increments=increments, seconds=done.seconds, warnings=tuple(sorted(codes)))
    fail = verdict.failures.append
    if "panicked" in done.messages or done.code == 101:
        fail("panic")
    elif done.code < 0:
        fail(f"ended by signal {-done.code}")
    elif done.code not in (COMPLETE, HALTED, INVALID, *INTERRUPTED):
        fail(f"exit status {done.code} is not documented")
    if verdict.failures:
        verdict.kind = "failed"
        return verdict
    if done.timed_out:
        verdict.kind = "slow"
        if done.code not in INTERRUPTED:
            fail(f"exit status {done.code} after SIGTERM")
        if not codes & {"R306", "R307"} and increments < 100_000:
            fail("slow without a warning")
        return verdict
    if done.code == INVALID:
        verdict.kind = "refused"
        if "-->" not in done.messages:
            fail("invalid input without file and line")
        return verdict
    if not summary:
        fail("no summary")
        return verdict
    if done.code == HALTED:
        verdict.kind = "halted"
        reason = str(summary.get("halt") or done.messages)
        if "increment" not in reason or "time" not in reason:
            fail(f"halted without increment and time: {reason[:200]}")
        return verdict
    if not all(math.isfinite(value) for values in done.rows.values() for value in values):
        fail("a history value is not finite")
    if not math.isfinite(drift) or drift > 0.2:
        fail(f"complete with a drift of {100 * drift:.1f} %")
    elif drift > BOUND and "R301" not in codes:
        fail(f"drift of {100 * drift:.2f} % without a warning")
    if drift > BOUND:
        verdict.kind = "warned of drift"
    else:
        verdict.kind = "closed, with a warning" if any(code.startswith("R") for code in codes) else "closed"
    silent = [found for found in violations(done.rows, scene) if not codes & {"R301", *found[1]}]
    if silent:
        # Rows of each increment show for how long, and the largest energy between rows.
        rows = confirm().rows
        for text, warnings, count, last in violations(rows, scene):
            if not codes & {"R301", *warnings} and (count >= BRIEF or last):
                fail(f"{text} in {count} increments, without a warning")
    if not silent and codes & {"R303", "R304"} and verdict.kind == "closed, with a warning":
        verdict.kind = "warned of a term"
    return verdict


def same_on_two_threads(program, deck, folder, limit, parts):
    """Returns the failure, or None; and whether both runs ended in time."""
    digests = []
    for threads in ("1", "2"):
        arguments = ["--threads", threads, "--no-frames", "--mesh-refine", str(parts)]
        done = run(program, deck, os.path.join(folder, f"threads{threads}"), limit, arguments)
        if done.timed_out or done.code == INVALID:
            return None, False
        if done.code not in (COMPLETE, HALTED):
            return f"exit status {done.code} on {threads} threads, --mesh-refine {parts}", True
        digests.append((done.digest, done.code))
    if digests[0] != digests[1]:
        return f"digest depends on the number of threads, --mesh-refine {parts}", True
    return None, True


def same_after_a_split(program, scene, whole, write, folder, limit):
    """Compares a run with fixed increments with the same run whose first step is two steps."""
    steps = whole.summary["steps"]
    smallest = min(step["smallest_increment"] for step in steps)
    count = 2 * math.ceil(scene.steps[0].time / smallest)
    if count > 20_000:
        return None, False
    increment = scene.steps[0].time / count
    results = []
    for split in (False, True):
        deck = write(scene.deck(100, split, increment), "split" if split else "whole")
        done = run(program, deck, os.path.join(folder, f"split{split}"), limit)
        if done.timed_out or done.code == INVALID:
            return (None if done.timed_out else f"split: {done.messages[:300]}"), False
        results.append(done)
    if results[0].code != results[1].code:
        return f"exit status {results[0].code} becomes {results[1].code} if the first step is split", True
    if results[0].code != COMPLETE:
        return None, False
    return difference_of_histories(results[0].rows, results[1].rows, increment, count), True


def difference_of_histories(first, second, increment, count):
    """Returns a difference of energies: at rounding errors shortly after the split, at half of `count` increments, and
    limited at the end. Contact, failure and explosives amplify rounding errors of the time in between."""
    largest = largest_energy(first)[-1]
    places = [{round(time / increment): i for i, time in enumerate(rows["time"])} for rows in (first, second)]
    names = [name for name in first if name.startswith(("ALL", "ETOTAL")) and name in second]
    for at in sorted(places[0].keys() & places[1].keys()):
        bound = 1e-6 if at <= 0.52 * count else 0.05 if at == max(places[0]) else math.inf
        for name in names:
            difference = abs(first[name][places[0][at]] - second[name][places[1][at]])
            if difference > bound * largest:
                return f"{name} differs by {difference / largest:.1e} of the largest energy if the first step is split"
    return None


def same_after_a_kill(program, deck, folder, limit, dice, whole_seconds, increments, arguments):
    """Kills a run at a random moment and resumes it; returns the failure or None, and whether it was killed."""
    every = ["--checkpoint-every", str(max(1, increments // 25)), *arguments]
    reference = run(program, deck, os.path.join(folder, "undisturbed"), limit, every)
    if reference.timed_out or reference.code not in (COMPLETE, HALTED):
        return None, False
    target = os.path.join(folder, "killed")
    for _ in range(8):
        process = start(program, deck, target, every)
        time.sleep(dice.uniform(0.0, reference.seconds))
        process.send_signal(signal.SIGKILL)
        process.communicate()
        if process.returncode == -signal.SIGKILL:
            break
    else:
        return None, False
    resumed = run(program, deck, target, limit, ["--resume", *every])
    if resumed.timed_out:
        return None, False
    if (resumed.code, resumed.digest) != (reference.code, reference.digest):
        return f"after kill -9 and --resume: exit status {resumed.code}, another digest; {resumed.messages[:200]}", True
    if resumed.rows != reference.rows:
        return "after kill -9 and --resume the history differs", True
    return None, True
