"""Warps the last frame of a series by U with the VTK library and prints extents and eigenvalues of S as JSON."""

import json
import os
import sys
from xml.etree import ElementTree

from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkDataObject
from vtkmodules.vtkFiltersGeneral import vtkWarpVector
from vtkmodules.vtkFiltersGeometry import vtkDataSetSurfaceFilter
from vtkmodules.vtkFiltersVerdict import vtkCellSizeFilter
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader


def last(pvd):
    """Return the reader of the last frame."""
    entry = list(ElementTree.parse(pvd).getroot().iter("DataSet"))[-1]
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(os.path.join(os.path.dirname(pvd), entry.get("file")))
    reader.Update()
    return reader


current, reference = last(sys.argv[1]), last(sys.argv[2])
warp = vtkWarpVector()
warp.SetInputConnection(reference.GetOutputPort())
warp.SetInputArrayToProcess(0, 0, 0, vtkDataObject.FIELD_ASSOCIATION_POINTS, "U")
warp.Update()
there = vtk_to_numpy(current.GetOutput().GetPoints().GetData())
warped = vtk_to_numpy(warp.GetOutput().GetPoints().GetData())
surface = vtkDataSetSurfaceFilter()
surface.SetInputConnection(current.GetOutputPort())
surface.Update()
sizes = vtkCellSizeFilter()
sizes.SetInputConnection(current.GetOutputPort())
sizes.Update()
cells = current.GetOutput().GetCellData()
grid = current.GetOutput()
used = sorted(
    {
        grid.GetCell(i).GetPointId(k)
        for i in range(grid.GetNumberOfCells())
        for k in range(grid.GetCell(i).GetNumberOfPoints())
    }
)
print(
    json.dumps(
        {
            "smallest": float(vtk_to_numpy(sizes.GetOutput().GetCellData().GetArray("Area")).min()),
            "unused": grid.GetNumberOfPoints() - len(used),
            "moved": float(abs(there - vtk_to_numpy(reference.GetOutput().GetPoints().GetData())).max()),
            "apart": float(abs(there - warped).max()),
            "cells": current.GetOutput().GetNumberOfCells(),
            "shown": surface.GetOutput().GetNumberOfCells(),
            "stress": [
                cells.GetArray("S").GetComponentName(i) for i in range(cells.GetArray("S").GetNumberOfComponents())
            ],
            "elements": vtk_to_numpy(cells.GetArray("ELEMENT")).tolist(),
            "materials": sorted(set(vtk_to_numpy(cells.GetArray("MATERIAL")).tolist())),
            "arrays": [
                current.GetOutput().GetPointData().GetArrayName(i)
                for i in range(current.GetOutput().GetPointData().GetNumberOfArrays())
            ],
        }
    )
)
