"""Finished runs: values, histories and frames."""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from . import _report
from ._report import Ledger

if TYPE_CHECKING:
    import pandas as pd
    import pyvista as pv

    from . import _revolve

_CELLS = {1: 1, 2: 3, 3: 5, 4: 9}
"""VTK cell types by number of corners: vertex, line, triangle, quadrilateral."""


class Run:
    """Results of a run."""

    def __init__(self, title: str, run: _revolve.Run) -> None:
        self._title = title
        self._run = run

    @property
    def status(self) -> str:
        """``completed`` or ``halted``."""
        return self._run.status

    @property
    def verdict(self) -> str:
        """``ok``, ``unverified``, ``suspect``, ``interrupted`` or ``halted``."""
        return self.summary["verdict"]

    @property
    def verdict_reasons(self) -> list[dict[str, str]]:
        """Reasons of the verdict, the worst first: ``code``, ``place``, ``reason``, ``card`` and ``verdict`` of each."""
        return self.summary["verdict_reasons"]

    @property
    def halt(self) -> _revolve.Halt | None:
        """Reason of a halt: ``kind``, ``code``, ``message``, ``element``, ``step``, ``increment``, ``time`` and ``place``.

        Attributes that do not apply are ``None``; the text has code and message. ``None`` for a completed run.
        """
        return self._run.halt

    @property
    def reason(self) -> str | None:
        """Code and message of a halt; ``None`` for a completed run."""
        return None if self.halt is None else str(self.halt)

    @property
    def warnings(self) -> list[str]:
        """Warnings, and notes on bodies that are still moving in a target."""
        return self._run.warnings

    @property
    def seconds(self) -> float:
        """Time in the time loop, in seconds."""
        return self._run.seconds

    def final(self, column: str) -> float:
        """Return the final value of a history column, such as ``"U2@REF"``."""
        return self._run.column(column, "final")

    def min(self, column: str) -> float:
        """Return the smallest value of a history column."""
        return self._run.column(column, "min")

    def max(self, column: str) -> float:
        """Return the largest value of a history column."""
        return self._run.column(column, "max")

    def quantity(self, expression: str) -> float:
        """Return the value of an expression over history columns, such as ``"-1000*final(U2@REF)"``."""
        return self._run.quantity(expression)

    @cached_property
    def arrays(self) -> dict[str, npt.NDArray[np.float64]]:
        """Histories by column name as NumPy arrays; ``time`` and ``step`` are the first."""
        return self._run.history()

    @property
    def history(self) -> dict[str, npt.NDArray[np.float64]] | pd.DataFrame:
        """Histories as a ``pandas.DataFrame`` over ``time`` if pandas is installed, otherwise as :attr:`arrays`."""
        try:
            import pandas as pd
        except ImportError:
            return self.arrays
        return pd.DataFrame(self.arrays).set_index("time")

    @cached_property
    def summary(self) -> dict[str, Any]:
        """Summary of the run, the contents of ``<job>.json``."""
        return json.loads(self._run.summary())

    @cached_property
    def ledger(self) -> Ledger:
        """Ledger of the simulated effects, with shares of the run time."""
        return Ledger(self.summary["ledger"])

    @cached_property
    def frames(self) -> Frames:
        """Frames as pyvista grids, created on access."""
        return Frames(self._run)

    def __repr__(self) -> str:
        steps = self.summary["steps"]
        increments = sum(step["increments"] for step in steps)
        return (
            f"<Run of {self._title!r}: {self.status}, {self.verdict}, {increments} increments in {self.seconds:.3g} s>"
        )

    def _repr_html_(self) -> str:
        facts = [repr(self)[1:-1]] + ([self.reason] if self.reason else []) + self.warnings
        return _report.paragraphs(facts) + "".join(self.charts().values())

    def charts(self) -> dict[str, str]:
        """Draw histories as SVG: one chart per variable, and one for all energies."""
        groups: dict[str, dict[str, npt.NDArray[np.float64]]] = defaultdict(dict)
        for name, values in self.arrays.items():
            if name not in ("time", "step"):
                variable = name.split("@")[0]
                energy = "@" not in name and (name.startswith("ALL") or name == "ETOTAL")
                groups["energies" if energy else variable][name] = values
        time = self.arrays["time"]
        return {label: _report.curves(self._title, label, time, columns) for label, columns in groups.items()}


class Frames(Sequence[Any]):
    """Frames of a run as ``pyvista.UnstructuredGrid``, with their time in ``field_data``."""

    def __init__(self, run: _revolve.Run) -> None:
        self._run = run
        self._reader: Any = None
        if run.series is not None and run.series.exists():
            import pyvista as pv

            self._reader = pv.PVDReader(str(run.series))

    @property
    def times(self) -> list[float]:
        """Total times of the frames."""
        if self._reader is not None:
            return list(self._reader.time_values)
        return [self._run.frame(i)["time"] for i in range(len(self))]

    def arrays(self, index: int) -> dict[str, Any]:
        """Return a frame as NumPy arrays, without pyvista; only for runs in memory."""
        return self._run.frame(range(len(self))[index])

    def __len__(self) -> int:
        return self._run.frame_count if self._reader is None else len(self._reader.time_values)

    def __getitem__(self, index: Any) -> Any:
        if isinstance(index, slice):
            return [self[i] for i in range(*index.indices(len(self)))]
        index = range(len(self))[index]
        if self._reader is not None:
            self._reader.set_active_time_point(index)
            return self._reader.read()[0]
        return _grid(self._run.frame(index))

    def __iter__(self) -> Iterator[pv.UnstructuredGrid]:
        return (self[i] for i in range(len(self)))


def _grid(frame: dict[str, Any]) -> pv.UnstructuredGrid:
    import pyvista as pv

    points = np.column_stack([frame["points"], np.zeros(len(frame["points"]))])
    starts, corners = frame["starts"], frame["corners"]
    counts = np.diff(np.append(starts, len(corners)))
    cells = np.insert(corners, starts, counts)
    kinds = np.array([_CELLS[int(count)] for count in counts], dtype=np.uint8)
    grid = pv.UnstructuredGrid(cells, kinds, points)
    for name, values in frame["point_fields"].items():
        grid.point_data[name] = values
    for name, values in frame["cell_fields"].items():
        grid.cell_data[name] = values
    grid.field_data["TimeValue"] = np.array([frame["time"]])
    return grid
