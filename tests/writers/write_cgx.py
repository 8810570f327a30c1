"""Writes the files of CalculiX cgx. Usage: write_cgx.py FOLDER. The program cgx must be installed."""

import os
import subprocess
import sys
import tempfile

from model import BODIES

TARGET = sys.argv[1]
SIDES = {"ROD": {"TIP": 1, "TAIL": 3}, "PLATE": {"EDGE": 2, "TOP": 3}}


def commands(element):
    """Returns the commands of cgx. QU4 writes S4, QU4C writes CAX4, QU4S writes CPS4."""
    lines = []
    for name, ((r0, r1), (z0, z1), columns, rows) in BODIES.items():
        letter = name[0].lower()
        for i, (r, z) in enumerate([(r0, z0), (r1, z0), (r1, z1), (r0, z1)], 1):
            lines.append(f"pnt {letter}p{i} {r!r} {z!r} 0")
        for i, count in enumerate((columns, rows, columns, rows), 1):
            lines.append(f"line {letter}l{i} {letter}p{i} {letter}p{i % 4 + 1} {count}")
        lines.append(f"gsur {letter}s + BLEND + {letter}l1 + {letter}l2 + {letter}l3 + {letter}l4")
        lines.append(f"seta {name} s {letter}s")
    lines += [f"elty all {element}", "mesh all"]
    lines += ["comp ROD do", "comp PLATE do", "seta BODY se ROD PLATE"]
    for name, sides in SIDES.items():
        for group, i in sides.items():
            lines += [f"seta {group} l {name[0].lower()}l{i}", f"comp {group} do", f"comp {group} do"]
    lines.append("send all abq")
    lines += [f"send {name} abq nam" for name in ("ROD", "PLATE", "BODY", "TIP", "TAIL", "EDGE", "TOP")]
    lines += [f"send {name} abq sur" for name in ("TIP", "TAIL", "EDGE", "TOP")]
    lines += ["send ROD abq", "send PLATE abq", "quit"]
    return "\n".join(lines) + "\n"


def run(element):
    """Runs cgx in a temporary folder and returns the text of each file."""
    with tempfile.TemporaryDirectory() as folder:
        with open(os.path.join(folder, "mesh.fbd"), "w") as file:
            file.write(commands(element))
        subprocess.run(["cgx", "-bg", "mesh.fbd"], cwd=folder, check=True, timeout=120,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        return {n: open(os.path.join(folder, n)).read() for n in os.listdir(folder) if n != "mesh.fbd"}


def save(name, text):
    with open(os.path.join(TARGET, name), "w") as file:
        file.write(text)


for element, word in (("QU4", "s4"), ("QU4S", "cps4"), ("QU4C", "cax4"), ("QU4CR", "cax4r")):
    files = run(element)
    names = "".join(files[f"{n}.nam"] for n in ("ROD", "PLATE", "BODY", "TIP", "TAIL", "EDGE", "TOP"))
    # The mesh, then the sets, in the order in which a deck includes the files.
    save(f"cgx_{word}.inp", files["all.msh"] + names)
    if word == "s4":
        for group in ("TIP", "TAIL", "EDGE", "TOP"):
            save(f"cgx_{group.lower()}.sur", files[f"{group}.sur"])
    if word == "cax4":
        save("cgx_bodies.inp", files["ROD.msh"] + files["PLATE.msh"])
