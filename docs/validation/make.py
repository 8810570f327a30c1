"""Computes every number of docs/validation.md: runs Revolve and compares with the data in input/reference.

make.py            writes the tables into docs/validation.md and as CSV into docs/validation
make.py --check    computes them again and compares with the page; exit status 1 if they differ
make.py --only NAME[,NAME]   only these families: apm2, rods, concrete, taylor, bars, outlines, plates,
                             gauge, flow, hugoniots, blast, materials
make.py --plot     also draws the pictures (requires matplotlib)

The environment variable REVOLVE names the program (default: target/release/revolve). Standard library only.
A number of the page may differ by 0.2 % and one unit of its last digit: runs are bit-identical on one machine, but
libraries of elementary functions differ between machines.
"""

import csv
import io
import itertools
import math
import os
import re
import statistics
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "validation.md"
MATERIALS_PAGE = ROOT / "docs" / "materials.md"
DECKS = ROOT / "input" / "validation"
DATA = ROOT / "input" / "reference"
REVOLVE = os.environ.get("REVOLVE", str(ROOT / "target" / "release" / "revolve"))
TEMPORARY = tempfile.TemporaryDirectory(prefix="validation-")
WORK = Path(TEMPORARY.name)
# Rounding that `--check` accepts: relative, and units of the last digit.
RELATIVE, LAST_DIGITS = 2e-3, 1.0


def revolve(*arguments):
    """Runs Revolve on one thread and returns its output."""
    command = [REVOLVE, *map(str, arguments)]
    if arguments[0] != "study":
        command += ["--threads", "1"]
    done = subprocess.run(command, check=False, capture_output=True, text=True, cwd=ROOT)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)}\n{done.stderr or done.stdout}")
    return done.stdout


def table(path):
    """Returns the rows of a CSV file without comments as dictionaries."""
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def settings(values):
    """Returns parameter values as `--set` options; text is quoted."""
    options = []
    for name, value in values.items():
        options += ["--set", f"{name}='{value}'" if isinstance(value, str) else f"{name}={value!r}"]
    return options


def run(deck, **values):
    """Runs a deck and returns its history: a list of rows as dictionaries of numbers."""
    out = WORK / "run"
    revolve("run", DECKS / f"{deck}.inp", *settings(values), "--out", out, "-q")
    return [{k: float(v) for k, v in row.items()} for row in table(out / f"{deck}_history.csv")]


def attempt(deck, **values):
    """Runs a deck in a folder of its own; returns its history, or the code of the error that stops it."""
    with tempfile.TemporaryDirectory(dir=WORK) as out:
        command = [REVOLVE, "run", str(DECKS / f"{deck}.inp"), *settings(values), "--out", out, "-q", "--threads", "1"]
        done = subprocess.run(command, check=False, capture_output=True, text=True, cwd=ROOT)
        if done.returncode == 0:
            return [{k: float(v) for k, v in row.items()} for row in table(Path(out) / f"{deck}_history.csv")]
    code = re.search(r"error\[(R\d+)\]", done.stderr)
    return code[1] if code else sys.exit(f"{' '.join(command)}\n{done.stderr or done.stdout}")


def two_at_a_time(function, items):
    with ThreadPoolExecutor(2) as pool:
        return list(pool.map(function, items))


def percent(computed, measured):
    return f"{100 * (computed - measured) / measured:+.1f}"


def root_sum_square(*parts):
    return math.sqrt(sum(p * p for p in parts))


def summary(quantity, errors, uncertainty):
    """Returns a row of the summary: errors and validation uncertainty in percent."""
    sizes = [abs(e) for e in errors]
    limit = "unknown" if uncertainty is None else f"{uncertainty:.1f}"
    return [quantity, f"{len(sizes)}", f"{statistics.median(sizes):.1f}", f"{max(sizes):.1f}", limit]


def observed_uncertainty(deck, refine, quantity, **values):
    """Returns the relative uncertainty that `revolve study` estimates for the finest level."""
    text = revolve(
        "study",
        DECKS / f"{deck}.inp",
        "--refine",
        refine,
        "--quantity",
        quantity,
        "--repeat",
        1,
        *settings(values),
        "--out",
        WORK / "study",
    )
    found = re.search(r"uncertainty \S+ \((\S+) %\)", text)
    return float(found[1]) / 100 if found else float("nan")


# AA6082-T651 plates


def limits(**values):
    """Returns the ballistic limit at each obliquity."""
    over = values.pop("over", "0,15,30,45")
    revolve(
        "limit",
        DECKS / "apm2_6082.inp",
        "--velocity",
        "V",
        "--between",
        "400,850",
        "--tolerance",
        1,
        "--shots",
        1,
        "--over",
        f"obliquity={over}",
        *settings(values),
        "--out",
        WORK / "limit",
        "-q",
    )
    rows = [r for r in table(WORK / "limit" / "apm2_6082_limit.csv") if r["outcome"] == "limit velocity"]
    return [(float(r["from"]) + float(r["to"])) / 2 for r in rows]


def apm2():
    """Compares cores and complete bullets with the same limits: a jacket that is stripped has no effect."""
    tests = table(DATA / "apm2_6082_t651.csv")
    angles = [0, 15, 30, 45]
    models = [
        ("cylindrical", "CYLINDRICAL", "OFF"),
        ("spherical", "SPHERICAL", "OFF"),
        ("spherical, free surfaces", "SPHERICAL", "ON"),
    ]
    found = {
        (name, f): limits(cavity=cavity, surface=surface, friction=f)
        for name, cavity, surface in models
        for f in (0.0, 0.02)
    }

    def error(limit, test):
        return 100 * (limit[angles.index(int(test["obliquity_deg"]))] / float(test["V50_mps"]) - 1)

    head = ["projectile", "obliquity, degrees", "measured, m/s"] + [f"{n}, friction {f:g}" for n, f in found]
    rows = []
    for test in tests:
        cells = [f"{x[angles.index(int(test['obliquity_deg']))]:.0f} ({error(x, test):+.1f} %)" for x in found.values()]
        rows.append([test["projectile"], test["obliquity_deg"], f"{float(test['V50_mps']):.0f}", *cells])
    worst = [f"{max(abs(error(x, test)) for test in tests):.1f} %" for x in found.values()]
    rows.append(["largest error", "", "", *worst])
    base = {"cavity": "SPHERICAL", "surface": "ON", "over": "0"}
    v = limits(**base)[0]

    def change(**values):
        return 100 * (limits(**base, **values)[0] / v - 1)

    inputs = [
        ("numerical: facets 12 to 24, bracket 0.5 m/s", root_sum_square(change(n=24, m=12), 100 * 0.5 / v)),
        ("Y, 5 % (assumed)", change(Y=265e6 * 1.05)),
        ("power n, 0.01 (assumed)", change(power=0.07)),
        ("friction, 0 to 0.02, divided by √3", change(friction=0.02) / math.sqrt(3)),
        ("diameter, 6.17 mm for 6.248 mm, divided by √3", change(d=6.17e-3) / math.sqrt(3)),
        ("fit of the law, up to 250 m/s for 300 m/s", change(top_velocity=250.0)),
    ]
    total = root_sum_square(*(x for _, x in inputs))
    budget = [[name, f"{x:+.1f}"] for name, x in inputs] + [["root of the sum of squares", f"{total:.1f}"]]
    short = [
        summary(f"limit of {p}s, {n}, friction 0", [error(x, t) for t in tests if t["projectile"] == p], total)
        for (n, f), x in found.items()
        for p in ("APM2 core", "APM2 bullet")
        if f == 0
    ]
    return {
        "summary": short,
        "apm2": (head, rows),
        "apm2-uncertainty": (["contribution", "change of the limit at 0 degrees, %"], budget),
    }


# Rods in 6061-T6511


def rods():
    shots = table(DATA / "shots_6061.csv")
    values = {
        "two terms": {},
        "three terms": {"B": 0.983, "C": 0.9402},
        "three terms, friction 0.02": {"B": 0.983, "C": 0.9402, "friction": 0.02},
    }
    found = {}
    for name, constants in values.items():
        revolve(
            "sweep",
            ROOT / "input" / "ogive.inp",
            "--set",
            "V=" + ",".join(s["V"] for s in shots),
            *settings(constants),
            "--quantity",
            "-1000*final(U2@REF)",
            "--out",
            WORK / "sweep",
            "-q",
        )
        rows = table(WORK / "sweep" / "ogive_sweep.csv")
        found[name] = [float(r["-1000*final(U2@REF)"]) for r in rows]
    head = ["velocity, m/s", "measured, mm", *found]
    body = [
        [s["V"], s["depth"]] + [f"{x[i]:.1f} ({percent(x[i], float(s['depth']))} %)" for x in found.values()]
        for i, s in enumerate(shots)
    ]
    # Two shots at 569 and 570 m/s differ by 3 mm of 56.5 mm.
    scatter = 100 * 3 / 56.5 / math.sqrt(2)
    short = [
        summary(
            f"depth of rods in 6061-T6511, {name}",
            [100 * (c / float(s["depth"]) - 1) for c, s in zip(x, shots)],
            scatter,
        )
        for name, x in found.items()
    ]
    return {"summary": short, "rods": (head, body)}


# Concrete


def nose_and_shank(d, length, crh):
    """Returns the volume of an ogive-nosed rod and the height of its nose."""
    a = d / 2
    r = 2 * crh * a
    c = a - r
    h = math.sqrt(r * r - c * c)
    nose = math.pi * (c * c * h + c * (r * r * math.asin(h / r) - h * c) + r * r * h - h**3 / 3)
    return nose + math.pi * a * a * (length - h), h


def closed_form(s):
    """Returns the depth in m of Forrestal and others 1994; in the crater, the same linear force."""
    a, n = s["d"] / 2, (8 * s["CRH"] - 1) / (24 * s["CRH"] ** 2)
    strength = 82.6 * (s["fc"] / 1e6) ** -0.544 * s["fc"]
    square = (s["m"] * s["V"] ** 2 - 4 * math.pi * a**3 * strength) / (s["m"] + 4 * math.pi * a**3 * n * s["rho"])
    if square <= 0:
        return s["V"] * math.sqrt(4 * s["m"] / (math.pi * a * strength))
    ratio = n * s["rho"] * square / strength
    return s["m"] / (2 * math.pi * a * a * s["rho"] * n) * math.log(1 + ratio) + 4 * a


def read_shot(row):
    """Returns a shot in SI units; the depth in mm."""
    number = {k: float(row[k]) for k in ("m_kg", "d_mm", "L_mm", "CRH", "rho_kgm3", "fc_MPa", "V_mps", "P_mm")}
    return {
        "V": number["V_mps"],
        "m": number["m_kg"],
        "d": number["d_mm"] / 1e3,
        "CRH": number["CRH"],
        "fc": number["fc_MPa"] * 1e6,
        "rho": number["rho_kgm3"],
        "L": number["L_mm"] / 1e3,
        "depth": number["P_mm"],
        "number": row["number"],
        "citation": row["citation"],
    }


def plausible_shots(rows, low=0.4, high=1.2):
    """Returns the shots that pass all rules, and the row numbers left out by rule. Depths of models play no part."""
    kept, left_out, seen = [], {}, set()

    def leave_out(rule, number):
        left_out.setdefault(rule, []).append(number)

    for row in rows:
        try:
            s = read_shot(row)
        except ValueError:
            leave_out("a quantity is missing or not a number", row["number"])
            continue
        if s["CRH"] < 0.5:
            leave_out("no ogive: calibre-radius-head below 0.5", s["number"])
            continue
        volume, nose = nose_and_shank(s["d"], s["L"], s["CRH"])
        share = s["m"] / (float(row["projectile_rho_kgm3"]) * volume)
        key = tuple(s[k] for k in ("m", "d", "CRH", "fc", "V", "depth"))
        if s["L"] < nose or not low <= share <= high:
            leave_out(f"mass outside {low:g} to {high:g} times that of a solid rod of this size", s["number"])
        elif row["thickness_m"] and s["depth"] >= 1e3 * float(row["thickness_m"]):
            leave_out("depth not below the thickness of the target", s["number"])
        elif key in seen:
            leave_out("repeats another row", s["number"])
        else:
            seen.add(key)
            kept.append(s)
    return kept, left_out


def depths(shots, **values):
    """Returns the depths in mm that Revolve computes for the shots, by `revolve sweep --samples`."""
    names = ["V", "m", "d", "CRH", "fc", "rho", "depth"]
    samples = WORK / "shots.csv"
    with open(samples, "w") as file:
        print(",".join(names), file=file)
        for s in shots:
            print(",".join(repr(s[n]) for n in names), file=file)
    revolve(
        "sweep",
        DECKS / "concrete_ogive.inp",
        "--samples",
        samples,
        "--compare-column",
        "depth",
        *settings(values),
        "--quantity",
        "-1000*final(U2@REF)",
        "--out",
        WORK / "sweep",
        "-q",
    )
    return [float(r["-1000*final(U2@REF)"]) for r in table(WORK / "sweep" / "concrete_ogive_sweep.csv")]


def concrete():
    sandia = [read_shot(r) for r in table(DATA / "concrete_sandia.csv")]
    plausible, left_out = plausible_shots(table(DATA / "concrete_shots.csv"))
    sets = {
        "1994, 17 shots into grout and concrete": [s for s in sandia if " 1994," in s["citation"]],
        "1996, 41 shots into grout": [s for s in sandia if " 1996," in s["citation"]],
        "compilation, all plausible rows": plausible,
    }
    head = [
        "rows",
        "model",
        "number",
        "median of absolute error, %",
        "median error, %",
        "standard deviation, %",
        "within 10 %",
        "within 20 %",
    ]
    rows, points, errors = [], {}, {}

    def add(name, shots, computed):
        for model, x in (("Revolve", computed), ("closed form", [1e3 * closed_form(s) for s in shots])):
            e = [100 * (c / s["depth"] - 1) for c, s in zip(x, shots)]
            errors[name, model] = e
            rows.append(
                [
                    name,
                    model,
                    f"{len(e)}",
                    f"{statistics.median(map(abs, e)):.1f}",
                    f"{statistics.median(e):+.1f}",
                    f"{statistics.stdev(e):.1f}",
                    f"{sum(abs(y) <= 10 for y in e)}",
                    f"{sum(abs(y) <= 20 for y in e)}",
                ]
            )

    for name, shots in sets.items():
        computed = depths(shots)
        points[name] = [(s["depth"], c) for s, c in zip(shots, computed)]
        add(name, shots, computed)
    computed = [c for _, c in points["compilation, all plausible rows"]]
    for name, rule in (
        ("compilation, deeper than the crater", lambda s: s["depth"] > 2e3 * s["d"]),
        ("compilation, within the crater", lambda s: s["depth"] <= 2e3 * s["d"]),
        ("compilation, above 110 MPa", lambda s: s["fc"] > 110e6),
        ("compilation, above 1000 m/s", lambda s: s["V"] > 1000),
    ):
        pairs = [(s, c) for s, c in zip(plausible, computed) if rule(s)]
        add(name, [s for s, _ in pairs], [c for _, c in pairs])
    limits = []
    for low, high in ((0.5, 1.15), (0.4, 1.2), (0.3, 1.3), (0.0, math.inf)):
        shots, _ = plausible_shots(table(DATA / "concrete_shots.csv"), low, high)
        medians = (
            statistics.median(abs(100 * (c / s["depth"] - 1)) for s, c in zip(shots, x))
            for x in (depths(shots), [1e3 * closed_form(s) for s in shots])
        )
        name = f"{low:g} to {high:g}" if high < math.inf else "no limits"
        limits.append([name, f"{len(shots)}", *(f"{m:.1f}" for m in medians)])
    first = sets["1994, 17 shots into grout and concrete"]
    base = depths(first)
    single = [
        [
            f"{s['V']:.0f}",
            f"{s['fc'] / 1e6:.1f}",
            f"{s['depth']:.0f}",
            f"{c:.0f}",
            percent(c, s["depth"]),
            f"{1e3 * closed_form(s):.0f}",
            percent(1e3 * closed_form(s), s["depth"]),
        ]
        for s, c in zip(first, base)
    ]

    def change(**values):
        return statistics.median(100 * (x / b - 1) for x, b in zip(depths(first, **values), base))

    numerical = 100 * observed_uncertainty("concrete_ogive", "n=10,20", "-1000*final(U2@REF)")
    parts = [
        ("numerical, 20 facets", numerical),
        ("S, 10 % (assumed)", change(scale=1.1)),
        ("friction, 0 to 0.02, divided by √3", change(friction=0.02) / math.sqrt(3)),
    ]
    budget = [[n, f"{x:+.2f}"] for n, x in parts] + [
        ["root of the sum of squares", f"{root_sum_square(*(x for _, x in parts)):.2f}"]
    ]
    out = [[rule, f"{len(n)}", " ".join(n)] for rule, n in left_out.items()]
    plot_points(points)
    total = root_sum_square(*(x for _, x in parts))
    short = [summary(f"depth in concrete, {name}", errors[name, "Revolve"], total) for name in sets]
    return {
        "summary": short,
        "concrete": (head, rows),
        "concrete-1994": (
            [
                "velocity, m/s",
                "strength, MPa",
                "measured, mm",
                "Revolve, mm",
                "error, %",
                "closed form, mm",
                "error, %",
            ],
            single,
        ),
        "concrete-uncertainty": (["contribution", "median change of the depth, 1994 shots, %"], budget),
        "concrete-limits": (["mass over that of a solid rod", "rows", "Revolve", "closed form"], limits),
        "concrete-left-out": (["rule", "rows", "numbers"], out),
    }


# Taylor bars of copper

FRACTIONS = (0.2, 0.25, 0.333, 0.5, 0.667)


def outline(history):
    """Returns the final length, the radius of the foot and the points of the side in mm."""
    last = history[-1]
    side = sorted((int(k.split("@")[1]), k.split("@")[1]) for k in last if re.fullmatch(r"COOR1@\d+", k))
    points = [(1e3 * last[f"COOR2@{n}"], 1e3 * last[f"COOR1@{n}"]) for _, n in side]
    return 1e3 * last["COOR2@TIP"] if "COOR2@TIP" in last else points[-1][0], points[0][1], points


def radius_at(points, z):
    for (z0, r0), (z1, r1) in itertools.pairwise(points):
        if z0 <= z <= z1:
            return r0 + (r1 - r0) * (z - z0) / (z1 - z0)
    return points[-1][1]


def taylor():
    tests = table(DATA / "taylor_copper.csv")
    head = [
        "test",
        "material",
        "velocity, m/s",
        "initial temperature, K",
        "constants",
        "length, measured",
        "computed",
        "error, %",
        "foot radius, measured",
        "computed",
        "error, %",
        "outline, rms difference",
    ]
    rows, curves = [], []
    for t in tests:
        shape = {
            "V": float(t["v0_mps"]),
            "length": float(t["L0_mm"]) / 1e3,
            "d": float(t["D0_mm"]) / 1e3,
            "T0": float(t["T0_K"]),
        }
        for label, material in (("Johnson-Cook 1983", "COPPER_OFHC"), ("Steinberg 1996", "COPPER_STEINBERG")):
            length, foot, points = outline(run("taylor_bar", material=material, **shape))
            lf, rf = float(t["Lf_mm"]), float(t["Rf_mm"])
            widths = [(f, float(t[f"W{f}_mm"])) for f in FRACTIONS]
            rms = math.sqrt(statistics.mean((radius_at(points, f * length) - w) ** 2 for f, w in widths))
            curves.append((t, label, points, widths, lf, rf))
            rows.append(
                [
                    t["test"],
                    t["material"],
                    t["v0_mps"],
                    t["T0_K"],
                    label,
                    f"{lf:.2f}",
                    f"{length:.2f}",
                    percent(length, lf),
                    f"{rf:.2f}",
                    f"{foot:.2f}",
                    percent(foot, rf),
                    f"{rms:.2f}",
                ]
            )
    base, foot, _ = outline(run("taylor_bar"))

    def change(**values):
        length, radius, _ = outline(run("taylor_bar", **values))
        return 100 * (length / base - 1), 100 * (radius / foot - 1)

    fine = [
        100 * observed_uncertainty("taylor_bar", "nr=6,12,24", q)
        for q in ("1000*final(COOR2@TIP)", "1000*final(COOR1@CORNER)")
    ]
    parts = [
        ("numerical, 6, 12 and 24 elements over the radius", *fine),
        ("A, 10 % (assumed)", *change(Cu_A=99e6)),
        ("B, 10 % (assumed)", *change(Cu_B=321.2e6)),
        ("velocity, 1 % (assumed)", *change(V=212.1)),
    ]
    budget = [[n, f"{x:+.2f}", f"{y:+.2f}"] for n, x, y in parts]
    budget.append(["root of the sum of squares"] + [f"{root_sum_square(*(p[i] for p in parts)):.2f}" for i in (1, 2)])
    plot_bars(curves)
    total = [root_sum_square(*(p[i] for p in parts)) for i in (1, 2)]
    short = []
    for label in ("Johnson-Cook 1983", "Steinberg 1996"):
        for i, what in ((0, "length"), (1, "foot radius")):
            errors = [float(r[(7, 10)[i]]) for r in rows if r[4] == label]
            short.append(summary(f"Taylor bars of copper, {what}, {label}", errors, total[i]))
    return {
        "summary": short,
        "taylor": (head, rows),
        "taylor-identify": identified_bars(tests),
        "taylor-uncertainty": (["contribution", "length, %", "foot radius, %"], budget),
    }


def identified_bars(tests):
    """Identifies A and B from the lengths and feet of three bars and predicts the bar that was left out."""
    shots = WORK / "bars.csv"
    quantities = ("1000*final(COOR2@TIP)", "1000*final(COOR1@CORNER)")
    rows = []
    for left_out in tests:
        lines = ["V,length,d,T0,Lf,Rf"]
        for t in tests:
            if t is not left_out:
                sizes = (float(t["L0_mm"]) / 1e3, float(t["D0_mm"]) / 1e3)
                lines.append(",".join(map(str, (t["v0_mps"], *sizes, t["T0_K"], t["Lf_mm"], t["Rf_mm"]))))
        shots.write_text("\n".join(lines) + "\n", encoding="utf-8")
        options = []
        for column, quantity in zip(("Lf", "Rf"), quantities):
            options += ["--measured", column, "--quantity", quantity, "--deviation", 0.3]
        options += ["--unknown", "Cu_A=20e6..300e6,Cu_B=100e6..600e6", "--set", "nr=6", "--out", WORK / "identify"]
        revolve("identify", DECKS / "taylor_bar.inp", "--shots", shots, *options, "-q")
        found = table(WORK / "identify" / "taylor_bar_identify.csv")
        a, b = (float(row["value"]) for row in found[:2])
        shape = {
            "V": float(left_out["v0_mps"]),
            "length": float(left_out["L0_mm"]) / 1e3,
            "d": float(left_out["D0_mm"]) / 1e3,
            "T0": float(left_out["T0_K"]),
        }
        length, foot, _ = outline(run("taylor_bar", Cu_A=a, Cu_B=b, nr=6, **shape))
        errors = (percent(length, float(left_out["Lf_mm"])), percent(foot, float(left_out["Rf_mm"])))
        rows.append([left_out["test"], f"{a / 1e6:.0f}", f"{b / 1e6:.0f}", *errors])
    return ["bar left out", "A, MPa", "B, MPa", "error of its length, %", "error of its foot radius, %"], rows


# Taylor bars of the collection

BAR_MATERIALS = {
    "OFHC copper": ("copper_ofhc.inp", "COPPER_OFHC", "Cu_A", 90e6),
    "ETP copper": ("copper_ofhc.inp", "COPPER_OFHC", "Cu_A", 90e6),
    "6061-T6 aluminium": ("aluminium_6061_t6.inp", "AL6061_T6", "Al_A", 324e6),
    "4340 steel": ("steel_4340.inp", "STEEL_4340", "St_A", 792e6),
}
TITANIUM = (
    ("Lesuer 2000", "titanium_6al4v.inp", "TI6AL4V"),
    ("Johnson 1985", "titanium_6al4v_1985.inp", "TI6AL4V_1985"),
)
RANGES = (("294 to 295 K", 0, 400), ("635 to 765 K", 400, 1000), ("1230 to 1285 K", 1000, 2000))


def bar_outline(test, file, material, faster=1.0, **values):
    """Returns the length, the radius of the foot and the points of the side in mm, or the code of a stop."""
    shape = {
        "V": float(test["v0_mps"]) * faster,
        "length": float(test["L0_mm"]) / 1e3,
        "d": float(test["D0_mm"]) / 1e3,
        "T0": float(test["T0_K"]),
    }
    rows = attempt("taylor_bars", **shape, file=file, material=material, **values)
    if isinstance(rows, str):
        return rows
    # The bar vibrates: its length is the mean over the last fifth of the time.
    return 1e3 * statistics.mean(r["COOR2@TIP"] for r in rows[-10:]), *outline(rows)[1:]


def bar(test, stronger=None, **values):
    """Returns length, foot diameter and the diameter at 0.2 of the initial length in mm, or the code of a stop."""
    file, material, name, strength = BAR_MATERIALS[test["material"]]
    if stronger:
        values[name] = stronger * strength
    found = bar_outline(test, file, material, **values)
    if isinstance(found, str):
        return found
    length, foot, points = found
    return length, 2 * foot, 2 * radius_at(points, 0.2 * float(test["L0_mm"]))


def bars():
    tests = table(DATA / "taylor_bars.csv")
    measures = (("length", "Lf_mm"), ("foot", "Df_mm"), ("diameter at 0.2 L", "W_mm"))
    base = two_at_a_time(bar, tests)
    errors = []
    for test, found in zip(tests, base):
        e = {}
        if not isinstance(found, str):
            e = {n: 100 * (x / float(test[c]) - 1) for (n, c), x in zip(measures, found) if test[c]}
            initial, final = float(test["L0_mm"]), float(test["Lf_mm"])
            e["shortening"] = 100 * ((initial - found[0]) / (initial - final) - 1)
        errors.append(e)
    names = ("length", "shortening", "foot", "diameter at 0.2 L")
    rows, short = [], []
    for material in BAR_MATERIALS:
        for label, low, high in RANGES:
            chosen = [i for i, t in enumerate(tests) if t["material"] == material and low < float(t["T0_K"]) < high]
            if not chosen:
                continue
            cells = []
            for n in names:
                e = [errors[i][n] for i in chosen if n in errors[i]]
                size = f"{statistics.median(map(abs, e)):.1f} / {max(map(abs, e)):.1f}" if e else ""
                cells += [size, f"{statistics.median(e):+.1f}"] if n == "length" else [size]
            cells[3] += f" ({sum('foot' in errors[i] for i in chosen)})" if cells[3] else ""
            stops = sum(isinstance(base[i], str) for i in chosen)
            rows.append([material, label, f"{len(chosen)}", f"{stops}", *cells])
    finished = [i for i, e in enumerate(errors) if e]

    def change(**values):
        """Returns the median absolute changes of length and foot in percent, of each third bar."""
        chosen = finished[::3]
        found = two_at_a_time(lambda i: bar(tests[i], **values), chosen)
        pairs = [(a, base[i]) for i, a in zip(chosen, found) if not isinstance(a, str)]
        return [statistics.median(abs(100 * (a[k] / b[k] - 1)) for a, b in pairs) for k in (0, 1)]

    parts = [
        ("numerical, 6 to 12 elements over the radius", *change(nr=12)),
        ("A, 10 % (assumed)", *change(stronger=1.1)),
        ("velocity, 1 % (assumed)", *change(faster=1.01)),
    ]
    budget = [[n, f"{x:.2f}", f"{y:.2f}"] for n, x, y in parts]
    total = [root_sum_square(*(p[k] for p in parts)) for k in (1, 2)]
    budget.append(["root of the sum of squares", *(f"{x:.2f}" for x in total)])
    in_range = [i for i in finished if float(tests[i]["T0_K"]) < 1000]
    for material in BAR_MATERIALS:
        for n, what, u in (("length", "length", total[0]), ("foot", "foot diameter", total[1])):
            e = [errors[i][n] for i in in_range if tests[i]["material"] == material and n in errors[i]]
            short.append(summary(f"90 Taylor bars: {material}, below 1000 K, {what}", e, u))
    hot = [errors[i]["length"] for i in finished if i not in in_range]
    short.append(summary("90 Taylor bars: above 1200 K, outside the range of the constants, length", hot, total[0]))

    def row(i):
        t, found = tests[i], base[i]
        stop = isinstance(found, str)
        cells = [t["number"], t["material"], t["T0_K"], t["v0_mps"], t["L0_mm"]]
        for k, (n, c) in enumerate(measures):
            value = "" if stop else f"{found[k]:.2f}"
            cells += [t[c], value, f"{errors[i][n]:+.1f}" if n in errors[i] else ""]
        return [*cells, found if stop else ""]

    head = ["number", "material", "initial temperature, K", "velocity, m/s", "initial length, mm"]
    for n, _ in measures:
        head += [f"{n}, measured, mm", "computed", "error, %"]
    head.append("stop")
    all_rows = [row(i) for i in range(len(tests))]
    worst = sorted(in_range, key=lambda i: -abs(errors[i]["length"]))[:6]
    plot_bar_scatter(tests, base)
    return {
        "summary": short,
        "bars": (
            [
                "material",
                "temperature",
                "bars",
                "stops",
                "length, absolute error, median / largest, %",
                "length, median error, %",
                "shortening, %",
                "foot, % (bars)",
                "diameter at 0.2 L, %",
            ],
            rows,
        ),
        "bars-worst": (head[:8], [all_rows[i][:8] for i in worst]),
        "bars-uncertainty": (["contribution, median absolute change", "length, %", "foot diameter, %"], budget),
        "files": {"bars-all": (head, all_rows)},
    }


def outlines():
    """Compares digitised outlines; plastic flow keeps the volume, so that the volume of an outline shows its quality."""
    tests = {}
    for r in table(DATA / "taylor_outlines.csv"):
        tests.setdefault(r["outline"], (r, []))[1].append((max(0.0, float(r["z_mm"])), float(r["r_mm"])))
    cases = []
    for t, points in tests.values():
        if t["material"] == "Ti-6Al-4V":
            cases += [(t, points, *x) for x in TITANIUM]
        else:
            cases.append((t, points, "", *BAR_MATERIALS[t["material"]][:2]))
    found = two_at_a_time(lambda c: bar_outline(c[0], *c[3:]), cases)
    rows, errors = [], []
    for (t, points, label, *_), (length, _, side) in zip(cases, found):
        points.sort()
        volume = sum(math.pi * (b - a) * (r * r + r * s + s * s) / 3 for (a, r), (b, s) in itertools.pairwise(points))
        volume /= math.pi / 4 * float(t["D0_mm"]) ** 2 * float(t["L0_mm"])
        shared = [(z, r) for z, r in points if z <= length]
        rms = math.sqrt(statistics.mean((radius_at(side, z) - r) ** 2 for z, r in shared))
        measured, (lowest, measured_foot) = points[-1][0], points[0]
        foot = radius_at(side, lowest)
        errors.append([100 * (length / measured - 1), 100 * (foot / measured_foot - 1)])
        cells = [f"{measured:.2f}", f"{length:.2f}", percent(length, measured)]
        cells += [f"{measured_foot:.2f}", f"{foot:.2f}", percent(foot, measured_foot), f"{rms:.2f}"]
        name = f"{t['outline']}, {label}" if label else t["outline"]
        rows.append([name, t["material"], t["v0_mps"], t["T0_K"], f"{100 * (volume - 1):+.1f}", *cells])
    head = ["outline", "material", "velocity, m/s", "initial temperature, K", "volume of the outline, %"]
    head += ["length, measured, mm", "computed", "error, %", "radius at the lowest point, mm", "computed", "error, %"]

    def change(k, **values):
        """Returns the median absolute change of length (0) or foot (1) in percent."""
        changed = two_at_a_time(lambda c: bar_outline(c[0], *c[3:], **values), cases)
        return statistics.median(abs(100 * (a[k] / b[k] - 1)) for a, b in zip(changed, found))

    short = [
        summary(
            f"outlines of Taylor bars, {what}",
            [e[k] for e in errors],
            root_sum_square(change(k, nr=12), change(k, faster=1.01)),
        )
        for k, what in ((0, "length"), (1, "radius at the lowest point"))
    ]
    return {"summary": short, "outlines": ([*head, "outline, rms difference, mm"], rows)}


# Plate impacts


def curve(history, column, scale=1.0):
    return [(1e6 * r["time"], scale * r[column]) for r in history]


def record(name):
    rows = table(DATA / f"{name}.csv")
    value = next(k for k in rows[0] if k not in ("time_us", "citation"))
    return [(float(r["time_us"]), float(r[value])) for r in rows]


def crossing(points, level):
    """Returns the first time at which a curve rises through a level."""
    for (t0, v0), (t1, v1) in itertools.pairwise(points):
        if v0 < level <= v1:
            return t0 + (t1 - t0) * (level - v0) / (v1 - v0)
    return float("nan")


def mean(points, start, end):
    """Returns the mean of a piecewise linear curve over an interval."""
    inside = [start] + [t for t, _ in points if start < t < end] + [end]
    values = [value(points, t) for t in inside]
    area = sum((t1 - t0) * (v0 + v1) / 2 for t0, t1, v0, v1 in zip(inside, inside[1:], values, values[1:]))
    return area / (end - start)


def value(points, time):
    for (t0, v0), (t1, v1) in itertools.pairwise(points):
        if t0 <= time <= t1:
            return v0 if t1 == t0 else v0 + (v1 - v0) * (time - t0) / (t1 - t0)
    return points[-1][1]


def measures_copper(points):
    return [
        ("precursor arrives (5 m/s), µs", crossing(points, 5), 4),
        ("main wave arrives (150 m/s), µs", crossing(points, 150), 4),
        ("velocity in the precursor at 0.90 µs, m/s", value(points, 0.90), 1),
        ("plateau, 1.05 to 1.45 µs, m/s", mean(points, 1.05, 1.45), 1),
    ]


def measures_titanium(points):
    start, main = crossing(points, 80), crossing(points, 280)
    return [
        ("main wave (280 m/s) after the precursor (80 m/s), µs", main - start, 4, start),
        ("velocity after the precursor, 0.02 to 0.04 µs after it, m/s", mean(points, start + 0.02, start + 0.04), 1),
        ("plateau, 0.20 to 0.45 µs after the main wave, m/s", mean(points, main + 0.20, main + 0.45), 1),
    ]


def measures_pmma(points, half):
    start, main = crossing(points, 0.3), crossing(points, half)
    return [
        (f"main wave ({half:g} GPa) after the precursor (0.3 GPa), µs", main - start, 4, start),
        ("plateau, 0.15 to 0.50 µs after the main wave, GPa", mean(points, main + 0.15, main + 0.50), 3),
    ]


def plates():
    rows, pictures = [], []

    def add(test, reference, measured, computed, coarse):
        name, interval, *_ = measured[0]
        if "after" in name:
            # The record has no time of impact: it is aligned at the computed precursor.
            start = computed[0][3]
            aligned = "main wave since impact, record aligned at the precursor, µs"
            measured = [(aligned, start + interval, 4, 0), *measured]
            computed, coarse = ([(aligned, x[0][3] + x[0][1], 4, 0), *x] for x in (computed, coarse))
        for (name, e, digits, *_), (_, s, *_), (_, c, *_) in zip(measured, computed, coarse):
            rows.append(
                [
                    test,
                    reference,
                    name,
                    f"{e:.{digits}f}",
                    f"{s:.{digits}f}",
                    percent(s, e),
                    f"{100 * abs(s - c) / abs(s):.2f}",
                ]
            )

    velocity, metal = "V2@FREE", [("Lesuer 2000", "TI6AL4V"), ("Johnson 1985", "TI6AL4V_1985")]
    copper = record("flyer_cu_308")
    for label, material in (("Johnson-Cook 1983", "COPPER_OFHC"), ("Steinberg 1996", "COPPER_STEINBERG")):
        fine, coarse = (curve(run("plate_copper", material=material, size=s), velocity) for s in (10e-6, 20e-6))
        pictures.append(("copper, 308 m/s", label, copper, fine, 0.0))
        add("copper, 308 m/s", label, *map(measures_copper, (copper, fine, coarse)))
    titanium = record("flyer_ti64_398")
    for label, material in metal:
        fine, coarse = (curve(run("plate_titanium", material=material, size=s), velocity) for s in (10e-6, 20e-6))
        pictures.append(("Ti-6Al-4V, 398 m/s", label, titanium, fine, crossing(titanium, 80) - crossing(fine, 80)))
        add("Ti-6Al-4V, 398 m/s", label, *map(measures_titanium, (titanium, fine, coarse)))
    for speed, flyer, target, half in ((591.0, 6e-3, 12e-3, 1.3), (765.0, 3e-3, 6e-3, 1.5)):
        stress = record(f"flyer_ti64_{speed:.0f}")
        for label, material in metal:
            shape = {
                "V": speed,
                "flyer": flyer,
                "target": target,
                "time": 4e-6 if flyer > 4e-3 else 3e-6,
                "material": material,
            }
            fine, coarse = (
                curve(run("plate_titanium_pmma", size=s, **shape), "S22@GAUGE", -1e-9) for s in (10e-6, 20e-6)
            )
            pictures.append(
                (
                    f"Ti-6Al-4V and PMMA, {speed:.0f} m/s",
                    label,
                    stress,
                    fine,
                    crossing(stress, 0.3) - crossing(fine, 0.3),
                )
            )
            add(
                f"Ti-6Al-4V and PMMA, {speed:.0f} m/s", label, *(measures_pmma(x, half) for x in (stress, fine, coarse))
            )
    budget = []
    for deck, measures, names in (
        ("plate_copper", measures_copper, ("Cu_A", 90e6, "Cu_c0", 3940.0)),
        ("plate_titanium", measures_titanium, ("Ti_A", 1098e6, "Ti_c0", 5130.0)),
    ):
        base = measures(curve(run(deck), velocity))
        strength = measures(curve(run(deck, **{names[0]: 1.1 * names[1]}), velocity))
        sound = measures(curve(run(deck, **{names[2]: 1.01 * names[3]}), velocity))
        if len(base[0]) == 4:
            base, strength, sound = (
                [("main wave since impact, µs", x[0][3] + x[0][1]), *x] for x in (base, strength, sound)
            )
        for (name, b, *_), (_, s, *_), (_, c, *_) in zip(base, strength, sound):
            x, y = 100 * (s / b - 1), 100 * (c / b - 1)
            budget.append([deck.split("_")[1] + ": " + name, f"{x:+.2f}", f"{y:+.2f}", f"{root_sum_square(x, y):.2f}"])
    plot_plates(pictures)
    spread = {b[0].partition(": ")[2]: float(b[3]) for b in budget}

    def short(title, test, quantity, uncertainty):
        chosen = [float(r[5]) for r in rows if r[0].startswith(test) and r[2].startswith(quantity)]
        return summary(title, chosen, uncertainty)

    level = spread[next(k for k in spread if k.startswith("plateau, 0.20"))]
    shorts = [
        short(
            "copper plates, arrival of precursor and main wave",
            "copper",
            ("precursor", "main"),
            spread["main wave arrives (150 m/s), µs"],
        ),
        short("copper plates, plateau", "copper", "plateau", spread["plateau, 1.05 to 1.45 µs, m/s"]),
        short(
            "titanium plates, arrival of the main wave", "Ti", "main wave since", spread["main wave since impact, µs"]
        ),
        short(
            "titanium plates, level of the precursor",
            "Ti-6Al-4V, 398",
            "velocity after",
            spread[next(k for k in spread if k.startswith("velocity after"))],
        ),
        short("titanium plates, plateau", "Ti", "plateau", level),
    ]
    return {
        "summary": shorts,
        "plates": (
            ["test", "constants", "quantity", "measured", "computed", "error, %", "change from 20 to 10 µm, %"],
            rows,
        ),
        "plates-uncertainty": (["quantity", "A + 10 %", "$c_0$ + 1 %", "root of the sum of squares"], budget),
    }


# Stress at a face of copper and titanium


def measures_gauge(points):
    """The zero of time of the record is not the impact: times count from the arrival of the main wave."""
    main = crossing(points, 3.4)
    falling = next(
        t0 + (t1 - t0) * (v0 - 6.0) / (v0 - v1)
        for (t0, v0), (t1, v1) in itertools.pairwise(points)
        if t0 > main + 1 and v0 >= 6.0 > v1
    )
    return [
        ("plateau, 0.60 to 1.50 µs after the main wave (3.4 GPa), GPa", mean(points, main + 0.6, main + 1.5), 3),
        ("release (6 GPa) after the main wave, µs", falling - main, 3),
    ]


def gauge():
    points = record("gauge_ti64_454")
    measured = measures_gauge(points)

    def computed(**values):
        return measures_gauge(curve(run("plate_gauge", **values), "S22@GAUGE", -1e-9))

    rows, errors = [], {}
    for label, _, material in TITANIUM:
        fine, coarse = computed(material=material), computed(material=material, size=20e-6)
        for (name, e, digits), (_, s, _), (_, c, _) in zip(measured, fine, coarse):
            rows.append(
                [label, name, f"{e:.{digits}f}", f"{s:.{digits}f}", percent(s, e), f"{100 * abs(s - c) / s:.2f}"]
            )
            errors.setdefault(name, []).append((100 * (s / e - 1), 100 * (c / s - 1)))
    base = computed()
    changed = [computed(Cu_c0=1.01 * 3940.0), computed(Ti_c0=1.01 * 5130.0), computed(V=1.01 * 454.0)]
    short = []
    for i, (name, e) in enumerate(errors.items()):
        inputs = [100 * (c[i][1] / base[i][1] - 1) for c in changed]
        quantity = f"gauge at a titanium face, {name.partition(' ')[0].rstrip(',')}"
        short.append(summary(quantity, [x for x, _ in e], root_sum_square(*inputs, *(u for _, u in e[:1]))))
    head = ["constants", "quantity", "measured", "computed", "error, %", "change from 20 to 10 µm, %"]
    return {"summary": short, "gauge": (head, rows)}


# Flow stresses

FLOW_STRAINS = (0.02, 0.05, 0.1, 0.2)
FLOW_FILE = "taylor_bars_material.csv"


def flow():
    """Compares digitised stress-strain curves with `revolve material`; above 1 per s plastic work heats the element."""
    tests = table(DATA / "flow_stress.csv")
    files = {"6061-T6 aluminium": "6061-T6 aluminium", "annealed copper": "OFHC copper"}

    def stresses(test, stronger=1.0):
        file, material, name, strength = BAR_MATERIALS[files[test["material"]]]
        rate, temperature = test["rate_1_s"], test["T0_K"]
        with tempfile.TemporaryDirectory(dir=WORK) as out:
            options = settings({"file": file, "material": material, name: stronger * strength})
            options += ["--rates", rate, "--temperatures", temperature, "--strain", 0.21, "--out", out, "-q"]
            heating = [] if float(rate) > 1 else ["--isothermal"]
            revolve("material", DECKS / "taylor_bars.inp", *options, *heating)
            points = [(float(r["true strain"]), float(r["true stress"]) / 1e6) for r in table(Path(out) / FLOW_FILE)]
        return [value(points, strain) for strain in FLOW_STRAINS]

    found = two_at_a_time(stresses, tests)
    groups = (
        ("6061-T6 aluminium", "77 to 250 K", 0, 250),
        ("6061-T6 aluminium", "250 to 310 K", 250, 310),
        ("6061-T6 aluminium", "360 to 480 K", 310, 500),
        ("6061-T6 aluminium", "530 to 644 K", 500, 700),
        ("annealed copper", "298 K", 0, 310),
        ("annealed copper", "473 to 873 K", 310, 1000),
    )

    measured = ([t[f"s{e:g}_MPa"] for e in FLOW_STRAINS] for t in tests)
    errors = [[100 * (c / float(m) - 1) if m else None for m, c in zip(x, y)] for x, y in zip(measured, found)]
    rows, short = [], []
    for material, label, low, high in groups:
        for speed, slow, fast in (("to 1", 0, 1), ("1.1 to 150", 1, 150), ("380 to 4000", 150, 1e4)):
            chosen = [
                e
                for t, e in zip(tests, errors)
                if t["material"] == material and low < float(t["T0_K"]) < high and slow < float(t["rate_1_s"]) <= fast
            ]
            cells = []
            for column in zip(*chosen):
                e = [x for x in column if x is not None]
                cells.append(f"{statistics.median(e):+.1f} / {max(e, key=abs):+.1f}" if e else "")
            if chosen:
                rows.append([material, label, speed, f"{len(chosen)}", *cells])
    ranges = {"6061-T6 aluminium": (293, 700, 1e-3, 1e4), "annealed copper": (223, 1000, 1, 1e5)}

    def in_range(t):
        """Returns whether a curve is in the range that the file of the material states."""
        cold, hot, slow, fast = ranges[t["material"]]
        return cold <= float(t["T0_K"]) <= hot and slow <= float(t["rate_1_s"]) <= fast

    strong = two_at_a_time(lambda t: stresses(t, 1.1), tests)
    for label, rule in (
        (
            "6061-T6 aluminium, 294 to 300 K",
            lambda t: t["material"][0] == "6" and in_range(t) and float(t["T0_K"]) < 310,
        ),
        (
            "6061-T6 aluminium, 366 to 618 K",
            lambda t: t["material"][0] == "6" and in_range(t) and float(t["T0_K"]) > 310,
        ),
        ("annealed copper", lambda t: t["material"][0] == "a" and in_range(t)),
        ("both metals outside the range of the constants", lambda t: not in_range(t)),
    ):
        change = [100 * (b[1] / a[1] - 1) for t, a, b in zip(tests, found, strong) if rule(t)]
        e = [x for t, row in zip(tests, errors) if rule(t) for x in row if x is not None]
        short.append(summary(f"flow stress of {label}", e, statistics.median(change)))
    plot_flow(tests, found)
    head = ["curve", "rate, per s", "temperature, K"]
    for e in FLOW_STRAINS:
        head += [f"at {e:g}, measured, MPa", "computed", "error, %"]
    single = []
    for t, c in zip(tests, found):
        cells = [t["curve"], t["rate_1_s"], t["T0_K"]]
        for e, x in zip(FLOW_STRAINS, c):
            m = t[f"s{e:g}_MPa"]
            cells += [m, f"{x:.1f}", percent(x, float(m)) if m else ""]
        single.append(cells)
    columns = ["material", "temperature", "rate, per s", "curves"] + [f"strain {e:g}" for e in FLOW_STRAINS]
    return {"summary": short, "flow": (columns, rows), "files": {"flow-all": (head, single)}}


# Blast

DISTANCES = ("overpressure_kPa", "impulse_Pas", "arrival_ms")


def blast():
    tests = table(DATA / "blast_surface_10kg.csv")
    mass = 1e6  # per area, as in the deck

    def wave(distance, **values):
        rows = run("blast_surface", R=distance, **values)
        first = next(r for r in rows if r["A2@REF"] != 0)
        return -mass * first["A2@REF"] / 1e3, -mass * rows[-1]["V2@REF"], 1e3 * first["time"]

    def simplified(distance, mass=10.0):
        """Returns the incident overpressure in kPa of the simplified equation of Swisdak 1994, 0.2 to 23.8 m/kg^(1/3)."""
        near, far = (7.2106, -2.1069, -0.3229, 0.1117, 0.0685), (7.5938, -3.0523, 0.40977, 0.0261, -0.01267)
        log = math.log(distance / mass ** (1 / 3))
        return math.exp(sum(c * log**i for i, c in enumerate(near if log < math.log(2.9) else far)))

    found = [wave(float(t["distance_m"])) for t in tests]
    rows, errors = [], {k: [] for k in (*DISTANCES, "simplified")}
    for t, w in zip(tests, found):
        x = simplified(float(t["distance_m"]))
        cells = [t["distance_m"], f"{x:.4g}", percent(w[0], x)]
        errors["simplified"].append(100 * (w[0] / x - 1))
        for k, x in zip(DISTANCES, w):
            cells += [t[k], f"{x:.4g}", percent(x, float(t[k]))]
            errors[k].append(100 * (x / float(t[k]) - 1))
        rows.append(cells)
    heavy = [wave(float(t["distance_m"]), W=10.5) for t in tests]
    wide = [wave(float(t["distance_m"]), width=1e-2) for t in tests]
    short = []
    names = ("overpressure of the set", "impulse of the set", "arrival of the set", "simplified overpressure")
    for i, (e, name) in enumerate(zip(errors.values(), names)):
        parts = (
            statistics.median(abs(100 * (a[i % 3] / b[i % 3] - 1)) for a, b in zip(x, found)) for x in (heavy, wide)
        )
        short.append(summary(f"surface burst, {name}", e, root_sum_square(*parts)))
    head = ["distance, m", "simplified overpressure, kPa", "difference, %"]
    for name in ("overpressure of the set, kPa", "impulse of the set, Pa s", "arrival of the set, ms"):
        head += [name, "Revolve", "difference, %"]
    return {"summary": short, "blast": (head, rows)}


# Hugoniots

HUGONIOTS = (
    ("copper_ofhc", "Cu_OFHC"),
    ("copper_half_hard", "Cu"),
    ("aluminium_2024_t351", "Al_2024"),
    ("aluminium_6061_t6", "Al_6061"),
    ("aluminium_7075_t651", "Al_7075_T6"),
    ("titanium_6al4v", "Ti_6Al_4V"),
    ("tungsten_alloy", "W"),
    ("PMMA of plate_titanium_pmma", "PMMA"),
)


def hugoniots():
    """Compares constants of the decks with published lines, and the pressure at a particle velocity of 500 m/s."""
    lines = {r["line"]: r for r in table(DATA / "hugoniots.csv")}
    rows, errors = [], []
    for name, line in HUGONIOTS:
        published = [float(lines[line][k]) for k in ("rho_kg_m3", "c0_m_s", "s")]
        path = DECKS / "plate_titanium_pmma.inp" if line == "PMMA" else ROOT / "input" / "materials" / f"{name}.inp"
        text = path.read_text(encoding="utf-8")
        density = re.search(r"\*Density\n *([^,]+),", text)[1]
        c0, s = (x.strip() for x in re.search(r"type=USUP\n(.*)", text)[1].split(",")[:2])
        if c0.startswith("<"):
            c0 = re.search(rf"{c0[1:-1]} = (\S+)", text)[1]
        given = [float(density), float(c0), float(s)]
        pressure = [r * (c + k * 500.0) * 500.0 / 1e9 for r, c, k in (given, published)]
        cells = [f"{g:g} ({percent(g, p)})" for g, p in zip(given, published)]
        errors.append(100 * (pressure[0] / pressure[1] - 1))
        file = f"`{name}.inp`" if line != "PMMA" else "PMMA of `plate_titanium_pmma.inp`"
        source = lines[line]["citation"].partition(",")[0]
        rows.append([file, f"{line}, {source}", *cells, f"{pressure[0]:.2f} ({percent(*pressure)})"])
    head = ["file", "published line", "density, kg/m³ (difference, %)", "$c_0$, m/s", "$s$", "pressure at 500 m/s, GPa"]
    independent = [e for e, (name, _) in zip(errors, HUGONIOTS) if name.startswith(("aluminium_6", "PMMA"))]
    return {
        "summary": [summary("pressure at 500 m/s of lines of other sources", independent, None)],
        "hugoniots": (head, rows),
    }


# Ready materials

ALL_MATERIALS = {
    "copper_ofhc": "COPPER_OFHC",
    "copper_half_hard": "COPPER_STEINBERG",
    "iron_armco": "IRON_ARMCO",
    "steel_4340": "STEEL_4340",
    "steel_weldox_460e": "STEEL_WELDOX_460E",
    "aluminium_2024_t351": "AL2024_T351",
    "aluminium_5083_h116": "AL5083_H116",
    "aluminium_6061_t6": "AL6061_T6",
    "aluminium_6082_t651": "AL6082_T651",
    "aluminium_7075_t651": "AL7075_T651",
    "titanium_6al4v": "TI6AL4V",
    "titanium_6al4v_1985": "TI6AL4V_1985",
    "tungsten_alloy": "TUNGSTEN_ALLOY",
}


def materials():
    """Stretches one element of each material at two rates and returns the true stress in MPa."""
    deck, rows, curves = ROOT / "input" / "materials" / "one_element.inp", [], {}
    strains = (0.02, 0.1, 0.3)
    for file, name in ALL_MATERIALS.items():
        row = [f"`{file}.inp`", name]
        for rate in (1e3, 1e5):
            # At the higher rate the element is smaller, so that waves cross it in the same strain.
            options = settings({"material": name, "file": f"{file}.inp", "rate": rate, "size": 1e-2 / rate})
            revolve("run", deck, *options, "--out", WORK / "run", "-q")
            points = []
            for r in table(WORK / "run" / "one_element_history.csv"):
                r = {k.partition("@")[0]: float(v) for k, v in r.items()}
                points.append((math.log1p(rate * r["time"]), r["S22"] / 1e6))
            row += [f"{value(points, strain):.0f}" for strain in strains]
            if rate == 1e3:
                curves[name] = points
        rows.append(row)
    plot_curves(curves)
    head = ["file", "material"] + [f"{x:g} at {r}" for r in ("1000/s", "100000/s") for x in strains]
    return {"materials": (head, rows)}


# Pictures


def figure(width, height, columns=1):
    if "--plot" not in sys.argv:
        return None, None
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    return pyplot.subplots(1, columns, figsize=(width, height), squeeze=False, layout="constrained")


def save(fig, name):
    fig.savefig(ROOT / "docs" / "validation" / f"{name}.png", dpi=80)


def plot_points(points):
    fig, axes = figure(6, 5.5)
    if fig:
        ax = axes[0][0]
        for (name, xy), colour in zip(list(points.items())[::-1], ("0.7", "tab:blue", "tab:red")):
            ax.loglog(*zip(*xy), ".", color=colour, label=name)
        line = [10, 3000]
        ax.loglog(line, line, "k-", lw=1)
        for f in (0.8, 1.2):
            ax.loglog(line, [f * x for x in line], "k--", lw=0.7)
        ax.set(xlabel="measured depth, mm", ylabel="computed depth, mm", xlim=line, ylim=line)
        ax.legend()
        save(fig, "concrete")


def plot_bars(curves):
    tests = list(dict.fromkeys(t["test"] for t, *_ in curves))
    fig, axes = figure(3 * len(tests), 4.5, len(tests))
    if fig:
        for ax, test in zip(axes[0], tests):
            shown = [c for c in curves if c[0]["test"] == test]
            for _, label, points, *_ in shown:
                ax.plot([r for _, r in points], [z for z, _ in points], label=label)
            t, _, _, widths, length, foot = shown[0]
            ax.plot([foot] + [w for _, w in widths], [0] + [f * length for f, _ in widths], "ko", label="measured")
            ax.axhline(length, color="k", lw=0.7, ls="--")
            title = f"{t['material']}, {t['v0_mps']} m/s, {t['T0_K']} K"
            ax.set(title=title, xlabel="radius, mm", xlim=(0, None), ylim=(0, None))
        axes[0][0].set_ylabel("height, mm")
        axes[0][-1].legend()
        save(fig, "taylor")


def plot_flow(tests, found):
    fig, axes = figure(10, 4.8, 2)
    if fig:
        for ax, material in zip(axes[0], ("6061-T6 aluminium", "annealed copper")):
            for k, strain in enumerate(FLOW_STRAINS):
                xy = [
                    (float(t[f"s{strain:g}_MPa"]), c[k])
                    for t, c in zip(tests, found)
                    if t["material"] == material and t[f"s{strain:g}_MPa"]
                ]
                ax.plot(*zip(*xy), "o", ms=4, label=f"strain {strain:g}")
            line = (30, max(ax.get_xlim()[1], ax.get_ylim()[1]))
            ax.plot(line, line, "k-", lw=1)
            for f in (0.9, 1.1):
                ax.plot(line, [f * x for x in line], "k--", lw=0.7)
            ax.set(title=material, xlabel="measured stress, MPa", ylabel="computed stress, MPa")
        axes[0][0].legend(fontsize="small")
        save(fig, "flow")


def plot_bar_scatter(tests, found):
    fig, axes = figure(10, 4.8, 2)
    if fig:
        quantities = (
            (0, "Lf_mm", "L0_mm", "length / initial length"),
            (1, "Df_mm", "D0_mm", "foot / initial diameter"),
        )
        for ax, (k, column, initial, name) in zip(axes[0], quantities):
            for material, colour in zip(BAR_MATERIALS, ("tab:red", "tab:orange", "tab:blue", "0.3")):
                for hot, mark in ((False, "o"), (True, "^")):
                    xy = [
                        (float(t[column]) / float(t[initial]), f[k] / float(t[initial]))
                        for t, f in zip(tests, found)
                        if t["material"] == material
                        and t[column]
                        and not isinstance(f, str)
                        and (float(t["T0_K"]) > 400) == hot
                    ]
                    if xy:
                        ax.plot(*zip(*xy), mark, ms=4, color=colour, label=material + (", heated" if hot else ""))
            line = ax.get_xlim()
            ax.plot(line, line, "k-", lw=1)
            for f in (0.95, 1.05):
                ax.plot(line, [f * x for x in line], "k--", lw=0.7)
            ax.set(xlabel=f"measured {name}", ylabel=f"computed {name}")
        axes[0][0].legend(fontsize="small")
        save(fig, "bars")


def plot_plates(pictures):
    tests = list(dict.fromkeys(p[0] for p in pictures))
    fig, axes = figure(4 * len(tests), 4, len(tests))
    if fig:
        for ax, test in zip(axes[0], tests):
            shown = [p for p in pictures if p[0] == test]
            measured = shown[0][2]
            ax.plot(*zip(*measured), "k.", label="measured")
            for _, label, _, points, shift in shown:
                ax.plot([t + shift for t, _ in points], [v for _, v in points], label=label)
            start = crossing(measured, 0.02 * max(v for _, v in measured))
            ax.set(title=test, xlabel="time, µs", xlim=(start - 0.1, min(measured[-1][0], start + 2.5)))
            ax.set_ylabel("stress, GPa" if "PMMA" in test else "velocity, m/s")
            ax.legend(loc="lower right")
        save(fig, "plates")


def plot_curves(curves):
    fig, axes = figure(7, 5)
    if fig:
        for i, (name, points) in enumerate(curves.items()):
            axes[0][0].plot(*zip(*points), "--" if i > 9 else "-", label=name)
        axes[0][0].set(xlabel="true strain", ylabel="true stress, MPa", xlim=(0, None), ylim=(0, None))
        axes[0][0].legend(fontsize="small", loc="upper left", bbox_to_anchor=(1, 1))
        save(fig, "materials")


# The page


def markdown(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows]) + "\n"


def comma_separated(head, rows):
    output = io.StringIO()
    writer = csv.writer(output, lineterminator="\n")
    writer.writerow(head)
    writer.writerows(rows)
    return output.getvalue()


def marked(name):
    return re.compile(rf"(<!-- {name} -->\n)(.*?)(<!-- end of {name} -->)", re.DOTALL)


NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?")


def differences(name, old, new):
    """Returns the lines in which two tables differ by more than the stated rounding."""
    found = []
    old, new = old.strip().split("\n"), new.strip().split("\n")
    if len(old) != len(new):
        return [f"{name}: {len(old)} lines on the page, {len(new)} computed"]
    for a, b in zip(old, new):
        x, y = NUMBER.findall(a), NUMBER.findall(b)
        same = NUMBER.sub("#", a) == NUMBER.sub("#", b) and len(x) == len(y)
        for p, q in zip(x, y):
            digit = 10.0 ** -len(p.partition(".")[2])
            same = same and abs(float(p) - float(q)) <= RELATIVE * abs(float(p)) + LAST_DIGITS * digit * 1.0001
        if not same:
            found.append(f"{name}:\n  page     {a}\n  computed {b}")
    return found


def merged_summary(family, rows, families):
    """Returns the summary in which the rows of one family are new and the others are those of the last run."""
    path = ROOT / "docs" / "validation" / "summary.csv"
    stored = list(csv.reader(path.read_text(encoding="utf-8").splitlines()))[1:] if path.exists() else []
    merged = [row for row in stored if row[0] != family] + [[family, *row] for row in rows]
    merged.sort(key=lambda row: families.index(row[0]))
    return ["family", "quantity", "comparisons", "median of absolute error, %", "largest, %", "$u_{val}$, %"], merged


def main():
    only = next((a.split("=", 1)[1].split(",") for a in sys.argv if a.startswith("--only=")), None)
    families = {
        "apm2": apm2,
        "rods": rods,
        "concrete": concrete,
        "taylor": taylor,
        "bars": bars,
        "outlines": outlines,
        "plates": plates,
        "gauge": gauge,
        "flow": flow,
        "hugoniots": hugoniots,
        "blast": blast,
        "materials": materials,
    }
    check, wrong = "--check" in sys.argv, []
    for family, compute in families.items():
        if only and family not in only:
            continue
        tables = compute()
        file = MATERIALS_PAGE if family == "materials" else PAGE
        for name, (head, rows) in tables.pop("files", {}).items():
            stored = ROOT / "docs" / "validation" / f"{name}.csv"
            if check:
                wrong += differences(name, stored.read_text(encoding="utf-8"), comma_separated(head, rows))
            else:
                stored.write_text(comma_separated(head, rows), encoding="utf-8")
        if "summary" in tables:
            tables["summary"] = merged_summary(family, tables["summary"], list(families))
        for name, (head, rows) in tables.items():
            page = file.read_text(encoding="utf-8")
            place = marked(name).search(page)
            if not place:
                sys.exit(f"{file.name} has no table `{name}`: add <!-- {name} --> and <!-- end of {name} -->")
            text = markdown(head, rows)
            if check:
                wrong += differences(name, place[2], text)
                continue
            file.write_text(page[: place.start(2)] + text + page[place.end(2) :], encoding="utf-8")
            (ROOT / "docs" / "validation" / f"{name}.csv").write_text(comma_separated(head, rows), encoding="utf-8")
        print(f"{family}: done", flush=True)
    if wrong:
        sys.exit("\n".join(wrong))
    if check:
        print("the page has the computed numbers")


main()
