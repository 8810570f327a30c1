"""Number of threads."""

from __future__ import annotations

import sys

from . import _revolve


def _in_worker() -> bool:
    """Return whether the code runs in a Dask worker; other workers use the other processors."""
    distributed = sys.modules.get("distributed")
    if distributed is None:
        return False
    try:
        distributed.get_worker()
    except ValueError:
        return False
    return True


def resolved(threads: int | None) -> int:
    """Return the number of threads; ``None`` and 0 mean all processors, or those assigned to a worker or task."""
    if threads is not None and threads < 0:
        raise ValueError(f"threads={threads}: expected 0 (all processors) or a number of threads")
    if threads:
        return threads
    return 1 if _in_worker() else _revolve.default_threads()
