"""Draws the last frame of two series of a run, with deformed and with initial points, with pyvista into a folder.

Prints measurements of the pictures as JSON.

    python tests/python/pictures.py NOW.pvd START.pvd FOLDER
"""

import json
import os
import sys

import numpy
import pyvista
from vtkmodules.vtkCommonDataModel import vtkDataObject
from vtkmodules.vtkFiltersCore import vtkTensorGlyph
from vtkmodules.vtkFiltersSources import vtkSphereSource

SIZE = 500


def frame(path, index):
    """Return a frame of a series."""
    reader = pyvista.PVDReader(path)
    reader.set_active_time_value(reader.time_values[index])
    return reader.read()[0]


def picture(name, meshes, bounds=None):
    """Return the pixels of a picture of meshes, each with arguments of add_mesh."""
    plotter = pyvista.Plotter(off_screen=True, window_size=(SIZE, SIZE))
    plotter.set_background("white")
    for mesh, how in meshes:
        plotter.add_mesh(mesh, show_scalar_bar=False, **how)
    if bounds is None:
        plotter.camera_position = [(0.6, 0.45, -1.0), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0)]
        plotter.reset_camera()
    else:
        middle = [0.5 * (bounds[0] + bounds[1]), 0.5 * (bounds[2] + bounds[3])]
        plotter.camera_position = [(*middle, 100.0), (*middle, 0.0), (0.0, 1.0, 0.0)]
        plotter.enable_parallel_projection()
        plotter.camera.parallel_scale = 0.55 * max(bounds[1] - bounds[0], bounds[3] - bounds[2])
        plotter.camera.clipping_range = (1.0, 1000.0)
    plotter.show(auto_close=False)
    pixels = plotter.screenshot(os.path.join(sys.argv[3], name), return_img=True)
    plotter.close()
    return pixels


def drawn(pixels):
    """Return a mask of the pixels that are not background."""
    return (pixels[:, :, :3] < 250).any(axis=2)


def apart(first, second):
    """Return the number of pixels drawn in exactly one of two pictures."""
    return int((drawn(first) ^ drawn(second)).sum())


now, start = frame(sys.argv[1], -1), frame(sys.argv[2], -1)
everything = [
    min(now.bounds[0], start.bounds[0]),
    max(now.bounds[1], start.bounds[1]),
    min(now.bounds[2], start.bounds[2]),
    max(now.bounds[3], start.bounds[3]),
]
flat = {"scalars": "PEEQ", "cmap": "turbo", "lighting": False, "nan_color": "grey"}

deformed = picture("deformed.png", [(now, flat)], everything)
warped = picture("warped.png", [(start.warp_by_vector("U"), flat)], everything)
undeformed = picture("undeformed.png", [(start, flat)], everything)
found = {
    "gone": frame(sys.argv[1], 0).n_cells - now.n_cells,
    "drawn": int(drawn(deformed).sum()),
    "warped_differs": apart(deformed, warped),
    "undeformed_differs": apart(deformed, undeformed),
}

body = now.extract_surface(algorithm=None).extrude_rotate(
    rotation_axis=(0.0, 1.0, 0.0), angle=270.0, resolution=90, capping=True
)
picture("revolved.png", [(body, {**flat, "lighting": True})])
found["height"] = [body.bounds[2] - now.bounds[2], body.bounds[3] - now.bounds[3]]
found["width"] = [body.bounds[1] / now.bounds[1], body.bounds[5] / now.bounds[1]]

principal = numpy.linalg.eigvalsh(
    numpy.stack([numpy.array([[s[0], s[3], s[5]], [s[3], s[1], s[4]], [s[5], s[4], s[2]]]) for s in now.cell_data["S"]])
)
centres = now.cell_centers()
width = float(numpy.median(now.compute_cell_sizes(length=False, volume=False).cell_data["Area"])) ** 0.5
source, tensors = vtkSphereSource(), vtkTensorGlyph()
source.SetThetaResolution(64)
source.SetPhiResolution(64)
tensors.SetInputData(centres)
tensors.SetInputArrayToProcess(0, 0, 0, vtkDataObject.FIELD_ASSOCIATION_POINTS, "S")
tensors.SetSourceConnection(source.GetOutputPort())
tensors.ExtractEigenvaluesOn()
tensors.SetColorModeToEigenvalues()
scale = width / float(numpy.abs(principal).max())
tensors.SetScaleFactor(scale)
tensors.Update()
shapes = pyvista.wrap(tensors.GetOutput())
colours = {"scalars": shapes.point_data.keys()[0], "cmap": "turbo"}
picture("tensors.png", [(now, {"style": "wireframe", "color": "lightgrey"}), (shapes, colours)], now.bounds)
# The glyph of a sphere of diameter 1 is as long as the largest eigenvalue times the scale.
each = shapes.points.reshape(now.n_cells, -1, 3)
across = each - each.mean(axis=1, keepdims=True)
found["glyph"] = float(
    max(
        abs(2.0 * numpy.linalg.norm(across[i], axis=1).max() / scale / numpy.abs(principal[i]).max() - 1.0)
        for i in range(now.n_cells)
        if numpy.abs(principal[i]).max() > 0.1 * numpy.abs(principal).max()
    )
)
print(json.dumps(found))
