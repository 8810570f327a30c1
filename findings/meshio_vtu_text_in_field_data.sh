#!/usr/bin/env bash
# meshio 5.3.5 and meshlane 5.5.0 read a .vtu file of PyVista 0.49.0 (VTK 9.7.2) whose field data have a text, such as the units.
# Guess: text in field data is read, or left out: it belongs neither to points nor to cells.
# Happens: VTK writes it as <Array type="String">, which the format allows. meshio and meshlane give up on the whole file: meshio
#   prints "Illegal data type" and raises SystemExit, which `except Exception` and `except ReadError` let through, so a script that
#   converts many files ends at the first such file. The same text as a comment of the XML file harms nobody.
# Hurt: who stores units, commit or command line in frames, and every colleague that reads these frames with meshio.
set -euo pipefail
t=$(mktemp -d); trap 'rm -rf "$t"' EXIT; cd "$t"
python3 -m venv v; v/bin/pip install -q meshio==5.3.5 meshlane==5.5.0 pyvista==0.49.0 vtk==9.7.2
v/bin/python - <<'P'
import sys
import meshio, meshlane, pyvista as pv
grid = pv.Plane(i_resolution=2, j_resolution=2).cast_to_unstructured_grid()
grid.save("plain.vtu")
text = open("plain.vtu").read()
open("comment.vtu", "w").write(text.replace("<VTKFile", "<!-- units: mm, t, s -->\n<VTKFile", 1))
grid.field_data["units"] = ["mm, t, s"]
grid.save("field.vtu")
def points(reader, name):
    try: return len(reader.read(name).points)
    except SystemExit as end: return f"SystemExit({end.code})"
    except Exception as error: return type(error).__name__
read = {r.__name__: [points(r, name) for name in ["plain.vtu", "comment.vtu", "field.vtu"]] for r in (meshio, meshlane)}
kept = list(pv.read("field.vtu").field_data["units"])
print("meshio", meshio.__version__, "meshlane", meshlane.__version__, "PyVista", pv.__version__)
print("points of plain, comment, field:", read, "; PyVista reads back", kept)
sys.exit(not (read["meshio"] == [9, 9, "SystemExit(1)"] and read["meshlane"][:2] == [9, 9] and read["meshlane"][2] != 9
              and kept == ["mm, t, s"]))
P
