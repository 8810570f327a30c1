"""Writes the files of Gmsh. Usage: write_gmsh.py FOLDER"""

import os
import sys

import gmsh

from model import BODIES

os.chdir(sys.argv[1])
option = gmsh.option.setNumber


def build(in_two_groups=True, order=1, clockwise=False):
    """Builds the model. With in_two_groups, each surface is also in the group BODY."""
    gmsh.clear()
    geo = gmsh.model.geo
    surfaces, lines = {}, {}
    for name, ((r0, r1), (z0, z1), columns, rows) in BODIES.items():
        corners = [(r0, z0), (r1, z0), (r1, z1), (r0, z1)]
        p = [geo.addPoint(x, y, 0) for x, y in corners]
        sides = [geo.addLine(p[i], p[(i + 1) % 4]) for i in range(4)]
        loop = [-s for s in reversed(sides)] if clockwise else sides
        surfaces[name] = geo.addPlaneSurface([geo.addCurveLoop(loop)])
        for side, count in zip(sides, (columns, rows, columns, rows)):
            geo.mesh.setTransfiniteCurve(side, count + 1)
        geo.mesh.setTransfiniteSurface(surfaces[name])
        geo.mesh.setRecombine(2, surfaces[name])
        lines[name] = sides
    geo.synchronize()
    for name, surface in surfaces.items():
        gmsh.model.addPhysicalGroup(2, [surface], name=name)
    if in_two_groups:
        gmsh.model.addPhysicalGroup(2, list(surfaces.values()), name="BODY")
    for name, line in (("TIP", lines["ROD"][0]), ("TAIL", lines["ROD"][2]),
                       ("EDGE", lines["PLATE"][1]), ("TOP", lines["PLATE"][2])):
        gmsh.model.addPhysicalGroup(1, [line], name=name)
    option("Mesh.SecondOrderIncomplete", 1)
    gmsh.model.mesh.generate(2)
    if order == 2:
        gmsh.model.mesh.setOrder(2)


def write(name, **options):
    """Writes one file with options of the group Mesh, which are reset afterwards."""
    before = {key: gmsh.option.getNumber(f"Mesh.{key}") for key in options}
    for key, value in options.items():
        option(f"Mesh.{key}", value)
    gmsh.write(name)
    for key, value in before.items():
        option(f"Mesh.{key}", value)


gmsh.initialize()
option("General.Terminal", 0)
build()
for version, word in ((1, "msh10"), (2.2, "msh22"), (4.0, "msh40"), (4.1, "msh41")):
    write(f"gmsh_{word}.msh", MshFileVersion=version)
    if version in (2.2, 4.1):  # Gmsh writes versions 1 and 4.0 as text only.
        write(f"gmsh_{word}_binary.msh", MshFileVersion=version, Binary=1)
write("gmsh_edges.inp")
write("gmsh_node_groups.inp", SaveGroupsOfNodes=1)
write("gmsh_save_all.inp", SaveAll=1, SaveGroupsOfNodes=1)
write("gmsh_ascii.vtk")
write("gmsh_binary.vtk", Binary=1)
write("gmsh_save_all_msh41.msh", SaveAll=1, MshFileVersion=4.1)
option("Mesh.PartitionCreateGhostCells", 1)
gmsh.model.mesh.partition(3)
write("gmsh_partitioned_msh41.msh", MshFileVersion=4.1)
build(in_two_groups=False)
write("gmsh_msh22_one_group.msh", MshFileVersion=2.2)
write("gmsh_one_group.inp")
build(in_two_groups=False, clockwise=True)
write("gmsh_clockwise.inp", SaveGroupsOfNodes=1)
write("gmsh_clockwise_msh41.msh", MshFileVersion=4.1)
build(in_two_groups=False, order=2)
write("gmsh_8_nodes.inp")
gmsh.finalize()
