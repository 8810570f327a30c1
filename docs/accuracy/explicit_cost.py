"""Run time per element and increment of the copper Taylor bar with 20x100 elements: Revolve beside CalculiX explicit.

``python3 docs/accuracy/explicit_cost.py [REVOLVE]`` in the checkout, with ``ccx`` of Debian's ``calculix-ccx``. Both run
on one thread, in turns. CalculiX 2.20 keeps all displacements of axisymmetric elements at zero in explicit dynamics, so it
computes the same section as a slab of one layer of C3D8R in plane strain, with the same material and boundary conditions.
Each time is the difference of a long and a short run, which excludes start and end.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

COLUMNS, ROWS = 20, 100
RADIUS, LENGTH = 3.2e-3, 32.4e-3
ROUNDS = 3


def slab(end: float) -> str:
    """Return the CalculiX deck of a run until ``end``; it prints displacements in each increment."""
    row, layer = COLUMNS + 1, (COLUMNS + 1) * (ROWS + 1)
    side = RADIUS / COLUMNS
    lines = ["*NODE, NSET=ALL"]
    for n in range(2 * layer):
        k, (j, i) = n // layer, divmod(n % layer, row)
        lines.append(f"{n + 1}, {side * i:.9e}, {LENGTH * j / ROWS:.9e}, {side * k:.9e}")
    lines.append("*ELEMENT, TYPE=C3D8R, ELSET=BAR")
    for e in range(COLUMNS * ROWS):
        first = e // COLUMNS * row + e % COLUMNS + 1
        face = [first, first + 1, first + row + 1, first + row]
        lines.append(", ".join(str(n) for n in [e + 1, *face, *(n + layer for n in face)]))
    lines += [f"*NSET, NSET=FOOT, GENERATE\n1, {row}\n{layer + 1}, {layer + row}", "*NSET, NSET=AXIS, GENERATE"]
    lines += [f"{1 + k * layer}, {1 + k * layer + ROWS * row}, {row}" for k in (0, 1)]
    lines.append(f"""*SOLID SECTION, ELSET=BAR, MATERIAL=COPPER
*MATERIAL, NAME=COPPER
*DENSITY
8930.
*ELASTIC
117.e9, 0.35
*PLASTIC
400.e6, 0.
500.e6, 1.
600.e6, 2.
900.e6, 5.
*INITIAL CONDITIONS, TYPE=VELOCITY
ALL, 2, -227.
*BOUNDARY
FOOT, 2, 2
AXIS, 1, 1
ALL, 3, 3
*STEP, NLGEOM, INC=1000000
*DYNAMIC, EXPLICIT
1.e-8, {end:e}
*NODE PRINT, NSET=FOOT, FREQUENCY=1
U
*END STEP
""")
    return "\n".join(lines)


def calculix(folder: Path, end: float) -> tuple[float, int]:
    """Return seconds and increments of a run of CalculiX."""
    (folder / "slab.inp").write_text(slab(end))
    begin = time.perf_counter()
    subprocess.run(
        ["ccx", "slab"], cwd=folder, check=True, capture_output=True, env=os.environ | {"OMP_NUM_THREADS": "1"}
    )
    seconds = time.perf_counter() - begin
    return seconds, (folder / "slab.dat").read_text().count("displacements")


def revolve(program: str, folder: Path, end: float) -> tuple[float, int]:
    """Return seconds and increments of a run of Revolve without frames."""
    deck = Path("input/taylor_copper.inp").read_text().replace(" , 80.e-6", f" , {end:e}")
    (folder / "bar.inp").write_text(deck)
    size = ["--set", f"nr={COLUMNS}", "--set", f"nz={ROWS}"]
    command = [program, "run", str(folder / "bar.inp"), *size, "--threads", "1", "--no-frames", "--json", "--quiet"]
    done = subprocess.run([*command, "--out", str(folder / "out")], check=True, capture_output=True)
    timing = json.loads(done.stdout)["timing"]
    return timing["seconds"], timing["increments"]


def main() -> None:
    """Run both in turns and print the best times."""
    program = sys.argv[1] if len(sys.argv) > 1 else "revolve"
    best = [float("inf"), float("inf")]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for _ in range(ROUNDS):
            codes = (lambda end: calculix(folder, end), 5e-7), (lambda end: revolve(program, folder, end), 1e-5)
            for i, (run, end) in enumerate(codes):
                (short, few), (long, many) = run(end), run(4 * end)
                best[i] = min(best[i], 1e9 * (long - short) / (many - few) / (COLUMNS * ROWS))
    print(f"ns per element and increment: CalculiX {best[0]:.0f}, Revolve {best[1]:.1f}, ratio {best[0] / best[1]:.0f}")


if __name__ == "__main__":
    main()
