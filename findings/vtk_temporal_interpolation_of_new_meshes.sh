#!/usr/bin/env bash
# VTK 9.7.0 (PyPI): vtkTemporalInterpolator ("Temporal Interpolator" of ParaView) on a series whose mesh changes, as after remeshing.
# Guess: between two frames with different meshes there is no interpolated value, or that of one frame, and a message says so.
# Happens: it warns "Interpolation aborted for array T because the number of tuples/components in each time step are different",
#   and then returns the array all the same, with values of both frames mixed by the index of the cell. At 0.75 between T = 0 on
#   2 cells and T = 10 on 3 cells: 2 cells of 7.5. Between 3 and 2 cells: 7.5, 7.5 and 0. With equal numbers of cells and other
#   places there is no message at all. vtkTemporalStatistics warns, too, but returns no array.
# Hurt: films and plots "between frames" of a body with new meshes show invented values. Show the frames as they are.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" -q install vtk==9.7.0
cat > "$folder/series.py" <<'PYTHON'
import sys
import vtk
from vtk.util.numpy_support import vtk_to_numpy
from vtk.util.vtkAlgorithm import VTKPythonAlgorithmBase

STEPS = vtk.vtkStreamingDemandDrivenPipeline


def strip(cells, value, length=1.0):
    """A row of quadrilaterals with the cell array T."""
    grid, points, array = vtk.vtkUnstructuredGrid(), vtk.vtkPoints(), vtk.vtkDoubleArray()
    for i in range(cells + 1):
        points.InsertNextPoint(length * i / cells, 0, 0)
        points.InsertNextPoint(length * i / cells, 1, 0)
    grid.SetPoints(points)
    array.SetName("T")
    for i in range(cells):
        grid.InsertNextCell(vtk.VTK_QUAD, 4, [2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1])
        array.InsertNextValue(value)
    grid.GetCellData().AddArray(array)
    return grid


class Series(VTKPythonAlgorithmBase):
    """Frames at the times 0 and 1."""

    def __init__(self, frames):
        super().__init__(nInputPorts=0, nOutputPorts=1, outputType="vtkUnstructuredGrid")
        self.frames = frames

    def RequestInformation(self, request, inputs, outputs):
        info = outputs.GetInformationObject(0)
        info.Set(STEPS.TIME_STEPS(), [0.0, 1.0], 2)
        info.Set(STEPS.TIME_RANGE(), [0.0, 1.0], 2)
        return 1

    def RequestData(self, request, inputs, outputs):
        info = outputs.GetInformationObject(0)
        time = info.Get(STEPS.UPDATE_TIME_STEP()) if info.Has(STEPS.UPDATE_TIME_STEP()) else 0.0
        grid = vtk.vtkUnstructuredGrid.GetData(outputs)
        grid.ShallowCopy(self.frames[round(time)])
        grid.GetInformation().Set(vtk.vtkDataObject.DATA_TIME_STEP(), float(round(time)))
        return 1


def values(grid):
    array = grid.GetCellData().GetArray("T")
    return None if array is None else vtk_to_numpy(array).round(6).tolist()


def interpolated(frames):
    messages = []
    source, between = Series(frames), vtk.vtkTemporalInterpolator()
    note = lambda *of_event: messages.append(of_event[-1])
    note.CallDataType = vtk.VTK_STRING
    between.AddObserver("WarningEvent", note)
    between.SetInputConnection(source.GetOutputPort())
    between.UpdateInformation()
    between.UpdateTimeStep(0.75)
    return values(between.GetOutputDataObject(0)), [m for m in messages if "array T" in m]


def statistics(frames):
    source, over = Series(frames), vtk.vtkTemporalStatistics()
    over.AddObserver("WarningEvent", lambda *_: None)
    over.SetInputConnection(source.GetOutputPort())
    over.Update()
    return over.GetOutputDataObject(0).GetCellData().GetNumberOfArrays()


two, three = ([strip(2, 0.0), strip(3, 10.0)], [strip(3, 0.0), strip(2, 10.0)])
elsewhere = [strip(2, 0.0), strip(2, 10.0, length=5.0)]
found = {
    "version": vtk.vtkVersion.GetVTKVersion(),
    "2 then 3 cells": interpolated(two)[0],
    "3 then 2 cells": interpolated(three)[0],
    "says that it is aborted": all("aborted" in "".join(interpolated(frames)[1]) for frames in (two, three)),
    "2 cells, elsewhere": interpolated(elsewhere),
    "arrays of the statistics": statistics(two),
}
expected = {
    "version": "9.7.0",
    "2 then 3 cells": [7.5, 7.5],
    "3 then 2 cells": [7.5, 7.5, 0.0],
    "says that it is aborted": True,
    "2 cells, elsewhere": ([7.5, 7.5], []),
    "arrays of the statistics": 0,
}
for name, value in found.items():
    print(f"{name}: {value}")
sys.exit(found != expected)
PYTHON
"$folder/venv/bin/python" "$folder/series.py"
