"""Reads a PVD series with the VTK library and prints its contents as JSON."""

import json
import os
import sys
from xml.etree import ElementTree

from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader


def arrays(data):
    found = {}
    for i in range(data.GetNumberOfArrays()):
        array = data.GetArray(i)
        found[array.GetName()] = {
            "components": array.GetNumberOfComponents(),
            "names": [array.GetComponentName(c) for c in range(array.GetNumberOfComponents())],
            "type": array.GetDataTypeAsString(),
            "values": vtk_to_numpy(array).tolist(),
        }
    return found


def frame(path):
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(path)
    reader.Update()
    assert reader.GetErrorCode() == 0, path
    grid = reader.GetOutput()
    return {
        "points": vtk_to_numpy(grid.GetPoints().GetData()).tolist(),
        "cell_types": [grid.GetCellType(i) for i in range(grid.GetNumberOfCells())],
        "time": grid.GetFieldData().GetArray("TimeValue").GetValue(0),
        "point": arrays(grid.GetPointData()),
        "cell": arrays(grid.GetCellData()),
    }


series = []
for entry in ElementTree.parse(sys.argv[1]).getroot().iter("DataSet"):
    path = os.path.join(os.path.dirname(sys.argv[1]), entry.get("file"))
    series.append({"timestep": float(entry.get("timestep")), **frame(path)})
print(json.dumps(series))
