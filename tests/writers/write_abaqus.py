"""Writes decks in the manner of ABAQUS/CAE: parts, moved instances, surfaces. Usage: write_abaqus.py FOLDER

ABAQUS itself is not used. The cards and their order are those of the Keywords Reference Guide.
"""

import os
import sys

from model import EDGES, NODES, POINTS, QUADS, SETS

os.chdir(sys.argv[1])
#: First node, node after the last, first element and element after the last of each body.
RODS = len(SETS["ROD"])
NODES_OF_ROD = 1 + max(n for quad in QUADS[:RODS] for n in quad)
RANGES = {"ROD": (0, NODES_OF_ROD, 0, RODS), "PLATE": (NODES_OF_ROD, len(POINTS), RODS, len(QUADS))}


def listed(values, count=16):
    return "".join(", ".join(str(v) for v in values[i:i + count]) + "\n" for i in range(0, len(values), count))


def part(name, place, element="CAX4R"):
    """Returns a part, numbered from 1, with the coordinates that `place` returns."""
    first, last, start, end = RANGES[name]
    text = f"*Part, name={name}\n*Node\n"
    text += "".join(f"{i:7d}, {r:.16g}, {z:.16g}\n"
                    for i, (r, z) in enumerate((place(*p) for p in POINTS[first:last]), 1))
    text += f"*Element, type={element}\n"
    text += "".join(f"{i}, " + ", ".join(str(n + 1 - first) for n in quad) + "\n"
                    for i, quad in enumerate(QUADS[start:end], 1))
    text += f"*Elset, elset={name}, generate\n 1, {end - start}, 1\n"
    text += f"*Nset, nset={name}, generate\n 1, {last - first}, 1\n"
    return text


#: Sides of the boundary groups: body, face number, set of elements of that face.
FACES = {"TIP": ("ROD", "S1"), "TAIL": ("ROD", "S3"), "EDGE": ("PLATE", "S2"), "TOP": ("PLATE", "S3")}


def face_elements(group):
    """Returns the elements of a boundary group, numbered from 1 in their part."""
    start, end = RANGES[FACES[group][0]][2:]
    edges = [set(e) for e in EDGES[group]]
    return [i - start + 1 for i in range(start, end) if any(e <= set(QUADS[i]) for e in edges)]


def deck(rod, plate, places, sections):
    """Returns parts, instances with their data lines, and the sets and surfaces of the assembly."""
    text = "*Heading\n** Generated in the manner of ABAQUS/CAE\n*Preprint, echo=NO, model=NO, history=NO, contact=NO\n**\n"
    for name, place in (("ROD", rod), ("PLATE", plate)):
        text += part(name, place)
        if sections:
            text += f"*Solid Section, elset={name}, material={'STEEL' if name == 'ROD' else 'ALUMINIUM'}\n,\n"
        text += "*End Part\n**\n"
    text += "*Assembly, name=Assembly\n**\n"
    for name, lines in places.items():
        text += f"*Instance, name={name}-1, part={name}\n{lines}*End Instance\n**\n"
    for name, members in NODES.items():
        body = FACES[name][0]
        text += f"*Nset, nset={name}, instance={body}-1\n{listed([n + 1 - RANGES[body][0] for n in members])}"
    for name in ("ROD", "PLATE"):
        text += f"*Elset, elset={name}, instance={name}-1, generate\n 1, {RANGES[name][3] - RANGES[name][2]}, 1\n"
    text += "*Elset, elset=BODY\nROD, PLATE\n"
    for name, (body, face) in FACES.items():
        text += f"*Elset, elset=_{name}_{face}, internal, instance={body}-1\n{listed(face_elements(name))}"
        text += f"*Surface, type=ELEMENT, name={name}\n_{name}_{face}, {face}\n"
    return text + "*End Assembly\n"


def flat(element="CAX4R", order=lambda quad: quad):
    """Returns the same mesh without parts."""
    text = "*Heading\n** The mesh of the deck with instances, without parts\n*Node\n"
    text += "".join(f"{i}, {r:.16g}, {z:.16g}\n" for i, (r, z) in enumerate(POINTS, 1))
    for name in ("ROD", "PLATE"):
        start, end = RANGES[name][2:]
        text += f"*Element, type={element}, elset={name}\n"
        text += "".join(f"{i + 1}, " + ", ".join(str(n + 1) for n in order(QUADS[i])) + "\n" for i in range(start, end))
    text += "*Elset, elset=BODY\nROD, PLATE\n"
    text += "".join(f"*Nset, nset={n}\n{listed([m + 1 for m in members])}" for n, members in NODES.items())
    for name, (body, face) in FACES.items():
        members = [e + RANGES[body][2] for e in face_elements(name)]
        text += f"*Elset, elset=_{name}_{face}, internal\n{listed(members)}"
        text += f"*Surface, type=ELEMENT, name={name}\n_{name}_{face}, {face}\n"
    return text


def save(name, text):
    with open(name, "w") as file:
        file.write(text)


# The rod is drawn at z = 0 and moved by a translation; the plate has no data line.
save("abaqus_instances_translated.inp",
     deck(lambda r, z: (r, z - 0.006), lambda r, z: (r, z), {"ROD": "          0.,        0.006,           0.\n", "PLATE": ""}, True))
# The rod is drawn along x with its axis at y = 0. The translation is applied first, then the rotation by 90 degrees.
save("abaqus_instances_rotated.inp",
     deck(lambda r, z: (z - 0.006, -r), lambda r, z: (r, z),
          {"ROD": "       0.006,           0.,           0.\n 0., 0., 0., 0., 0., 1., 90.\n", "PLATE": ""}, True))
save("abaqus_flat.inp", flat())
# The types of quadrilaterals that other programs write.
for word in ("CAX4", "CAX4P", "CPE4R", "CPS4", "S4"):
    save(f"abaqus_type_{word.lower()}.inp", flat(word))
