"""Growth of CPU time with the number of cards of one kind: exponents by `check` on decks of N, 2 N and 4 N cards."""

import math
import os
import subprocess
import tempfile

METAL = "*Material, name=M\n*Density\n 7850.,\n*Elastic\n 2.1e11, 0.3\n"
SECTION = "*Solid Section, elset=SOLID, material=M\n"


def grid(count, first=1, level=0.0):
    """Returns a strip of `count` elements with the node sets and the surfaces of both long edges."""
    text = "*Node, nset=ALL\n"
    for i in range(count + 1):
        text += f" {first + 2 * i}, {1e-3 * i + 1.0!r}, {level!r}\n {first + 2 * i + 1}, {1e-3 * i + 1.0!r}, {level + 1e-3!r}\n"
    name = f"SOLID{first}" if first > 1 else "SOLID"
    text += f"*Element, type=CAX4R, elset={name}\n"
    for i in range(count):
        a = first + 2 * i
        text += f" {first + i}, {a}, {a + 2}, {a + 3}, {a + 1}\n"
    return text + f"*Surface, name=LOW{first}\n {name}, S1\n*Surface, name=UP{first}\n {name}, S3\n"


def step(cards="", history=""):
    return f"*Step\n*Dynamic, Explicit\n , 1.e-9\n*Boundary\n 1, 2, 2\n{cards}{history}*End Step\n"


def solid(count, model="", cards="", history=""):
    return grid(count) + SECTION + METAL + model + step(cards, history)


def rows(count, text):
    return "".join(text.replace("#", str(i)) for i in range(1, count + 1))


def instances(count):
    part = "*Part, name=P\n" + grid(1) + SECTION + "*End Part\n*Assembly, name=ALL\n"
    each = "".join(f"*Instance, name=I{i}, part=P\n {0.01 * i!r}, 0.\n*End Instance\n" for i in range(count))
    return part + each + "*End Assembly\n" + METAL + step().replace("*Boundary\n 1, 2, 2\n", "")


def two_bodies(count, cards, model=""):
    second = 10 * count + 1
    text = grid(count) + SECTION + grid(count, second, 1.01e-3)
    text += f"*Solid Section, elset=SOLID{second}, material=M\n" + METAL
    text += model.replace("SECOND", f"LOW{second}").replace("FIRST", "UP1")
    return text + step(cards.replace("SECOND", f"LOW{second}").replace("FIRST", "UP1"))


CARDS = {
    "elements": (20_000, lambda n: solid(n)),
    "*BOUNDARY, a node each": (10_000, lambda n: solid(n, cards="*Boundary\n" + rows(n, " #, 2, 2\n"))),
    "*CLOAD, a node each": (10_000, lambda n: solid(n, cards="*Cload\n" + rows(n, " #, 2, 1.\n"))),
    "*DLOAD, an element each": (10_000, lambda n: solid(n, cards="*Dload\n" + rows(n, " #, P1, 1.\n"))),
    "sets": (10_000, lambda n: solid(n, rows(n, "*Nset, nset=N#\n #,\n"))),
    "amplitudes": (
        10_000,
        lambda n: solid(
            n, rows(n, "*Amplitude, name=A#\n 0., 0., 1., 1.\n"), rows(n, "*Cload, amplitude=A#\n #, 2, 1.\n")
        ),
    ),
    "materials": (10_000, lambda n: solid(n, rows(n, METAL.replace("name=M", "name=X#")))),
    "equations": (
        5_000,
        lambda n: solid(2 * n, "".join(f"*Equation\n 2\n {4 * i + 1}, 1, 1., {4 * i + 3}, 1, -1.\n" for i in range(n))),
    ),
    "steps": (1_000, lambda n: solid(4) + rows(n - 1, "*Step\n*Dynamic, Explicit\n , 1.e-9\n*End Step\n")),
    "history columns": (
        5_000,
        lambda n: solid(
            n,
            "*Nset, nset=LATE, generate\n 1, N\n".replace("N\n", f"{n}\n"),
            history="*Output, history, frequency=1\n*Node Output, nset=LATE\n U2\n",
        ),
    ),
    "instances": (1_000, instances),
    "*TIE": (2_000, lambda n: two_bodies(n, "", "*Tie, name=T, position tolerance=1.e-4\n SECOND, FIRST\n")),
    "*CONTACT PAIR": (
        1_000,
        lambda n: two_bodies(n, "*Contact Pair, interaction=I\n SECOND, FIRST\n", "*Surface Interaction, name=I\n"),
    ),
    "two bodies without contact": (
        1_000,
        lambda n: two_bodies(n, "", "*Initial Conditions, type=VELOCITY\n 1, 2, 1.\n"),
    ),
}


def seconds_of(program, text):
    """Returns the CPU time of `check`, and its exit status."""
    with tempfile.TemporaryDirectory(prefix="soak-growth-") as folder:
        deck = os.path.join(folder, "deck.inp")
        with open(deck, "w", encoding="utf-8") as file:
            file.write(text)
        process = subprocess.Popen(
            [program, "check", deck, "--quiet"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        return usage.ru_utime + usage.ru_stime, process.returncode


def report(program):
    """Prints CPU times and exponents; times are not judged."""
    print("\n## Growth\n\n| cards | N | CPU time of N, 2 N, 4 N, s | exponent |\n|---|---|---|---|")
    for name, (count, deck) in CARDS.items():
        found = [seconds_of(program, deck(factor * count)) for factor in (1, 2, 4)]
        times = [seconds for seconds, _ in found]
        exponent = math.log2(max(times[2] - times[1], 1e-9) / max(times[1] - times[0], 1e-9))
        note = "" if all(code == 0 for _, code in found) else f", exit status {found[-1][1]}"
        print(f"| {name} | {count} | {', '.join(f'{t:.2f}' for t in times)} | {exponent:.2f}{note} |", flush=True)
