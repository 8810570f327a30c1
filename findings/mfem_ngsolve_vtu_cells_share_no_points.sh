#!/usr/bin/env bash
# mfem 4.10.0.1 (Mesh.PrintVTU, ParaViewDataCollection) and ngsolve 6.2.2608 (VTKOutput): a square of 4 x 4 cells is saved for VTK.
# Guess: the file is the mesh: 25 points, cells share the points of their edges, as in the legacy file of MFEM (PrintVTK) and in
#   the exports of Netgen.
# Happens: each cell has points of its own (64 for 16 cells); nothing in the file says so, and pictures look the same. PyVista finds
#   16 bodies and draws each edge as boundary; after clean() there is one body with 25 points, but bodies that touch are joined too.
# Hurt: anyone who reads the file as a mesh in another solver (the cells fly apart) or asks for connectivity, boundary edges or
#   averages at points.
set -euo pipefail
t=$(mktemp -d); trap 'rm -rf "$t"' EXIT; cd "$t"
python3 -m venv v; v/bin/pip install -q mfem==4.10.0.1 ngsolve==6.2.2608 netgen-mesher==6.2.2608 netgen-occt==7.8.1 pyvista==0.46.4 vtk==9.5.2
v/bin/python - <<'P' 2>&1 | grep -v "only meant for debugging"
import importlib.metadata as m, sys
import mfem.ser as mfem, pyvista
from ngsolve import Mesh, VTKOutput
from ngsolve.meshes import MakeStructured2DMesh
square = mfem.Mesh.MakeCartesian2D(4, 4, mfem.Element.QUADRILATERAL)
square.PrintVTK("mesh.vtk")
square.PrintVTU("print_vtu", mfem.VTKFormat_BINARY)
VTKOutput(MakeStructured2DMesh(nx=4, ny=4), filename="output", subdivision=0).Do()
print("mfem", m.version("mfem"), "ngsolve", m.version("ngsolve"))
found = {}
for name in ("mesh.vtk", "print_vtu.vtu", "output.vtu"):
    grid = pyvista.read(name)
    bodies = int(grid.connectivity()["RegionId"].max()) + 1
    found[name] = (grid.n_points, bodies, grid.clean().n_points)
    print(f"{name}: {grid.n_cells} cells, {grid.n_points} points, {bodies} bodies; after clean() {found[name][2]} points")
sys.exit(found != {"mesh.vtk": (25, 1, 25), "print_vtu.vtu": (64, 16, 25), "output.vtu": (64, 16, 25)})
P
