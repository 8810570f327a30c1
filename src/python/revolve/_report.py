"""HTML and text of decks, ledgers, runs and studies."""

from __future__ import annotations

import html
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _revolve

_MOST_POINTS = 2000
"""Largest number of points of a drawn curve."""


@dataclass(frozen=True)
class Effect:
    """Row of the ledger: a simulated effect."""

    effect: str
    """Name of the effect."""
    count: int
    """Number of facets, nodes, bodies, … that the effect acts on."""
    unit: str
    """Unit of the count."""
    asked_by: tuple[str, ...]
    """``file:line`` of the cards that request the effect."""
    detail: str
    """Law, scheme and values."""
    bytes: int
    """Memory of the arrays of the effect, in bytes."""
    share: float | None = None
    """Share of the run time; ``None`` if not measured."""


class Ledger(Sequence[Effect]):
    """List of the simulated effects, with the cards that request them and their memory."""

    def __init__(self, written: dict[str, Any]) -> None:
        self._written = written
        self._rows = [_effect(row) for row in written["effects"]]
        self.unused: list[dict[str, str]] = written["unused"]
        """Ignored cards: ``what``, ``asked_by``, ``why``."""

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
        header = ["effect", "count", "requested by", "detail", "bytes"] + (["share of run time"] if shares else [])
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
    """Return ``file:line`` without folders."""
    return place.rsplit("/", 1)[-1]


def table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Format a table as HTML."""
    head = "".join(f"<th>{html.escape(cell)}</th>" for cell in header)
    body = "".join("<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def paragraphs(texts: Iterable[str]) -> str:
    """Format texts as HTML paragraphs."""
    return "".join(f"<p>{html.escape(text)}</p>" for text in texts)


def preformatted(text: str) -> str:
    """Format a text as preformatted HTML."""
    return f"<pre>{html.escape(text)}</pre>" if text.strip() else ""


def curves(title: str, label: str, time: npt.NDArray[np.float64], columns: dict[str, npt.NDArray[np.float64]]) -> str:
    """Draw curves over time as SVG; long curves are thinned."""
    step = max(1, len(time) // _MOST_POINTS)
    thin = slice(None, None, step)
    series = [(name, time[thin].tolist(), values[thin].tolist(), False) for name, values in columns.items()]
    return _revolve.chart(title, "time", label, series) if len(time) > 1 else ""
