#!/usr/bin/env bash
# scikit-fem 12.0.2 (with meshio 5.3.5): a mesh of triangles is loaded, refined and saved as an ABAQUS input file.
# Guess: connectivities come back as they were, counterclockwise, as for quadrilaterals; refinement and the generated meshes
#   (MeshTri.init_tensor) are counterclockwise, too.
# Happens: the nodes of each triangle are sorted by number when a mesh is made, so that half of the triangles of an ordinary mesh
#   are clockwise in the saved file, 8 of 16 after a refinement, 9 of 18 of a generated grid. Quadrilaterals keep their order.
#   scikit-fem itself takes the absolute value of the determinant.
# Hurt: who prepares or refines a mesh of CAX3, CPS3 or C3D4 with scikit-fem for a code that takes the sign: negative volumes, or
#   a side number (S1 to S3) that means another side.
set -euo pipefail
t=$(mktemp -d); trap 'rm -rf "$t"' EXIT; cd "$t"
python3 -m venv v; v/bin/pip install -q scikit-fem==12.0.2 meshio==5.3.5 numpy==2.4.4
v/bin/python - <<'P'
import importlib.metadata, sys
import meshio, numpy as np, skfem
points = np.array([[0, 0], [1, 0], [2, 0], [0, 1], [1, 1], [2, 1.0]])
triangles = np.array([[0, 1, 4], [4, 3, 0], [1, 2, 5], [5, 4, 1]])
quads = np.array([[4, 3, 0, 1], [1, 2, 5, 4]])
def clockwise(p, t):
    a, b = p[t[:, 1]] - p[t[:, 0]], p[t[:, 2]] - p[t[:, 0]]
    return int((a[:, 0] * b[:, 1] < a[:, 1] * b[:, 0]).sum()), len(t)
def passed_through(kind, cells):
    meshio.write("a.inp", meshio.Mesh(points, [(kind, cells)]))
    mesh = skfem.Mesh.load("a.inp"); mesh.save("b.inp")
    return mesh, meshio.read("b.inp")
mesh, saved = passed_through("triangle", triangles)
file = clockwise(saved.points[:, :2], saved.cells[0].data)
fine = mesh.refined(1); grid = skfem.MeshTri.init_tensor(np.linspace(0, 1, 4), np.linspace(0, 1, 4))
kept = np.array_equal(passed_through("quad", quads)[1].cells[0].data, quads)
print("scikit-fem", importlib.metadata.version("scikit-fem"))
print("clockwise triangles: given", clockwise(points, triangles), "saved", file, "refined", clockwise(fine.p.T, fine.t.T),
      "generated", clockwise(grid.p.T, grid.t.T), "; quadrilaterals kept:", kept)
sys.exit(not (clockwise(points, triangles) == (0, 4) and file == (2, 4) and clockwise(fine.p.T, fine.t.T) == (8, 16)
              and clockwise(grid.p.T, grid.t.T) == (9, 18) and kept))
P
