#!/usr/bin/env bash
# VTK 9.5.2 (PyVista 0.46.4): a cell array of 0 and 1, type uint8, saved as legacy text (.vtk) and read back.
# Guess: the array comes back with its name and with 0 and 1, as it does from .vtu; the number type does not matter.
# Happens: the first uint8 array is written as COLOR_SCALARS, as fractions of 255: 1 becomes 0.00392157. Its name is escaped
#   twice, so that "ELSET ROD" comes back as "ELSET"; "ELSET_ROD" keeps its name. Later uint8 arrays, and int64, are written as
#   they are.
# Hurt: anyone who marks sets by uint8 (numpy bool or mask) in legacy files: a reader that tests for 1, or rounds, finds no member.
set -euo pipefail
t=$(mktemp -d); trap 'rm -rf "$t"' EXIT; cd "$t"
python3 -m venv v; v/bin/pip install -q pyvista==0.46.4 vtk==9.5.2
v/bin/python - <<'P'
import sys
import numpy as np, pyvista, vtk
points = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0], [1, 1, 0], [2, 1, 0.0]])
def written(arrays):
    grid = pyvista.UnstructuredGrid({vtk.VTK_QUAD: np.array([[0, 1, 4, 3], [1, 2, 5, 4]])}, points)
    for name, kind in arrays.items(): grid.cell_data[name] = np.array([0, 1], kind)
    grid.save("a.vtk", binary=False); grid.save("a.vtu")
    lines = [line for line in open("a.vtk").read().splitlines() if "ELSET" in line]
    back = [{k: v.tolist() for k, v in pyvista.read(f).cell_data.items()} for f in ("a.vtk", "a.vtu")]
    numbers = [word for word in open("a.vtk").read().split() if word.startswith("0.0039")]
    return lines, numbers, back
print("VTK", vtk.__version__, "PyVista", pyvista.__version__)
blank = written({"ELSET ROD": np.uint8})
plain = written({"ELSET_ROD": np.uint8, "ELSET_TIP": np.uint8})
whole = written({"ELSET_ROD": np.int64})
for result in (blank, plain, whole): print(*result, sep="  |  ")
sys.exit(not (blank[0] == ["COLOR_SCALARS ELSET%%20ROD 1"] and blank[1] == ["0.00392157"] and list(blank[2][0]) == ["ELSET"]
              and plain[0][0] == "COLOR_SCALARS ELSET_ROD 1" and len(plain[1]) == 1 and not whole[1]))
P
