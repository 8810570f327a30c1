"""Evaluation of quantities for samples of parameters."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    import pandas as pd

    from ._deck import Deck

Array = npt.NDArray[np.float64]
Parameters = Mapping[str, npt.ArrayLike | str]
"""Values by parameter: arrays of the same length, or numbers and texts that apply to all samples."""


@dataclass(frozen=True)
class Samples:
    """Table of samples with the names of its columns, and fixed parameters."""

    names: tuple[str, ...]
    fixed: tuple[tuple[str, str], ...]
    table: Array


def sorted_out(parameters: Parameters) -> Samples:
    """Combine arrays and numbers to a table of samples; texts are fixed parameters."""
    texts = {name: value for name, value in parameters.items() if isinstance(value, str)}
    given = {name: np.asarray(v, dtype=np.float64) for name, v in parameters.items() if name not in texts}
    for name, values in given.items():
        if values.ndim > 1:
            raise ValueError(f"{name}: expected one number per sample, found an array of {values.ndim} dimensions")
    lengths = {len(values) for values in given.values() if values.ndim == 1}
    if len(lengths) > 1:
        sizes = ", ".join(f"{name}: {len(v)}" for name, v in given.items() if v.ndim == 1)
        raise ValueError(f"arrays of different lengths: {sizes}")
    count = lengths.pop() if lengths else 1
    table = np.empty((count, len(given)))
    for column, values in enumerate(given.values()):
        table[:, column] = values
    return Samples(tuple(given), tuple(texts.items()), table)


@dataclass(frozen=True)
class Evaluation:
    """Table of quantities with one row per sample; can be used like an array."""

    values: Array
    """Array ``(N, k)``; NaN for failed runs."""
    quantities: tuple[str, ...]
    """Expressions of the columns."""
    reasons: dict[int, str] = field(default_factory=dict)
    """Errors of the failed runs by row."""
    samples: Samples = field(default_factory=lambda: Samples((), (), np.empty((0, 0))))
    """Samples of the parameters."""
    deck: Deck | None = None
    """The deck that was run."""

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Array:
        return self.values.astype(dtype) if dtype is not None or copy else self.values

    def __len__(self) -> int:
        return len(self.values)

    def __getitem__(self, index: Any) -> Any:
        return self.values[index]

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the table, ``(N, k)``."""
        return self.values.shape

    def to_pandas(self) -> pd.DataFrame:
        """Return a table of parameters, quantities and ``failure``: the error of a failed run, else none.

        ``attrs["units"]`` are the units of the deck, ``attrs["fixed"]`` the parameters that are texts.
        """
        import pandas as pd

        columns = {name: self.samples.table[:, at] for at, name in enumerate(self.samples.names)}
        columns |= {quantity: self.values[:, at] for at, quantity in enumerate(self.quantities)}
        failures = pd.Series([self.reasons.get(row) for row in range(len(self))], dtype=object, name="failure")
        table = pd.DataFrame(columns).assign(failure=failures)
        table.attrs = {"units": self.deck.units if self.deck else {}, "fixed": dict(self.samples.fixed)}
        return table

    @property
    def ok(self) -> npt.NDArray[np.bool_]:
        """Boolean array of the rows with values."""
        good = np.ones(len(self.values), dtype=bool)
        good[list(self.reasons)] = False
        return good


@dataclass
class Sampler:
    """Function ``f(X: (N, d)) -> (N, k)``, as expected by packages for uncertainty, design and optimisation.

    It can be pickled for use in other processes.
    """

    deck: Deck
    names: tuple[str, ...]
    quantities: tuple[str, ...]
    options: dict[str, Any]

    def __call__(self, samples: npt.ArrayLike) -> Array:
        """Evaluate samples; ``(N,)`` are values of a single parameter, ``(d,)`` is one sample of several parameters."""
        table = np.asarray(samples, dtype=np.float64)
        single = table.ndim == 1 and len(self.names) > 1
        if table.ndim == 1:
            table = table[np.newaxis, :] if single else table[:, np.newaxis]
        if table.ndim != 2 or table.shape[1] != len(self.names):
            raise ValueError(f"expected samples of {len(self.names)} parameters: {', '.join(self.names)}")
        columns = {name: table[:, i] for i, name in enumerate(self.names)}
        found = self.deck.evaluate(columns, self.quantities, **self.options).values
        return found[0] if single else found


def sampler(
    deck: Deck, names: Sequence[str], quantities: str | Sequence[str], **options: Any
) -> Callable[[npt.ArrayLike], Array]:
    """Return a function of an array of samples, one column per parameter; ``options`` as in ``Deck.evaluate``."""
    wanted = (quantities,) if isinstance(quantities, str) else tuple(quantities)
    return Sampler(deck, tuple(names), wanted, options)
