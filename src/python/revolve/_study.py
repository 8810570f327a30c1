"""Results of convergence studies."""

from __future__ import annotations

from typing import Any

from . import _report


class Study:
    """Result of a convergence study: settings from coarse to fine with values, errors and run times."""

    def __init__(self, found: dict[str, Any]) -> None:
        self._found = found

    @property
    def record(self) -> dict[str, Any]:
        """Record of the study, the contents of ``<job>_study.json``."""
        return self._found["record"]

    @property
    def limit(self) -> float | None:
        """Exact value or estimated limit; ``None`` with too few results."""
        reference = self._found["reference"]
        return None if reference is None else reference["value"]

    @property
    def uncertainty(self) -> float | None:
        """Uncertainty of the limit; 0 for an exact value."""
        reference = self._found["reference"]
        return None if reference is None else reference["uncertainty"]

    @property
    def reached(self) -> bool | None:
        """Whether the error target was reached; ``None`` without a target."""
        return self._found["met"]

    @property
    def conclusions(self) -> list[str]:
        """Conclusions of the study as sentences."""
        return self._found["conclusions"]

    @property
    def table(self) -> list[dict[str, str]]:
        """Table with one row per setting, as text."""
        return [dict(zip(self._found["header"], row)) for row in self._found["rows"]]

    def charts(self) -> dict[str, str]:
        """Charts of error against run time and against size, as SVG."""
        charts = {"price": self._found["price_chart"], "order": self._found["order_chart"]}
        return {name: chart for name, chart in charts.items() if chart}

    def __repr__(self) -> str:
        return f"<Study of {len(self._found['rows'])} settings: limit {self.limit}, uncertainty {self.uncertainty}>"

    def _repr_html_(self) -> str:
        table = _report.table(self._found["header"], self._found["rows"])
        return table + _report.paragraphs(self.conclusions) + "".join(self.charts().values())


class Limit:
    """Ballistic limit velocity with the outcomes of all shots."""

    def __init__(self, found: dict[str, Any]) -> None:
        self._found = found

    @property
    def bracket(self) -> tuple[float, float] | None:
        """Largest velocity without and smallest velocity with perforation; ``None`` without a limit in the interval."""
        bracket = self._found["bracket"]
        return None if bracket is None else (bracket[0], bracket[1])

    @property
    def velocity(self) -> float | None:
        """Limit velocity, the midpoint of the bracket; ``None`` without a limit."""
        return None if self.bracket is None else sum(self.bracket) / 2.0

    @property
    def bands(self) -> list[tuple[str, float, float]]:
        """Outcome, lowest and highest striking velocity of each interval of shots with the same outcome."""
        return [(band["end"], band["from"], band["to"]) for band in self._found["bands"]]

    @property
    def shots(self) -> list[tuple[float, float, str]]:
        """Striking velocity, residual velocity and outcome of each shot."""
        return [(shot["velocity"], shot["residual"], shot["end"]) for shot in self._found["shots"]]

    @property
    def record(self) -> dict[str, Any]:
        """All results, the JSON object of ``revolve limit --json``."""
        return self._found

    def __repr__(self) -> str:
        return f"<Limit of {len(self.shots)} shots: velocity {self.velocity}, bands {self.bands}>"
