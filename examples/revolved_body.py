"""The body of revolution of a frame: a .vtp for ParaView, and a picture.

    revolve run input/taylor_copper.inp
    python examples/revolved_body.py out/taylor_copper/taylor_copper.pvd PEEQ body.vtp body.png

Needs the `vtk` wheel (pip install vtk). In ParaView: Extract Surface, Rotational Extrusion with the axis (0, 1, 0), the axis
of symmetry.
"""
import os
import sys
import xml.etree.ElementTree as ElementTree

import vtkmodules.vtkInteractionStyle  # noqa: F401
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401
from vtkmodules.vtkCommonCore import vtkLookupTable
from vtkmodules.vtkFiltersGeometry import vtkGeometryFilter
from vtkmodules.vtkFiltersModeling import vtkRotationalExtrusionFilter
from vtkmodules.vtkIOImage import vtkPNGWriter
from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter, vtkXMLUnstructuredGridReader
from vtkmodules.vtkRenderingCore import (
    vtkActor,
    vtkPolyDataMapper,
    vtkRenderer,
    vtkRenderWindow,
    vtkWindowToImageFilter,
)

ANGLE = 270.0
PARTS = 90


def last_frame(pvd):
    """Path of the last frame of a series."""
    entries = list(ElementTree.parse(pvd).getroot().iter("DataSet"))
    return os.path.join(os.path.dirname(pvd), entries[-1].get("file"))


def revolved(path):
    """Return the outline of the frame, rotated about the axis."""
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(path)
    reader.Update()
    surface = vtkGeometryFilter()
    surface.SetInputConnection(reader.GetOutputPort())
    turned = vtkRotationalExtrusionFilter()
    turned.SetInputConnection(surface.GetOutputPort())
    turned.SetRotationAxis(0.0, 1.0, 0.0)
    turned.SetAngle(ANGLE)
    turned.SetResolution(PARTS)
    turned.Update()
    return turned.GetOutput()


def picture(body, array, path):
    """Write a picture of the body, coloured by a cell or point array."""
    mapper = vtkPolyDataMapper()
    mapper.SetInputData(body)
    over_cells = body.GetCellData().HasArray(array)
    data = body.GetCellData() if over_cells else body.GetPointData()
    if not data.HasArray(array):
        sys.exit(f"the frame has no array {array}")
    (mapper.SetScalarModeToUseCellFieldData if over_cells else mapper.SetScalarModeToUsePointFieldData)()
    mapper.SelectColorArray(array)
    blue_to_red = vtkLookupTable()
    blue_to_red.SetHueRange(2 / 3, 0.0)
    mapper.SetLookupTable(blue_to_red)
    mapper.SetScalarRange(data.GetArray(array).GetRange())
    actor = vtkActor()
    actor.SetMapper(mapper)
    renderer = vtkRenderer()
    renderer.SetBackground(1.0, 1.0, 1.0)
    renderer.AddActor(actor)
    camera = renderer.GetActiveCamera()
    camera.Azimuth(-35.0)
    camera.Elevation(20.0)
    renderer.ResetCamera()
    window = vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetSize(900, 900)
    window.AddRenderer(renderer)
    window.Render()
    image = vtkWindowToImageFilter()
    image.SetInput(window)
    writer = vtkPNGWriter()
    writer.SetFileName(path)
    writer.SetInputConnection(image.GetOutputPort())
    writer.Write()


if __name__ == "__main__":
    if len(sys.argv) < 4:
        sys.exit(__doc__)
    result = revolved(last_frame(sys.argv[1]))
    output = vtkXMLPolyDataWriter()
    output.SetFileName(sys.argv[3])
    output.SetInputData(result)
    output.Write()
    print(f"{sys.argv[3]}: {result.GetNumberOfCells()} cells")
    if len(sys.argv) > 4:
        picture(result, sys.argv[2], sys.argv[4])
