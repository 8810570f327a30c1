#!/usr/bin/env bash
# meshio 5.3.5 reads a mesh with physical groups that Gmsh 4.15.2 has saved in its default version, MSH 4.1, and writes .vtu or .vtk.
# Guess: every cell keeps its group, as with the same mesh in version 2.2.
# Happens: meshio reads the numbers of the bounding points and curves of each entity, such as 1 and -2, as cells of a set
#   "gmsh:bounding_entities". Sets are written as one array with one number a cell, the last set wins: 6 of 20 cells leave their
#   groups without a message, those at the indices 1 to 4 and -2. In a coarser mesh the index is too large, and `meshio convert`
#   ends with IndexError. `del mesh.cell_sets["gmsh:bounding_entities"]` before writing keeps all groups.
# Hurt: who converts Gmsh meshes with meshio: a boundary condition or material is missing at a few cells.
set -euo pipefail
t=$(mktemp -d); trap 'rm -rf "$t"' EXIT; cd "$t"
python3 -m venv v; v/bin/pip install -q meshio==5.3.5 gmsh==4.15.2
v/bin/python - <<'P'
import sys
import gmsh, meshio, numpy as np
def square(cells, version):
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    surface = gmsh.model.occ.addRectangle(0, 0, 0, 1, 1)
    gmsh.model.occ.synchronize()
    for _, curve in gmsh.model.getEntities(1):
        gmsh.model.mesh.setTransfiniteCurve(curve, cells + 1)
    gmsh.model.mesh.setTransfiniteSurface(surface)
    gmsh.model.mesh.setRecombine(2, surface)
    gmsh.model.addPhysicalGroup(2, [surface], name="BODY")
    gmsh.model.addPhysicalGroup(1, [1], name="FOOT")
    gmsh.model.mesh.generate(2)
    gmsh.option.setNumber("Mesh.MshFileVersion", version)
    gmsh.write("square.msh")
    gmsh.finalize()
    return meshio.read("square.msh")
def lost(mesh):
    """Number of cells that have left their group in the written file."""
    expected = [block.type for block in mesh.cells]
    try: mesh.write("square.vtu")
    except IndexError as error: return f"IndexError: {error}"
    read = meshio.read("square.vtu")
    (name,) = [name for name in read.cell_data if "BODY" in name]
    number = {"line": name.split("-").index("FOOT"), "quad": name.split("-").index("BODY")}
    return sum(int((np.ravel(a) != number[kind]).sum()) for kind, a in zip(expected, read.cell_data[name]))
print("Gmsh", gmsh.__version__, "meshio", meshio.__version__)
fine, coarse, repaired = square(4, 4.1), square(1, 4.1), square(4, 4.1)
members = [list(map(int, cells)) for cells in fine.cell_sets["gmsh:bounding_entities"]]
del repaired.cell_sets["gmsh:bounding_entities"]
results = [lost(fine), lost(coarse), lost(repaired)]
print("members of gmsh:bounding_entities:", members, "of", [len(block.data) for block in fine.cells], "cells")
print("cells that leave their group: 4 x 4 cells:", results[0], "; one cell:", results[1], "; without the set:", results[2])
sys.exit(not (results[0] == 6 and str(results[1]).startswith("IndexError") and results[2] == 0))
P
