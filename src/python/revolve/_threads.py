"""Number of threads."""

from __future__ import annotations

import sys

from . import _revolve


def _in_worker() -> bool:
    """Return whether the code runs in one of several workers: a child process of multiprocessing, or a Dask worker."""
    # Children have this module (ProcessPoolExecutor, joblib with loky, Dask); without it, it need not be imported.
    process = sys.modules.get("multiprocessing.process")
    if process is not None and process.parent_process() is not None:
        return True
    distributed = sys.modules.get("distributed")
    if distributed is None:
        return False
    try:
        distributed.get_worker()
    except ValueError:
        return False
    return True


def resolved(threads: int | None) -> int:
    """Return the number of threads.

    ``None`` and 0 mean one thread in a worker process (child process of multiprocessing or loky, Dask worker), the
    assigned processors in a task of a scheduler, and all processors elsewhere.
    """
    if threads is not None and threads < 0:
        raise ValueError(f"threads={threads}: expected 0 (all processors) or a number of threads")
    if threads:
        return threads
    return 1 if _in_worker() else _revolve.default_threads()
