"""How many threads there are to be."""

from __future__ import annotations

import sys

from . import _revolve


def _in_worker() -> bool:
    """Whether a worker of Dask calls: its neighbours have the other processors."""
    distributed = sys.modules.get("distributed")
    if distributed is None:
        return False
    try:
        distributed.get_worker()
    except ValueError:
        return False
    return True


def resolved(threads: int | None) -> int:
    """``None`` and 0 stand for all processors; in a worker or a task of a scheduler for those it was given, or one."""
    if threads is not None and threads < 0:
        raise ValueError(f"threads={threads}: 0 for all processors, or a number of them")
    if threads:
        return threads
    return 1 if _in_worker() else _revolve.default_threads()
