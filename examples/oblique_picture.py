"""A body in oblique impact: three frames of a run with the pressure on its surface, and the inclined front of the target.

    revolve run input/oblique.inp --set V=400. --set obliquity=65. --out out/oblique
    python examples/oblique_picture.py out/oblique/oblique.pvd oblique.png

Needs pyvista (pip install pyvista). In ParaView: open the .pvd and colour by PRESSURE.
"""
import json
import math
import sys

import pyvista

PARTS = (0.15, 0.3, 0.6)


def front(path, size):
    """The front of the first target, from the summary next to the frames."""
    with open(path.removesuffix(".pvd") + ".json") as file:
        target = json.load(file)["scene"]["targets"][0]
    angle = math.radians(target.get("obliquity", 0.0))
    normal = (-math.sin(angle), math.cos(angle), 0.0)
    return pyvista.Plane(
        center=(0.0, target["front"], 0.0), direction=normal, i_size=size, j_size=0.6 * size, i_resolution=1, j_resolution=1
    )


def main(series, picture):
    reader = pyvista.PVDReader(series)
    plotter = pyvista.Plotter(off_screen=True, shape=(1, len(PARTS)), window_size=(1500, 620), border=False)
    plotter.set_background("white")
    frames = []
    for part in PARTS:
        reader.set_active_time_value(reader.time_values[round(part * (len(reader.time_values) - 1))])
        frames.append((reader.active_time_value, reader.read()[0]))
    # The deck is in m, kg and s.
    for _, frame in frames:
        frame.cell_data["PRESSURE"] = 1e-6 * frame.cell_data["PRESSURE"]
    highest = max(frame.cell_data["PRESSURE"].max() for _, frame in frames)
    for column, (time, frame) in enumerate(frames):
        plotter.subplot(0, column)
        body = plotter.add_mesh(frame, scalars="PRESSURE", clim=(0.0, highest), cmap="YlOrRd", show_scalar_bar=False)
        plotter.add_mesh(front(series, 3.0 * frame.length / 2.0), color="tan", opacity=0.45)
        if column == 1:
            bar = {"vertical": False, "position_x": 0.1, "position_y": 0.04, "width": 0.8, "height": 0.06}
            plotter.add_scalar_bar("PRESSURE, MPa", mapper=body.mapper, n_labels=4, fmt="%.0f", title_font_size=18, label_font_size=16, **bar)
        plotter.add_text(f"{1e6 * time:.0f} µs", font_size=11, color="black")
        plotter.camera_position = [(0.0, 0.0, 1.0), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0)]
        plotter.camera.azimuth = 12.0
        plotter.camera.elevation = 8.0
        plotter.reset_camera()
    plotter.screenshot(picture)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(sys.argv[1], sys.argv[2])
