#!/usr/bin/env bash
# meshpy 2026.1.1 (Triangle) with meshio 5.3.5: triangles of second order, build(..., mesh_order=2), saved as triangle6.
# Guess: the middle points follow the edges 1-2, 2-3, 3-1, as in meshio, VTK, Gmsh and ABAQUS.
# Happens: Triangle lists the middle point of the edge opposite to each corner: 2-3, 3-1, 1-2. Areas by corners and pictures of flat
#   elements are right; the element with its middle points is folded (the determinant of the Jacobian is negative in parts of it).
#   cells[:, [0, 1, 2, 5, 3, 4]] is the order of meshio.
# Hurt: anyone who solves on six-node triangles from MeshPy: wrong or singular stiffness, no message from either package.
set -euo pipefail
t=$(mktemp -d); trap 'rm -rf "$t"' EXIT; cd "$t"
python3 -m venv v; v/bin/pip install -q meshpy==2026.1.1 meshio==5.3.5
v/bin/python - <<'P'
import importlib.metadata as m, sys
import meshio, numpy as np
from meshpy import triangle
info = triangle.MeshInfo()
info.set_points([(0, 0), (2, 0), (2, 1), (0, 1)])
info.set_facets([(0, 1), (1, 2), (2, 3), (3, 0)])
mesh = triangle.build(info, max_volume=0.1, mesh_order=2)
points, cells = np.array([(x, y, 0.0) for x, y in mesh.points]), np.array(mesh.elements)
meshio.Mesh(points, [("triangle6", cells)]).write("mesh.vtk")
read = meshio.read("mesh.vtk")
p = read.points[read.cells[0].data][:, :, :2]
def is_middle(point, a, b):
    return np.allclose(p[:, point], 0.5 * (p[:, a] + p[:, b]))
def smallest_jacobian(p):
    least = np.inf
    for x, y in ((0, 0), (1, 0), (0, 1), (0.5, 0), (0.5, 0.5), (0, 0.5)):
        l = 1 - x - y
        dx = np.array([1 - 4 * l, 4 * x - 1, 0, 4 * (l - x), 4 * y, -4 * y])
        dy = np.array([1 - 4 * l, 0, 4 * y - 1, -4 * x, 4 * x, 4 * (l - y)])
        a, b = np.einsum("n,enk->ek", dx, p), np.einsum("n,enk->ek", dy, p)
        least = min(least, (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).min())
    return least
print("meshpy", m.version("meshpy"), "meshio", m.version("meshio"))
by_edges = is_middle(3, 0, 1) and is_middle(4, 1, 2) and is_middle(5, 2, 0)
opposite = is_middle(3, 1, 2) and is_middle(4, 2, 0) and is_middle(5, 0, 1)
written, ordered = smallest_jacobian(p), smallest_jacobian(p[:, [0, 1, 2, 5, 3, 4]])
print(f"{len(p)} elements; middle points by edges: {by_edges}, opposite to corners: {opposite}")
print(f"smallest determinant of the Jacobian: {written:.3g} as written, {ordered:.3g} in the order of meshio")
sys.exit(not (opposite and not by_edges and written < 0 < ordered))
P
