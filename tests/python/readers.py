"""Reads a frame with several packages and prints number of cells, bounds, area and largest averaged PEEQ of each as JSON."""

import json
import sys

import meshio
import numpy
import pyvista
import vedo
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkFiltersCore import vtkCellDataToPointData
from vtkmodules.vtkFiltersVerdict import vtkCellSizeFilter
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader


def by_vtk(path):
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(path)
    sizes, averages = vtkCellSizeFilter(), vtkCellDataToPointData()
    sizes.SetInputConnection(reader.GetOutputPort())
    averages.SetInputConnection(reader.GetOutputPort())
    sizes.Update()
    averages.Update()
    grid = reader.GetOutput()
    area = vtk_to_numpy(sizes.GetOutput().GetCellData().GetArray("Area")).sum()
    largest = vtk_to_numpy(averages.GetOutput().GetPointData().GetArray("PEEQ")).max()
    return grid.GetNumberOfCells(), grid.GetBounds(), area, largest


def by_pyvista(path):
    grid = pyvista.read(path)
    area = grid.compute_cell_sizes()["Area"].sum()
    return grid.n_cells, grid.bounds, area, grid.cell_data_to_point_data()["PEEQ"].max()


def by_vedo(path):
    grid = vedo.UnstructuredGrid(path)
    area = grid.clone().compute_cell_size().celldata["Area"].sum()
    grid.map_cells_to_points(["PEEQ"])
    return grid.ncells, grid.bounds(), area, grid.pointdata["PEEQ"].max()


def by_meshio(path):
    mesh = meshio.read(path)
    (block,) = mesh.cells
    x, y = mesh.points[block.data][..., 0], mesh.points[block.data][..., 1]
    area = 0.5 * (x * numpy.roll(y, -1, 1) - numpy.roll(x, -1, 1) * y).sum()
    sums, counts = numpy.zeros(len(mesh.points)), numpy.zeros(len(mesh.points))
    for corner in block.data.T:
        numpy.add.at(sums, corner, mesh.cell_data["PEEQ"][0])
        numpy.add.at(counts, corner, 1)
    bounds = numpy.stack([mesh.points.min(0), mesh.points.max(0)], axis=1).ravel()
    return len(block.data), bounds, area, (sums / counts).max()


found = {}
for name, read in (("vtk", by_vtk), ("pyvista", by_pyvista), ("vedo", by_vedo), ("meshio", by_meshio)):
    cells, bounds, area, largest = read(sys.argv[1])
    found[name] = {
        "cells": int(cells),
        "bounds": [float(b) for b in bounds],
        "area": float(area),
        "peeq": float(largest),
    }
print(json.dumps(found))
