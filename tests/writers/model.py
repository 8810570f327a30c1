"""Reference mesh of all writers: a rod above a plate in the (r, z) plane, in metres.

The rod has r from 0 to 0.005, z from 0.006 to 0.036 and 4 x 20 quadrilaterals.
The plate has r from 0 to 0.05, z from 0 to 0.006 and 40 x 5 quadrilaterals.
With MESH=coarse in the environment the bodies have 2 x 4 and 8 x 2 quadrilaterals.
The bodies share no nodes. All lists count from 0.
"""

import os

COARSE = os.environ.get("MESH") == "coarse"
#: Limits of r, limits of z, numbers of quadrilaterals along r and z.
BODIES = {"ROD": ((0.0, 0.005), (0.006, 0.036), *((2, 4) if COARSE else (4, 20))),
          "PLATE": ((0.0, 0.05), (0.0, 0.006), *((8, 2) if COARSE else (40, 5)))}


def spaced(limits, count):
    """Returns count + 1 equidistant values."""
    return [limits[0] + (limits[1] - limits[0]) * i / count for i in range(count + 1)]


def build():
    """Returns points, quadrilaterals, element sets and boundary edges of the reference mesh."""
    points, quads, sets, sides = [], [], {}, {}
    for name, (r, z, columns, rows) in BODIES.items():
        first = len(points)
        points += [(x, y) for y in spaced(z, rows) for x in spaced(r, columns)]

        def node(i, j, first=first, columns=columns):
            return first + j * (columns + 1) + i

        start = len(quads)
        quads += [(node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1))
                  for j in range(rows) for i in range(columns)]
        sets[name] = list(range(start, len(quads)))
        # Edges follow the boundary counter-clockwise: the body is on the left.
        sides[name] = {
            "bottom": [(node(i, 0), node(i + 1, 0)) for i in range(columns)],
            "outer": [(node(columns, j), node(columns, j + 1)) for j in range(rows)],
            "top": [(node(i + 1, rows), node(i, rows)) for i in reversed(range(columns))],
        }
    sets["BODY"] = sets["ROD"] + sets["PLATE"]
    edges = {"TIP": sides["ROD"]["bottom"], "TAIL": sides["ROD"]["top"],
             "EDGE": sides["PLATE"]["outer"], "TOP": sides["PLATE"]["top"]}
    return points, quads, sets, edges


POINTS, QUADS, SETS, EDGES = build()
#: Nodes of each boundary group, in ascending order.
NODES = {name: sorted({n for edge in edges for n in edge}) for name, edges in EDGES.items()}
#: Each quadrilateral cut along its first diagonal.
TRIANGLES = [t for a, b, c, d in QUADS for t in ((a, b, c), (a, c, d))]
TRIANGLE_SETS = {name: [t for q in cells for t in (2 * q, 2 * q + 1)] for name, cells in SETS.items()}
