"""Writes the files of Netgen, MeshPy, pygmsh, medcoupling and pyNastran. Usage: write_others.py FOLDER TOOL"""

import math
import os
import sys

import numpy as np

from model import BODIES, EDGES, NODES, POINTS, QUADS, SETS, TRIANGLES, TRIANGLE_SETS

os.chdir(sys.argv[1])


def netgen():
    """Netgen meshes both bodies with triangles; the rod is domain 1, the plate domain 2."""
    from netgen.geom2d import SplineGeometry

    names = {"ROD": ["TIP", "SIDE", "TAIL", "AXIS"], "PLATE": ["BACK", "EDGE", "TOP", "AXIS2"]}
    geometry = SplineGeometry()
    for domain, (name, ((r0, r1), (z0, z1), _, _)) in enumerate(BODIES.items(), 1):
        # Netgen merges points of the outline that coincide: without the gap the bodies share the node on the axis.
        gap = 1e-4 if name == "ROD" else 0.0
        corners = [(r0, z0 + gap), (r1, z0 + gap), (r1, z1 + gap), (r0, z1 + gap)]
        p = [geometry.AppendPoint(*corner) for corner in corners]
        for i, side in enumerate(names[name]):
            geometry.Append(["line", p[i], p[(i + 1) % 4]], leftdomain=domain, rightdomain=0, bc=side)
        geometry.SetMaterial(domain, name)
    mesh = geometry.GenerateMesh(maxh=0.002)
    mesh.Export("netgen_abaqus.inp", "Abaqus Format")
    mesh.Export("netgen_gmsh2.msh", "Gmsh2 Format")


def meshpy():
    """Triangle, called by MeshPy, with a marker for each boundary and an attribute for each body."""
    import meshio
    from meshpy import triangle

    names = {"ROD": [1, 9, 2, 9], "PLATE": [9, 3, 4, 9]}
    label = {1: "TIP", 2: "TAIL", 3: "EDGE", 4: "TOP"}
    points, cells, sets, markers = [], [], {}, []
    for name, ((r0, r1), (z0, z1), _, _) in BODIES.items():
        info = triangle.MeshInfo()
        info.set_points([(r0, z0), (r1, z0), (r1, z1), (r0, z1)])
        info.set_facets([(0, 1), (1, 2), (2, 3), (3, 0)], facet_markers=names[name])
        mesh = triangle.build(info, max_volume=3e-6, min_angle=30, generate_faces=True)
        start, first = len(points), len(cells)
        points += [(x, y, 0.0) for x, y in mesh.points]
        cells += [[start + n for n in t] for t in mesh.elements]
        sets[name] = np.arange(first, len(cells))
        markers += [(m, start + n) for f, m in zip(mesh.faces, mesh.face_markers) for n in f]
    sets["BODY"] = np.arange(len(cells))
    groups = {label[i]: np.array(sorted({n for m, n in markers if m == i})) for i in label}
    out = meshio.Mesh(np.array(points), [("triangle", np.array(cells))],
                      cell_sets={n: [m] for n, m in sets.items()}, point_sets=groups)
    out.write("meshpy_meshio.inp")
    data = {f"ELSET_{n}": [np.isin(np.arange(len(cells)), m).astype(int)] for n, m in sets.items()}
    nodal = {f"NSET_{n}": np.isin(np.arange(len(points)), m).astype(int) for n, m in groups.items()}
    meshio.Mesh(out.points, out.cells, cell_data=data, point_data=nodal).write(
        "meshpy_meshio.vtk", file_format="vtk42", binary=False)


def pygmsh():
    """pygmsh names the groups; meshio and Gmsh write the files."""
    import gmsh
    import meshio
    import pygmsh as tool

    with tool.geo.Geometry() as geo:
        gmsh.option.setNumber("General.Terminal", 0)
        sides, faces = {}, {}
        for name, ((r0, r1), (z0, z1), columns, rows) in BODIES.items():
            p = [geo.add_point((x, y)) for x, y in ((r0, z0), (r1, z0), (r1, z1), (r0, z1))]
            sides[name] = [geo.add_line(p[i], p[(i + 1) % 4]) for i in range(4)]
            faces[name] = geo.add_plane_surface(geo.add_curve_loop(sides[name]))
            for side, count in zip(sides[name], (columns, rows, columns, rows)):
                geo.set_transfinite_curve(side, count + 1, "Progression", 1.0)
            geo.set_transfinite_surface(faces[name], "Left", [])
            geo.set_recombined_surfaces([faces[name]])
            geo.add_physical(faces[name], name)
        geo.add_physical(list(faces.values()), "BODY")
        for name, line in (("TIP", sides["ROD"][0]), ("TAIL", sides["ROD"][2]),
                           ("EDGE", sides["PLATE"][1]), ("TOP", sides["PLATE"][2])):
            geo.add_physical(line, name)
        mesh = geo.generate_mesh(dim=2)
        tool.write("pygmsh_gmsh.msh")
    # pygmsh also returns vertices, for which the ABAQUS writer of meshio has no element type.
    kept = [i for i, block in enumerate(mesh.cells) if block.type != "vertex"]
    # pygmsh numbers the members of a set over all blocks, meshio over each block: the sets of areas are shifted.
    # A block without members is None in pygmsh, which meshio refuses: it becomes an empty array.
    empty = np.array([], int)
    sets = {name: [empty if blocks[i] is None else blocks[i] for i in kept] for name, blocks in mesh.cell_sets.items()}
    mesh = meshio.Mesh(mesh.points, [mesh.cells[i] for i in kept], cell_sets=sets)
    mesh.write("pygmsh_meshio.inp")


def medcoupling():
    """medcoupling, the mesh library of Salome: .vtu, .med, and .med through Gmsh."""
    import gmsh
    import medcoupling as mc

    mesh = mc.MEDCouplingUMesh("mesh", 2)
    mesh.setCoords(mc.DataArrayDouble([x for p in POINTS for x in p], len(POINTS), 2))
    mesh.allocateCells(len(QUADS))
    for quad in QUADS:
        mesh.insertNextCell(mc.NORM_QUAD4, 4, list(quad))
    mesh.finishInsertingCells()
    lines = mc.MEDCouplingUMesh("mesh", 1)
    lines.setCoords(mesh.getCoords())
    pairs = [e for edges in EDGES.values() for e in edges]
    lines.allocateCells(len(pairs))
    for pair in pairs:
        lines.insertNextCell(mc.NORM_SEG2, 2, list(pair))
    lines.finishInsertingCells()

    def group(name, members):
        array = mc.DataArrayInt([int(m) for m in members])
        array.setName(name)
        return array

    file = mc.MEDFileUMesh()
    # The universal name contains the user, the date and the process number.
    file.setUnivNameWrStatus(False)
    file[0] = mesh
    file[-1] = lines
    file.setGroupsAtLevel(0, [group(n, m) for n, m in SETS.items()])
    first, members = 0, []
    for name, edges in EDGES.items():
        members.append(group(name, range(first, first + len(edges))))
        first += len(edges)
    file.setGroupsAtLevel(-1, members)
    file.setGroupsAtLevel(1, [group(n, m) for n, m in NODES.items()])
    file.write("medcoupling.med", 2)
    # Gmsh reads version 4.1 of the format.
    file.write41("for_gmsh.med", 2)
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.open("for_gmsh.med")
    os.remove("for_gmsh.med")
    gmsh.option.setNumber("Mesh.SaveGroupsOfNodes", 1)
    gmsh.write("gmsh_from_med.inp")
    gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
    gmsh.write("gmsh_from_med_msh41.msh")
    gmsh.option.setNumber("Mesh.MshFileVersion", 2.2)
    gmsh.write("gmsh_from_med_msh22.msh")
    gmsh.finalize()
    # One array for each set.
    fields = []
    for name, cells in SETS.items():
        field = mc.MEDCouplingFieldDouble(mc.ON_CELLS, mc.ONE_TIME)
        field.setMesh(mesh)
        field.setName("ELSET_" + name)
        field.setArray(mc.DataArrayDouble([float(i in set(cells)) for i in range(len(QUADS))]))
        field.setTime(0.0, 0, 0)
        fields.append(field)
    for name, nodes in NODES.items():
        field = mc.MEDCouplingFieldDouble(mc.ON_NODES, mc.ONE_TIME)
        field.setMesh(mesh)
        field.setName("NSET_" + name)
        field.setArray(mc.DataArrayDouble([float(i in set(nodes)) for i in range(len(POINTS))]))
        field.setTime(0.0, 0, 0)
        fields.append(field)
    mc.MEDCouplingFieldDouble.WriteVTK("medcoupling_binary.vtu", fields, True)
    mc.MEDCouplingFieldDouble.WriteVTK("medcoupling_ascii.vtu", fields, False)


def pynastran():
    """pyNastran reads decks with one block of elements, and writes them again."""
    from cpylog import SimpleLogger
    from pyNastran.converters.abaqus.abaqus import read_abaqus

    log = SimpleLogger("critical")
    def listed(values):
        return "".join(", ".join(str(v + 1) for v in values[i:i + 8]) + "\n" for i in range(0, len(values), 8))
    for word, element in (("cps4r", "CPS4R"), ("cax3", "CAX3")):
        cells, sets = (QUADS, SETS) if word == "cps4r" else (TRIANGLES, TRIANGLE_SETS)
        text = "*HEADING\nrod and plate\n*PART, NAME=BODIES\n*NODE\n"
        text += "".join(f"{i}, {r!r}, {z!r}, 0.\n" for i, (r, z) in enumerate(POINTS, 1))
        text += f"*ELEMENT, TYPE={element}, ELSET=ALL\n"
        text += "".join(f"{i}, " + ", ".join(str(n + 1) for n in cell) + "\n" for i, cell in enumerate(cells, 1))
        text += "".join(f"*ELSET, ELSET={n}\n{listed(m)}" for n, m in sets.items())
        text += "".join(f"*NSET, NSET={n}\n{listed(m)}" for n, m in NODES.items())
        text += "*SOLID SECTION, ELSET=ALL, MATERIAL=STEEL\n1.,\n*END PART\n"
        text += "*MATERIAL, NAME=STEEL\n*DENSITY\n7800.,\n*ELASTIC\n207.e9, 0.3\n"
        with open("input.tmp", "w") as file:
            file.write(text)
        model = read_abaqus("input.tmp", log=log)
        model.write(f"pynastran_{word}.inp")
        if word == "cps4r":
            # With is_2d=True the file has three coordinates, with is_2d=False it has two.
            model.write(f"pynastran_{word}_2d.inp", is_2d=True)
    os.remove("input.tmp")


globals()[sys.argv[2]]()
