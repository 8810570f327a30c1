"""A study: what refinement says of the limit, and what accuracy costs."""

from __future__ import annotations

from typing import Any

from . import _report


class Study:
    """Settings from coarse to fine, what they gave, and how far that is from the limit."""

    def __init__(self, found: dict[str, Any]) -> None:
        self._found = found

    @property
    def record(self) -> dict[str, Any]:
        """What the program writes as ``<job>_study.json``."""
        return self._found["record"]

    @property
    def limit(self) -> float | None:
        """The exact value, or the estimate of the limit; ``None`` where too little came out."""
        reference = self._found["reference"]
        return None if reference is None else reference["value"]

    @property
    def uncertainty(self) -> float | None:
        """That of the limit; 0 of an exact value."""
        reference = self._found["reference"]
        return None if reference is None else reference["uncertainty"]

    @property
    def reached(self) -> bool | None:
        """Whether the target was reached; ``None`` without one."""
        return self._found["met"]

    @property
    def conclusions(self) -> list[str]:
        """What it comes to, in words."""
        return self._found["conclusions"]

    @property
    def table(self) -> list[dict[str, str]]:
        """One row a setting, as text."""
        return [dict(zip(self._found["header"], row)) for row in self._found["rows"]]

    def charts(self) -> dict[str, str]:
        """Error against cost, and against size, as SVG."""
        charts = {"price": self._found["price_chart"], "order": self._found["order_chart"]}
        return {name: chart for name, chart in charts.items() if chart}

    def __repr__(self) -> str:
        return f"<Study of {len(self._found['rows'])} settings: limit {self.limit}, uncertainty {self.uncertainty}>"

    def _repr_html_(self) -> str:
        table = _report.table(self._found["header"], self._found["rows"])
        return table + _report.paragraphs(self.conclusions) + "".join(self.charts().values())
