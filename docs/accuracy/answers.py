"""Closed forms of the scenes in scenes.csv, computed without Revolve. Standard library only; see the sources there."""

import math
from math import exp, log, pi, sin, sqrt


def bisect(function, low, high):
    """Returns a root between two numbers at which the function has different signs."""
    positive = function(high) > 0
    for _ in range(200):
        middle = 0.5 * (low + high)
        if (function(middle) > 0) == positive:
            high = middle
        else:
            low = middle
    return 0.5 * (low + high)


def integral(function, low, high, parts=4000):
    """Returns the integral of a function by Simpson's rule."""
    h = (high - low) / parts
    inside = sum((4 if i % 2 else 2) * function(low + i * h) for i in range(1, parts))
    return (function(low) + function(high) + inside) * h / 3


def solve(rows, right):
    """Returns the solution of a small linear system by elimination with pivots."""
    n = len(rows)
    m = [list(row) + [b] for row, b in zip(rows, right)]
    for k in range(n):
        pivot = max(range(k, n), key=lambda i: abs(m[i][k]))
        m[k], m[pivot] = m[pivot], m[k]
        for i in range(n):
            if i != k:
                f = m[i][k] / m[k][k]
                m[i] = [x - f * y for x, y in zip(m[i], m[k])]
    return [m[k][n] / m[k][k] for k in range(n)]


def runge_kutta(slope, state, time, parts=20000):
    """Returns the state at a time by the classical Runge-Kutta method."""
    h, t = time / parts, 0.0
    for _ in range(parts):
        k1 = slope(t, state)
        k2 = slope(t + h / 2, [x + h / 2 * k for x, k in zip(state, k1)])
        k3 = slope(t + h / 2, [x + h / 2 * k for x, k in zip(state, k2)])
        k4 = slope(t + h, [x + h * k for x, k in zip(state, k3)])
        state = [x + h / 6 * (a + 2 * b + 2 * c + d) for x, a, b, c, d in zip(state, k1, k2, k3, k4)]
        t += h
    return state


def bessel(order, x):
    """Returns the Bessel function of the first kind by Bessel's integral."""
    return integral(lambda a: math.cos(order * a - x * sin(a)), 0, pi, 400) / pi


def bessel_zeros(count):
    """Returns the first zeros of the Bessel function of order 0."""
    return [bisect(lambda x: bessel(0, x), (k + 0.5) * pi, (k + 1.0) * pi) for k in range(count)]


# Rigid bodies


def bilinear_spring(time):
    """Mass 1, velocity 1, stiffness 4 up to 0.25, then 12; before the displacement is largest."""
    start = math.asin(0.5) / 2
    velocity, w, t = sqrt(1 - 4 * 0.25**2), sqrt(12), time - start
    return 0.25 - 1 / 12 + math.cos(w * t) / 12 + velocity / w * sin(w * t)


def cone_embedded(v, a, half_angle_tangent, mass, strength, inertia):
    sine2 = half_angle_tangent**2 / (1 + half_angle_tangent**2)
    alpha, beta = pi * a * a * strength, pi * a * a * inertia * sine2
    return mass / (2 * beta) * log(1 + beta * v * v / alpha)


def sphere_entry(v, radius, mass, strength):
    """Depth at which the displaced volume times the resistance is the kinetic energy."""
    energy = mass * v * v / 2
    return bisect(lambda z: strength * pi * z * z * (radius - z / 3) - energy, 0, radius)


# Heat conduction


def slab_held(alpha, time):
    """Temperature at the insulated face of a slab of thickness 1 that is held at 1 at the other."""
    modes = ((n + 0.5) * pi for n in range(40))
    return 1 - sum(2 * (-1) ** n / m * exp(-m * m * alpha * time) for n, m in enumerate(modes))


def cylinder_cooled(alpha, time):
    return sum(2 / (m * bessel(1, m)) * exp(-m * m * alpha * time) for m in bessel_zeros(12))


def cylinder_heated(source, conductivity, alpha, time):
    series = sum(exp(-m * m * alpha * time) / (m**3 * bessel(1, m)) for m in bessel_zeros(12))
    return source / (4 * conductivity) - 2 * source / conductivity * series


def sphere_insulated(a, b, alpha, time):
    """Temperature at the insulated radius a after b is held at 1: r (T - 1) is a series of sines of b - r."""
    total = 0.0
    for k in range(1, 12):
        m = bisect(
            lambda x: sin(x * (b - a)) + x * a * math.cos(x * (b - a)), (k - 0.5) * pi / (b - a), k * pi / (b - a)
        )
        norm = integral(lambda r, m=m: sin(m * (b - r)) ** 2, a, b)
        weight = integral(lambda r, m=m: -r * sin(m * (b - r)), a, b) / norm
        total += weight * sin(m * (b - a)) / a * exp(-m * m * alpha * time)
    return 1 + total


# Elasticity


def layered_sphere(pressure, radii, materials):
    """Displacement of the bore of bonded spheres under internal pressure; u = C r + D/r^2 in each."""
    size = 2 * len(materials)
    rows, right = [], []

    def stress(layer, r):
        e, nu = materials[layer]
        row = [0.0] * size
        row[2 * layer : 2 * layer + 2] = [e / (1 - 2 * nu), -2 * e / (1 + nu) / r**3]
        return row

    def displacement(layer, r):
        row = [0.0] * size
        row[2 * layer : 2 * layer + 2] = [r, 1 / r**2]
        return row

    rows.append(stress(0, radii[0]))
    right.append(-pressure)
    for i in range(1, len(materials)):
        for quantity in (stress, displacement):
            rows.append([x - y for x, y in zip(quantity(i - 1, radii[i]), quantity(i, radii[i]))])
            right.append(0.0)
    rows.append(stress(len(materials) - 1, radii[-1]))
    right.append(0.0)
    constants = solve(rows, right)
    return constants[0] * radii[0] + constants[1] / radii[0] ** 2


def hill_outer(y, c, b, e, nu):
    """Outer displacement of a plastic sphere with the front at c (Hill 1950, chapter 5)."""
    return y * c**3 * (1 - nu) / (e * b**2)


def hill_pressure(y, a, c, b):
    return y * (2 * log(c / a) + 2 / 3 * (1 - c**3 / b**3))


def sphere_outer(p, a, b, e, nu):
    """Outer displacement of an elastic sphere under internal pressure (Lame)."""
    return 3 * p * a**3 * b * (1 - nu) / (2 * e * (b**3 - a**3))


def cavity_elongation(tension, e, nu):
    """Displacement of the pole of a spherical cavity of radius 1 under remote tension along the axis (Eshelby 1957)."""
    return tension / e * ((1 - nu) / 2 + 10 * (1 - nu**2) / (7 - 5 * nu))


# Plates and shells: E = 1, nu = 0.3

THICKNESS = 0.05
BENDING = THICKNESS**3 / (12 * (1 - 0.09))
SHEAR = 5 / 6 * THICKNESS / 2.6


def plate_part_loaded(q, c, a, nu=0.3):
    """Centre of a supported plate of radius a under the pressure q inside the radius c."""
    d, k = BENDING, SHEAR

    def outer(r):
        return q * c * c / (2 * d) * (r * log(r) / 2 - r / 4), q * c * c / (2 * d) * (log(r) / 2 + 1 / 4)

    (w1, w2), (e1, e2) = outer(c), outer(a)
    # Slope q r^3/(16 D) + x r inside, outer + y r/2 + z/r outside.
    rows = [[c, -c / 2, -1 / c], [1, -0.5, 1 / c**2], [0, 0.5 * (1 + nu), (nu - 1) / a**2]]
    x, y, z = solve(rows, [w1 - q * c**3 / (16 * d), w2 - 3 * q * c**2 / (16 * d), -e2 - nu * e1 / a])
    bent = -(q * c**4 / (64 * d) + x * c * c / 2) - integral(lambda r: outer(r)[0] + y * r / 2 + z / r, c, a)
    return bent + q * c * c / (4 * k) + q * c * c / (2 * k) * log(a / c)


def annular_plate(v, b, a, nu=0.3):
    """Inner edge b of a plate supported at a under the line load v along its inner edge."""
    d, k = BENDING, SHEAR

    def slope(r):
        return v * b / d * (r * log(r) / 2 - r / 4), v * b / d * (log(r) / 2 + 1 / 4)

    rows = [[0.5 * (1 + nu), (nu - 1) / r**2] for r in (b, a)]
    y, z = solve(rows, [-slope(r)[1] - nu * slope(r)[0] / r for r in (b, a)])
    return -integral(lambda r: slope(r)[0] + y * r / 2 + z / r, b, a) + v * b / k * log(a / b)


def cylinder_clamped(p):
    """Radial reaction of the clamped end of a long cylinder of radius 1: Timoshenko beam on an elastic foundation."""
    import cmath

    d, s, k = BENDING, SHEAR, THICKNESS
    root = cmath.sqrt((k / (2 * s)) ** 2 - k / d)
    decays = [-cmath.sqrt(k / (2 * s) + root), -cmath.sqrt(k / (2 * s) - root)]
    turns = [(s * x * x - k) / (s * x) for x in decays]
    w1, w2 = solve([[1, 1], turns], [-p / k, 0])
    return 2 * pi * (w1 * k / decays[0] + w2 * k / decays[1]).real


# Gases and shocks


def velocity_change(p, state, g=1.4):
    """Returns the change of velocity between a gas (density, pressure) and the pressure p (Toro 2009, section 4.2)."""
    density, before = state
    if p > before:
        return (p - before) * sqrt(2 / ((g + 1) * density) / (p + (g - 1) / (g + 1) * before))
    return 2 * sqrt(g * before / density) / (g - 1) * ((p / before) ** ((g - 1) / (2 * g)) - 1)


def sod_pressure():
    """Pressure between the waves of Sod's two gases at rest."""
    return bisect(lambda p: velocity_change(p, (1.0, 1.0)) + velocity_change(p, (0.125, 0.1)), 1e-6, 1.0)


def reflected_pressure(velocity, pressure, g=1.4):
    """Pressure after the shock of a piston in a gas of density 1 is reflected by a wall."""
    first = bisect(lambda p: velocity_change(p, (1.0, pressure)) - velocity, pressure, 1e3)
    k = (g - 1) / (g + 1)
    density = (first / pressure + k) / (k * first / pressure + 1)
    return bisect(lambda p: velocity_change(p, (density, first)) - velocity, first, 1e3)


def gas_spring(time):
    """Displacement of the mass pi on the area pi of a gas of pressure 1, gamma 1.4; half the gas moves with it."""
    inertia = 1 + 0.5e-5
    return runge_kutta(lambda _, s: [s[1], s[0] ** -1.4 / inertia], [1.0, -0.8], time)[0] - 1


def impedance_match(v, target, flyer):
    """Pressure from two Hugoniots (density, c, s) that meet at the velocity v."""

    def pressure(m, u):
        return m[0] * (m[1] + m[2] * u) * u

    u = bisect(lambda x: pressure(target, x) - pressure(flyer, v - x), 0, v)
    return pressure(target, u)


def jwl_pressure(volume):
    a, b, w, r1, r2, energy = 3.712, 0.03231, 0.3, 4.15, 0.95, 0.0429448 * 1.63
    start = a * (1 - w / r1) * exp(-r1) + b * (1 - w / r2) * exp(-r2) + w * energy
    c = start - a * exp(-r1) - b * exp(-r2)
    return a * exp(-r1 * volume) + b * exp(-r2 * volume) + c * volume ** -(1 + w)
