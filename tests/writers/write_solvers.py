"""Writes the files of NGSolve, MFEM and Kratos, and of second-order and quadrilateral meshes of Netgen and MeshPy.
Usage: write_solvers.py FOLDER TOOL"""

import os
import sys

from model import BODIES, EDGES, NODES, POINTS, QUADS, SETS

os.chdir(sys.argv[1])


def outline():
    """Returns the outlines of both bodies for Netgen, with a gap that keeps their points apart."""
    from netgen.geom2d import SplineGeometry

    geometry = SplineGeometry()
    for domain, (name, ((r0, r1), (z0, z1), _, _)) in enumerate(BODIES.items(), 1):
        gap = 1e-4 if name == "ROD" else 0.0
        corners = [(r0, z0 + gap), (r1, z0 + gap), (r1, z1 + gap), (r0, z1 + gap)]
        p = [geometry.AppendPoint(*corner) for corner in corners]
        for i in range(4):
            geometry.Append(["line", p[i], p[(i + 1) % 4]], leftdomain=domain, rightdomain=0)
        geometry.SetMaterial(domain, name)
    return geometry


def ngsolve():
    """VTKOutput of NGSolve gives each element points of its own; Netgen writes the mesh of quadrilaterals."""
    from ngsolve import Mesh, VTKOutput

    netgen = outline().GenerateMesh(maxh=0.004, quad_dominated=True)
    netgen.Export("netgen_quads_gmsh2.msh", "Gmsh2 Format")
    mesh = Mesh(netgen)
    rod = mesh.MaterialCF({"ROD": 1}, default=0)
    for legacy in (False, True):
        VTKOutput(mesh, coefs=[rod], names=["rod"], filename="ngsolve_apart", subdivision=0, legacy=legacy).Do()
    triangles = outline().GenerateMesh(maxh=0.004)
    triangles.SecondOrder()
    triangles.Export("netgen_second_order_gmsh2.msh", "Gmsh2 Format")


def meshpy():
    """Triangle numbers the middle points by the opposite corners; VTK and meshio by the edges."""
    import meshio
    import numpy as np
    from meshpy import triangle

    points, cells, sets = [], [], {}
    for name, ((r0, r1), (z0, z1), _, _) in BODIES.items():
        info = triangle.MeshInfo()
        info.set_points([(r0, z0), (r1, z0), (r1, z1), (r0, z1)])
        info.set_facets([(0, 1), (1, 2), (2, 3), (3, 0)])
        mesh = triangle.build(info, max_volume=2e-5, min_angle=30, mesh_order=2)
        start, first = len(points), len(cells)
        points += [(x, y, 0.0) for x, y in mesh.points]
        cells += [[start + n for n in t] for t in mesh.elements]
        sets["ELSET_" + name] = range(first, len(cells))
    cells = np.array(cells)[:, [0, 1, 2, 5, 3, 4]]
    sets["ELSET_BODY"] = range(len(cells))
    data = {n: [np.isin(np.arange(len(cells)), list(m)).astype(int)] for n, m in sets.items()}
    out = meshio.Mesh(np.array(points), [("triangle6", cells)], cell_data=data)
    out.write("meshpy_second_order.vtk", file_format="vtk42", binary=False)


def mfem():
    """PrintVTK writes the mesh; PrintVTU and the collections for ParaView give each element points of its own."""
    import mfem.ser as tool

    mesh = tool.Mesh(2, len(POINTS), len(QUADS), sum(map(len, EDGES.values())), 2)
    for r, z in POINTS:
        mesh.AddVertex(r, z)
    rod = set(SETS["ROD"])
    for i, quad in enumerate(QUADS):
        mesh.AddQuad(*map(int, quad), 1 if i in rod else 2)
    for attribute, pairs in enumerate(EDGES.values(), 1):
        for a, b in pairs:
            mesh.AddBdrSegment(int(a), int(b), attribute)
    mesh.FinalizeQuadMesh(1, 0, True)
    mesh.PrintVTK("mfem.vtk")
    mesh.PrintVTU("mfem_apart", tool.VTKFormat_ASCII, False, 0)
    mesh.PrintVTU("mfem_high_order", tool.VTKFormat_ASCII, True, 0)


def kratos():
    """VtkOutput writes one file of the elements, and one for each sub-part."""
    import KratosMultiphysics as tool

    part = tool.Model().CreateModelPart("Main")
    part.ProcessInfo[tool.DOMAIN_SIZE] = 2
    for i, (r, z) in enumerate(POINTS, 1):
        part.CreateNewNode(i, r, z, 0.0)
    properties = part.CreateNewProperties(1)
    for i, quad in enumerate(QUADS, 1):
        part.CreateNewElement("Element2D4N", i, [int(n) + 1 for n in quad], properties)
    for name, members in NODES.items():
        part.CreateSubModelPart(name).AddNodes([int(n) + 1 for n in members])
    for word in ("ascii", "binary"):
        settings = tool.Parameters('{"model_part_name": "Main", "output_precision": 17, "write_ids": true}')
        settings.AddString("file_format", word)
        settings.AddString("output_path", ".")
        settings.AddString("custom_name_prefix", f"kratos_{word}_")
        tool.VtkOutput(part, settings).PrintOutput()
        os.rename(f"kratos_{word}_Main_0_0.vtk", f"kratos_{word}.vtk")


globals()[sys.argv[2]]()
