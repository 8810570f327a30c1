"""Load functions in Python: functions of arrays, and addresses of compiled functions."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

LoadFunction = Callable[[Array, Array, Array, float, Array], None]
"""``load(coordinates, velocities, normals, time, pressures)``: the first three have a row ``[r, z]`` for each point,
normals point outwards; the function fills ``pressures`` in place. An optional sixth argument is the name of the
surface."""


class HasAddress(Protocol):
    """Result of a just-in-time compiler, such as ``numba.cfunc``."""

    @property
    def address(self) -> int:
        """Memory address of the function."""


Load = LoadFunction | HasAddress | int
"""A load: a function, the address of a compiled one, or an object with an ``address``."""

_ARGUMENTS = 5


def resolved(load: Load | None) -> int | tuple[Any, bool] | None:
    """Convert a load to the form of the extension module."""
    if load is None:
        return None
    address = getattr(load, "address", load)
    if isinstance(address, int) and not isinstance(address, bool):
        if address <= 0:
            raise ValueError(f"load: {address} is not the address of a function")
        return address
    if not callable(load):
        raise TypeError("load: expected a function of arrays, an address, or an object with an address")
    return (load, _takes_surface(load))


def _takes_surface(load: Any) -> bool:
    try:
        parameters = inspect.signature(load).parameters.values()
    except (TypeError, ValueError):
        return False
    positional = [p for p in parameters if p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD)]
    return len(positional) > _ARGUMENTS


def cfunc_signature() -> Any:
    """Return the ``numba.cfunc`` signature of a load: ``load(n, time, coordinates, velocities, normals, pressures)``.

    Coordinates, velocities and normals contain r of all points, followed by z of all points:
    ``numba.carray(coordinates, (2, n))``; pressures are ``numba.carray(pressures, n)``.
    """
    from numba import types

    numbers = types.CPointer(types.float64)
    return types.void(types.int64, types.float64, numbers, numbers, numbers, numbers)
