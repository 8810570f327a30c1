#!/usr/bin/env bash
# meshio 5.3.5 writes Exodus (.e), VTK 9.7.2 (as ParaView does) and exodus_helper 1.6.0 read it.
# Guess: an Exodus file of meshio with a temperature at nodes, plastic strain and sets of cells is what the mesh was.
# Happens: cell data and sets of cells are left out without a word. Node data are in the file, in the layout of "large" Exodus
#   files (one variable for each name), but the attribute file_size = 1 that announces this layout is missing: VTK lists the name
#   and gives other values than those written, with messages in its log only; exodus_helper, which does not look at the
#   attribute, gives the right ones. With the attribute added by netCDF4, VTK gives them, too.
# Hurt: who sends fields to a code or viewer that takes Exodus (Sierra, MOOSE, Cubit, ParaView) by way of meshio.
set -euo pipefail
t=$(mktemp -d); trap 'rm -rf "$t"' EXIT; cd "$t"
python3 -m venv v; v/bin/pip install -q meshio==5.3.5 netCDF4==1.7.4 vtk==9.7.2 exodus_helper==1.6.0 numpy==2.4.4
v/bin/python - <<'P' 2>log || { cat log; exit 1; }
import shutil, sys
import exodus_helper, meshio, netCDF4, numpy as np, vtk
from vtk.util.numpy_support import vtk_to_numpy
points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0], [2, 1, 0.0]])
cells = [("quad", np.array([[0, 1, 2, 3]])), ("quad", np.array([[1, 4, 5, 2]]))]
temperature = np.array([300.0, 310, 320, 330, 340, 350])
none = np.array([], int)
mesh = meshio.Mesh(points, cells, point_data={"T": temperature}, cell_data={"PEEQ": [np.array([0.1]), np.array([0.2])]},
                   point_sets={"AXIS": np.array([0, 3])}, cell_sets={"ROD": [np.array([0]), none], "PLATE": [none, np.array([0])]})
meshio.write("a.e", mesh)
shutil.copy("a.e", "b.e")
with netCDF4.Dataset("b.e", "a") as file: file.setncattr("file_size", np.int32(1))
def by_vtk(name):
    reader = vtk.vtkExodusIIReader(); reader.SetFileName(name); reader.UpdateInformation()
    reader.SetAllArrayStatus(vtk.vtkExodusIIReader.NODAL, 1); reader.Update()
    names = [reader.GetPointResultArrayName(i) for i in range(reader.GetNumberOfPointResultArrays())]
    block = reader.GetOutput().GetBlock(0).GetBlock(0)
    return names, vtk_to_numpy(block.GetPointData().GetArray("T"))
back = meshio.read("a.e")
plain, announced = by_vtk("a.e"), by_vtk("b.e")
other = np.asarray(exodus_helper.Exodus("a.e").get_node_variable_values("T", 1))
print("meshio", meshio.__version__, "VTK", vtk.vtkVersion().GetVTKVersion())
print("read back by meshio: cell data", back.cell_data, "sets of cells", back.cell_sets, "sets of points", list(back.point_sets))
print("VTK lists", plain[0], "; values as written:", np.allclose(plain[1], temperature[:4]))
print("with file_size = 1:", announced[1], "; by exodus_helper:", other)
sys.exit(not (not back.cell_data and not back.cell_sets and plain[0] == ["T"] and not np.allclose(plain[1], temperature[:4])
              and np.allclose(announced[1], temperature[:4]) and np.allclose(other, temperature)))
P
