"""Writes all mesh files with the installed tools. Usage: write.py FOLDER

Each tool writes the full mesh (280 quadrilaterals) and a coarse mesh (24 quadrilaterals) of the same bodies.
The full mesh is kept for the main files of each tool, the coarse mesh for the variants.
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
TARGET = os.path.abspath(sys.argv[1])

#: Files of which the full mesh is kept.
FULL = """
abaqus_flat.inp abaqus_instances_translated.inp abaqus_instances_rotated.inp
cgx_s4.inp cgx_edge.sur cgx_tail.sur cgx_tip.sur cgx_top.sur
freecad_all.inp freecad_highest.inp freecad_export.inp freecad_calculix.inp freecad.vtu
gmsh_msh22.msh gmsh_msh41.msh gmsh_node_groups.inp gmsh_ascii.vtk gmsh_from_med.inp gmsh_from_med_msh41.msh
medcoupling_ascii.vtu medcoupling_binary.vtu
meshio_abaqus.inp meshio_abaqus_edges.inp meshio_vtk42.vtk meshio_vtk51.vtk meshio_ascii.vtu meshio_zlib.vtu
meshio_cell_sets.vtu meshio_from_gmsh.vtu
meshpy_meshio.inp meshpy_meshio.vtk meshpy_second_order.vtk
netgen_abaqus.inp netgen_gmsh2.msh netgen_quads_gmsh2.msh netgen_second_order_gmsh2.msh
pynastran_cps4r.inp pynastran_cax3.inp
pyvista_ascii.vtk pyvista_zlib.vtu
vtk_lz4.vtu vtk_zlib.vtu
""".split()

#: Tools that make their own triangles: their mesh does not depend on MESH.
OWN = ("netgen", "meshpy")


#: Runs a program at a fixed time: the objects of a .med file (HDF5) have time stamps.
FIXED_TIME = ["faketime", "-f", "2000-01-01 00:00:00"]


def commands(folder):
    """Returns the commands of all tools, and additions to their environment."""
    python = [sys.executable]
    freecad = {"MODEL": HERE, "FOLDER": folder, "HOME": folder}
    yield python + ["write_gmsh.py", folder], {}
    yield python + ["write_meshio.py", folder], {}
    yield python + ["write_pyvista.py", folder], {}
    for tool in ("netgen", "meshpy", "pygmsh", "medcoupling", "pynastran"):
        yield (FIXED_TIME if tool == "medcoupling" else []) + python + ["write_others.py", folder, tool], {}
    # They need another version of NumPy than pyNastran and medcoupling.
    solvers = [os.environ["SOLVERS_PYTHON"]]
    for tool in ("ngsolve", "meshpy", "mfem", "kratos"):
        yield solvers + ["write_solvers.py", folder, tool], {}
    yield python + ["write_cgx.py", folder], {}
    yield python + ["write_abaqus.py", folder], {}
    yield FIXED_TIME + ["freecadcmd", os.path.join(HERE, "write_freecad.py")], freecad


def write(mesh, folder):
    for command, added in commands(folder):
        environment = os.environ | {"MESH": mesh, "PYTHONDONTWRITEBYTECODE": "1", "PYTHONHASHSEED": "0"} | added
        done = subprocess.run(command, cwd=HERE, env=environment, stdin=subprocess.DEVNULL, capture_output=True,
                              text=True, timeout=300)
        if done.returncode != 0:
            sys.exit(f"{' '.join(command[-2:])} failed:\n{done.stdout[-2000:]}{done.stderr[-2000:]}")


def scrub(path):
    """Removes dates and folders from a text file. Binary files are only searched."""
    data = open(path, "rb").read()
    if os.path.basename(path).startswith("freecad"):
        data = re.sub(rb"(written on    -->)[^\n]*", rb"\1", data)
        data = re.sub(rb"(file name     -->)[^\n]*", rb"\1", data)
        open(path, "wb").write(data)
    host = os.uname().nodename.encode()
    private = [b"/tmp/", b"/home/", b"/root/", HERE.encode(), rb"\d\d:\d\d:\d\d", rb"20\d\d-\d\d-\d\d"]
    private += [rb"\b" + re.escape(host) + rb"\b"] if len(host) > 3 else []
    for pattern in private:
        if re.search(pattern, data):
            sys.exit(f"{os.path.basename(path)} contains {pattern!r}")


with tempfile.TemporaryDirectory() as scratch:
    folders = {}
    for mesh in ("full", "coarse"):
        folders[mesh] = os.path.join(scratch, mesh)
        os.mkdir(folders[mesh])
        write(mesh, folders[mesh])
    for name in sorted(os.listdir(folders["full"])):
        stem, ending = os.path.splitext(name)
        if os.path.isdir(os.path.join(folders["full"], name)) or ending not in (
                ".inp", ".msh", ".vtk", ".vtu", ".vtp", ".med", ".unv", ".sur"):
            continue
        if name not in FULL and stem.startswith(OWN):
            continue
        mesh, saved = ("full", name) if name in FULL else ("coarse", f"{stem}_coarse{ending}")
        shutil.copy(os.path.join(folders[mesh], name), os.path.join(TARGET, saved))
        scrub(os.path.join(TARGET, saved))
    missing = [n for n in FULL if not os.path.exists(os.path.join(TARGET, n))]
    if missing:
        sys.exit(f"not written: {missing}")
