"""Tables of quantities over samples of parameters."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from ._deck import Deck

Array = npt.NDArray[np.float64]
Parameters = Mapping[str, npt.ArrayLike | str]
"""Values by parameter: arrays of one length, numbers for all samples alike, or texts."""


@dataclass(frozen=True)
class Samples:
    """Samples, sorted out."""

    names: tuple[str, ...]
    fixed: tuple[tuple[str, str], ...]
    table: Array


def sorted_out(parameters: Parameters) -> Samples:
    """Arrays side by side; numbers go with them, texts stay as they are."""
    texts = {name: value for name, value in parameters.items() if isinstance(value, str)}
    given = {name: np.asarray(v, dtype=np.float64) for name, v in parameters.items() if name not in texts}
    for name, values in given.items():
        if values.ndim > 1:
            raise ValueError(f"{name}: one number a sample is meant, not an array of {values.ndim} dimensions")
    lengths = {len(values) for values in given.values() if values.ndim == 1}
    if len(lengths) > 1:
        sizes = ", ".join(f"{name}: {len(v)}" for name, v in given.items() if v.ndim == 1)
        raise ValueError(f"samples of different number: {sizes}")
    count = lengths.pop() if lengths else 1
    table = np.empty((count, len(given)))
    for column, values in enumerate(given.values()):
        table[:, column] = values
    return Samples(tuple(given), tuple(texts.items()), table)


@dataclass(frozen=True)
class Evaluation:
    """A table of quantities, one row a sample; behaves as its array does."""

    values: Array
    """``(N, k)``; NaN where a run gave nothing."""
    quantities: tuple[str, ...]
    """The expressions of the columns."""
    reasons: dict[int, str] = field(default_factory=dict)
    """Why a row has no numbers, by row."""

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Array:
        return self.values.astype(dtype) if dtype is not None or copy else self.values

    def __len__(self) -> int:
        return len(self.values)

    def __getitem__(self, index: Any) -> Any:
        return self.values[index]

    @property
    def shape(self) -> tuple[int, ...]:
        """``(N, k)``."""
        return self.values.shape

    @property
    def ok(self) -> npt.NDArray[np.bool_]:
        """Which rows have numbers."""
        good = np.ones(len(self.values), dtype=bool)
        good[list(self.reasons)] = False
        return good


@dataclass
class Sampler:
    """``f(X: (N, d)) -> (N, k)``, as programs for uncertainty, design and optimisation call models.

    It can be pickled, and so goes to other processes.
    """

    deck: Deck
    names: tuple[str, ...]
    quantities: tuple[str, ...]
    options: dict[str, Any]

    def __call__(self, samples: npt.ArrayLike) -> Array:
        """The table of quantities; ``(N,)`` in for one parameter, ``(d,)`` in for one sample of several."""
        table = np.asarray(samples, dtype=np.float64)
        single = table.ndim == 1 and len(self.names) > 1
        if table.ndim == 1:
            table = table[np.newaxis, :] if single else table[:, np.newaxis]
        if table.ndim != 2 or table.shape[1] != len(self.names):
            raise ValueError(f"samples of {len(self.names)} parameters are meant: {', '.join(self.names)}")
        columns = {name: table[:, i] for i, name in enumerate(self.names)}
        found = self.deck.evaluate(columns, self.quantities, **self.options).values
        return found[0] if single else found


def sampler(
    deck: Deck, names: Sequence[str], quantities: str | Sequence[str], **options: Any
) -> Callable[[npt.ArrayLike], Array]:
    """A deck as a function of an array of samples, one column a parameter; ``options`` are those of ``Deck.evaluate``."""
    wanted = (quantities,) if isinstance(quantities, str) else tuple(quantities)
    return Sampler(deck, tuple(names), wanted, options)
