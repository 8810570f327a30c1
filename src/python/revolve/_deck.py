"""The class ``Deck``: checks, runs, evaluations and convergence studies of an input deck."""

from __future__ import annotations

import html
import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from . import _load, _program, _progress, _report, _revolve, _threads
from ._errors import Diagnostic, HaltedError, read
from ._evaluate import Evaluation, Parameters, sorted_out
from ._load import Load
from ._progress import Progress
from ._report import Ledger
from ._run import Run
from ._study import Limit, Study
from ._view import NotebookView

User = str | os.PathLike[str] | Sequence[str | os.PathLike[str]] | None
"""User subroutine files: Fortran, C or shared libraries."""
Value = float | int | str
"""A value of a ``*PARAMETER``."""

_VIEW_HEIGHT = 900
"""Height of the live view in a notebook, in pixels."""
_KNOWN = 8
"""Largest number of evaluators that a deck caches."""


class Deck:
    """An input deck; its text is read when the object is created.

    ``Deck("ogive.inp")`` reads a file, ``Deck(text=...)`` takes a text. Relative paths of includes refer to the folder
    of the file or of ``name``.
    Decks can be pickled.
    """

    def __init__(
        self,
        path: str | os.PathLike[str] | None = None,
        *,
        text: str | None = None,
        name: str = "deck.inp",
    ) -> None:
        if (path is None) == (text is None):
            raise TypeError("Deck: give either a path or text=")
        self.name = name if path is None else os.fspath(path)
        self._deck = _revolve.Deck(self.name, text)
        self._evaluators: dict[Any, _revolve.Evaluator] = {}

    @property
    def text(self) -> str:
        """Text of the deck, without its includes."""
        return self._deck.text

    def __reduce__(self) -> tuple[Any, ...]:
        return (_again, (self.name, self.text))

    def check(self, *, user: User = None, load: Load | None = None, **parameters: Value) -> list[Diagnostic]:
        """Check the deck; returns errors, warnings and notes with their locations."""
        return read(self._checked(user, load, parameters)["findings"])

    @property
    def ledger(self) -> Ledger:
        """Ledger of the simulated effects and the cards that request them."""
        return Ledger(self._checked(None, None, {})["ledger"])

    @property
    def parameters(self) -> dict[str, float]:
        """Values of the ``*PARAMETER`` of the deck."""
        return dict(self._checked(None, None, {})["parameters"])

    @property
    def units(self) -> dict[str, str]:
        """Units of ``length``, ``mass``, ``time`` and ``temperature``; empty without ``*UNITS``."""
        return self._checked(None, None, {})["units"] or {}

    @property
    def columns(self) -> list[str]:
        """Names of the history columns."""
        return self._checked(None, None, {})["columns"]

    def _checked(self, user: User, load: Load | None, parameters: Mapping[str, Value]) -> dict[str, Any]:
        return json.loads(self._deck.check(_settings(parameters), _compiled(user), _load.resolved(load)))

    def run(
        self,
        *,
        user: User = None,
        load: Load | None = None,
        threads: int | None = None,
        frames: bool = True,
        out: str | os.PathLike[str] | None = None,
        progress: Progress = None,
        view: bool = False,
        check: bool = True,
        **parameters: Value,
    ) -> Run:
        """Run the deck with the given parameter values; results are kept in memory.

        ``user`` gives user subroutine files, ``load`` a load function in Python (see
        :data:`revolve._load.LoadFunction`) or the address of a compiled one. With ``out`` the result files are also
        written to that folder. ``progress`` is called with the completed fraction and a text. ``view`` shows the run
        in a notebook while it writes to ``out``, and afterwards a picture of its last frame. A halted run raises
        :class:`HaltedError` unless ``check`` is false. Ctrl-C ends a run after the current increment.
        """
        folder = None if out is None else Path(out)
        if view and folder is None:
            raise TypeError("Deck.run: view=True needs a result folder, out=")
        told = _progress.resolved(progress)
        live = NotebookView(folder, _VIEW_HEIGHT, told) if view and folder and _progress.in_notebook() else None
        arguments = (_settings(parameters), _compiled(user), _load.resolved(load), _threads.resolved(threads))
        try:
            found = Run(self.name, self._deck.run(*arguments, frames, folder, live or told))
        finally:
            if live is not None:
                live.close()
            _progress.closed(told)
        if check and found.reason is not None:
            raise HaltedError(found.reason, run=found)
        return found

    def evaluate(
        self,
        parameters: Parameters,
        quantities: str | Sequence[str],
        *,
        threads: int | None = 0,
        user: User = None,
        load: Load | None = None,
        in_increments: bool = False,
        progress: Progress = None,
    ) -> Evaluation:
        """Evaluate ``k`` quantities for samples: arrays of ``N`` values per parameter give a table ``(N, k)``.

        A single number applies to all samples. Rows do not depend on the number of threads or on other rows. A failed
        run gives NaN, and its error in ``reasons``. A load function in Python must not depend on earlier calls. With
        ``in_increments`` every run has the bits of ``run``; by default, rigid shots are solved by stages.
        """
        wanted = (quantities,) if isinstance(quantities, str) else tuple(quantities)
        samples = sorted_out(parameters)
        evaluator = self._evaluator(samples.names, samples.fixed, wanted, user, load, in_increments)
        told = _progress.resolved(progress)
        try:
            values, reasons = evaluator.run(samples.table, _threads.resolved(threads), told)
        finally:
            _progress.closed(told)
        return Evaluation(values, wanted, dict(reasons), samples, self)

    def _evaluator(
        self,
        names: tuple[str, ...],
        fixed: tuple[tuple[str, str], ...],
        wanted: tuple[str, ...],
        user: User,
        load: Load | None,
        in_increments: bool,
    ) -> _revolve.Evaluator:
        key = (names, fixed, wanted, load, in_increments) if user is None else None
        try:
            known = self._evaluators.get(key) if key is not None else None
        except TypeError:
            key = known = None
        if known is None:
            routines = (_compiled(user), _load.resolved(load))
            known = self._deck.evaluator(list(names), list(fixed), list(wanted), routines, in_increments)
            if key is not None:
                while len(self._evaluators) >= _KNOWN:
                    self._evaluators.pop(next(iter(self._evaluators)))
                self._evaluators[key] = known
        return known

    def study(
        self,
        refine: Mapping[str, Sequence[Value]],
        quantity: str,
        *,
        target: float | str | None = None,
        exact: float | str | None = None,
        jitter: int | None = None,
        repeat: int = 1,
        threads: int | None = None,
        user: User = None,
        progress: Progress = None,
        **parameters: Value,
    ) -> Study:
        """Run a convergence study.

        ``refine`` gives values from coarse to fine for parameters of the deck or for ``increment`` (factors),
        ``load-velocity``, ``hourglass`` or ``estimate``.
        ``target`` is the largest allowed error (a relative one is a text such as ``"0.5%"``), ``exact`` the exact
        value. Each setting runs ``repeat`` times, one after the other; its run time is the median. ``jitter`` is the
        number of runs with small perturbations that measure the noise (default 8 with contact, failure, element
        deletion or new meshes, otherwise 0).
        """
        levels = [f"{name}={','.join(_written(v) for v in values)}" for name, values in refine.items()]
        told = _progress.resolved(progress)
        try:
            found = _revolve.study(
                self._deck,
                _settings(parameters),
                levels,
                quantity,
                None if exact is None else _written(exact),
                None if target is None else _written(target),
                jitter,
                repeat,
                _threads.resolved(threads),
                _compiled(user),
                told,
            )
        finally:
            _progress.closed(told)
        return Study(json.loads(found))

    def uncertainty(
        self,
        quantities: str | Sequence[str],
        *,
        budget: float = 0.4,
        distributions: Mapping[str, str] | None = None,
        threads: int | None = None,
        user: User = None,
        **parameters: Value,
    ) -> dict[str, Any]:
        """Run the deck in memory and estimate the uncertainty of quantities from cheap companion runs.

        ``budget`` is the largest cost of these runs relative to that of the run. ``distributions`` gives random
        parameters, such as ``{"V": "normal(800, 8)"}``. The result has the keys of ``<job>_certificate.json``; its
        ``conclusions`` are the lines that ``revolve run --uncertainty`` prints.
        """
        wanted = [quantities] if isinstance(quantities, str) else list(quantities)
        random = [f"{name}={of}" for name, of in (distributions or {}).items()]
        count = _threads.resolved(threads)
        return json.loads(
            _revolve.uncertainty(self._deck, _settings(parameters), wanted, budget, random, count, _compiled(user))
        )

    def sensitivity(
        self,
        of: str | Sequence[str],
        to: str | Sequence[str],
        *,
        steps: Mapping[str, float] | None = None,
        jitter: int | None = None,
        threads: int | None = None,
        user: User = None,
        **parameters: Value,
    ) -> dict[str, Any]:
        """Differentiate the quantities ``of`` by the parameters ``to``, at their values in ``parameters`` or in the deck.

        Rigid shots by stages have exact derivatives, other decks those of companion runs. ``steps`` gives the largest
        changes of parameters in these runs, ``jitter`` the number of perturbed runs that measure the noise (default 8
        with contact, failure, element deletion or new meshes, otherwise 0). The result has the keys of
        ``<deck>_sensitivity.json``. A derivative that noise exceeds is ``None``, with a ``reason``.
        """
        wanted = [of] if isinstance(of, str) else list(of)
        names = [to] if isinstance(to, str) else list(to)
        changes = [(steps or {}).get(name) for name in names]
        return json.loads(
            _revolve.sensitivity(
                self._deck,
                _settings(parameters),
                wanted,
                names,
                changes,
                jitter,
                _threads.resolved(threads),
                _compiled(user),
            )
        )

    def limit(
        self,
        velocity: str,
        between: tuple[float, float],
        tolerance: float,
        *,
        residual: str | None = None,
        least: float | None = None,
        shots: int = 12,
        user: User = None,
        threads: int | None = None,
        **parameters: Value,
    ) -> Limit:
        """Find the ballistic limit velocity and the outcomes of slower shots.

        ``velocity`` is the parameter of the deck that holds the striking velocity, ``between`` the search interval,
        ``tolerance`` the largest width of the bracket. ``residual`` and ``least`` are required only for decks
        without a moving projectile, as in ``revolve limit``. ``shots`` are fired on each side of the limit.
        """
        low, high = between
        found = _revolve.limit(
            self._deck,
            _settings(parameters),
            velocity,
            f"{low!r},{high!r}",
            tolerance,
            residual,
            least,
            shots,
            _threads.resolved(threads),
            _compiled(user),
        )
        return Limit(json.loads(found))

    def scatter(
        self,
        distributions: Mapping[str, str],
        quantities: str | Sequence[str],
        *,
        count: int = 1000,
        seed: int = 0,
        sampling: str = "random",
        quantiles: Sequence[float] = (0.05, 0.5, 0.95),
        correlations: Mapping[tuple[str, str], float] | None = None,
        indices: bool = False,
        table: str | os.PathLike[str] | None = None,
        in_increments: bool = False,
        user: User = None,
        threads: int | None = None,
        **parameters: Value,
    ) -> dict[str, Any]:
        """Estimate statistics of quantities for random parameters, and with ``indices`` their Sobol indices.

        ``distributions`` are such as ``{"V": "normal(569, 5)"}``, ``sampling`` is ``random``, ``latin`` or ``sobol``.
        The result has the keys of ``<deck>_scatter.json``: ``estimates`` has one row for each quantity and statistic.
        ``table`` is a file for all samples.
        """
        wanted = [quantities] if isinstance(quantities, str) else quantities
        options = [
            *_program.common(_settings(parameters), user, threads),
            *_program.pairs("distribution", distributions),
            *_program.pairs("correlation", {":".join(names): value for names, value in (correlations or {}).items()}),
            *(("quantity", quantity) for quantity in wanted),
            *(("count", count), ("seed", seed), ("sampling", sampling), ("quantiles", quantiles)),
            *(("indices", indices), ("table", _path(table)), ("in-increments", in_increments)),
        ]
        return _program.record(self, "scatter", options)

    def identify(
        self,
        unknowns: Mapping[str, float | str | tuple[float, float]],
        shots: str | os.PathLike[str],
        measured: Mapping[str, str] | None = None,
        *,
        curves: Mapping[str, str] | None = None,
        deviations: Sequence[str | float] = (),
        starts: int = 1,
        posterior: bool | int = False,
        model_error: bool = False,
        most_runs: int | None = None,
        seed: int = 0,
        in_increments: bool = False,
        user: User = None,
        threads: int | None = None,
        **parameters: Value,
    ) -> dict[str, Any]:
        """Fit parameters of the deck to measured values.

        ``unknowns`` gives a start or bounds ``(low, high)`` for each parameter, ``shots`` is a CSV file with a row for
        each shot, ``measured`` gives the computed quantity for each of its columns, ``curves`` that for columns which
        name files of curves. ``deviations`` are columns or numbers in the order of both. ``posterior`` computes the
        posterior distribution, up to an effective sample size. The result has the keys of ``<deck>_identify.json``.
        """
        options = [
            *_program.common(_settings(parameters), user, threads),
            *_program.pairs("unknown", unknowns),
            ("shots", _path(shots)),
            *(option for column, of in (measured or {}).items() for option in (("measured", column), ("quantity", of))),
            *_program.pairs("curve", curves or {}),
            *(("deviation", deviation) for deviation in deviations),
            *(("starts", starts), ("posterior", posterior), ("model-error", model_error), ("most-runs", most_runs)),
            *(("seed", seed if posterior else None), ("in-increments", in_increments)),
        ]
        return _program.record(self, "identify", options)

    def resistance(
        self,
        to: float,
        *,
        material: str | None = None,
        shape: str = "spherical",
        terms: int = 3,
        points: int | None = None,
        static: bool = False,
        **parameters: Value,
    ) -> dict[str, Any]:
        """Compute the cavity-expansion pressure of a material of the deck up to the velocity ``to``, and fit it.

        ``shape`` is ``spherical`` or ``cylindrical``. The result has the keys of ``revolve resistance --json``.
        """
        options = [
            *(("set", f"{name}={value}") for name, value in _settings(parameters)),
            *(("to", to), ("material", material), ("type", shape), ("terms", terms)),
            *(("points", points), ("static", static)),
        ]
        return _program.record(self, "resistance", options, writes=False)

    def material(
        self,
        name: str | None = None,
        *,
        rates: Sequence[float] | None = None,
        temperatures: Sequence[float] | None = None,
        strain: float = 0.5,
        isothermal: bool = False,
        confinements: Sequence[float] | None = None,
        length: float | None = None,
        user: User = None,
        **parameters: Value,
    ) -> dict[str, Any]:
        """Compute stress over strain of the materials of the deck, or of the material ``name``.

        ``confinements`` are pressures of triaxial compression, ``length`` the element length of damage and cracks. The
        result has the keys of ``revolve material --json``.
        """
        options = [
            *_program.common(_settings(parameters), user, None),
            *(("material", name), ("rates", rates), ("temperatures", temperatures), ("strain", strain)),
            *(("isothermal", isothermal), ("confinements", confinements), ("length", length)),
        ]
        return _program.record(self, "material", options)

    def __repr__(self) -> str:
        return f"<Deck {self.name!r}>"

    def _repr_html_(self) -> str:
        found = self._checked(None, None, {})
        parameters = [(name, f"{value:g}") for name, value in found["parameters"]]
        title = f"<p><b>{html.escape(self.name)}</b> {html.escape(found['title'])}</p>"
        tables = _report.table(["parameter", "value"], parameters) if parameters else ""
        return title + _report.preformatted(found["text"]) + tables + Ledger(found["ledger"])._repr_html_()


def _again(name: str, text: str) -> Deck:
    """Recreate a pickled deck."""
    return Deck(text=text, name=name)


def _written(value: Value) -> str:
    """Format a value for the command line, with all digits of a number."""
    if isinstance(value, str):
        return value
    return repr(int(value)) if isinstance(value, (int, np.integer)) else repr(float(value))


def _path(path: str | os.PathLike[str] | None) -> Path | None:
    return None if path is None else Path(path)


def _settings(parameters: Mapping[str, Value]) -> list[tuple[str, str]]:
    return [(name, _written(value)) for name, value in parameters.items()]


def _compiled(user: User) -> _revolve.User | None:
    if user is None:
        return None
    files = [user] if isinstance(user, (str, os.PathLike)) else list(user)
    return _revolve.compile([Path(file) for file in files], False)
