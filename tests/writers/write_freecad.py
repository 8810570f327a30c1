"""Writes the files of FreeCAD. Usage: FOLDER=... freecadcmd write_freecad.py, with the folder of model.py in PYTHONPATH."""

import os
import sys

sys.path.insert(0, os.environ["MODEL"])
os.chdir(os.environ["FOLDER"])

import Fem  # noqa: E402  the modules of FreeCAD
import FreeCAD  # noqa: E402

from model import EDGES, NODES, POINTS, QUADS, SETS  # noqa: E402


def build(groups=True, edges=True):
    """Returns the mesh, with lines for the boundary groups."""
    mesh = Fem.FemMesh()
    for i, (r, z) in enumerate(POINTS, 1):
        mesh.addNode(r, z, 0.0, i)
    lines, faces = {}, []
    for name, pairs in EDGES.items() if edges else ():
        lines[name] = [mesh.addEdge([a + 1, b + 1]) for a, b in pairs]
    for quad in QUADS:
        faces.append(mesh.addFace([n + 1 for n in quad]))
    if groups:
        for name, members in SETS.items():
            mesh.addGroupElements(mesh.addGroup(name, "Face"), [faces[i] for i in members])
        for name, members in lines.items():
            mesh.addGroupElements(mesh.addGroup(name, "Edge"), members)
        for name, members in NODES.items():
            mesh.addGroupElements(mesh.addGroup(name + "_N", "Node"), [n + 1 for n in members])
    return mesh


mesh = build()
# The arguments are the elements (0 all, 1 highest dimension, 2 only those that belong to no face) and the groups.
mesh.writeABAQUS("freecad_all.inp", 0, True)
mesh.writeABAQUS("freecad_highest.inp", 1, True)
mesh.writeABAQUS("freecad_fem.inp", 2, False)
mesh.write("freecad_export.inp")
mesh.write("freecad.unv")
mesh.write("freecad.med")
mesh.write("freecad.vtk")
mesh.write("freecad.vtu")

# The input file of the CalculiX solver of FreeCAD.
import ObjectsFem  # noqa: E402
from femtools.ccxtools import FemToolsCcx  # noqa: E402

document = FreeCAD.newDocument("model")
analysis = ObjectsFem.makeAnalysis(document, "Analysis")
solver = ObjectsFem.makeSolverCalculixCcxTools(document, "Solver")
section = ObjectsFem.makeElementGeometry2D(document, 1.0, "Section")
steel = ObjectsFem.makeMaterialSolid(document, "STEEL")
card = steel.Material
card.update(Name="STEEL", YoungsModulus="207000 MPa", PoissonRatio="0.30", Density="7800 kg/m^3")
steel.Material = card
holder = document.addObject("Fem::FemMeshObject", "Mesh")
holder.FemMesh = mesh
for item in (solver, section, steel, holder):
    analysis.addObject(item)
document.recompute()
tools = FemToolsCcx(analysis, solver, test_mode=True)
tools.setup_working_dir(os.getcwd())
tools.update_objects()
tools.write_inp_file()
os.replace(tools.inp_file_name, "freecad_calculix.inp")
