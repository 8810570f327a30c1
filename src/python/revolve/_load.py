"""Loads written in Python: functions of arrays, and addresses of compiled functions."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

LoadFunction = Callable[[Array, Array, Array, float, Array], None]
"""``load(coordinates, velocities, normals, time, pressures)``: the first three have a row ``[r, z]`` for each point,
normals point out of a surface; ``pressures`` is to be filled in place. A sixth argument is given the name of the surface."""


class HasAddress(Protocol):
    """What a just-in-time compiler gives, such as ``numba.cfunc``."""

    @property
    def address(self) -> int:
        """Where the function is."""


Load = LoadFunction | HasAddress | int
"""A load: a function, the address of a compiled one, or what has an ``address``."""

_ARGUMENTS = 5


def resolved(load: Load | None) -> int | tuple[Any, bool] | None:
    """A load as the extension takes it."""
    if load is None:
        return None
    address = getattr(load, "address", load)
    if isinstance(address, int) and not isinstance(address, bool):
        if address <= 0:
            raise ValueError(f"load: {address} is no address of a function")
        return address
    if not callable(load):
        raise TypeError("load: a function of arrays, an address, or an object with one (such as a numba.cfunc)")
    return (load, _takes_surface(load))


def _takes_surface(load: Any) -> bool:
    try:
        parameters = inspect.signature(load).parameters.values()
    except (TypeError, ValueError):
        return False
    positional = [p for p in parameters if p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD)]
    return len(positional) > _ARGUMENTS


def cfunc_signature() -> Any:
    """The signature for ``numba.cfunc`` of a load: ``load(n, time, coordinates, velocities, normals, pressures)``.

    Of coordinates, velocities and normals come the r of all points, then the z of all points:
    ``numba.carray(coordinates, (2, n))``; pressures are ``numba.carray(pressures, n)``.
    """
    from numba import types

    numbers = types.CPointer(types.float64)
    return types.void(types.int64, types.float64, numbers, numbers, numbers, numbers)
