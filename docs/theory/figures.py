"""Draws the figures of the theory manual: `python3 docs/theory/figures.py` writes docs/theory/*.svg.

Standard library only. Figures have a white background, so that they can be read on light and dark pages.
"""

import itertools
import math
from pathlib import Path

INK, BLUE, RED, GREY, FILL = "#333", "#1f6fb4", "#c0392b", "#8a8a8a", "#dce9f5"


class Figure:
    """An SVG drawing with the origin at the lower left, in pixels."""

    def __init__(self, name: str, width: int, height: int, title: str) -> None:
        self.name, self.width, self.height, self.title, self.parts = name, width, height, title, []

    def points(self, points) -> str:
        return " ".join(f"{x:.2f},{self.height - y:.2f}" for x, y in points)

    def line(self, points, colour=INK, width=1.6, dash="", fill="none", close=False) -> None:
        tag, dashes = ("polygon" if close else "polyline"), (f' stroke-dasharray="{dash}"' if dash else "")
        self.parts.append(
            f'<{tag} points="{self.points(points)}" fill="{fill}" stroke="{colour}" stroke-width="{width}"'
            f' stroke-linejoin="round"{dashes}/>'
        )

    def arrow(self, start, end, colour=INK, width=1.6) -> None:
        (x, y), (u, v) = start, end
        size = math.hypot(u - x, v - y)
        c, s = (u - x) / size, (v - y) / size
        self.line([start, end], colour, width)
        head = [(u, v), (u - 9 * c - 4 * s, v - 9 * s + 4 * c), (u - 9 * c + 4 * s, v - 9 * s - 4 * c)]
        self.line(head, colour, 1, fill=colour, close=True)

    def dot(self, at, colour=INK, radius=3.2) -> None:
        x, y = at
        self.parts.append(f'<circle cx="{x:.2f}" cy="{self.height - y:.2f}" r="{radius}" fill="{colour}"/>')

    def text(self, at, text, colour=INK, anchor="middle", size=14) -> None:
        """Writes text; `_x` sets a subscript, `^x` a superscript of one character or of {several}."""
        x, y = at
        body, i = "", 0
        while i < len(text):
            if text[i] in "_^":
                shift, i = (4 if text[i] == "_" else -6), i + 1
                end = text.index("}", i) if text[i] == "{" else i
                inner = text[i + 1 : end] if text[i] == "{" else text[i]
                body += f'<tspan dy="{shift}" font-size="70%">{inner}</tspan><tspan dy="{-shift}">\u200b</tspan>'
                i = end + 1
            else:
                body += text[i].replace("&", "&amp;").replace("<", "&lt;")
                i += 1
        self.parts.append(
            f'<text x="{x:.1f}" y="{self.height - y:.1f}" fill="{colour}" font-size="{size}" text-anchor="{anchor}">'
            f"{body}</text>"
        )

    def write(self) -> None:
        head = (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {self.width} {self.height}" width="{self.width}"'
            f' height="{self.height}" font-family="sans-serif" role="img"><title>{self.title}</title>'
            f'<rect width="{self.width}" height="{self.height}" fill="white"/>'
        )
        text = "\n".join([head, *self.parts, "</svg>\n"])
        Path(__file__).with_name(f"{self.name}.svg").write_text(text, encoding="utf-8")


def facet() -> None:
    """A tangent ogive as a chain of facets."""
    f = Figure("facet", 520, 300, "A nose as a chain of facets")
    radius, psi, count = 95.0, 3.0, 5
    s = 2 * psi * radius
    start = math.asin((2 * psi - 1) / (2 * psi))
    height = s * math.cos(start)

    scale = 230 / height
    nodes = []
    for i in range(count + 1):
        angle = start + (math.pi / 2 - start) * i / count
        nodes.append((60 + (s * math.sin(angle) - (s - radius)) * 1.7, 30 + scale * (height - s * math.cos(angle))))
    f.line([(60, 15), (60, 285)], GREY, 1.2, "8 3 2 3")
    f.text((48, 272), "z", GREY)
    f.line([*nodes, (60, nodes[-1][1])], "none", 0, fill=FILL, close=True)
    f.line(nodes, BLUE, 2.4)
    for node in nodes:
        f.dot(node, BLUE)
    a, b = nodes[2], nodes[3]
    middle = ((a[0] + b[0]) / 2, (a[1] + b[1]) / 2)
    along = (b[0] - a[0], b[1] - a[1])
    size = math.hypot(*along)
    normal = (along[1] / size, -along[0] / size)
    f.arrow(middle, (middle[0] + 75 * normal[0], middle[1] + 75 * normal[1]), RED)
    f.text((middle[0] + 88 * normal[0], middle[1] + 88 * normal[1] - 4), "n", RED)
    f.arrow((middle[0], middle[1]), (middle[0], middle[1] - 82))
    f.text((middle[0] - 14, middle[1] - 72), "V")
    f.text((a[0] - 8, a[1] - 2), "(r_1, z_1)", BLUE, "end")
    f.text((b[0] + 12, b[1] - 2), "(r_2, z_2)", BLUE, "start")
    f.line([(60, middle[1]), middle], GREY, 1, "3 3")
    f.text((60 + (middle[0] - 60) / 2, middle[1] + 6), "r", GREY)
    f.text((310, 120), "area A = π (r_1 + r_2) L", anchor="start")
    f.text((310, 96), "normal velocity v_n = V |n_z|", anchor="start")
    f.text((310, 72), "pressure σ_n(v_n) against n", anchor="start")
    f.write()


def hourglass() -> None:
    """The two hourglass patterns of a square, and the pattern of a skewed element."""
    f = Figure("hourglass", 560, 210, "Hourglass patterns")
    square = [(0, 0), (1, 0), (1, 1), (0, 1)]
    skewed = [(0.0, 0.0), (1.15, 0.12), (0.85, 0.95), (-0.05, 0.75)]
    gamma = [1, -1, 1, -1]

    def operators(at):
        (a, b, c, d) = at
        area = 0.5 * ((c[0] - a[0]) * (d[1] - b[1]) - (d[0] - b[0]) * (c[1] - a[1]))
        by_x = [(b[1] - d[1]), (c[1] - a[1]), (d[1] - b[1]), (a[1] - c[1])]
        by_y = [(d[0] - b[0]), (a[0] - c[0]), (b[0] - d[0]), (c[0] - a[0])]
        return [x / (2 * area) for x in by_x], [y / (2 * area) for y in by_y]

    for index, (corners, way, label) in enumerate(
        [(square, 0, "along r"), (square, 1, "along z"), (skewed, 0, "γ of a skewed element")]
    ):
        b_x, b_y = operators(corners)
        g_x = sum(g * x for g, (x, _) in zip(gamma, corners))
        g_y = sum(g * y for g, (_, y) in zip(gamma, corners))
        shape = [g - g_x * p - g_y * q for g, p, q in zip(gamma, b_x, b_y)]
        left, low, scale = 45 + 180 * index, 60, 105
        place = [(left + scale * x, low + scale * y) for x, y in corners]
        moved = [(x + (18 * s if way == 0 else 0), y + (18 * s if way == 1 else 0)) for (x, y), s in zip(place, shape)]
        f.line(place, GREY, 1.4, "4 3", close=True)
        f.line(moved, BLUE, 2.2, fill=FILL, close=True)
        f.line(place, GREY, 1.4, "4 3", close=True)
        for start, end in zip(place, moved):
            f.arrow(start, end, RED, 1.6)
        f.dot((sum(p[0] for p in place) / 4, sum(p[1] for p in place) / 4))
        f.text((left + scale / 2, 22), label)
    f.write()


def return_mapping() -> None:
    """Radial return in the deviatoric plane, with hardening."""
    f = Figure("return-mapping", 480, 320, "Radial return")
    centre, old, new, angle = (190, 150), 90, 108, math.radians(36)

    def ring(radius):
        angles = [k / 40 * math.pi for k in range(81)]
        return [(centre[0] + radius * math.cos(a), centre[1] + radius * math.sin(a)) for a in angles]

    for k in range(3):
        t = math.radians(90 + 120 * k)
        f.line([centre, (centre[0] + 145 * math.cos(t), centre[1] + 145 * math.sin(t))], GREY, 1)
        f.text((centre[0] + 156 * math.cos(t), centre[1] + 156 * math.sin(t) - 5), f"s_{k + 1}", GREY)
    f.line(ring(old), BLUE, 2, fill="none")
    f.line(ring(new), BLUE, 2, "6 4")

    def at(radius, turn=0.0):
        return centre[0] + radius * math.cos(angle + turn), centre[1] + radius * math.sin(angle + turn)

    start = (centre[0] + 80 * math.cos(-0.1), centre[1] + 80 * math.sin(-0.1))
    f.dot(start)
    f.text((start[0] - 4, start[1] - 18), "s_n")
    f.arrow(start, at(190), GREY)
    f.text((330, 168), "2G Δe", GREY, "start")
    f.dot(at(190), RED)
    f.text((at(190)[0] + 10, at(190)[1] + 4), "s^{tr}", RED, "start")
    f.arrow(at(190), at(new), RED, 2)
    f.text((at(150)[0] - 12, at(150)[1] + 16), "3G Δε̄", RED, "end")
    f.dot(at(new))
    f.text((at(new)[0] - 6, at(new)[1] - 22), "s_{n+1}")
    f.text((centre[0] - 62, centre[1] - 112), "σ_y before", BLUE, "end", 12)
    f.text((centre[0] + 62, centre[1] - 122), "σ_y after hardening", BLUE, "start", 12)
    f.write()


def contact_gap() -> None:
    """The gap between two surfaces, with pieces and Gauss points."""
    f = Figure("contact-gap", 540, 280, "Contact gap")
    master = [(20, 60), (180, 96), (330, 92), (520, 50)]
    slave = [(40, 175), (210, 190), (380, 182), (505, 150)]
    f.line([*master, (520, 15), (20, 15)], "none", 0, fill="#eeeeee", close=True)
    f.line([*slave, (505, 260), (40, 260)], "none", 0, fill=FILL, close=True)
    f.line(master, INK, 2.2)
    f.line(slave, BLUE, 2.2)
    for node in master:
        f.dot(node)
    for node in slave:
        f.dot(node, BLUE)

    def nearest(p):
        best = None
        for (x, y), (u, v) in itertools.pairwise(master):
            c, s = u - x, v - y
            t = min(1, max(0, ((p[0] - x) * c + (p[1] - y) * s) / (c * c + s * s)))
            q = (x + t * c, y + t * s)
            d = math.hypot(p[0] - q[0], p[1] - q[1])
            best = min(best or (d, q), (d, q))
        return best[1]

    cuts = [0.0, 0.72, 1.0]
    (x, y), (u, v) = slave[1], slave[2]
    for low, high in itertools.pairwise(cuts):
        for g in (-1 / math.sqrt(3), 1 / math.sqrt(3)):
            t = 0.5 * (low + high) + 0.5 * (high - low) * g
            p = (x + t * (u - x), y + t * (v - y))
            f.line([p, nearest(p)], RED, 1.2, "4 3")
            f.dot(p, RED, 2.8)
    t = cuts[1]
    cut = (x + t * (u - x), y + t * (v - y))
    f.line([(cut[0], cut[1] - 10), (cut[0], cut[1] + 10)], BLUE, 1.6)
    # The hat function of the second point.
    hat = [(slave[0][0], slave[0][1] + 4), (slave[1][0], slave[1][1] + 44), (slave[2][0], slave[2][1] + 4)]
    f.line(hat, BLUE, 1.4, "2 3")
    f.text((slave[1][0] + 4, slave[1][1] + 50), "φ_a", BLUE)
    f.text((cut[0] + 8, cut[1] + 14), "cut", BLUE, "start", 12)
    f.text((228, 140), "(x − y)·n", RED, "end")
    f.text((90, 30), "other surface", INK, "start", 12)
    f.text((300, 240), "surface that carries pressures", BLUE, "start", 12)
    f.write()


def shock() -> None:
    """A piston drives a shock into a bar of cells (uniaxial strain), with and without bulk viscosity."""
    density, c0, s, piston, cells = 2785.0, 5328.0, 1.338, 500.0, 120
    exact = density * (c0 + s * piston) * piston
    front = c0 + s * piston

    def profile(b1, b2, end):
        h = 1.0 / cells
        x = [h * i for i in range(cells + 1)]
        v = [0.0] * (cells + 1)
        v[0], time, old = piston, 0.0, [0.0] * cells
        dt = 0.3 * h / c0
        while time < end:
            total = []
            for i in range(cells):
                size, rate = x[i + 1] - x[i], (v[i + 1] - v[i]) / (x[i + 1] - x[i])
                eta = 1 - size / h
                p = density * c0 * c0 * eta / (1 - s * eta) ** 2
                rho = density * h / size
                q = -rho * size * (b1 * c0 * rate - b2 * b2 * size * rate * min(0.0, rate)) if rate else 0.0
                total.append((p + q, p))
            for i in range(1, cells):
                v[i] += dt * (total[i - 1][0] - total[i][0]) / (density * h)
            for i in range(cells + 1):
                x[i] += dt * v[i]
            time += dt
            old = [p for _, p in total]
        return [(0.5 * (x[i] + x[i + 1]), old[i] / exact) for i in range(cells)]

    f = Figure("shock", 560, 290, "Shock in a bar of elements")
    left, low, wide, high = 60, 50, 470, 150
    end = 0.62 / front
    f.line([(left, low + 1.55 * high), (left, low), (left + wide, low)], INK, 1.2)
    for value in (0.0, 0.5, 1.0, 1.5):
        f.text((left - 8, low + value * high - 4), f"{value:.1f}", anchor="end", size=12)
        f.line([(left - 4, low + value * high), (left, low + value * high)], INK, 1)
    f.text((left + wide / 2, 14), "position along the bar")
    f.text((12, low + 1.5 * high + 24), "pressure over the Hugoniot pressure", anchor="start", size=12)

    def to(points):
        return [(left + wide * x, low + high * min(1.6, max(0.0, p))) for x, p in points]

    f.line(to(profile(0.0, 0.0, end)), GREY, 1.2)
    f.line(to(profile(0.06, 1.2, end)), BLUE, 2.2)
    f.line(to([(piston * end, 1.0), (0.62, 1.0), (0.62, 0.0)]), RED, 1.4, "5 4")
    for row, (colour, text) in enumerate([(GREY, "no viscosity"), (BLUE, "b₁ = 0.06, b₂ = 1.2"), (RED, "exact")]):
        y = low + 1.42 * high - 20 * row
        f.line([(left + 330, y + 4), (left + 355, y + 4)], colour, 2.2)
        f.text((left + 362, y), text, colour, "start", 12)
    f.write()


def richardson() -> None:
    """Extrapolation of three levels to size zero."""
    f = Figure("richardson", 500, 290, "Richardson extrapolation")
    left, low, wide, high = 70, 50, 380, 190
    f.line([(left, low + high + 15), (left, low), (left + wide, low)], INK, 1.2)
    limit, order = 0.15, 2.0

    def value(h):
        return limit + 0.75 * h**order

    def at(h, y):
        return left + wide * 0.92 * h, low + high * y

    f.line([at(i / 50, value(i / 50)) for i in range(51)], BLUE, 1.6, "5 4")
    fine = value(0.25)
    error = (value(0.5) - fine) / 3
    for h, name in ((1.0, "h_1"), (0.5, "h_2"), (0.25, "h_3")):
        f.dot(at(h, value(h)), BLUE, 4)
        f.line([at(h, 0), at(h, value(h))], GREY, 0.8, "3 3")
        f.text((at(h, 0)[0], low - 18), name)
    f.dot(at(0, limit), RED, 4)
    f.text((left - 10, at(0, limit)[1] - 5), "φ_0", RED, "end")
    for y in (fine - 1.25 * error, fine + 1.25 * error):
        f.line([at(0, y), at(0.25, y)], RED, 1)
    f.text((at(0.29, 0)[0], at(0, fine)[1] - 14), "φ_3 ± U", RED, "start")
    f.text((left + wide / 2, 12), "size h")
    f.text((left - 10, low + high + 4), "φ", anchor="end")
    f.text((at(0.72, 0)[0], at(0, 0.78)[1]), "φ_0 + C h^p", BLUE, "end")
    f.write()


def polygon_faces(f: Figure, corners, middles=()) -> None:
    """An element with its node numbers and the names of its faces."""
    f.line(corners, BLUE, 2, fill=FILL, close=True)
    centre = tuple(sum(c[i] for c in corners) / len(corners) for i in (0, 1))
    for i, (a, b) in enumerate(zip(corners, [*corners[1:], corners[0]], strict=True)):
        middle = tuple(0.35 * (a[k] + b[k]) + 0.3 * centre[k] for k in (0, 1))
        f.text((middle[0], middle[1] - 5), f"S{i + 1}", RED)
    for i, at in enumerate([*corners, *middles]):
        f.dot(at)
        away = math.hypot(at[0] - centre[0], at[1] - centre[1])
        f.text((at[0] + 14 * (at[0] - centre[0]) / away, at[1] + 14 * (at[1] - centre[1]) / away - 5), str(i + 1))


def element_faces() -> None:
    """Node numbers and faces of all elements."""
    f = Figure("element-faces", 720, 330, "Nodes and faces of the elements")
    f.arrow((16, 182), (66, 182), GREY)
    f.text((76, 178), "r", GREY)
    f.arrow((16, 182), (16, 232), GREY)
    f.text((16, 238), "z", GREY)
    polygon_faces(f, [(100, 205), (200, 198), (212, 290), (105, 296)])
    f.text((152, 170), "CAX4R, CAX4RT")
    polygon_faces(f, [(290, 200), (400, 208), (330, 296)])
    f.text((345, 170), "CAX3, CAX3T")
    corners = [(490, 200), (640, 205), (555, 296)]
    middles = [
        tuple((a[i] + b[i]) / 2 for i in (0, 1)) for a, b in zip(corners, [*corners[1:], corners[0]], strict=True)
    ]
    polygon_faces(f, corners, middles)
    f.text((565, 170), "CAX6M")
    for left, name in ((60, "SAX1"), (250, "RAX2")):
        a, b = (left, 60), (left + 120, 95)
        f.line([a, b], BLUE, 2.4)
        for i, at in enumerate((a, b)):
            f.dot(at)
            f.text((at[0], at[1] - 22), str(i + 1))
        f.arrow((left + 60, 77.5), (left + 50, 112))
        f.text((left + 62, 120), "SPOS", RED)
        f.text((left + 75, 52), "SNEG", RED)
        f.text((left + 60, 10), name)
    bottom, top = [(470, 55), (640, 62)], [(640, 92), (470, 85)]
    f.line(bottom + top, BLUE, 1, fill=FILL, close=True)
    for i, (at, side) in enumerate(zip(bottom + top, (-1, -1, 1, 1), strict=True)):
        f.dot(at)
        f.text((at[0], at[1] + (10 if side > 0 else -22)), str(i + 1))
    f.line(bottom, BLUE, 2.4)
    f.line(top, BLUE, 2.4)
    f.text((555, 40), "S1", RED)
    f.text((555, 96), "S3", RED)
    f.text((555, 10), "COHAX4")
    f.write()


def analytical_surface() -> None:
    """The front of an analytical surface."""
    f = Figure("analytical-surface", 560, 230, "Front of an analytical surface")
    start, corner, low = (60, 190), (60, 110), (110, 60)
    arc = [(110 - 50 * math.cos(t), 110 - 50 * math.sin(t)) for t in (math.pi / 2 * i / 24 for i in range(25))]
    end = (300, 60)
    f.line([start, *arc, end, (300, 30), (30, 30), (30, 190)], "none", 0, fill=FILL, close=True)
    f.line([start, *arc, end], BLUE, 2.4)
    for at in (start, corner, low, end):
        f.dot(at, BLUE)
    f.text((66, 202), "START", BLUE, "start")
    f.text((70, 112), "LINE", BLUE, "start")
    f.text((112, 42), "CIRCL", BLUE, "start")
    f.text((300, 42), "LINE", BLUE, "end")
    f.arrow((60, 150), (95, 150), RED)
    f.arrow((210, 60), (210, 95), RED)
    f.text((140, 160), "front: bodies come from here,", RED, "start")
    f.text((140, 140), "left of the direction from START", RED, "start")
    f.text((335, 84), "back: the inside of the tool;", anchor="start")
    f.text((335, 64), "bodies start in front of it", anchor="start")
    f.write()


def target_layers() -> None:
    """Layers of a target without a mesh."""
    f = Figure("target-layers", 680, 300, "Layers of *TARGET")
    axis = 110
    f.line([(axis, 10), (axis, 292)], GREY, 1.2, "8 3 2 3")
    f.text((axis - 12, 280), "z", GREY)
    nose = [(axis, 182), (axis + 14, 200), (axis + 24, 222), (axis + 28, 246), (axis + 28, 288), (axis, 288)]
    f.line(nose, BLUE, 2, fill=FILL, close=True)
    f.arrow((axis + 13, 270), (axis + 13, 232))
    rows = [
        (170, 130, "#e9e9e9", "STEEL, 0.012", "layer 1"),
        (130, 95, "white", ", 0.010", "gap: the material is left out"),
        (95, 45, "#f3e3d3", "ALUMINIUM, 0.015", "layer 2; without a thickness the last layer has no end"),
    ]
    for high, low, colour, text, meaning in rows:
        f.line(
            [(axis, low), (370, low), (370, high), (axis, high)],
            INK if colour != "white" else GREY,
            1.2,
            "" if colour != "white" else "3 3",
            colour,
            True,
        )
        f.text((axis + 130, 0.5 * (high + low) - 5), text)
        f.text((385, 0.5 * (high + low) - 5), meaning, anchor="start", size=12)
    f.arrow((340, 240), (340, 173), RED)
    f.text((348, 236), "FRONT: z of the impact face", RED, "start", 12)
    f.arrow((40, 168), (40, 60))
    f.text((8, 40), "DIRECTION=-1", anchor="start", size=12)
    f.arrow((axis, 22), (370, 22), GREY)
    f.text((240, 5), "RADIUS (default: no lateral face)", GREY, size=12)
    f.write()


def shot_outcomes() -> None:
    """Outcomes of `revolve limit`."""
    f = Figure("shot-outcomes", 640, 200, "Outcomes of shots")

    def body(x, y, up=False) -> None:
        s = -1 if up else 1
        f.line(
            [(x - 9, y + 26 * s), (x - 9, y), (x, y - 16 * s), (x + 9, y), (x + 9, y + 26 * s)],
            BLUE,
            1.6,
            fill=FILL,
            close=True,
        )

    cases = [
        ("perforation", 57, "out of the rear face"),
        ("embedded", 110, "at rest inside"),
        ("ricochet", 160, "out of the front face"),
        ("moving", 102, "not at rest at the end"),
        ("not-met", 160, "has not touched the target"),
    ]
    for i, (name, y, meaning) in enumerate(cases):
        x = 64 + 128 * i
        beside = 44 if name == "not-met" else 0
        f.line(
            [(x - 40, 84), (x + 40 - beside, 84), (x + 40 - beside, 130), (x - 40, 130)],
            INK,
            1,
            fill="#e9e9e9",
            close=True,
        )
        at = x + (28 if beside else 0)
        body(at, y)
        if name in ("perforation", "moving", "not-met"):
            f.arrow((at + 16, y + 16), (at + 16, y - 16), RED)
        if name == "ricochet":
            f.arrow((at + 16, y - 12), (at + 34, y + 20), RED)
        f.text((x, 8), meaning, size=11)
        f.text((x, 22), name)
    f.write()


if __name__ == "__main__":
    drawings = [facet, hourglass, return_mapping, contact_gap, shock, richardson]
    for draw in (*drawings, element_faces, analytical_surface, target_layers, shot_outcomes):
        draw()
