"""Compares a VTKHDF file with the frames of a PVD series, as the VTK library reads them, and prints the numbers of steps."""

import json
import os
import sys
from xml.etree import ElementTree

import numpy
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOHDF import vtkHDFReader
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader


def arrays(grid):
    found = {
        "points": vtk_to_numpy(grid.GetPoints().GetData()),
        "connectivity": vtk_to_numpy(grid.GetCells().GetConnectivityArray()),
        "offsets": vtk_to_numpy(grid.GetCells().GetOffsetsArray()),
        "types": numpy.array([grid.GetCellType(i) for i in range(grid.GetNumberOfCells())]),
    }
    for place, data in (("point", grid.GetPointData()), ("cell", grid.GetCellData())):
        for i in range(data.GetNumberOfArrays()):
            found[place, data.GetArrayName(i)] = vtk_to_numpy(data.GetArray(i))
    return found


hdf, pvd = sys.argv[1:]
reader = vtkHDFReader()
assert reader.CanReadFile(hdf), hdf
reader.SetFileName(hdf)
reader.UpdateInformation()
entries = list(ElementTree.parse(pvd).getroot().iter("DataSet"))
cells = []
for step in range(reader.GetNumberOfSteps()):
    reader.SetStep(step)
    reader.Update()
    assert reader.GetTimeValue() == float(entries[step].get("timestep")), step
    frame = vtkXMLUnstructuredGridReader()
    frame.SetFileName(os.path.join(os.path.dirname(pvd), entries[step].get("file")))
    frame.Update()
    found, expected = arrays(reader.GetOutput()), arrays(frame.GetOutput())
    assert found.keys() >= expected.keys(), (step, expected.keys() - found.keys())
    for name in found.keys() - expected.keys():
        values, count = found[name], len(expected["points"] if name[0] == "point" else expected["types"])
        assert len(values) == count and (numpy.isnan(values) if values.dtype.kind == "f" else values == 0).all(), (
            step,
            name,
        )
    for name, values in expected.items():
        assert found[name].dtype == values.dtype, (step, name)
        assert numpy.array_equal(found[name], values, equal_nan=values.dtype.kind == "f"), (step, name)
    cells.append(len(expected["types"]))
print(json.dumps({"steps": len(cells), "frames": len(entries), "cells": cells}))
