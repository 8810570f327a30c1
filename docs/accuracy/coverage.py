"""Measures how often the uncertainty that `revolve study` states contains the true error: scenes with known answers.

coverage.py                 runs the scenes of scenes.csv, prints the table and writes coverage.csv
coverage.py --only TEXT     only scenes whose name or deck contains the text; writes no file

The environment variable REVOLVE names the program (default: target/release/revolve). Standard library only.
"""

import argparse
import csv
import json
import os
import statistics
import subprocess
import sys
import tempfile
from datetime import date
from pathlib import Path

import answers

HERE = Path(__file__).resolve().parent
REVOLVE = os.environ.get("REVOLVE", str(HERE.parents[1] / "target" / "release" / "revolve"))
LIMIT = 120  # seconds of a study


def scenes():
    """Returns the rows of scenes.csv."""
    with open(HERE / "scenes.csv", newline="", encoding="utf-8") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def study(scene, folder):
    """Runs the refinement study of a scene and returns its record."""
    command = [REVOLVE, "study", HERE / "scenes" / f"{scene['deck']}.inp", "--refine", scene["levels"]]
    command += ["--quantity", scene["quantity"], "--repeat", "1", "--out", folder, "--json"]
    for setting in scene["set"].split():
        command += ["--set", setting]
    done = subprocess.run([str(c) for c in command], check=False, capture_output=True, text=True, timeout=LIMIT)
    if done.returncode != 0:
        raise RuntimeError((done.stderr or done.stdout).strip().splitlines()[-1])
    return json.loads(done.stdout)


def measure(scene, folder):
    """Returns the row of a scene: value, stated uncertainty, true error."""
    exact = eval(scene["answer"], vars(answers))
    record = study(scene, folder)
    last = record["runs"][-1]
    value, uncertainty = last["value"], last["uncertainty"]
    estimate = next((e for e in reversed(last["estimates"]) if e), {})
    error = abs(value - exact)
    return {
        "scene": scene["scene"],
        "unseen": scene["unseen"],
        "value": f"{value:.9g}",
        "answer": f"{exact:.9g}",
        "uncertainty": f"{uncertainty:.3g}",
        "error": f"{error:.3g}",
        "inside": "yes" if error <= uncertainty else "NO",
        "ratio": f"{uncertainty / error:.3g}" if error else "inf",
        "order": f"{estimate['order']:.2f}" if estimate.get("order") else "",
        "behaviour": estimate.get("behaviour", ""),
        "levels": " ".join(f"{run['value']:.9g}" for run in record["runs"]),
    }


def totals(rows):
    """Returns the share inside and the median ratio of stated uncertainty and true error."""
    inside = sum(row["inside"] == "yes" for row in rows)
    ratio = statistics.median(float(row["ratio"]) for row in rows)
    return f"{inside} of {len(rows)} inside ({100 * inside / len(rows):.0f} %), median ratio {ratio:.3g}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default="", help="text in the name or deck of a scene")
    only = parser.parse_args().only
    rows, failed = [], []
    line = "{scene:<46} {value:>15} {uncertainty:>10} {error:>10} {inside:>6} {ratio:>9} {order:>6} {behaviour}"
    print(
        line.format(
            **{k: k for k in ("scene", "value", "uncertainty", "error", "inside", "ratio", "order", "behaviour")}
        )
    )
    with tempfile.TemporaryDirectory(prefix="coverage-") as folder:
        for scene in scenes():
            if only not in scene["scene"] and only not in scene["deck"]:
                continue
            try:
                rows.append(measure(scene, folder))
                print(line.format(**rows[-1]), flush=True)
            except (RuntimeError, subprocess.TimeoutExpired) as problem:
                failed.append(scene["scene"])
                print(f"{scene['scene']:<46} failed: {problem}", flush=True)
    for name, part in [
        ("all", rows),
        ("unseen", [r for r in rows if r["unseen"] == "yes"]),
        ("not unseen", [r for r in rows if r["unseen"] == "no"]),
    ]:
        if part:
            print(f"{name}: {totals(part)}")
    for row in rows:
        if row["inside"] == "NO":
            print(f"outside: {row['scene']}: {row['value']} +- {row['uncertainty']}, true {row['answer']}")
    if failed:
        print(f"failed: {', '.join(failed)}")
    if rows and not only:
        version = subprocess.run(
            [REVOLVE, "--version"], check=True, capture_output=True, text=True
        ).stdout.splitlines()[0]
        with open(HERE / "coverage.csv", "w", newline="", encoding="utf-8") as file:
            file.write(f"# {version}; {date.today().isoformat()}\n")
            writer = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
