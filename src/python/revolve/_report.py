"""What decks, ledgers, runs and studies look like on a page."""

from __future__ import annotations

import html
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _revolve

_MOST_POINTS = 2000
"""Points of a curve on a page."""


@dataclass(frozen=True)
class Effect:
    """A row of the ledger: an effect that a deck brings to life."""

    effect: str
    """What it is."""
    count: int
    """How many facets, nodes, bodies, … it acts on."""
    unit: str
    """What is counted."""
    asked_by: tuple[str, ...]
    """``file:line`` of the cards that asked for it."""
    detail: str
    """Law, scheme, values."""
    bytes: int
    """Of its arrays."""
    share: float | None = None
    """Share of the run's time, where it was measured."""


class Ledger(Sequence[Effect]):
    """What is simulated, effect by effect: which card asked, what it holds."""

    def __init__(self, written: dict[str, Any]) -> None:
        self._written = written
        self._rows = [_effect(row) for row in written["effects"]]
        self.unused: list[dict[str, str]] = written["unused"]
        """Cards that change nothing here: ``what``, ``asked_by``, ``why``."""

    def __len__(self) -> int:
        return len(self._rows)

    def __getitem__(self, index: Any) -> Any:
        return self._rows[index]

    def __str__(self) -> str:
        rows = [(r.effect, f"{r.count} {r.unit}", ", ".join(map(_last, r.asked_by)), r.detail) for r in self]
        widths = [max(len(row[i]) for row in rows) for i in range(3)] if rows else [0] * 3
        lines = ["  ".join([*(c.ljust(w) for c, w in zip(row, widths)), row[3]]).rstrip() for row in rows]
        unused = [f"not used: {u['what']} ({_last(u['asked_by'])}): {u['why']}" for u in self.unused]
        return "\n".join(lines + unused)

    def __repr__(self) -> str:
        return f"<Ledger of {len(self)} effects>"

    def _repr_html_(self) -> str:
        shares = any(row.share is not None for row in self)
        header = ["effect", "count", "asked by", "detail", "bytes"] + (["share of time"] if shares else [])
        rows = []
        for row in self:
            asked = ", ".join(map(_last, row.asked_by))
            cells = [row.effect, f"{row.count} {row.unit}", asked, row.detail, f"{row.bytes}"]
            if shares:
                cells.append("" if row.share is None else f"{100 * row.share:.1f} %")
            rows.append(cells)
        notes = [f"not used: {u['what']} ({_last(u['asked_by'])}): {u['why']}" for u in self.unused]
        return table(header, rows) + paragraphs(notes)


def _effect(row: dict[str, Any]) -> Effect:
    return Effect(
        effect=row["effect"],
        count=row["count"],
        unit=row["unit"],
        asked_by=tuple(row["asked_by"]),
        detail=row["detail"],
        bytes=sum(size for _, size in row["arrays"]),
        share=row.get("share"),
    )


def _last(place: str) -> str:
    """``file:line`` without folders."""
    return place.rsplit("/", 1)[-1]


def table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table as HTML."""
    head = "".join(f"<th>{html.escape(cell)}</th>" for cell in header)
    body = "".join("<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def paragraphs(texts: Iterable[str]) -> str:
    """Lines as HTML."""
    return "".join(f"<p>{html.escape(text)}</p>" for text in texts)


def preformatted(text: str) -> str:
    """Text as it stands."""
    return f"<pre>{html.escape(text)}</pre>" if text.strip() else ""


def curves(title: str, label: str, time: npt.NDArray[np.float64], columns: dict[str, npt.NDArray[np.float64]]) -> str:
    """Curves over time as SVG; long ones are thinned."""
    step = max(1, len(time) // _MOST_POINTS)
    thin = slice(None, None, step)
    series = [(name, time[thin].tolist(), values[thin].tolist(), False) for name, values in columns.items()]
    return _revolve.chart(title, "time", label, series) if len(time) > 1 else ""
