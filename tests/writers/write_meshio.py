"""Writes the files of meshio. Usage: write_meshio.py FOLDER"""

import os
import sys

import meshio
import numpy as np

from model import EDGES, NODES, POINTS, QUADS, SETS, TRIANGLE_SETS, TRIANGLES

os.chdir(sys.argv[1])
points = np.array([(r, z, 0.0) for r, z in POINTS])
nodes = {name: np.array(members) for name, members in NODES.items()}


def mesh(cells=QUADS, sets=SETS, shape="quad", edges=False, clockwise=False, **data):
    """Returns a mesh of one block of area elements, after one block of lines for each boundary group."""
    area = np.array(cells)
    if clockwise:
        area = area[:, ::-1]
    blocks = [("line", np.array(pairs)) for pairs in EDGES.values()] if edges else []
    groups = {}
    for i, name in enumerate(EDGES if edges else ()):
        groups[name] = [np.arange(len(b[1])) if j == i else np.array([], int) for j, b in enumerate(blocks)]
        groups[name].append(np.array([], int))
    for name, members in sets.items():
        groups[name] = [np.array([], int) for _ in blocks] + [np.array(members)]
    return meshio.Mesh(points, [*blocks, (shape, area)], cell_sets=groups, **data)


# ABAQUS: sets of elements and nodes, without and with the lines of the boundary.
mesh(point_sets=nodes).write("meshio_abaqus.inp")
mesh(edges=True).write("meshio_abaqus_edges.inp")
mesh(clockwise=True, point_sets=nodes).write("meshio_abaqus_clockwise.inp")
mesh(TRIANGLES, TRIANGLE_SETS, "triangle", point_sets=nodes).write("meshio_abaqus_triangles.inp")

# VTK and VTU: sets by cell_sets become one array; sets as separate arrays keep their members.
def arrays(number):
    """Returns point and cell arrays in the names that Revolve reads."""
    cell = {f"ELSET_{n}": [np.isin(np.arange(len(QUADS)), m).astype(number)] for n, m in SETS.items()}
    point = {f"NSET_{n}": np.isin(np.arange(len(POINTS)), m).astype(number) for n, m in nodes.items()}
    return {"cell_data": cell, "point_data": point}


def with_arrays(number=np.int64, **options):
    return mesh(sets={}, **arrays(number), **options)


# The format "vtk51" of meshio writes version 4.2; "vtk" writes version 5.1.
with_arrays().write("meshio_vtk42.vtk", file_format="vtk42", binary=False)
with_arrays().write("meshio_vtk51.vtk", file_format="vtk", binary=False)
with_arrays(float).write("meshio_vtk42_float.vtk", file_format="vtk42", binary=False)
with_arrays().write("meshio_vtk42_binary.vtk", file_format="vtk42", binary=True)
with_arrays().write("meshio_vtk51_binary.vtk", file_format="vtk", binary=True)
with_arrays().write("meshio_ascii.vtu", binary=False)
with_arrays().write("meshio_none.vtu", compression=None)
with_arrays().write("meshio_zlib.vtu", compression="zlib")
with_arrays(np.uint8).write("meshio_zlib_uint8.vtu", compression="zlib")
with_arrays(clockwise=True).write("meshio_zlib_clockwise.vtu", compression="zlib")
mesh().write("meshio_cell_sets.vtu", compression="zlib")
mesh().write("meshio_cell_sets_vtk51.vtk", file_format="vtk", binary=False)
mesh(edges=True).write("meshio_edges_cell_sets.vtu", compression="zlib")

# Gmsh: one physical tag for each cell, with the names in field_data.
tags = {"TIP": (1, 1), "TAIL": (2, 1), "EDGE": (3, 1), "TOP": (4, 1), "ROD": (5, 2), "PLATE": (6, 2)}
tagged = mesh(sets={}, edges=True)
physical = [np.full(len(pairs), tags[name][0]) for name, pairs in EDGES.items()]
physical.append(np.where(np.isin(np.arange(len(QUADS)), SETS["ROD"]), 5, 6))
tagged.cell_sets = {}
tagged.cell_data = {"gmsh:physical": physical, "gmsh:geometrical": [p.copy() for p in physical]}
tagged.field_data = {name: np.array(value) for name, value in tags.items()}
# Tags are 32-bit integers in the files of Gmsh.
tagged.cell_data = {k: [v.astype(np.int32) for v in values] for k, values in tagged.cell_data.items()}
tagged.write("meshio_msh22.msh", file_format="gmsh22", binary=False)
tagged.write("meshio_msh22_binary.msh", file_format="gmsh22", binary=True)
# Version 4.1 with two dimensions of cells needs an entity for each point: meshio has them after it has read a file of Gmsh.
only = meshio.Mesh(points, tagged.cells[-1:], cell_data={k: v[-1:] for k, v in tagged.cell_data.items()},
                   field_data=tagged.field_data)
only.write("meshio_msh41.msh", file_format="gmsh", binary=False)
meshio.read("gmsh_msh41.msh").write("meshio_from_gmsh_msh41.msh", file_format="gmsh", binary=False)
meshio.read("gmsh_msh41.msh").write("meshio_from_gmsh.inp")
# meshio cannot write the sets of this file to .vtu (IndexError in gmsh:bounding_entities): the sets are deleted.
read = meshio.read("gmsh_msh41.msh")
read.cell_sets = {}
read.write("meshio_from_gmsh.vtu", compression="zlib")
meshio.read("gmsh_node_groups.inp").write("meshio_from_gmsh_inp.inp")
