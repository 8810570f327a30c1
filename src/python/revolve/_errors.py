"""Findings on decks, and the exceptions that carry them."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ._run import Run


@dataclass(frozen=True)
class Diagnostic:
    """What is found in a deck: where, what, and what would be right."""

    severity: str
    """``note``, ``warning`` or ``error``."""
    code: str
    """Stable code; ``revolve explain CODE`` tells more."""
    message: str
    """What is wrong."""
    place: str | None = None
    """``file:line``, where it has a place."""
    file: str | None = None
    """The file as it was named."""
    line: int | None = None
    """From 1."""
    column: int | None = None
    """In letters, from 1."""
    help: str | None = None
    """What would be right."""

    def __str__(self) -> str:
        place = f"{self.place}: " if self.place else ""
        advice = f" ({self.help})" if self.help else ""
        return f"{place}{self.severity}[{self.code}]: {self.message}{advice}"


def read(findings: list[dict[str, Any]]) -> list[Diagnostic]:
    """Findings as the library writes them."""
    return [Diagnostic(**finding) for finding in findings]


class RevolveError(Exception):
    """Anything that the library refuses."""

    diagnostics: list[Diagnostic]
    """What was found, where findings have places in a deck."""

    def __init__(self, message: str, findings: str = "[]") -> None:
        super().__init__(message)
        self._findings = findings
        self.diagnostics = read(json.loads(findings))

    def __reduce__(self) -> tuple[Any, ...]:
        return (type(self), (str(self), self._findings))


class DeckError(RevolveError):
    """A deck or a file of user routines is refused."""


class StudyError(RevolveError):
    """A quantity, a study or an evaluation that has no meaning."""


class HaltedError(RevolveError):
    """A run halted; ``run`` is what there is of it, up to the last good state."""

    run: Run | None

    def __init__(self, message: str, findings: str = "[]", run: Run | None = None) -> None:
        super().__init__(message, findings)
        self.run = run
