"""Run times of the Python package: ``python tests/python/cost.py [SHOTS]`` in the checkout, on an idle machine.

Needs SALib and numba. The shots are those of ``docs/python.md``.
"""

from __future__ import annotations

import resource
import sys
import time
from collections.abc import Callable
from typing import Any

import numba
import numpy as np
import revolve as rv
from SALib.sample import sobol

DEPTH = "-1000*final(U2@REF)"


def best(work: Callable[[], Any], times: int, excluded: Callable[[Any], float] = lambda _: 0.0) -> float:
    """Return the shortest of several run times, less the time given by ``excluded``."""
    shortest = float("inf")
    for _ in range(times):
        begin = time.perf_counter()
        result = work()
        shortest = min(shortest, time.perf_counter() - begin - excluded(result))
    return shortest


def tables(shots: int) -> None:
    """Print the run time and memory of many shots on one thread and on two."""
    deck = rv.Deck("input/ogive.inp")
    rng = np.random.default_rng(1)
    samples = {"V": rng.uniform(500, 900, shots), "friction": rng.uniform(0, 0.05, shots)}
    few = {name: values[: shots // 5] for name, values in samples.items()}
    one = best(lambda: deck.evaluate(few, DEPTH, threads=1), 1) / (shots // 5)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    two = best(lambda: deck.evaluate(samples, DEPTH, threads=2), 1) / shots
    grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    print(
        f"shot: {1e6 * one:.1f} us on one thread, {1e6 * two:.1f} on two ({one / two:.2f} x); {grown / 1024:.1f} MiB more"
    )


def sobols() -> None:
    """Print the time of 512 SALib samples, including deck and samples."""
    for third, bounds in (("mass", [0.02, 0.022]), ("CRH", [2, 4])):
        problem = {"num_vars": 3, "names": ["V", "friction", third], "bounds": [[500, 900], [0, 0.05], bounds]}

        def work(problem: dict[str, Any] = problem) -> Any:
            samples = sobol.sample(problem, 128, calc_second_order=False, seed=1)[:512]
            return rv.sampler(rv.Deck("input/ogive.inp"), problem["names"], DEPTH)(samples)

        print(f"512 samples of V, friction, {third}: {best(work, 3):.3f} s")


def calls() -> None:
    """Print the overhead of a call in addition to its run."""
    deck = rv.Deck("input/ogive.inp")
    table = {"V": np.full(40, 821.0)}
    alone = best(lambda: deck.evaluate(table, DEPTH, threads=1), 200) / 40
    once = best(lambda: deck.evaluate({"V": 821.0}, DEPTH, threads=1), 3000)
    print(f"evaluate: {1e6 * (once - alone):.1f} us")
    without = best(lambda: deck.run(V=821, frames=False), 1000, lambda run: run.seconds)
    kept = best(lambda: deck.run(V=821), 1000, lambda run: run.seconds)
    print(f"run: {1e6 * without:.1f} us, with frames {1e6 * kept:.1f} us")


@numba.cfunc(rv.cfunc_signature())
def constant_compiled(n, time, coordinates, velocities, normals, pressures):
    """Apply a constant pressure."""
    p = numba.carray(pressures, n)
    for i in range(n):
        p[i] = 1e6


@numba.cfunc(rv.cfunc_signature())
def compiled(n, time, coordinates, velocities, normals, pressures):
    """Apply the pressure of ``input/vdload_cavity.f``."""
    v, normal = numba.carray(velocities, (2, n)), numba.carray(normals, (2, n))
    p = numba.carray(pressures, n)
    for i in range(n):
        into = v[0, i] * normal[0, i] + v[1, i] * normal[1, i]
        p[i] = 276e6 * 5.0394 + 0.9830 * 2710.0 * into * into if into > 0.0 else 0.0


def constant(coordinates, velocities, normals, time, pressures):
    """Apply a constant pressure."""
    pressures.fill(1e6)


def loads() -> None:
    """Print the run time of an increment for several kinds of loads."""
    deck = rv.Deck("input/ogive_user.inp")
    kinds = {
        "VDLOAD in Fortran": {"user": "input/vdload_cavity.f"},
        "numba": {"load": compiled},
        "constant by numba": {"load": constant_compiled},
        "constant by Python": {"load": constant},
    }
    for name, options in kinds.items():
        runs = [deck.run(frames=False, **options).summary["timing"] for _ in range(15)]
        print(f"increment, {name}: {1e9 * min(t['seconds'] / t['increments'] for t in runs):.0f} ns")


if __name__ == "__main__":
    sobols()
    calls()
    loads()
    tables(int(sys.argv[1]) if len(sys.argv) > 1 else 100_000)
