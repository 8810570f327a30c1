"""Type stubs of the extension module."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

__version__: str

_Settings: TypeAlias = Sequence[tuple[str, str]]
_Load: TypeAlias = int | tuple[Any, bool] | None
_Told: TypeAlias = Callable[[float, str], None] | None

def default_threads() -> int: ...
def main(arguments: Sequence[str]) -> int: ...
def compile(files: Sequence[Path], checked: bool) -> User: ...
def chart(title: str, x: str, y: str, series: Sequence[tuple[str, Sequence[float], Sequence[float], bool]]) -> str: ...
def study(
    deck: Deck,
    settings: _Settings,
    refine: Sequence[str],
    quantity: str,
    exact: str | None,
    target: str | None,
    jitter: int | None,
    repeat: int,
    threads: int,
    user: User | None,
    progress: _Told,
) -> str: ...
def uncertainty(
    deck: Deck,
    settings: list[tuple[str, str]],
    quantities: list[str],
    budget: float,
    distributions: list[str],
    threads: int,
    user: User | None,
) -> str: ...
def sensitivity(
    deck: Deck,
    settings: list[tuple[str, str]],
    quantities: list[str],
    parameters: list[str],
    steps: list[float | None],
    jitter: int | None,
    threads: int,
    user: User | None,
) -> str: ...
def limit(
    deck: Deck,
    settings: _Settings,
    velocity: str,
    between: str,
    tolerance: float,
    residual: str | None,
    least: float | None,
    shots: int,
    threads: int,
    user: User | None,
) -> str: ...

class User:
    notes: str

class Deck:
    text: str
    def __init__(self, name: str, text: str | None) -> None: ...
    def check(self, settings: _Settings, user: User | None, load: _Load) -> str: ...
    def run(
        self,
        settings: _Settings,
        user: User | None,
        load: _Load,
        threads: int,
        frames: bool,
        out: Path | None,
        progress: _Told,
    ) -> Run: ...
    def evaluator(
        self,
        names: Sequence[str],
        fixed: _Settings,
        quantities: Sequence[str],
        routines: tuple[User | None, _Load],
        in_increments: bool,
    ) -> Evaluator: ...

class Evaluator:
    def run(
        self, samples: npt.NDArray[np.float64], threads: int, progress: _Told
    ) -> tuple[npt.NDArray[np.float64], list[tuple[int, str]]]: ...

class Halt:
    kind: str
    code: str
    message: str
    element: str | None
    step: int | None
    increment: int | None
    time: float | None
    place: tuple[float, float] | None

class Run:
    status: str
    halt: Halt | None
    warnings: list[str]
    seconds: float
    series: Path | None
    frame_count: int
    def summary(self) -> str: ...
    def ledger(self) -> str: ...
    def column(self, name: str, which: str) -> float: ...
    def quantity(self, text: str) -> float: ...
    def history(self) -> dict[str, npt.NDArray[np.float64]]: ...
    def frame(self, index: int) -> dict[str, Any]: ...
