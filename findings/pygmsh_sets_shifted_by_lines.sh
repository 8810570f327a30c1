#!/usr/bin/env bash
# pygmsh 7.1.17 with Gmsh 4.15.2: a square of 2 x 2 quadrilaterals, its lower side in the group FOOT, its surface in BODY.
# Guess: cell_sets follow meshio's convention, which numbers the cells of each block from 0: BODY is 0 1 2 3 of the quadrilaterals,
#   FOOT is 0 1 of the lines.
# Happens: Gmsh's numbers over all groups, less one: BODY is 2 3 4 5, shifted by the two lines of FOOT. No message. In .inp the set
#   names other cells; without a group of lines BODY is right.
# Hurt: anyone who gives materials by group and conditions by side: each new side shifts the bodies.
set -euo pipefail
t=$(mktemp -d); trap 'rm -rf "$t"' EXIT; cd "$t"
python3 -m venv v; v/bin/pip install -q pygmsh==7.1.17 gmsh==4.15.2 meshio==5.3.5 numpy==1.26.4
v/bin/python - <<'P'
import sys
import gmsh, meshio, pygmsh
def square(with_side):
    with pygmsh.geo.Geometry() as geo:
        corners = [geo.add_point(p) for p in ((0, 0), (1, 0), (1, 1), (0, 1))]
        sides = [geo.add_line(corners[i], corners[(i + 1) % 4]) for i in range(4)]
        face = geo.add_plane_surface(geo.add_curve_loop(sides))
        for side in sides: geo.set_transfinite_curve(side, 3, "Progression", 1.0)
        geo.set_transfinite_surface(face, "Left", [])
        geo.set_recombined_surfaces([face])
        if with_side: geo.add_physical(sides[0], "FOOT")
        geo.add_physical(face, "BODY")
        return geo.generate_mesh(dim=2)
members = []
for with_side in (False, True):
    mesh = square(with_side)
    blocks = {block.type: (i, len(block.data)) for i, block in enumerate(mesh.cells)}
    body = [int(cell) for cell in mesh.cell_sets["BODY"][blocks["quad"][0]]]
    members.append(body)
    print("pygmsh", pygmsh.__version__, "group of lines" if with_side else "no group of lines",
          "quadrilaterals:", blocks["quad"][1], "BODY:", body)
sys.exit(members != [[0, 1, 2, 3], [2, 3, 4, 5]])
P
