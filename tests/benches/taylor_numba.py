"""Copper Taylor bar as a short numba loop, compared with Revolve: time of an element and increment, and final shape.

The loop is what a user writes who knows numba: structs of arrays, one compiled pass over elements and one over nodes, forces
of the corners stored and gathered. It has CAX4R with one point, the Jaumann rate, von Mises plasticity with linear hardening,
stiffness hourglass control, bulk viscosity, and a fixed increment. Source: Flanagan and Belytschko 1981, Int. J. Numer. Meth.
Engng 17, 679 (operators, hourglass control).

    target/python/bin/python tests/benches/taylor_numba.py [nr nz] [path of the program]
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numba
import numpy as np

RADIUS, LENGTH, SPEED, DURATION = 3.2e-3, 32.4e-3, 227.0, 20e-6
DENSITY, YOUNG, POISSON, YIELD, HARDENING = 8930.0, 117e9, 0.35, 400e6, 100e6
SHEAR = YOUNG / (2 + 2 * POISSON)
BULK = YOUNG / (3 - 6 * POISSON)
HOURGLASS, LINEAR, QUADRATIC = 0.005, 0.06, 1.2


@numba.njit(fastmath=True, error_model="numpy")
def update_elements(corners, place, velocity, stress, strain, hourglass, mass, forces, dt):
    """Updates stresses, and computes the force on each corner of each element (n, 4, 2), per radian."""
    wave = np.sqrt((BULK + 4 / 3 * SHEAR) / DENSITY)
    for e in range(corners.shape[0]):
        a, b, c, d = corners[e]
        r0, r1, r2, r3 = place[a, 0], place[b, 0], place[c, 0], place[d, 0]
        z0, z1, z2, z3 = place[a, 1], place[b, 1], place[c, 1], place[d, 1]
        u0, u1, u2, u3 = velocity[a, 0], velocity[b, 0], velocity[c, 0], velocity[d, 0]
        w0, w1, w2, w3 = velocity[a, 1], velocity[b, 1], velocity[c, 1], velocity[d, 1]
        area = 0.5 * ((r2 - r0) * (z3 - z1) - (r3 - r1) * (z2 - z0))
        radius = 0.25 * (r0 + r1 + r2 + r3)
        volume, half = area * radius, 0.5 / area
        # Derivatives of the shape functions at the centre; those of opposite corners are opposite.
        br0, br1, bz0, bz1 = half * (z1 - z3), half * (z2 - z0), half * (r3 - r1), half * (r0 - r2)
        rr = br0 * (u0 - u2) + br1 * (u1 - u3)
        zz = bz0 * (w0 - w2) + bz1 * (w1 - w3)
        hoop = 0.25 * (u0 + u1 + u2 + u3) / radius
        ur_z = bz0 * (u0 - u2) + bz1 * (u1 - u3)
        uz_r = br0 * (w0 - w2) + br1 * (w1 - w3)
        shear, spin = 0.5 * dt * (ur_z + uz_r), 0.5 * dt * (ur_z - uz_r)
        rate = rr + zz + hoop
        mean = dt * rate / 3
        s0, s1, s2, s3 = stress[e]
        turned = 2 * spin * s3
        pressure = (s0 + s1 + s2) / 3 + BULK * dt * rate
        middle = (s0 + s1 + s2) / 3
        d0 = s0 - middle + turned + 2 * SHEAR * (dt * rr - mean)
        d1 = s1 - middle - turned + 2 * SHEAR * (dt * zz - mean)
        d2 = s2 - middle + 2 * SHEAR * (dt * hoop - mean)
        d3 = s3 + spin * (s1 - s0) + 2 * SHEAR * shear
        trial = np.sqrt(1.5 * (d0 * d0 + d1 * d1 + d2 * d2) + 3 * d3 * d3)
        flow = max(0.0, (trial - YIELD - HARDENING * strain[e]) / (3 * SHEAR + HARDENING))
        strain[e] += flow
        kept = 1 - 3 * SHEAR * flow / max(trial, 1.0)
        s0, s1, s2, s3 = kept * d0 + pressure, kept * d1 + pressure, kept * d2 + pressure, kept * d3
        stress[e, 0], stress[e, 1], stress[e, 2], stress[e, 3] = s0, s1, s2, s3
        # The length of the bulk viscosity is the area over the longer diagonal.
        size = area / np.sqrt(max((r2 - r0) ** 2 + (z2 - z0) ** 2, (r3 - r1) ** 2 + (z3 - z1) ** 2))
        viscous = DENSITY * size * (LINEAR * wave + QUADRATIC**2 * size * max(-rate, 0.0)) * rate
        t0, t1, t2, t3 = volume * (s0 + viscous), volume * (s1 + viscous), 0.25 * area * (s2 + viscous), volume * s3
        # Hourglass pattern, orthogonal to linear fields.
        x, y = r0 - r1 + r2 - r3, z0 - z1 + z2 - z3
        g0, g1 = 1 - x * br0 - y * bz0, -1 - x * br1 - y * bz1
        g2, g3 = 1 + x * br0 + y * bz0, -1 + x * br1 + y * bz1
        stiff = HOURGLASS * SHEAR * dt * 2 * (br0 * br0 + br1 * br1 + bz0 * bz0 + bz1 * bz1)
        hourglass[e, 0] += stiff * (g0 * u0 + g1 * u1 + g2 * u2 + g3 * u3)
        hourglass[e, 1] += stiff * (g0 * w0 + g1 * w1 + g2 * w2 + g3 * w3)
        q, p = volume * hourglass[e, 0], volume * hourglass[e, 1]
        f0, f1 = br0 * t0 + bz0 * t3, br1 * t0 + bz1 * t3
        k0, k1 = bz0 * t1 + br0 * t3, bz1 * t1 + br1 * t3
        forces[e, 0, 0], forces[e, 0, 1] = -f0 - t2 - g0 * q, -k0 - g0 * p
        forces[e, 1, 0], forces[e, 1, 1] = -f1 - t2 - g1 * q, -k1 - g1 * p
        forces[e, 2, 0], forces[e, 2, 1] = f0 - t2 - g2 * q, k0 - g2 * p
        forces[e, 3, 0], forces[e, 3, 1] = f1 - t2 - g3 * q, k1 - g3 * p


@numba.njit(fastmath=True, error_model="numpy")
def update_nodes(slots, forces, place, velocity, mass, held, dt):
    """Sums the forces of the corners at each node (slots of an unused corner point to a zero), and moves the nodes."""
    for n in range(place.shape[0]):
        fr, fz = 0.0, 0.0
        for k in range(4):
            fr += forces[slots[n, k], 0]
            fz += forces[slots[n, k], 1]
        velocity[n, 0] += dt * fr / mass[n] * (place[n, 0] > 0)
        velocity[n, 1] += dt * fz / mass[n] * (1 - held[n])
        place[n, 0] += dt * velocity[n, 0]
        place[n, 1] += dt * velocity[n, 1]


@numba.njit
def increments(count, corners, slots, place, velocity, stress, strain, hourglass, mass, held, forces, dt):
    of_elements = forces[: 4 * corners.shape[0]].reshape(corners.shape[0], 4, 2)
    for _ in range(count):
        update_elements(corners, place, velocity, stress, strain, hourglass, mass, of_elements, dt)
        update_nodes(slots, forces, place, velocity, mass, held, dt)


def bar(nr, nz):
    """Returns the arrays of a bar before the impact."""
    j, i = np.divmod(np.arange((nr + 1) * (nz + 1)), nr + 1)
    place = np.stack([RADIUS * i / nr, LENGTH * j / nz], axis=1)
    first = (np.arange(nz)[:, None] * (nr + 1) + np.arange(nr)).ravel()
    corners = np.stack([first, first + 1, first + nr + 2, first + nr + 1], axis=1)
    count = len(corners)
    # Lumped masses per radian: integrals of the shape functions of each rectangle.
    inner, outer, height = place[corners[:, 0], 0], place[corners[:, 1], 0], LENGTH / nz
    low, high = (2 * inner + outer) * (RADIUS / nr) / 6, (inner + 2 * outer) * (RADIUS / nr) / 6
    mass = np.zeros(len(place))
    for corner, share in enumerate([low, high, high, low]):
        np.add.at(mass, corners[:, corner], DENSITY * 0.5 * height * share)
    slots = np.full((len(place), 4), 4 * count)
    used = np.zeros(len(place), dtype=int)
    for slot, node in enumerate(corners.ravel()):
        slots[node, used[node]] = slot
        used[node] += 1
    velocity = np.stack([np.zeros(len(place)), np.where(j == 0, 0.0, -SPEED)], axis=1)
    held = (j == 0).astype(float)
    zeros = [np.zeros((count, 4)), np.zeros(count), np.zeros((count, 2))]
    return [corners, slots, place, velocity, *zeros, mass, held, np.zeros((4 * count + 1, 2))]


def of_loop(nr, nz, dt, count):
    """Returns nanoseconds per element and increment, and the length and the foot radius in mm."""
    increments(2, *bar(nr, nz), dt)
    arrays = bar(nr, nz)
    begin = time.process_time()
    increments(count, *arrays, dt)
    seconds = time.process_time() - begin
    place = arrays[2]
    return 1e9 * seconds / (count * nr * nz), 1e3 * place[-nr - 1, 1], 1e3 * place[nr, 0]


def of_program(program, nr, nz, dt):
    """Returns the same of Revolve: user CPU time of the whole process."""
    deck = Path(__file__).parents[2] / "input" / "taylor_copper.inp"
    text = deck.read_text().replace("*Dynamic, Explicit\n ,", f"*Dynamic, Explicit, direct user control\n {dt!r},")
    text = text.replace("80.e-6", repr(DURATION))
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "bar.inp"
        copy.write_text(text)
        command = [program, "run", copy, "--out", folder, "--no-frames", "--threads", "1", "--json"]
        before = os.times().children_user
        output = subprocess.run([*command, "--set", f"nr={nr}", "--set", f"nz={nz}"], capture_output=True, check=True)
        seconds = os.times().children_user - before
    summary = json.loads(output.stdout)
    count = summary["steps"][0]["increments"]
    history = {name: column["final"] for name, column in summary["history"].items()}
    return 1e9 * seconds / (count * nr * nz), 1e3 * history["COOR2@TIP"], 1e3 * history["COOR1@CORNER"]


def main():
    sizes = [int(text) for text in sys.argv[1:3]] or [16, 80]
    program = sys.argv[3] if len(sys.argv) > 3 else str(Path(__file__).parents[2] / "target" / "release" / "revolve")
    nr, nz = sizes
    # Elements at the foot become flat, so that their stable increment falls.
    dt = float(0.25 * min(RADIUS / nr, LENGTH / nz) / np.sqrt((BULK + 4 / 3 * SHEAR) / DENSITY))
    count = int(DURATION / dt)
    for _ in range(3):
        loop, length, foot = of_loop(nr, nz, dt, count)
        revolve, *shape = of_program(program, nr, nz, dt)
        print(f"numba {loop:.1f} ns, length {length:.3f}, foot {foot:.3f} mm; ", end="")
        print(f"Revolve {revolve:.1f} ns, {shape[0]:.3f}, {shape[1]:.3f} mm; ratio {revolve / loop:.2f}")


if __name__ == "__main__":
    main()
