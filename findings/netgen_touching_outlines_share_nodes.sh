#!/usr/bin/env bash
# netgen-mesher 6.2.2608: a rod on a plate, two domains whose outlines have separate points (a contact problem).
# Guess: separate outlines give separate meshes, as two surfaces do in Gmsh: no common node, and contact between the bodies; or
#   all points of the common line are merged.
# Happens: outline points with equal coordinates become one node, the points between them do not: the bodies are joined at single
#   nodes and free elsewhere. No message. A gap of 1e-4 of the width separates them.
# Hurt: anyone who meshes touching bodies for contact: the bodies hang on a few nodes and cannot part there.
set -euo pipefail
t=$(mktemp -d); trap 'rm -rf "$t"' EXIT; cd "$t"
python3 -m venv v; v/bin/pip install -q netgen-mesher==6.2.2608 netgen-occt==7.8.1
v/bin/python - <<'P'
import importlib.metadata, sys
from netgen.geom2d import SplineGeometry
from netgen.meshing import PointId
def shared(gap):
    geometry = SplineGeometry()
    rod = ((0, 1 + gap), (0.9, 1 + gap), (0.9, 3), (0, 3))
    plate = ((0, 0), (5, 0), (5, 1), (0, 1))
    for domain, corners in enumerate((rod, plate), 1):
        points = [geometry.AppendPoint(*corner) for corner in corners]
        for i in range(4):
            geometry.Append(["line", points[i], points[(i + 1) % 4]], leftdomain=domain, rightdomain=0, bc=f"{domain}{i}")
    mesh = geometry.GenerateMesh(maxh=0.5)
    nodes = [{v.nr for e in mesh.Elements2D() if e.index == d for v in e.vertices} for d in (1, 2)]
    on_rod = [n for n in nodes[0] if abs(mesh[PointId(n)].p[1] - 1 - gap) < 1e-9]
    common = sorted(tuple(round(c, 6) for c in mesh[PointId(n)].p[:2]) for n in nodes[0] & nodes[1])
    return common, len(on_rod)
touching, apart = shared(0.0), shared(1e-4)
print("netgen-mesher", importlib.metadata.version("netgen-mesher"))
print("touching: common nodes", touching[0], "of", touching[1], "nodes of the rod's foot; with a gap:", apart[0])
sys.exit(not (0 < len(touching[0]) < touching[1] and apart[0] == []))
P
