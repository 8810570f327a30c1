"""Writes the files of PyVista and VTK. Usage: write_pyvista.py FOLDER"""

import os
import sys

import numpy as np
import pyvista
import vtk

from model import NODES, POINTS, QUADS, SETS

os.chdir(sys.argv[1])


def grid(number):
    """Returns the mesh with one array per set."""
    cells = {vtk.VTK_QUAD: np.array(QUADS)}
    mesh = pyvista.UnstructuredGrid(cells, np.array([(r, z, 0.0) for r, z in POINTS]))
    for name, members in SETS.items():
        mesh.cell_data["ELSET_" + name] = np.isin(np.arange(len(QUADS)), members).astype(number)
    for name, members in NODES.items():
        mesh.point_data["NSET_" + name] = np.isin(np.arange(len(POINTS)), members).astype(number)
    return mesh


grid(np.uint8).save("pyvista_ascii.vtk", binary=False)
grid(np.uint8).save("pyvista_binary.vtk")
grid(np.uint8).save("pyvista_zlib.vtu")
grid(np.uint8).save("pyvista_ascii.vtu", binary=False)
grid(float).save("pyvista_double_ascii.vtk", binary=False)
grid(bool).save("pyvista_bool.vtu")
named = grid(np.uint8)
named.cell_data["thickness"] = np.ones(len(QUADS))
named.cell_data["velocity"] = np.zeros((len(QUADS), 3))
named.field_data["TimeValue"] = [0.0]
named.save("pyvista_vectors_field.vtu")
named.save("pyvista_vectors_field_ascii.vtk", binary=False)
grid(np.uint8).extract_surface().save("pyvista_polydata.vtp")
grid(np.uint8).extract_surface().save("pyvista_polydata_ascii.vtk", binary=False)

# The writers of VTK itself: legacy versions, compression and encoding.
for version, word in ((42, "42"), (51, "51")):
    writer = vtk.vtkUnstructuredGridWriter()
    writer.SetInputData(grid(np.int32))
    writer.SetFileVersion(version)
    writer.SetFileTypeToASCII()
    writer.SetFileName(f"vtk_legacy{word}.vtk")
    writer.Write()
for name, mode, compressor in (("ascii", "Ascii", "None"), ("zlib", "Binary", "ZLib"), ("lz4", "Appended", "LZ4"),
                               ("lzma", "Appended", "LZMA"), ("raw", "Appended", "None")):
    writer = vtk.vtkXMLUnstructuredGridWriter()
    writer.SetInputData(grid(np.int32))
    getattr(writer, f"SetDataModeTo{mode}")()
    getattr(writer, f"SetCompressorTypeTo{compressor}")()
    writer.SetEncodeAppendedData(False)
    writer.SetFileName(f"vtk_{name}.vtu")
    writer.Write()
