"""Progress of a run, as a bar in a notebook or by a callback function."""

from __future__ import annotations

import html
import sys
import time
from collections.abc import Callable
from typing import Any

Progress = Callable[[float, str], None] | bool | None
"""A function of the completed fraction and a text; ``None`` for a bar in notebooks, ``False`` for no progress."""

_SOON = 0.5
"""Delay in seconds after which the bar appears."""


class NotebookBar:
    """Progress bar below a notebook cell; it appears after a short delay."""

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
        """Remove the bar."""
        if self._handle is not None:
            from IPython.display import HTML

            self._handle.update(HTML(""))


def in_notebook() -> bool:
    """Return whether the code runs in a notebook."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython is not None else None
    return shell is not None and "IPKernelApp" in shell.config


def resolved(progress: Progress) -> Callable[[float, str], None] | None:
    """Return the callback function for progress."""
    if progress is None:
        return NotebookBar() if in_notebook() else None
    return None if isinstance(progress, bool) else progress


def closed(told: Callable[[float, str], None] | None) -> None:
    """Remove the bar after the work."""
    if isinstance(told, NotebookBar):
        told.close()
