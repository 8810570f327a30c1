"""How far a run is, in a notebook or told to a function."""

from __future__ import annotations

import html
import sys
import time
from collections.abc import Callable
from typing import Any

Progress = Callable[[float, str], None] | bool | None
"""A function of a fraction and a text; ``None`` for a bar in notebooks, ``False`` for nothing."""

_SOON = 0.5
"""Seconds after which a bar appears."""


class NotebookBar:
    """A bar below a cell, once the work takes longer than a moment."""

    def __init__(self) -> None:
        self._began = time.monotonic()
        self._handle: Any = None

    def __call__(self, fraction: float, words: str) -> None:
        if time.monotonic() - self._began < _SOON:
            return
        from IPython.display import HTML, display

        bar = HTML(f'<progress value="{fraction:.4f}" style="width:20em"></progress> {html.escape(words)}')
        if self._handle is None:
            self._handle = display(bar, display_id=True)
        else:
            self._handle.update(bar)

    def close(self) -> None:
        """Takes the bar away."""
        if self._handle is not None:
            from IPython.display import HTML

            self._handle.update(HTML(""))


def in_notebook() -> bool:
    """Whether cells of a notebook run here."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython is not None else None
    return shell is not None and "IPKernelApp" in shell.config


def resolved(progress: Progress) -> Callable[[float, str], None] | None:
    """What is told of progress."""
    if progress is None:
        return NotebookBar() if in_notebook() else None
    return None if isinstance(progress, bool) else progress


def closed(told: Callable[[float, str], None] | None) -> None:
    """The work is over."""
    if isinstance(told, NotebookBar):
        told.close()
