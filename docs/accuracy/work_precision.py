"""Measures error against CPU time on one core, and draws the diagrams of docs/accuracy.md.

work_precision.py                  runs all scenes, writes work_precision.csv and work_precision_*.svg
work_precision.py --only NAME,...  runs these scenes and replaces their rows
work_precision.py --draw           draws the diagrams from work_precision.csv

The environment variable REVOLVE names the program (default: target/release/revolve). CalculiX (`ccx`) takes part if it
is installed; its decks are in the folder calculix. Standard library only. CPU times are user and system times of the
process, with its start and the reading of the deck.
"""

import argparse
import csv
import itertools
import json
import math
import os
import re
import shutil
import subprocess
import sys
import tempfile
import xml.sax.saxutils
from datetime import date
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
REVOLVE = os.environ.get("REVOLVE", str(ROOT / "target" / "release" / "revolve"))
CCX = shutil.which("ccx")
LIMIT = 400  # seconds of a run
COSTLY = 1.0  # CPU seconds of the default setting above which a mesh is run with fewer settings
SHOTS = 300  # runs of a rigid projectile in one process, because one takes less time than the start of the program

HOURGLASS = ["relax-stiffness", "stiffness", "viscous", "combined", "enhanced"]
FACTORS = [1.0, 0.5, 0.25]

# Name, title, deck, levels as settings, quantity, exact value (None: limit of the finest meshes), relative error of this
# value (default 0), hourglass kinds.
SCENES = {
    "wave": {
        "title": "Elastic wave: column under a smooth pulse",
        "deck": "scenes/smooth_pulse.inp",
        "levels": [{"n": n} for n in (10, 20, 40, 80, 160)],
        "quantity": "-final(U2@TIP)",
        "exact": 0.6e-6 / math.sqrt(3),
        "floor": 2e-7,
        "hourglass": HOURGLASS[:1],
    },
    "lame": {
        "title": "Thick sphere under pressure (Lamé)",
        "deck": "scenes/lame_sphere.inp",
        "levels": [{"n": n} for n in (4, 8, 16, 32)],
        "quantity": "final(U1@BORE)",
        "exact": 8e-8,
        "hourglass": HOURGLASS,
    },
    "hill": {
        "title": "Plastic sphere (Hill)",
        "deck": "scenes/hill_sphere.inp",
        "levels": [{"n": n} for n in (6, 12, 24, 48)],
        "quantity": "final(U1@RIM)",
        "exact": 1.771875e-6,
        "hourglass": HOURGLASS,
    },
    "verney": {
        "title": "Imploding shell (Verney): inner radius at rest",
        "deck": "verney",
        "levels": [{"n": n} for n in (6, 12, 24, 48)],
        "quantity": "8 + min(U1@INNER)",
        "exact": 4.0,
        "floor": 1.5e-4,
        "hourglass": HOURGLASS,
    },
    "taylor": {
        "title": "Copper Taylor bar: length after 80 µs",
        "floor": 6e-5,
        "deck": "../../input/taylor_copper.inp",
        "levels": [{"nr": n, "nz": 5 * n} for n in (5, 10, 20, 40)],
        "quantity": "1000*final(COOR2@TIP)",
        "exact": None,
        "hourglass": HOURGLASS,
    },
    "noh": {
        "title": "Gas shock (Noh): density",
        "deck": "scenes/noh.inp",
        "levels": [{"n": n} for n in (25, 50, 100, 200, 400)],
        "quantity": "final(DENSITY@ONE)",
        "exact": 4.0,
        "hourglass": ["viscous"],
    },
    "hertz": {
        "title": "Rigid sphere on a block (Hertz): pressure",
        "deck": "scenes/hertz.inp",
        "levels": [{"k": k} for k in (2, 4, 8, 16)],
        "quantity": "mean(CPRESS@MIDDLE, 250, 400)",
        "exact": 2 / (0.91 * 5000 * math.pi),
        "hourglass": HOURGLASS,
    },
    "ogive": {
        "title": "Rigid ogive (Forrestal): depth",
        "deck": "scenes/ogive.inp",
        "levels": [{"n": n} for n in (5, 10, 20, 40, 80, 160)],
        "quantity": "-final(U2@REF)",
        "exact": 59.612643939e-3,
        "accuracy": [1e-3, 1e-4, 1e-5, 1e-6, 1e-7],
    },
    "bars": {
        "title": "Contact of three columns: velocity of the last",
        "deck": "scenes/three_bars.inp",
        "levels": [{"n": n} for n in (10, 20, 40, 80, 160)],
        "quantity": "-final(V2_MEAN@ALL)",
        "exact": 1e-4,
        "hourglass": HOURGLASS[:1],
    },
}
COLUMNS = ["scene", "code", "mesh", "increment", "hourglass", "value", "error", "cpu_seconds", "front"]


def cpu_time(command, folder):
    """Runs a command and returns its CPU time in seconds and its output."""
    with tempfile.TemporaryFile("w+") as output:
        child = subprocess.Popen(
            ["timeout", str(LIMIT), *map(str, command)],
            stdout=output,
            stderr=subprocess.STDOUT,
            cwd=folder,
            env={**os.environ, "OMP_NUM_THREADS": "1"},
        )
        _, status, usage = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
        output.seek(0)
        text = output.read()
    if status:
        raise RuntimeError(text.strip().splitlines()[-1] if text.strip() else f"status {status}")
    return usage.ru_utime + usage.ru_stime, text


def shortest(measure):
    """Returns the result with the shortest CPU time of up to three runs; long runs are not repeated."""
    best = measure()
    for _ in range(2):
        if best[0] < 0.3:
            best = min(best, measure())
    return best


# Revolve


def verney(n):
    """Returns the deck of the imploding shell of `tests/program/study_cases.rs` on n by n elements (cm, g, µs)."""
    bulk, shear = 11.80, 15.1
    young = 9 * bulk * shear / (3 * bulk + shear)
    ratio = (3 * bulk - 2 * shear) / (2 * (3 * bulk + shear))
    radii = [8 + 2 * i / n for i in range(n + 1)]
    rays = [(math.cos(0.5 * math.pi * j / n), math.sin(0.5 * math.pi * j / n)) for j in range(n)] + [(0.0, 1.0)]
    places = [(radius * r, radius * z) for r, z in rays for radius in radii]
    speeds = [
        (-0.0619787076 * (8 / radius) ** 2 * r, -0.0619787076 * (8 / radius) ** 2 * z)
        for r, z in rays
        for radius in radii
    ]
    text = "*Node\n" + "".join(f" {k}, {r!r}, {z!r}\n" for k, (r, z) in enumerate(places, 1))
    text += f"*Element, type=CAX4R\n 1, 1, 2, {n + 3}, {n + 2}\n*Elgen, elset=SOLID\n 1, {n}, 1, 1, {n}, {n + 1}, {n}\n"
    text += f"*Nset, nset=J0, generate\n 1, {n + 1}\n*Nset, nset=J1, generate\n {n * (n + 1) + 1}, {(n + 1) ** 2}\n"
    text += "*Nset, nset=INNER\n 1,\n*Solid Section, elset=SOLID, material=M\n*Material, name=M\n*Density\n 1.845\n"
    text += f"*Elastic\n {young!r}, {ratio!r}\n*Plastic\n 0.0033, 0.\n*Initial Conditions, type=VELOCITY\n"
    text += "".join(f" {k}, 1, {r!r}\n {k}, 2, {z!r}\n" for k, (r, z) in enumerate(speeds, 1))
    return text + (
        "*Step\n*Dynamic, Explicit, element by element\n , 105.\n*Bulk Viscosity, linear term=UNFILTERED\n 0.06, 1.2\n"
        "*Boundary\n J0, 2, 2\n J1, 1, 1\n*Output, history, time interval=0.1\n*Node Output, nset=INNER\n U1\n*End Step\n"
    )


def deck_text(scene, level, factor, hourglass):
    """Returns the deck of a scene with a factor on the stable time increment and a kind of hourglass control."""
    text = verney(level["n"]) if scene["deck"] == "verney" else (HERE / scene["deck"]).read_text(encoding="utf-8")
    if "accuracy" in scene:
        text = re.sub(r"accuracy=\S+", f"accuracy={factor:g}", text)
        return text.replace("*Parameter\n", "*Parameter\nshot = 1\n", 1)
    if factor != 1:
        text = re.sub(r"(\*Dynamic, Explicit[^\n]*)", rf"\1, scale factor={factor:g}", text)
    if hourglass != "default":
        text = re.sub(r"(\*Solid Section[^\n]*)", r"\1, controls=HOURGLASS", text)
        controls = f"*Section Controls, name=HOURGLASS, hourglass={hourglass.replace('-', ' ')}\n"
        text = re.sub(r"(?m)^\*Step\b", controls + "*Step", text, count=1)
    return text


def run_revolve(name, level, factor, hourglass, folder):
    """Returns the CPU time and the quantity of one run."""
    scene = SCENES[name]
    (folder / "deck.inp").write_text(deck_text(scene, level, factor, hourglass), encoding="utf-8")
    settings = [] if scene["deck"] == "verney" else [x for k, v in level.items() for x in ("--set", f"{k}={v}")]
    command = ["deck.inp", *settings, "--quantity", scene["quantity"], "--threads", 1, "--out", "out"]
    if "accuracy" in scene:

        def shots(count):
            seconds, text = cpu_time([REVOLVE, "sweep", *command, "--set", f"shot=1:{count}:1", "--json"], folder)
            return seconds, json.loads(text)["runs"][0]["values"][scene["quantity"]]

        many, value = shortest(lambda: shots(SHOTS))
        return (many - shortest(lambda: shots(1))[0]) / (SHOTS - 1), value

    def measure():
        more = ["--no-frames", "--quiet"]
        seconds, text = cpu_time([REVOLVE, "run", *command, *more], folder)
        return seconds, float(text.strip().splitlines()[-1].rsplit("=", 1)[1])

    return shortest(measure)


def row(name, code, level, factor, hourglass, measured, exact):
    seconds, value = measured
    return {
        "scene": name,
        "code": code,
        "mesh": " ".join(f"{k}={v}" for k, v in level.items()),
        "increment": f"{factor:g}",
        "hourglass": hourglass,
        "value": f"{value:.9g}",
        "error": f"{abs(value / exact - 1):.3e}",
        "cpu_seconds": f"{seconds:.3g}",
        "front": "",
    }


def limit_of_finest(name, folder):
    """Returns the limit by Richardson extrapolation from the three finest meshes, one of them finer than those measured."""
    scene = SCENES[name]
    finest = {k: 2 * v for k, v in scene["levels"][-1].items()}
    levels = [*scene["levels"][-2:], finest]
    a, b, c = (run_revolve(name, level, 1.0, "default", folder)[1] for level in levels)
    order = math.log2((b - a) / (c - b))
    limit = c + (c - b) / (2 ** min(order, 2.0) - 1)
    print(f"{name}: {a:.6f}, {b:.6f}, {c:.6f}, order {order:.2f}, limit {limit:.6f}", flush=True)
    return limit


def measure_revolve(name, folder):
    """Returns the rows of a scene: mesh, increment and hourglass control."""
    scene = SCENES[name]
    exact = scene["exact"] or limit_of_finest(name, folder)
    rows = []
    for level in scene["levels"]:
        if "accuracy" in scene:
            settings = [(f, "") for f in scene["accuracy"]]
        else:
            settings = list(itertools.product(FACTORS, scene["hourglass"]))
        costly = False
        for factor, hourglass in settings:
            if costly and factor != 1:
                continue
            try:
                measured = run_revolve(name, level, factor, hourglass, folder)
            except RuntimeError as problem:
                print(f"{name} {level} {factor:g} {hourglass}: {problem}", flush=True)
                continue
            costly |= measured[0] > COSTLY
            rows.append(row(name, "Revolve", level, factor, hourglass, measured, exact))
            print(*rows[-1].values(), flush=True)
    return rows


# CalculiX


def listed(keyword, numbers):
    return keyword + "\n" + "".join(f"{n},\n" for n in numbers)


def calculix_mesh(name, n, kind):
    """Returns the mesh of a scene for CalculiX: the nodes and elements of the Revolve deck."""
    nr, nz = (1, n) if name == "wave" else (n, 2 * n)
    lines = ["*NODE, NSET=ALL"]
    for j, i in itertools.product(range(nz + 1), range(nr + 1)):
        r, z = i / n, j / n
        if name != "wave":
            radius, angle = 1 + i / nr, 0.5 * math.pi * j / nz
            r, z = (0.0 if j == nz else radius * math.cos(angle)), radius * math.sin(angle)
        lines.append(f"{1 + i + j * (nr + 1)}, {r:.13g}, {z:.13g}, 0.")
    lines.append(f"*ELEMENT, TYPE={kind}, ELSET=SOLID")
    for e, (j, i) in enumerate(itertools.product(range(nz), range(nr)), 1):
        a = 1 + i + j * (nr + 1)
        lines.append(f"{e}, {a}, {a + 1}, {a + nr + 2}, {a + nr + 1}")
    top = nz * (nr + 1) + 1
    text = "\n".join(lines) + "\n"
    for nset, nodes in [
        ("EQUATOR", range(1, nr + 2)),
        ("BOTTOM", range(1, nr + 2)),
        ("AXIS", range(top, top + nr + 1)),
        ("BORE", [1]),
        ("RIM", [nr + 1]),
        ("TIP", [top]),
    ]:
        text += listed(f"*NSET, NSET={nset}", nodes)
    text += listed("*ELSET, ELSET=EINNER", range(1, nr * nz + 1, nr))
    return text + listed("*ELSET, ELSET=ETOP", range((nz - 1) * nr + 1, nz * nr + 1))


def smooth_step():
    """Returns the amplitude of a smooth step over a unit of time, four points a line."""
    points = [(k / 200, (k / 200) ** 3 * (10 - 15 * k / 200 + 6 * (k / 200) ** 2)) for k in range(201)] + [(2.0, 1.0)]
    lines = [points[i : i + 4] for i in range(0, len(points), 4)]
    return "\n".join(", ".join(f"{t:.6g}, {a:.12g}" for t, a in line) for line in lines)


# Deck, component of the displacement, sign, kinds of elements, increments by elements.
CALCULIX = {
    "wave": ("smooth_pulse", 1, -1, ["CAX4"], [lambda n: 1.1 / n, lambda n: 1.1 / (2 * n), lambda n: 1.1 / (4 * n)]),
    "lame": ("lame_sphere", 0, 1, ["CAX4", "CAX4R"], [lambda n: 1.0]),
    "hill": ("hill_sphere", 0, 1, ["CAX4", "CAX4R"], [lambda n: 0.2, lambda n: 0.05, lambda n: 0.0125]),
}


def measure_calculix(name, folder):
    """Returns the rows of CalculiX for a scene on the same meshes."""
    deck, component, sign, kinds, increments = CALCULIX[name]
    scene, rows = SCENES[name], []
    for level, kind, increment in itertools.product(scene["levels"], kinds, increments):
        n = level["n"]
        values = {
            "increment": f"{increment(n):.9g}",
            "pressure": f"{3 * (2 * math.log(1.5) + 2 / 3 * (1 - 1.5**3 / 8)):.12g}",
            "ramp": smooth_step(),
        }
        text = (HERE / "calculix" / f"{deck}.inp").read_text(encoding="utf-8")
        for key, value in values.items():
            text = text.replace(f"<{key}>", value)
        (folder / "job.inp").write_text(text, encoding="utf-8")
        (folder / "mesh.inp").write_text(calculix_mesh(name, n, kind), encoding="utf-8")

        def measure():
            seconds, _ = cpu_time([CCX, "-i", "job"], folder)
            found = (folder / "job.dat").read_text(encoding="utf-8").split()[-3:]
            return seconds, sign * float(found[component])

        try:
            rows.append(row(name, "CalculiX", level, increment(n), kind, shortest(measure), scene["exact"]))
            print(*rows[-1].values(), flush=True)
        except (RuntimeError, OSError, ValueError) as problem:
            print(f"CalculiX {name} {level} {kind}: {problem}", flush=True)
    return rows


# Results and diagrams


def visible_error(entry):
    """Returns the error, at least that of the exact value (finite strains, elastic strains, limit of the finest meshes)."""
    return max(float(entry["error"]), SCENES[entry["scene"]].get("floor", 1e-9))


def mark_front(rows):
    """Marks the rows of one scene and code for which no other is both faster and more accurate."""
    best = math.inf
    for entry in rows:
        entry["front"] = ""
    for entry in sorted(rows, key=lambda r: (float(r["cpu_seconds"]), visible_error(r))):
        if visible_error(entry) < best:
            best, entry["front"] = visible_error(entry), "yes"


def read_table():
    """Returns the first line and the rows of work_precision.csv."""
    lines = (HERE / "work_precision.csv").read_text(encoding="utf-8").splitlines()
    return lines[0], list(csv.DictReader(line for line in lines if not line.startswith("#")))


def versions():
    """Returns the first line of the table: versions and date."""
    version = subprocess.run([REVOLVE, "--version"], check=True, capture_output=True, text=True).stdout.splitlines()[0]
    other = "CalculiX not installed"
    if CCX:
        text = subprocess.run([CCX, "-v"], check=False, capture_output=True, text=True).stdout
        other = "CalculiX " + re.search(r"Version (\S+)", text)[1]
    return f"# {version}; {other}; {date.today().isoformat()}; one thread; CPU time of the process"


def write_table(head, rows):
    for name, code in itertools.product(SCENES, ("Revolve", "CalculiX")):
        mark_front([r for r in rows if r["scene"] == name and r["code"] == code])
    with open(HERE / "work_precision.csv", "w", newline="", encoding="utf-8") as file:
        file.write(head + "\n")
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


INK, GREY, LIGHT = "#333", "#8a8a8a", "#e3e3e3"
COLOURS = {
    "relax-stiffness": "#1f6fb4",
    "stiffness": "#2e8b57",
    "viscous": "#e08214",
    "combined": "#8e44ad",
    "enhanced": "#c0392b",
    "": "#1f6fb4",
}
WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM = 640, 440, 78, 178, 34, 52


def decades(values):
    """Returns the powers of ten that enclose positive values."""
    low, high = math.floor(math.log10(min(values))), math.ceil(math.log10(max(values)))
    return low, max(high, low + 1)


def draw(name, rows):
    """Writes the diagram of one scene: error over CPU time, with the Pareto front of each code."""
    scene, points = SCENES[name], [(float(r["cpu_seconds"]), visible_error(r), r) for r in rows]
    (x0, x1), (y0, y1) = decades([p[0] for p in points]), decades([p[1] for p in points])

    def place(x, y):
        u = LEFT + (math.log10(x) - x0) / (x1 - x0) * (WIDTH - LEFT - RIGHT)
        v = HEIGHT - BOTTOM - (math.log10(y) - y0) / (y1 - y0) * (HEIGHT - TOP - BOTTOM)
        return u, v

    parts = []

    def text(x, y, words, anchor="start", size=13, more=""):
        words = xml.sax.saxutils.escape(words)
        parts.append(
            f'<text x="{x:.1f}" y="{y:.1f}" font-size="{size}" text-anchor="{anchor}" fill="{INK}"{more}>{words}</text>'
        )

    def line(a, b, colour=LIGHT, width=1.0, dash=""):
        dash = f' stroke-dasharray="{dash}"' if dash else ""
        parts.append(
            f'<path d="M{a[0]:.1f} {a[1]:.1f}L{b[0]:.1f} {b[1]:.1f}" stroke="{colour}" stroke-width="{width}"{dash}/>'
        )

    def power(x, y, exponent, anchor):
        text(x, y, "10" + str(exponent).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")), anchor, 12)

    for k in range(x0, x1 + 1):
        line(place(10.0**k, 10.0**y0), place(10.0**k, 10.0**y1))
        u, v = place(10.0**k, 10.0**y0)
        power(u, v + 17, k, "middle")
    for k in range(y0, y1 + 1):
        line(place(10.0**x0, 10.0**k), place(10.0**x1, 10.0**k))
        u, v = place(10.0**x0, 10.0**k)
        power(u - 8, v + 4, k, "end")
    corner = place(10.0**x0, 10.0**y0)
    line(corner, place(10.0**x1, 10.0**y0), INK)
    line(corner, place(10.0**x0, 10.0**y1), INK)
    text(LEFT, 20, scene["title"], size=15)
    text((LEFT + WIDTH - RIGHT) / 2, HEIGHT - 12, "CPU time (s)", "middle")
    middle = (TOP + HEIGHT - BOTTOM) / 2
    text(18, middle, "relative error", "middle", more=f' transform="rotate(-90 18 {middle:.1f})"')

    def marker(u, v, entry, scale=1.0):
        if entry["code"] == "CalculiX":
            s = 4.2
            fill = INK if entry["hourglass"] == "CAX4" else "white"
            parts.append(
                f'<rect x="{u - s:.1f}" y="{v - s:.1f}" width="{2 * s}" height="{2 * s}" fill="{fill}" stroke="{INK}" '
                'stroke-width="1.4"/>'
            )
            return
        colour = COLOURS[entry["hourglass"]]
        radius = 4.6 if "accuracy" in scene else 2.6 + 2.4 * float(entry["increment"])
        parts.append(
            f'<circle cx="{u:.1f}" cy="{v:.1f}" r="{radius * scale:.1f}" fill="{colour}" stroke="{colour}" stroke-width="1.4" '
            'fill-opacity="0.75"/>'
        )

    codes = sorted({r["code"] for r in rows}, reverse=True)
    for code in codes:
        front = sorted((p for p in points if p[2]["code"] == code and p[2]["front"]), key=lambda p: p[0])
        dash = "" if code == "Revolve" else "5 3"
        for (xa, ya, _), (xb, yb, _) in itertools.pairwise(front):
            line(place(xa, ya), place(xb, ya), INK, 1.6, dash)
            line(place(xb, ya), place(xb, yb), INK, 1.6, dash)
    for x, y, entry in points:
        marker(*place(x, y), entry)
    u, v = WIDTH - RIGHT + 16, TOP + 8
    entries = []
    if "accuracy" not in scene:
        for kind in scene["hourglass"]:
            entries.append(
                (
                    {"code": "Revolve", "hourglass": kind, "increment": "1"},
                    kind.replace("-", " "),
                )
            )
        first = scene["hourglass"][0]
        for f in ("0.5", "0.25"):
            entries.append(({"code": "Revolve", "hourglass": first, "increment": f}, f"increment x {f}"))
    else:
        entries.append(({"code": "Revolve", "hourglass": "", "increment": "1"}, "facets, accuracy"))
    for kind in sorted({r["hourglass"] for r in rows if r["code"] == "CalculiX"}):
        entries.append(({"code": "CalculiX", "hourglass": kind}, f"CalculiX {kind}"))
    for entry, words in entries:
        marker(u, v, entry)
        text(u + 12, v + 4, words, size=12)
        v += 19
    for code in codes:
        line((u - 8, v), (u + 8, v), INK, 1.6, "" if code == "Revolve" else "5 3")
        text(u + 12, v + 4, f"Pareto front{'' if code == 'Revolve' else ', ' + code}", size=12)
        v += 19
    svg = (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" height="{HEIGHT}" '
        f'font-family="sans-serif" fill="none" role="img">\n<title>{xml.sax.saxutils.escape(scene["title"])}</title>\n'
        f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>\n' + "\n".join(parts) + "\n</svg>\n"
    )
    (HERE / f"work_precision_{name}.svg").write_text(svg, encoding="utf-8")


def seconds_text(seconds):
    """Returns a time in two digits."""
    rounded = float(f"{seconds:.1e}")
    return f"{1000 * rounded:g} ms" if rounded < 1 else f"{rounded:g} s"


def cost_table(rows):
    """Returns the least CPU time for errors of 1 %, 0.1 %, 0.01 % and 0.001 % as a Markdown table."""
    lines = ["| scene | code | 1 % | 0.1 % | 0.01 % | 0.001 % |", "|---|---|---|---|---|---|"]
    for name, code in itertools.product(SCENES, ("Revolve", "CalculiX")):
        part = [r for r in rows if r["scene"] == name and r["code"] == code]
        cells = []
        for limit in (1e-2, 1e-3, 1e-4, 1e-5):
            least = min((float(r["cpu_seconds"]) for r in part if visible_error(r) <= limit), default=None)
            cells.append("" if least is None else seconds_text(least))
        if part:
            lines.append(f"| {name} | {code} | {' | '.join(cells)} |")
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default=",".join(SCENES), help="names of scenes")
    parser.add_argument("--draw", action="store_true", help="draw from the table")
    options = parser.parse_args()
    head, rows = read_table() if (HERE / "work_precision.csv").exists() else ("", [])
    names = [] if options.draw else options.only.split(",")
    for name in names:
        if name not in SCENES:
            sys.exit(f"unknown scene {name}; scenes: {', '.join(SCENES)}")
        with tempfile.TemporaryDirectory(prefix="work-precision-") as temporary:
            folder = Path(temporary)
            for include in (HERE / "scenes").glob("*.inc"):
                shutil.copy(include, folder)
            found = measure_revolve(name, folder)
            if CCX and name in CALCULIX:
                found += measure_calculix(name, folder)
        rows = [r for r in rows if r["scene"] != name] + found
        rows.sort(key=lambda r: list(SCENES).index(r["scene"]))
        head = versions()
        write_table(head, rows)
    write_table(head, rows)
    for name in SCENES:
        part = [r for r in rows if r["scene"] == name]
        if part:
            draw(name, part)
    print(cost_table(rows))


if __name__ == "__main__":
    main()
