#!/usr/bin/env bash
# pint 0.25.3, unyt 3.2.0, scipp 26.8.0 (PyPI, units of quantities): the names of engineering units in tables of materials.
# Guess: "ton" is the unit of mass of decks in ton, mm and s (steel 7.85e-9 ton/mm^3), kip is the force in ksi, mil a thickness;
#   and the three libraries agree.
# Happens: ton is the short ton of 907.18474 kg in all three, without a message: steel has 7121 in place of 7850 kg/m^3. tonne and t
#   are right in all. kip is 4448 N in pint and unyt, and a mass of 453.592 kg in scipp, where ksi nevertheless is the pressure of
#   the force kip: kip/in^2 and ksi have different dimensions. mil is 25.4 micrometres in unyt and scipp. In pint it is an angle,
#   and a tenth of the mil of artillery: pi/32000, not pi/3200 (1/6400 of a turn).
# Hurt: anyone who converts the densities of a deck in ton, mm, s to SI: masses, impulses and kinetic energies are 9.3 % too small,
#   and nothing else looks wrong, because moduli in MPa convert exactly.
set -euo pipefail
t=$(mktemp -d); trap 'rm -rf "$t"' EXIT; cd "$t"
python3 -m venv v; v/bin/pip install -q pint==0.25.3 unyt==3.2.0 scipp==26.8.0 numpy==2.3.5
v/bin/python - <<'P'
import importlib.metadata, sys
import pint, scipp, unyt
registry = pint.UnitRegistry()
def in_pint(text, unit): return registry(text).to(unit).magnitude
def in_unyt(text, unit): return float(unyt.unyt_quantity(1, text).to(unit))
def in_scipp(text, unit): return scipp.scalar(1.0, unit=text).to(unit=unit).value
libraries = {"pint": in_pint, "unyt": in_unyt, "scipp": in_scipp}
def value(convert, text, unit):
    try: return float(round(convert(text, unit), 9))
    except Exception as error: return type(error).__name__
names = [("ton", "kg"), ("tonne", "kg"), ("t", "kg"), ("kip", "N"), ("kip", "kg"), ("ksi", "Pa"), ("mil", "m"), ("mil", "rad")]
table = {(text, unit): [value(f, text, unit) for f in libraries.values()] for text, unit in names}
print({name: importlib.metadata.version(name) for name in libraries})
for (text, unit), values in table.items(): print(f"1 {text} in {unit}: {values}")
steel = {"pint": in_pint("7.85e-9 ton/mm^3", "kg/m^3"), "unyt": 7.85e-9 * in_unyt("ton/mm**3", "kg/m**3"),
         "scipp": 7.85e-9 * in_scipp("ton/mm^3", "kg/m^3")}
print("7.85e-9 ton/mm^3 in kg/m^3:", {k: float(round(v, 1)) for k, v in steel.items()})
number = lambda x: isinstance(x, float)
ok = (all(abs(x - 907.18474) < 1e-6 for x in table["ton", "kg"]) and table["tonne", "kg"] == table["t", "kg"] == [1000.0] * 3
      and [number(x) for x in table["kip", "N"]] == [True, True, False] and [number(x) for x in table["kip", "kg"]] == [False, False, True]
      and all(abs(x / 6894757.293 - 1) < 1e-6 for x in table["ksi", "Pa"])
      and [number(x) for x in table["mil", "m"]] == [False, True, True] and abs(table["mil", "rad"][0] - 9.8175e-5) < 1e-9
      and all(abs(x - 7121.4) < 0.1 for x in steel.values()))
sys.exit(not ok)
P
