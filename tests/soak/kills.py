"""Kills of sweep, study, limit, identify and scatter at random moments: the same tables after another run."""

import json
import os
import random
import shutil
import signal
import subprocess
import tempfile
import time

# A rigid body in a target: a run takes less than a millisecond.
DECK = """*Parameter
V = 500.
A = 4.
n = 12
v = -V
last = 1 + n
*Node
 1, 0., 0.
 <last>, 3.e-3, 6.e-3
 9999, 0., 6.e-3
*Ngen, nset=NOSE
 1, <last>, 1
*Nset, nset=REF
 9999
*Element, type=RAX2, elset=NOSE
 1, 1, 2
*Elgen, elset=NOSE
 1, <n>, 1, 1
*Element, type=MASS, elset=BODY
 9999, 9999
*Mass, elset=BODY
 0.02
*Rigid Body, ref node=REF, elset=NOSE
*Surface, name=NOSE
 NOSE, SNEG
*Material, name=PLATE
*Density
 2700.,
*Cavity Expansion, yield=276.e6
 <A>, 0., 1.
*Target, name=BLOCK, front=0., direction=-1
 PLATE, 0.02
*Initial Conditions, type=VELOCITY
 REF, 2, <v>
*Step
*Dynamic, Explicit
 , 2.e-4
*Dsload, target=BLOCK
 NOSE, CAVITY
*Output, history, number interval=20
*Node Output, nset=REF
 U2, V2
*Energy Output
 ALL
*End Step
"""
SHOTS = "V,depth\n" + "".join(f"{v},{0.02 * v}\n" for v in range(100, 320, 10))
QUANTITY = ("--quantity", "-1000*final(U2@REF)")

COMMANDS = {
    "sweep": (
        ["sweep", "DECK", "--set", "V=200:800:#400", "--set", "A=3,4,5", *QUANTITY],
        ["--resume"],
    ),
    "study": (["study", "DECK", "--refine", "n=4,8,16,32,64", "--repeat", "20", *QUANTITY], []),
    "limit": (
        ["limit", "DECK", "--velocity", "V", "--between", "50,1500", "--tolerance", "0.01"]
        + ["--distribution", "A=normal(4, 0.2)", "--count", "60"],
        [],
    ),
    "identify": (
        [
            "identify",
            "DECK",
            "--shots",
            "SHOTS",
            "--measured",
            "depth",
            *QUANTITY,
            "--unknown",
            "A=2..8",
            "--starts",
            "40",
        ],
        [],
    ),
    "scatter": (
        ["scatter", "DECK", "--distribution", "V=normal(500, 10)", "--distribution", "A=normal(4, 0.3)"]
        + ["--count", "2000", "--indices", "--sampling", "sobol", *QUANTITY],
        [],
    ),
}
# Values that depend on the clock.
CLOCK = ("timing", "front", "prices", "sentence")
CLOCK_COLUMNS = ("second", "time", "note")


def without_clock(value):
    """Returns a JSON value without the members that depend on the clock."""
    if isinstance(value, dict):
        return {key: without_clock(item) for key, item in value.items() if key not in CLOCK and "second" not in key}
    if isinstance(value, list):
        return [without_clock(item) for item in value]
    return value


def tables(folder):
    """Returns the tables in a folder by file name; columns of times are left out."""
    found = {}
    for name in sorted(os.listdir(folder)) if os.path.isdir(folder) else ():
        path = os.path.join(folder, name)
        if name.startswith(".revolve-") or name.endswith((".svg", ".png", ".sfv", ".sta")):
            continue
        with open(path, encoding="utf-8", errors="replace") as file:
            text = file.read()
        if name.endswith(".json"):
            found[name] = without_clock(json.loads(text))
        elif name.endswith(".csv"):
            rows = [line.split(",") for line in text.splitlines()]
            keep = (
                [i for i, title in enumerate(rows[0]) if not any(word in title for word in CLOCK_COLUMNS)]
                if rows
                else []
            )
            found[name] = [[row[i] for i in keep if i < len(row)] for row in rows]
    return found


def start(program, arguments, folder, scratch):
    places = {"DECK": os.path.join(scratch, "shot.inp"), "SHOTS": os.path.join(scratch, "shots.csv")}
    command = [program, *(places.get(argument, argument) for argument in arguments), "--out", folder, "--quiet"]
    return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)


def kill_once(program, name, reference, seconds, dice, scratch):
    """Kills a command, runs `report` on its folder, and runs the command again. Returns a failure or None, and whether
    it was killed."""
    arguments, resume = COMMANDS[name]
    folder = os.path.join(scratch, f"killed-{name}")
    shutil.rmtree(folder, ignore_errors=True)
    process = start(program, arguments, folder, scratch)
    time.sleep(dice.uniform(0.0, seconds))
    process.send_signal(signal.SIGKILL)
    process.communicate()
    killed = process.returncode == -signal.SIGKILL
    if os.path.isdir(folder):
        try:
            left = tables(folder)
        except ValueError as error:
            return f"{name}: incomplete JSON file after a kill: {error}", killed
        torn = [file for file in left if file in reference and left[file] != reference[file]]
        if torn:
            return f"{name}: after a kill {', '.join(torn)} differs from the complete file", killed
        report = subprocess.run([program, "report", folder], capture_output=True, text=True, check=False)
        if report.returncode not in (0, 1, 2) or "panicked" in report.stderr:
            return f"{name}: report of a killed folder: exit status {report.returncode}", killed
        for extra in ("index.html", "report.html"):
            if os.path.exists(os.path.join(folder, extra)):
                os.remove(os.path.join(folder, extra))
    again = start(program, [*arguments, *resume], folder, scratch)
    messages = again.communicate()[1]
    if again.returncode != 0:
        return f"{name}: exit status {again.returncode} after a kill: {messages[:300]}", killed
    found = tables(folder)
    different = [file for file in reference if found.get(file) != reference[file]]
    if different:
        return f"{name}: {', '.join(different)} differs after a kill", killed
    more = [file for file in found if file not in reference]
    return (f"{name}: {', '.join(more)} remains after a kill" if more else None), killed


def report(program, count, seed):
    """Kills the commands `count` times in all and prints a table; returns whether something failed."""
    dice, failures = random.Random(seed), []
    print("\n## Kills\n\n| command | run time, s | kills | failures |\n|---|---|---|---|")
    with tempfile.TemporaryDirectory(prefix="soak-kills-") as scratch:
        for name, text in (("shot.inp", DECK), ("shots.csv", SHOTS)):
            with open(os.path.join(scratch, name), "w", encoding="utf-8") as file:
                file.write(text)
        for name, (arguments, _) in COMMANDS.items():
            folder = os.path.join(scratch, f"whole-{name}")
            begin = time.monotonic()
            whole = start(program, arguments, folder, scratch)
            messages = whole.communicate()[1]
            seconds = time.monotonic() - begin
            if whole.returncode != 0:
                failures.append(f"{name}: exit status {whole.returncode}: {messages[:300]}")
                continue
            reference, kills, own = tables(folder), 0, []
            for _ in range(4 * count):
                failure, killed = kill_once(program, name, reference, seconds, dice, scratch)
                kills += killed
                own += [failure] if failure else []
                if kills >= count // len(COMMANDS):
                    break
            failures += own
            print(f"| {name} | {seconds:.2f} | {kills} | {len(own)} |", flush=True)
    for failure in failures:
        print(f"\n{failure}")
    return bool(failures)
