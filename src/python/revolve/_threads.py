"""How many threads there are to be."""

from __future__ import annotations

import os


def available() -> int:
    """Processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def resolved(threads: int | None) -> int:
    """``None`` and 0 stand for all processors."""
    if threads is not None and threads < 0:
        raise ValueError(f"threads={threads}: 0 for all processors, or a number of them")
    return threads or available()
