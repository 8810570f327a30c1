"""Random decks: materials, bodies, contact of all kinds, element deletion, shells, heat, mass scaling, targets, steps.

The same seed and number give the same deck. Values are drawn in SI units and written in one of three systems of units.
"""

import math
import random
from dataclasses import dataclass, field
from typing import ClassVar

TAKES_HEAT = "CAX4RT"
SOFT = ("LINEAR", "EXPONENTIAL", "TABULAR")
# Increments that a scene shall take, by the estimated stable time increment of its elements.
INCREMENTS = (150.0, 1800.0)


class Dice(random.Random):
    """Random numbers with the distributions of this file."""

    def power(self, low, high):
        return 10.0 ** self.uniform(low, high)

    def chance(self, share):
        return self.random() < share


class Units:
    """A consistent system of units: factors on SI values."""

    SYSTEMS: ClassVar = {"SI": (1.0, 1.0, 1.0), "mm-t-s": (1e3, 1e-3, 1.0), "cm-g-us": (1e2, 1e3, 1e6)}

    def __init__(self, name):
        self.name = name
        length, mass, time = self.SYSTEMS[name]
        self.length, self.mass, self.time = length, mass, time
        self.speed = length / time
        self.density = mass / length**3
        self.stress = mass / (length * time**2)
        self.force = mass * length / time**2
        self.per_mass = length**2 / time**2
        self.conductivity = mass * length / time**3
        self.conductance = mass / time**3
        self.acceleration = length / time**2
        self.stiffness = mass / time**2


@dataclass
class Material:
    """Cards of a material, its wave speed and its yield stress in SI units."""

    name: str
    law: str
    cards: str
    density: float
    modulus: float
    hourglass: bool = True
    stores: bool = False
    fails: bool = False
    plastic: bool = False
    initial: str = ""

    @property
    def sound(self):
        return math.sqrt(1.4 * self.modulus / self.density)


@dataclass
class Body:
    """A meshed body: its text, the number of its elements, its smallest element edge and its extent in SI units."""

    name: str
    text: str
    elements: int
    edge: float
    inner: float
    outer: float
    bottom: float
    top: float
    material: Material
    shell: bool = False
    quads: bool = True


@dataclass
class Scene:
    """A deck, and the facts that its checks use."""

    seed: int
    number: int
    name: str
    units: Units
    model: str
    steps: list
    elements: int
    loaded: bool
    stores: bool
    features: set = field(default_factory=set)

    def deck(self, rows=200, split=False, increment=None):
        """Returns the text of the deck. With `increment` it is used in all steps; with `split` the first step is two."""
        text = f"** scene {self.number} of seed {self.seed}: {self.name}\n{self.model}"
        for index, step in enumerate(self.steps):
            text += step.text(rows, increment, 0.5 if split and index == 0 else 1.0, False)
            if split and index == 0:
                text += step.text(rows, increment, 0.5, True)
        return text


@dataclass
class Step:
    """An analysis step: length, options of *DYNAMIC, cards of the whole step, cards that start something."""

    time: float
    procedure: str
    options: str
    controls: str
    conditions: str

    def text(self, rows, increment, part, continued):
        options = self.options
        first = ""
        time = self.time * part
        if increment is not None:
            options = options.replace(", element by element", "") + ", direct user control"
            first = f"{increment!r}"
            time = round(time / increment) * increment
        every = "frequency=1" if rows is None else f"number interval={max(1, round(rows * part))}"
        conditions = "" if continued else self.conditions
        return (
            f"*Step\n*{self.procedure}, explicit{options}\n {first}, {time!r}\n{self.controls}{conditions}"
            "*Output, field, number interval=1\n*Node Output\n U, V\n*Element Output\n S\n"
            f"*Output, history, {every}\n*Energy Output\n ALL\n*End Step\n"
        )


def numbers(*values):
    return ", ".join(f"{value:.12g}" for value in values)


LAWS = (
    "elastic",
    "nearly incompressible",
    "plastic",
    "perfectly plastic",
    "Johnson-Cook",
    "power law",
    "yield ratio",
    "kinematic",
    "shear failure",
    "Johnson-Cook failure",
    "ductile damage, displacement",
    "ductile damage, energy",
    "Johnson-Cook damage",
    "tensile failure",
    "tensile cutoff",
    "Us-Up metal",
    "Us-Up liquid",
    "neo-Hooke",
    "Mooney-Rivlin",
    "Ogden",
    "Yeoh",
    "foam, volumetric",
    "foam, isotropic",
    "ideal gas",
    "explosive",
    "thermal expansion",
)
RUBBER = ("neo-Hooke", "Mooney-Rivlin", "Ogden", "Yeoh")
FLUIDS = ("Us-Up liquid", "ideal gas", "explosive")
SHELL_LAWS = ("elastic", "plastic", "perfectly plastic", "Johnson-Cook", "power law")
# Laws whose elements have no stiffness for penalty contact.
WITHOUT_PENALTY = (*RUBBER, "ideal gas", "explosive")
# Laws that *SECTION CONTROLS, WEIGHTING=AREA accepts.
AREA_LAWS = tuple(
    law
    for law in LAWS
    if law not in (*RUBBER, *FLUIDS, "thermal expansion") and law[:4] not in ("foam", "Us-U", "tens")
)


def material(dice, units, name, laws, heat, damped=True):
    """Returns a random material of one of the laws."""
    law = dice.choice(laws)
    density = dice.power(2.8, 4.2)
    modulus = dice.power(9.3, 11.5)
    if law in RUBBER:
        modulus, density = dice.power(5.5, 8.0), dice.uniform(900.0, 1300.0)
    if law.startswith("foam"):
        modulus, density = dice.power(6.0, 9.0), dice.uniform(50.0, 600.0)
    ratio = 0.49 if law == "nearly incompressible" else dice.uniform(0.0, 0.45)
    yields = modulus * dice.power(-3.5, -1.8)
    stress = units.stress
    shear = modulus / 2.6
    elastic = f"*Elastic\n {numbers(modulus * stress, ratio)}\n"
    tangent = yields * dice.uniform(1.0, 3.0)
    plastic = f"{elastic}*Plastic\n {numbers(yields * stress, 0)}\n {numbers(tangent * stress, 0.5)}\n"
    strain = dice.power(-1.5, 0.0)
    bulk = dice.power(-1.5, 0.0)
    result = Material(name, law, "", density, modulus)
    result.plastic = law not in ("elastic", "nearly incompressible", *RUBBER, *FLUIDS, "thermal expansion")
    result.hourglass = law not in (*RUBBER, *FLUIDS)
    result.stores = law in ("Us-Up metal", "tensile cutoff", *FLUIDS, "thermal expansion")
    if law in ("elastic", "nearly incompressible"):
        cards = elastic
    elif law == "perfectly plastic":
        cards = f"{elastic}*Plastic\n {numbers(yields * stress, 0)}\n"
    elif law == "Johnson-Cook":
        reference = 1.0 / units.time
        cards = (
            f"{elastic}*Plastic, hardening=JOHNSON COOK\n "
            f"{numbers(yields * stress, yields * dice.uniform(0.1, 2) * stress, dice.uniform(0.05, 0.9), 1, 1300, 293)}\n"
            f"*Rate Dependent, type=JOHNSON COOK\n {numbers(dice.uniform(0, 0.08), reference)}\n"
        )
    elif law == "power law":
        cards = f"{plastic}*Rate Dependent\n {numbers(dice.power(1, 4) / units.time, dice.uniform(1, 8))}\n"
    elif law == "yield ratio":
        cards = (
            f"{plastic}*Rate Dependent, type=YIELD RATIO\n 1., 0.\n {numbers(1.2, 1e2 / units.time)}\n"
            f" {numbers(2.0, 1e5 / units.time)}\n"
        )
    elif law == "kinematic":
        cards = f"{elastic}*Plastic, hardening=KINEMATIC\n {numbers(yields * stress, 0)}\n {numbers(tangent * stress * 1.2, 0.5)}\n"
    elif law == "shear failure":
        cards, result.fails = f"{plastic}*Shear Failure\n {strain:.12g},\n", True
    elif law == "Johnson-Cook failure":
        cards = f"{plastic}*Shear Failure, type=JOHNSON COOK\n {numbers(0.5 * strain, strain, -1.5, 0, 0)}\n"
        result.fails = True
    elif law.startswith("ductile damage"):
        kind = "ENERGY" if law.endswith("energy") else "DISPLACEMENT"
        # An energy per area that fails an element of a millimetre at some tenths of strain.
        value = dice.power(-4.5, -2.5) * units.length
        if kind == "ENERGY":
            value = yields * dice.power(-4.5, -2.5) * stress * units.length
        cards = (
            f"{plastic}*Damage Initiation, criterion=DUCTILE\n {numbers(strain, 0, 0)}\n"
            f"*Damage Evolution, type={kind}\n {value:.12g},\n"
        )
        result.fails = True
    elif law == "Johnson-Cook damage":
        cards = (
            f"{plastic}*Damage Initiation, criterion=JOHNSON COOK\n {numbers(0.3 * strain, strain, 1.5, 0, 0, 0, 0, 1 / units.time)}\n"
            f"*Damage Evolution, type=DISPLACEMENT\n {dice.power(-4.5, -2.5) * units.length:.12g},\n"
        )
        result.fails = True
    elif law == "tensile failure":
        cards, result.fails = f"{plastic}*Tensile Failure\n {yields * dice.uniform(0.5, 4) * stress:.12g},\n", True
    elif law == "tensile cutoff":
        wave = math.sqrt(modulus / density) * units.speed
        cards = (
            f"*Eos, type=USUP\n {numbers(wave, dice.uniform(0, 1.8), dice.uniform(0.5, 2.2))}\n"
            f"*Elastic, type=SHEAR\n {shear * stress:.12g},\n*Plastic\n {numbers(yields * stress, 0)}\n"
            f"*Tensile Failure, element deletion=NO\n {yields * dice.uniform(0.5, 4) * stress:.12g},\n"
        )
    elif law == "Us-Up metal":
        wave = math.sqrt(modulus / density) * units.speed
        cards = (
            f"*Eos, type=USUP\n {numbers(wave, dice.uniform(0, 1.8), dice.uniform(0.5, 2.2))}\n"
            f"*Elastic, type=SHEAR\n {shear * stress:.12g},\n*Plastic\n {numbers(yields * stress, 0)}\n"
        )
    elif law == "Us-Up liquid":
        density, modulus = 1000.0, 2.2e9
        cards = f"*Eos, type=USUP\n {numbers(1480 * units.speed, 1.9, 0.1)}\n"
        if dice.chance(0.5):
            cards += f"*Viscosity\n {dice.power(-3, 3) * stress * units.time:.12g},\n"
    elif law == "neo-Hooke":
        cards = f"*Hyperelastic, neo hooke\n {numbers(0.5 * shear * stress, bulk / (modulus * stress))}\n"
    elif law == "Mooney-Rivlin":
        cards = f"*Hyperelastic, mooney-rivlin\n {numbers(0.4 * shear * stress, 0.1 * shear * stress, bulk / (modulus * stress))}\n"
    elif law == "Ogden":
        cards = f"*Hyperelastic, ogden\n {numbers(shear * stress, dice.uniform(1, 5), bulk / (modulus * stress))}\n"
    elif law == "Yeoh":
        first = 0.5 * shear * stress
        cards = (
            f"*Hyperelastic, yeoh\n {numbers(first, -0.02 * first, 0.005 * first, bulk / (modulus * stress), 0, 0)}\n"
        )
    elif law == "foam, volumetric":
        cards = (
            f"*Elastic\n {numbers(modulus * stress, dice.uniform(0, 0.3))}\n*Crushable Foam, hardening=VOLUMETRIC\n 1.1, 0.1\n"
            f"*Crushable Foam Hardening\n {numbers(yields * stress, 0)}\n {numbers(yields * stress * dice.uniform(1.2, 4), 0.8)}\n"
        )
    elif law == "foam, isotropic":
        cards = (
            f"*Elastic\n {numbers(modulus * stress, dice.uniform(0, 0.3))}\n*Crushable Foam, hardening=ISOTROPIC\n 1.1, 0.2\n"
            f"*Crushable Foam Hardening\n {numbers(yields * stress, 0)}\n {numbers(yields * stress * dice.uniform(1.2, 4), 0.8)}\n"
        )
    elif law == "ideal gas":
        temperature = dice.uniform(250, 1500)
        density = dice.uniform(0.5, 20)
        modulus = 1.4 * density * 287 * temperature
        cards = f"*Eos, type=IDEAL GAS\n {numbers(287 * units.per_mass, 0)}\n*Specific Heat\n {718 * units.per_mass:.12g},\n"
        result.initial = (
            f"*Initial Conditions, type=SPECIFIC ENERGY\n {name}, {718 * temperature * units.per_mass:.12g}\n"
        )
    elif law == "explosive":
        density, modulus = 1630.0, 1630.0 * 6930.0**2
        cards = (
            f"*Eos, type=JWL\n {numbers(6930 * units.speed, 3.712e11 * stress, 3.231e9 * stress, 0.3, 4.15, 0.95, 4.29e6 * units.per_mass)}\n"
            "*Detonation Point\n 0., 0.\n"
        )
    elif law == "thermal expansion":
        cards = f"{elastic}*Expansion, zero=293\n {dice.power(-6, -4.5):.12g},\n"
    else:
        cards = plastic
    if heat and "Specific Heat" not in cards:
        cards += f"*Specific Heat\n {dice.uniform(300, 1500) * units.per_mass:.12g},\n"
        cards += "*Inelastic Heat Fraction\n 0.9\n" if result.plastic else ""
    if heat == "coupled":
        cards += f"*Conductivity\n {dice.power(0, 2.5) * units.conductivity:.12g},\n"
    if damped and dice.chance(0.1) and not law.startswith("Us-Up") and law not in FLUIDS:
        wave = math.sqrt(modulus / density)
        cards += f"*Damping, alpha={dice.power(-2, 0) * wave / 0.05 / units.time:.12g}\n"
    result.density, result.modulus = density, modulus
    result.cards = f"*Material, name=M{name}\n*Density\n {density * units.density:.12g},\n{cards}"
    return result


def controls(dice, law, name, area, element):
    """Returns a *SECTION CONTROLS card and the parameter that names it, or nothing."""
    if dice.chance(0.4) and not area:
        return "", ""
    text = f"*Section Controls, name=C{name}"
    kinds = (
        ("", "RELAX STIFFNESS", "STIFFNESS", "VISCOUS", "COMBINED", "ENHANCED") if law.hourglass else ("", "VISCOUS")
    )
    if element == "CAX6M":
        return text + "\n", f", controls=C{name}"
    kind = dice.choice(kinds)
    text += f", hourglass={kind}" if kind else ""
    text += ", distortion control=YES" if dice.chance(0.3) else ""
    text += ", element deletion=NO" if "damage" in law.law and dice.chance(0.3) else ""
    text += ", weighting=AREA" if area else ""
    return text + "\n", f", controls=C{name}"


def solid(dice, units, name, first, law, inner, outer, bottom, top, cells, heat, area=False, flat=False):
    """Returns a block of solid elements with the surfaces NAME (all exterior faces) and the node sets of its edges."""
    n, m = cells
    kind = "CAX4R"
    if heat == "coupled":
        kind = TAKES_HEAT
    elif dice.chance(0.15):
        kind = "CAX3"
    elif n % 2 == 0 and m % 2 == 0 and not area and law.law not in FLUIDS and dice.chance(0.2):
        kind = "CAX6M"
    wobble = 0.0 if dice.chance(0.5) or kind == "CAX6M" else dice.uniform(0.0, 0.3)
    width, height = (outer - inner) / n, (top - bottom) / m
    taper = dice.uniform(0.0, 0.3) if dice.chance(0.2) and not flat else 0.0

    def node(i, j):
        return first + i + j * (n + 1)

    text = f"*Node, nset=N{name}\n"
    for j in range(m + 1):
        for i in range(n + 1):
            edge_r, edge_z = i in (0, n), j in (0, m)
            r = inner + width * (i + (0.0 if edge_r else dice.uniform(-wobble, wobble)))
            z = bottom + height * (j + (0.0 if edge_z else dice.uniform(-wobble, wobble)))
            # A rounded lower face.
            z += taper * (top - bottom) * (r / outer) ** 2 * (1.0 - j / m)
            text += f" {node(i, j)}, {r * units.length!r}, {z * units.length!r}\n"
    text += f"*Element, type={kind}, elset={name}\n"
    count = 0
    lowest = []
    if kind == "CAX6M":
        for j in range(0, m, 2):
            for i in range(0, n, 2):
                a, b, c, d = node(i, j), node(i + 2, j), node(i + 2, j + 2), node(i, j + 2)
                lowest += [first + count] if j == 0 else []
                below, right, middle = node(i + 1, j), node(i + 2, j + 1), node(i + 1, j + 1)
                above, left = node(i + 1, j + 2), node(i, j + 1)
                text += f" {first + count}, {a}, {b}, {c}, {below}, {right}, {middle}\n"
                text += f" {first + count + 1}, {a}, {c}, {d}, {middle}, {above}, {left}\n"
                count += 2
    else:
        for j in range(m):
            for i in range(n):
                a, b, c, d = node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)
                lowest += [first + count] if j == 0 else []
                if kind == "CAX3":
                    text += f" {first + count}, {a}, {b}, {c}\n {first + count + 1}, {a}, {c}, {d}\n"
                    count += 2
                else:
                    text += f" {first + count}, {a}, {b}, {c}, {d}\n"
                    count += 1
    for edge, begin, end, step in (
        ("I", node(0, 0), node(0, m), n + 1),
        ("O", node(n, 0), node(n, m), n + 1),
        ("B", node(0, 0), node(n, 0), 1),
        ("T", node(0, m), node(n, m), 1),
    ):
        text += f"*Nset, nset={name}{edge}, generate\n {begin}, {end}, {step}\n"
    text += f"*Surface, name={name}\n {name},\n*Surface, name={name}FOOT\n"
    text += "".join(f" {element}, S1\n" for element in lowest)
    card, by_name = controls(dice, law, name, area, kind)
    text += f"{card}*Solid Section, elset={name}, material=M{name}{by_name}\n{law.cards}"
    edge = min(width, height) * (1.0 - 1.5 * wobble) * (0.5 if kind == "CAX3" else 1.0)
    return Body(name, text, count, edge, inner, outer, bottom, top, law, quads=kind != "CAX3")


def shell(dice, units, name, first, law, radius, bottom, top, cells):
    """Returns a shell: a tube, a plate or a part of a sphere, with the surface NAME (both sides)."""
    kind = dice.choice(("tube", "plate", "sphere"))
    text = f"*Node, nset=N{name}\n"
    length = 0.0
    places = []
    for i in range(cells + 1):
        x = i / cells
        if kind == "tube":
            r, z = radius, bottom + (top - bottom) * x
        elif kind == "plate":
            r, z = radius * x, bottom
        else:
            r, z = radius * math.sin(0.5 * math.pi * x), bottom + radius * (1.0 - math.cos(0.5 * math.pi * x))
        places.append((r, z))
        text += f" {first + i}, {r * units.length!r}, {z * units.length!r}\n"
    length = math.dist(places[0], places[1])
    text += f"*Element, type=SAX1, elset={name}\n"
    for i in range(cells):
        text += f" {first + i}, {first + i}, {first + i + 1}\n"
    text += f"*Nset, nset={name}B\n {first},\n*Nset, nset={name}T\n {first + cells},\n"
    text += f"*Nset, nset={name}I\n {first},\n*Nset, nset={name}O\n {first + cells},\n"
    thickness = length * dice.power(-1.3, 0.0)
    text += f"*Surface, name={name}\n {name},\n*Surface, name={name}UP\n {name}, SPOS\n"
    text += (
        f"*Shell Section, elset={name}, material=M{name}\n {thickness * units.length:.12g}, {dice.choice((3, 5, 9))}\n"
    )
    text += law.cards
    level = max(z for _, z in places)
    body = Body(name, text, cells, min(length, 2.0 * thickness), 0.0, radius, bottom, level, law, shell=True)
    body.on_axis = kind != "tube"
    return body


def interaction(dice, units, soft_modulus, edge, heat, features):
    """Returns the cards of the interaction I, and whether it has a pressure-overclosure relationship."""
    text = "*Surface Interaction, name=I\n"
    behavior = dice.choice(("HARD", "HARD", "HARD", *SOFT))
    per_length = soft_modulus / edge * dice.power(-1.0, 1.0)
    if behavior == "LINEAR":
        text += f"*Surface Behavior, pressure-overclosure=LINEAR\n {per_length * units.stress / units.length:.12g},\n"
    elif behavior == "EXPONENTIAL":
        # Pressure begins below the initial gap of bodies: no energy is stored at the start.
        gap = edge * dice.uniform(0.001, 0.009)
        text += (
            "*Surface Behavior, pressure-overclosure=EXPONENTIAL\n "
            f"{numbers(gap * units.length, per_length * gap * dice.uniform(0.1, 1) * units.stress)}\n"
        )
    elif behavior == "TABULAR":
        depth = edge * 0.1
        text += "*Surface Behavior, pressure-overclosure=TABULAR\n 0., 0.\n"
        text += f" {numbers(0.3 * per_length * depth * units.stress, 0.5 * depth * units.length)}\n"
        text += f" {numbers(per_length * depth * units.stress, depth * units.length)}\n"
    friction = dice.choice(("none", "none", "constant", "constant", "decay", "rough", "limit"))
    if friction == "constant":
        text += f"*Friction\n {dice.uniform(0.01, 0.8):.12g},\n"
    elif friction == "decay":
        text += f"*Friction, exponential decay\n {numbers(0.5, 0.1, dice.power(-3, 0) / units.speed)}\n"
    elif friction == "rough":
        text += "*Friction, rough\n"
    elif friction == "limit":
        text += f"*Friction, taumax={soft_modulus * dice.power(-4, -2) * units.stress:.12g}\n 0.4,\n"
    features.add(f"friction: {friction}")
    if heat == "coupled" and dice.chance(0.7):
        text += f"*Gap Conductance\n {numbers(dice.power(2, 6) * units.conductance, 0)}\n {numbers(0, edge * 0.1 * units.length)}\n"
        text += "*Gap Heat Generation\n 1., 0.5\n" if dice.chance(0.3) else ""
    return text, behavior


def contact(dice, units, pairs, behavior, bodies, features, tied=False):
    """Returns cards of the model and of the step for contact between pairs of surfaces."""
    model, step = "", ""
    soft = behavior != "HARD"
    general = not tied and dice.chance(0.45)
    penalty = not soft and dice.chance(0.5) and all(b.material.law not in WITHOUT_PENALTY for b in bodies)
    if general:
        step += "*Contact\n*Contact Inclusions, all exterior\n*Contact Property Assignment\n , , I\n"
        if penalty:
            step += f"*Contact Controls Assignment, type=SCALE PENALTY\n , , {dice.power(-1, 1):.12g}\n"
        if dice.chance(0.3):
            step += "*Contact Controls Assignment, nodal erosion=YES\n"
    else:
        method = ", mechanical constraint=PENALTY" if penalty else ""
        step += f"*Contact Pair, interaction=I, cpset=P{method}"
        if dice.chance(0.2):
            step += f", weight={dice.choice((0, 0.5, 1))}"
        step += "\n"
        for first, second in pairs:
            one, other = (first, second) if dice.chance(0.5) else (second, first)
            step += f" {one}, {other}\n" if first != second else f" {first},\n"
        if penalty and dice.chance(0.6):
            step += f"*Contact Controls, cpset=P, scale penalty={dice.power(-1, 1):.12g}\n"
    damping = ""
    if (soft or penalty) and dice.chance(0.35):
        damping = f"*Contact Damping, definition=CRITICAL DAMPING FRACTION\n {dice.uniform(0, 1):.12g},\n"
    kind = "general" if general else "pair"
    features.add(f"contact: {kind}, {'penalty' if penalty else behavior.lower()}")
    if damping:
        features.add("contact damping")
    return model, step, damping


def erosion(dice, units, bodies, features):
    if not dice.chance(0.3):
        return ""
    limit = dice.choice(("distortion", "plastic strain", "principal strain", "increment"))
    if limit == "plastic strain" and not all(b.material.plastic for b in bodies):
        limit = "principal strain"
    if limit == "distortion" and any(b.shell for b in bodies):
        limit = "principal strain"
    value = {
        "distortion": dice.uniform(0.01, 0.3),
        "plastic strain": dice.power(-1.3, 0.3),
        "principal strain": dice.power(-1.3, 0.3),
        "increment": min(b.edge / b.material.sound for b in bodies) * dice.power(-1.5, -0.3) * units.time,
    }[limit]
    features.add(f"erosion: {limit}")
    return f"*Erosion, {limit}={value:.12g}\n"


def mass_scaling(dice, stable, units, features):
    if not dice.chance(0.12):
        return ""
    target = stable * dice.uniform(1.0, 2.5) * units.time
    kind = dice.choice(("BELOW MIN", "UNIFORM", "SET EQUAL DT"))
    features.add("mass scaling")
    if dice.chance(0.5):
        choice = f"factor={dice.uniform(1, 4):.12g}" if dice.chance(0.3) else f"dt={target:.12g}, type={kind}"
        return f"*Fixed Mass Scaling, {choice}\n"
    every = f"frequency={dice.choice((1, 10, 50))}" if dice.chance(0.6) else f"number interval={dice.choice((3, 20))}"
    return f"*Variable Mass Scaling, dt={target:.12g}, type={kind}, {every}\n"


class Builder:
    """Collects the parts of a scene."""

    def __init__(self, seed, number):
        self.dice = Dice(seed * 1_000_003 + number)
        self.seed, self.number = seed, number
        self.units = Units(self.dice.choice(tuple(Units.SYSTEMS)))
        self.features = {f"units: {self.units.name}"}
        self.heat = self.dice.choice(("", "", "", "adiabatic", "coupled"))
        self.model, self.conditions = "", ""
        self.bodies = []
        self.loaded = False
        self.length = self.dice.power(-3.0, -0.5)
        self.area = self.dice.chance(0.06)
        if self.area:
            self.features.add("area weighting")
            self.heat = ""

    def law(self, name, laws=LAWS):
        allowed = tuple(law for law in laws if law in AREA_LAWS) if self.area else laws
        law = material(self.dice, self.units, name, allowed, self.heat, laws is not SHELL_LAWS and not self.area)
        self.features.add(f"material: {law.law}")
        return law

    def add(self, body):
        self.bodies.append(body)
        self.model += body.text
        self.features.add("shell" if body.shell else "solid")

    def block(self, name, first, law, bottom, scale=1.0, cells=(7, 8), flat=False):
        dice = self.dice
        width = self.length * scale * dice.uniform(0.5, 1.5)
        n, m = dice.randint(1, cells[0]), dice.randint(1, cells[1])
        height = width * m / n * dice.power(-0.4, 0.4)
        inner = 0.0 if self.on_axis else self.inner
        body = solid(
            dice,
            self.units,
            name,
            first,
            law,
            inner,
            inner + width,
            bottom,
            bottom + height,
            (n, m),
            self.heat,
            self.area,
            flat,
        )
        self.add(body)
        return body

    def stable(self):
        """Returns an estimate of the stable time increment in seconds."""
        return min(0.7 * b.edge / b.material.sound for b in self.bodies)

    def slowest(self):
        return min(b.material.sound for b in self.bodies)

    def hold_axis(self):
        """Holds nodes on the axis of symmetry along r."""
        rows = "".join(f" {b.name}I, 1, 1\n" for b in self.bodies if b.inner == 0.0 and not b.shell)
        for b in self.bodies:
            if b.shell and b.on_axis:
                rows += f" {b.name}B, XSYMM\n"
        return rows

    def velocity(self, sets, speed):
        rows = "".join(
            f" {name}, 2, {value * self.units.speed:.12g}\n" for name, value in zip(sets, speed, strict=True)
        )
        self.model += f"*Initial Conditions, type=VELOCITY\n{rows}"

    def temperatures(self):
        if not self.heat and not any("expansion" in b.material.law for b in self.bodies):
            return
        if self.heat == "" or all(b.material.law in FLUIDS for b in self.bodies):
            return
        rows = "".join(f" N{b.name}, {self.dice.uniform(280, 400):.6g}\n" for b in self.bodies)
        self.model += f"*Initial Conditions, type=TEMPERATURE\n{rows}"

    def finish(self, name, boundary, conditions, time=None, later=None):
        """Returns the scene: `boundary` are rows of *BOUNDARY, `conditions` further cards of the first step."""
        dice, units = self.dice, self.units
        self.temperatures()
        self.model += "".join(b.material.initial for b in self.bodies)
        if self.bodies:
            stable = self.stable()
            most = stable * dice.uniform(*INCREMENTS)
            time = most if time is None else min(time, 2.0 * most)
        procedure, options = "Dynamic", ""
        if self.heat == "coupled":
            procedure = "Dynamic Temperature-displacement"
            self.features.add("coupled heat")
        elif self.heat == "adiabatic":
            options, _ = ", adiabatic", self.features.add("adiabatic")
        if self.bodies and dice.chance(0.3):
            options += ", element by element"
        controls_of_step = ""
        if self.bodies and not self.area and dice.chance(0.25):
            controls_of_step += dice.choice(
                ("*Bulk Viscosity\n 0., 0.\n", "*Bulk Viscosity, linear term=UNFILTERED\n 0.06, 1.2\n")
            )
        if self.bodies and not self.area and not any(b.material.stores for b in self.bodies):
            controls_of_step += mass_scaling(dice, self.stable(), units, self.features)
        held = f"*Boundary\n{boundary}" if boundary else ""
        steps = [Step(time * units.time, procedure, options, controls_of_step, held + conditions)]
        if dice.chance(0.25):
            self.features.add("several steps")
            for _ in range(dice.randint(1, 2)):
                cards = later(dice) if later else ""
                # A condition that stops moving nodes does work.
                self.loaded |= bool(cards)
                steps.append(
                    Step(time * units.time * dice.uniform(0.2, 1.0), procedure, options, controls_of_step, cards)
                )
        elements = sum(b.elements for b in self.bodies)
        stores = any(b.material.stores for b in self.bodies)
        return Scene(
            self.seed,
            self.number,
            f"{name} ({units.name})",
            units,
            self.model,
            steps,
            elements,
            self.loaded,
            stores,
            self.features,
        )

    @property
    def laws_of_heat(self):
        if self.heat == "coupled":
            return tuple(
                law for law in LAWS if law not in FLUIDS and law != "Us-Up metal" and not law.startswith("foam")
            )
        return LAWS


def wall_text(units, kind, level, extent, mass, name="W", first=90001):
    """Returns a rigid wall at a level, its surface W and the reference node set WREF."""
    far, z = extent * 20 * units.length, level * units.length
    text = f"*Node, nset={name}REF\n {first}, 0., {z!r}\n"
    if mass:
        text += f"*Element, type=MASS, elset={name}MASS\n {first + 5}, {first}\n*Mass, elset={name}MASS\n {mass * units.mass:.12g},\n"
    if kind == "analytical":
        text += f"*Surface, name={name}, type=SEGMENTS\n START, 0., {z!r}\n LINE, {far!r}, {z!r}\n"
        return text + f"*Rigid Body, ref node={first}, analytical surface={name}\n"
    text += f"*Node\n {first + 1}, 0., {z!r}\n {first + 2}, {far!r}, {z!r}\n"
    text += f"*Element, type=RAX2, elset={name}LINE\n {first}, {first + 2}, {first + 1}\n"
    text += f"*Surface, name={name}\n {name}LINE, SNEG\n"
    return text + f"*Rigid Body, ref node={first}, elset={name}LINE\n"


def impact_on_wall(build):
    """A body hits a rigid wall, fixed or with mass."""
    dice, units = build.dice, build.units
    law = build.law("A", build.laws_of_heat)
    if build.heat != "coupled" and dice.chance(0.2):
        law = build.law("A", SHELL_LAWS)
        build.add(
            shell(dice, units, "A", 1, law, build.length, 0.0, build.length * dice.uniform(0.5, 3), dice.randint(4, 20))
        )
    else:
        build.block("A", 1, law, 0.0)
    body = build.bodies[0]
    moving = dice.chance(0.3)
    mass = (
        law.density * math.pi * body.outer**2 * (body.top - body.bottom + body.edge) * dice.power(-1, 1)
        if moving
        else 0.0
    )
    kind = dice.choice(("analytical", "facet"))
    gap = 0.01 * body.edge + (body.edge if body.shell else 0.0)
    build.model += wall_text(units, kind, -gap, body.outer, mass)
    speed = law.sound * dice.power(-3, -0.6)
    build.velocity(["NA"], [-speed])
    cards, behavior = interaction(dice, units, law.modulus, body.edge, build.heat, build.features)
    model, step, damping = contact(dice, units, [("A", "W")], behavior, build.bodies, build.features)
    build.model += cards + damping + erosion(dice, units, build.bodies, build.features) + model
    held = build.hold_axis() + ("" if moving else " WREF, 2, 2\n")
    time = gap / speed + (body.top - body.bottom + body.edge) / law.sound * dice.power(-0.2, 1.2)
    return build.finish(f"{law.law} on a {kind} wall", held, step, time)


def two_bodies(build):
    """Two bodies collide."""
    dice, units = build.dice, build.units
    lower_law, upper_law = build.law("A", build.laws_of_heat), build.law("B", build.laws_of_heat)
    lower = build.block("A", 1, lower_law, 0.0)
    gap = 0.01 * lower.edge
    upper = build.block("B", 10001, upper_law, lower.top + gap, dice.uniform(0.4, 1.4))
    speed = build.slowest() * dice.power(-3, -0.6)
    build.velocity(["NB"], [-speed])
    if dice.chance(0.3):
        build.velocity(["NA"], [0.3 * speed])
    softer = min(lower_law.modulus, upper_law.modulus)
    cards, behavior = interaction(dice, units, softer, min(lower.edge, upper.edge), build.heat, build.features)
    model, step, damping = contact(dice, units, [("A", "B")], behavior, build.bodies, build.features)
    build.model += cards + damping + erosion(dice, units, build.bodies, build.features) + model
    held = build.hold_axis() + (" AB, 2, 2\n" if dice.chance(0.5) else "")
    time = gap / speed + (upper.top - lower.bottom) / build.slowest() * dice.power(-0.5, 1.0)

    def later(more):
        return more.choice(("", "*Boundary, op=NEW\n" + (held or " AB, 2, 2\n")))

    return build.finish(f"{upper_law.law} on {lower_law.law}", held, step, time, later)


def rigid_nose(build):
    """A rigid sphere or cone enters a block or a shell."""
    dice, units = build.dice, build.units
    build.on_axis = True
    if build.heat != "coupled" and dice.chance(0.35):
        law = build.law("A", SHELL_LAWS)
        body = shell(dice, units, "A", 1, law, build.length, 0.0, build.length, dice.randint(6, 24))
        build.add(body)
        if not body.on_axis:
            return impact_between_plates(build)
        # The nose meets the lowest point, on the axis, from below.
        tip, up = body.bottom - 1.1 * body.edge, -1.0
    else:
        law = build.law("A", build.laws_of_heat)
        body = build.block("A", 1, law, -build.length, cells=(10, 10))
        tip, up = body.top + 0.02 * body.edge, 1.0
    radius = body.outer * dice.uniform(0.2, 0.7)
    corners = [(0.0, 0.0)]
    if dice.chance(0.5):
        corners += [(radius * math.sin(a), radius * (1 - math.cos(a))) for a in (0.3, 0.6, 0.9, 1.2, 1.5)]
    else:
        corners += [(radius, radius * dice.uniform(0.1, 1.5))]
    corners.append((corners[-1][0], corners[-1][1] + radius))
    text = f"*Node, nset=NOSEREF\n 80000, 0., {tip * units.length!r}\n*Node\n"
    for i, (r, z) in enumerate(corners):
        text += f" {80001 + i}, {r * units.length!r}, {(tip + up * z) * units.length!r}\n"
    text += "*Element, type=RAX2, elset=NOSE\n"
    for i in range(len(corners) - 1):
        text += f" {80001 + i}, {80001 + i}, {80002 + i}\n"
    side = "SNEG" if up > 0 else "SPOS"
    mass = law.density * radius**3 * dice.power(-0.5, 1.5)
    text += f"*Element, type=MASS, elset=NOSEMASS\n 80100, 80000\n*Mass, elset=NOSEMASS\n {mass * units.mass:.12g},\n"
    text += f"*Surface, name=NOSE\n NOSE, {side}\n*Rigid Body, ref node=80000, elset=NOSE\n"
    build.model += text
    speed = law.sound * dice.power(-2.5, -0.5)
    build.velocity(["NOSEREF"], [-up * speed])
    cards, behavior = interaction(dice, units, law.modulus, body.edge, build.heat, build.features)
    model, step, damping = contact(dice, units, [("NOSE", "A")], behavior, build.bodies, build.features)
    build.model += cards + damping + erosion(dice, units, build.bodies, build.features) + model
    held = build.hold_axis() + (
        " AO, 2, 2\n" if dice.chance(0.5) else (" AB, 2, 2\n" if not body.shell else " AO, PINNED\n")
    )
    build.features.add("rigid nose")
    return build.finish(f"rigid nose into {law.law}", held, step, radius / speed * dice.power(-0.5, 0.7))


def impact_between_plates(build):
    """A tube is crushed between two rigid plates, with self-contact."""
    dice, units = build.dice, build.units
    if build.bodies:
        body = build.bodies[0]
        law = body.material
    else:
        law = build.law(
            "A", ("plastic", "perfectly plastic", "power law", "elastic", "neo-Hooke", "ductile damage, displacement")
        )
        radius = build.length
        wall = radius * dice.uniform(0.05, 0.3)
        rows = dice.randint(8, 40)
        height = radius * dice.uniform(1, 4)
        body = solid(
            dice,
            units,
            "A",
            1,
            law,
            radius,
            radius + wall,
            0.0,
            height,
            (dice.randint(1, 3), rows),
            build.heat,
            build.area,
        )
        build.add(body)
    gap = 0.01 * body.edge + (0.6 * body.edge if body.shell else 0.0)
    build.model += wall_text(units, "facet", -gap, body.outer, 0.0)
    upper = wall_text(units, "facet", body.top + gap, body.outer, 0.0, "V", 91001)
    build.model += upper.replace("VLINE, SNEG", "VLINE, SPOS")
    speed = law.sound * dice.power(-2.2, -1.0)
    cards, behavior = interaction(dice, units, law.modulus, body.edge, build.heat, build.features)
    model, step, damping = contact(
        dice, units, [("A", "W"), ("A", "V"), ("A", "A")], behavior, build.bodies, build.features
    )
    build.model += cards + damping + erosion(dice, units, build.bodies, build.features) + model
    build.model += "*Amplitude, name=START, definition=SMOOTH STEP, time=TOTAL TIME\n "
    build.model += f"0., 0., {20 * build.stable() * units.time:.12g}, 1.\n"
    drive = f"*Boundary, type=VELOCITY, amplitude=START\n VREF, 2, 2, {-speed * units.speed:.12g}\n"
    build.loaded = True
    build.features.add("self-contact")
    time = 0.6 * (body.top - body.bottom) / speed
    return build.finish(f"{law.law} tube crushed", build.hold_axis() + " WREF, 2, 2\n", drive + step, time)


def single_body(build):
    """One body under loads, prescribed motion or springs."""
    dice, units = build.dice, build.units
    use_shell = build.heat != "coupled" and dice.chance(0.35)
    law = build.law("A", SHELL_LAWS if use_shell else build.laws_of_heat)
    if use_shell:
        body = shell(
            dice, units, "A", 1, law, build.length, 0.0, build.length * dice.uniform(0.5, 2), dice.randint(4, 30)
        )
        build.add(body)
        held = build.hold_axis() + (" AO, PINNED\n" if body.on_axis else " AB, ENCASTRE\n")
    else:
        body = build.block("A", 1, law, 0.0, cells=(8, 12))
        held = build.hold_axis() + " AB, 2, 2\n"
    pressure = law.modulus * dice.power(-5, -1.5) * (0.01 if use_shell else 1.0)
    build.loaded = True
    crossing = (body.outer + body.top - body.bottom) / law.sound
    build.model += f"*Amplitude, name=RAMP, definition=SMOOTH STEP, time=TOTAL TIME\n 0., 0., {0.5 * crossing * units.time:.12g}, 1.\n"
    timing = dice.choice(("", ", amplitude=RAMP"))
    load = dice.choice(
        ("pressure", "gravity", "force", "driven", "spring", "viscous pressure", "traction", "heat flux")
    )
    if load == "heat flux" and build.heat != "coupled":
        load = "pressure"
    p = pressure * units.stress
    force = pressure * math.pi * body.outer**2 * units.force
    weight = pressure / law.density / (body.top - body.bottom + body.edge) * units.acceleration
    surface = "AUP" if use_shell else "A"
    cards = {
        "pressure": f"*Dsload{timing}\n {surface}, P, {p:.12g}\n",
        "gravity": f"*Dload{timing}\n A, GRAV, {weight:.12g}, 0., -1.\n",
        "force": f"*Cload{timing}\n AT, 2, {-0.2 * force:.12g}\n",
        "driven": f"*Boundary, type=VELOCITY{timing}\n AT, 2, 2, {law.sound * dice.power(-3, -1) * dice.choice((1, -1)) * units.speed:.12g}\n",
        "viscous pressure": f"*Dsload{timing}\n {surface}, P, {p:.12g}\n*Dsload\n {surface}, VP, {0.1 * law.density * law.sound * units.stress / units.speed:.12g}\n",
        "traction": f"*Dsload{timing}, follower=NO\n {surface}, TRVEC, {p:.12g}, 0.3, 1.\n",
        "heat flux": f"*Dsflux\n A, S, {dice.power(3, 8) * units.conductance:.12g}\n",
        "spring": f"*Cload{timing}\n AT, 2, {-0.2 * force:.12g}\n",
    }[load]
    if load == "spring":
        stiffness = law.modulus * body.edge * dice.power(-2, 0) * units.stiffness
        damper = law.density * law.sound * body.edge**2 * dice.power(-1, 0) * units.mass / units.time
        node = 1
        build.model += f"*Element, type=SPRING1, elset=SP\n 70001, {node}\n*Spring, elset=SP\n 2,\n {stiffness:.12g},\n"
        build.model += f"*Element, type=DASHPOT1, elset=DP\n 70002, {node}\n*Dashpot, elset=DP\n 2,\n {damper:.12g},\n"
        held = build.hold_axis() + (" AO, PINNED\n" if use_shell else "")
    build.features.add(f"load: {load}")
    build.model += erosion(dice, units, build.bodies, build.features)

    def later(more):
        return more.choice(("", "*Dsload, op=NEW\n" if load in ("pressure", "traction", "viscous pressure") else ""))

    return build.finish(f"{law.law}, {load}", held, cards, crossing * dice.power(0, 1.2), later)


def tied_bodies(build):
    """Two tied bodies, the lower one hits a wall."""
    dice, units = build.dice, build.units
    laws = tuple(law for law in build.laws_of_heat if law not in FLUIDS)
    lower_law = build.law("A", laws)
    lower = build.block("A", 1, lower_law, 0.0)
    upper_law = build.law("B", laws)
    upper = build.block("B", 10001, upper_law, lower.top, dice.uniform(0.5, 1.0), flat=True)
    slave, master = ("B", "A") if dice.chance(0.5) else ("A", "B")
    build.model += f"*Tie, name=T, position tolerance={0.4 * min(lower.edge, upper.edge) * units.length:.12g}\n {slave}, {master}\n"
    kind = dice.choice(("analytical", "facet"))
    gap = 0.01 * lower.edge
    build.model += wall_text(units, kind, -gap, lower.outer, 0.0)
    speed = build.slowest() * dice.power(-3, -0.8)
    build.velocity(["NA", "NB"], [-speed, -speed])
    cards, behavior = interaction(dice, units, lower_law.modulus, lower.edge, build.heat, build.features)
    model, step, damping = contact(dice, units, [("AFOOT", "W")], behavior, build.bodies, build.features, True)
    build.model += cards + damping + erosion(dice, units, build.bodies, build.features) + model
    build.features.add("tie")
    held = build.hold_axis() + " WREF, 2, 2\n"
    time = gap / speed + (upper.top - lower.bottom) / build.slowest() * dice.power(-0.3, 1.0)
    return build.finish(f"{upper_law.law} tied to {lower_law.law}", held, step, time)


def three_bodies(build):
    """A body hits two stacked plates."""
    dice, units = build.dice, build.units
    lowest = build.block("A", 1, build.law("A", build.laws_of_heat), 0.0)
    middle = build.block(
        "B", 10001, build.law("B", build.laws_of_heat), lowest.top + 0.01 * lowest.edge, dice.uniform(0.5, 1.3), (7, 4)
    )
    gap = 0.01 * middle.edge
    upper = build.block(
        "D", 20001, build.law("D", build.laws_of_heat), middle.top + gap, dice.uniform(0.3, 0.8), (5, 6)
    )
    speed = build.slowest() * dice.power(-3, -0.6)
    build.velocity(["ND"], [-speed])
    modulus = min(b.material.modulus for b in build.bodies)
    cards, behavior = interaction(dice, units, modulus, min(b.edge for b in build.bodies), build.heat, build.features)
    model, step, damping = contact(dice, units, [("A", "B"), ("B", "D")], behavior, build.bodies, build.features)
    build.model += cards + damping + erosion(dice, units, build.bodies, build.features) + model
    held = build.hold_axis() + (" AB, 2, 2\n" if dice.chance(0.5) else "")
    time = gap / speed + upper.top / build.slowest() * dice.power(-0.4, 0.8)
    return build.finish("three bodies", held, step, time)


def cavity_target(build):
    """A rigid or deformable projectile enters a target that is a resistance law."""
    dice, units = build.dice, build.units
    build.on_axis = True
    build.heat = ""
    strength, density = dice.power(7.5, 9.0), dice.uniform(1500, 8000)
    coefficients = (dice.uniform(2, 6), dice.choice((0.0, dice.uniform(0, 1.5))), dice.uniform(0.5, 1.5))
    radius = build.length * 0.3
    deep = radius * dice.power(0, 1.5)
    friction = dice.choice((0.0, dice.uniform(0, 0.2)))
    options = dice.choice(
        (
            "",
            ", free surface=ON",
            ", free surface=LAYERS",
            ", separation=ON",
            f", crater={2 * radius * units.length:.12g}",
        )
    )
    target = (
        f"*Material, name=TARGET\n*Density\n {density * units.density:.12g},\n*Cavity Expansion, yield={strength * units.stress:.12g}\n"
        f" {numbers(*coefficients)}\n*Elastic\n {numbers(70e9 * units.stress, 0.33)}\n*Plastic\n {numbers(strength * units.stress, 0)}\n*Target, name=BLOCK, front=0., direction=-1{options}\n"
    )
    layers = dice.randint(1, 3)
    for index in range(layers):
        target += f" TARGET, {deep * dice.uniform(0.3, 1) * units.length:.12g}\n"
        if index + 1 < layers and dice.chance(0.3):
            target += f" , {0.3 * radius * units.length:.12g}\n"
    build.model += target
    speed = math.sqrt(strength / density) * dice.power(-0.5, 0.8)
    build.features.add("cavity loads")
    build.loaded = True
    if dice.chance(0.5):
        count = dice.randint(2, 20)
        height = radius * dice.uniform(0.5, 3)
        text = f"*Node, nset=REF\n 80000, 0., {height * units.length!r}\n*Node\n"
        for i in range(count + 1):
            x = i / count
            text += f" {i + 1}, {radius * math.sqrt(x) * units.length!r}, {height * x * units.length!r}\n"
        text += "*Element, type=RAX2, elset=NOSE\n" + "".join(f" {i}, {i}, {i + 1}\n" for i in range(1, count + 1))
        mass = 7800 * radius**3 * dice.power(0, 1.3)
        text += f"*Element, type=MASS, elset=PM\n 80100, 80000\n*Mass, elset=PM\n {mass * units.mass:.12g},\n"
        text += "*Rigid Body, ref node=80000, elset=NOSE\n*Surface, name=NOSE\n NOSE, SNEG\n"
        build.model += text
        build.velocity(["REF"], [-speed])
        conditions = f"*Dsload, target=BLOCK, friction={friction:.12g}\n NOSE, CAVITY\n"
        scene = build.finish("rigid projectile, cavity", "", conditions, deep / speed * dice.power(0, 0.7))
        return scene
    law = build.law(
        "A",
        ("elastic", "plastic", "Johnson-Cook", "perfectly plastic", "shear failure", "ductile damage, displacement"),
    )
    body = solid(
        dice,
        units,
        "A",
        1,
        law,
        0.0,
        radius,
        1e-3 * radius,
        radius * dice.uniform(2, 6),
        (dice.randint(2, 4), dice.randint(4, 16)),
        "",
        build.area,
    )
    build.add(body)
    build.velocity(["NA"], [-min(speed, 0.3 * law.sound)])
    build.model += erosion(dice, units, build.bodies, build.features)
    conditions = f"*Dsload, target=BLOCK, friction={friction:.12g}\n A, CAVITY\n"
    return build.finish(
        f"{law.law} projectile, cavity", build.hold_axis(), conditions, deep / speed * dice.power(-0.5, 0.5)
    )


KINDS = (
    (two_bodies, 30),
    (impact_on_wall, 20),
    (rigid_nose, 14),
    (single_body, 12),
    (tied_bodies, 8),
    (three_bodies, 7),
    (impact_between_plates, 5),
    (cavity_target, 4),
)


def scene(seed, number):
    """Returns the scene with a number."""
    build = Builder(seed, number)
    build.on_axis = build.dice.chance(0.6)
    build.inner = build.length * build.dice.power(-1.0, 1.0)
    kinds = [kind for kind, weight in KINDS for _ in range(weight)]
    return build.dice.choice(kinds)(build)
