"""Diagnostics of decks, and the exceptions of the package."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ._run import Run


@dataclass(frozen=True)
class Diagnostic:
    """Error, warning or note on a deck, with its location and a suggestion."""

    severity: str
    """``note``, ``warning`` or ``error``."""
    code: str
    """Stable code; ``revolve explain CODE`` gives details."""
    message: str
    """Description of the error."""
    place: str | None = None
    """``file:line``; ``None`` without a location."""
    file: str | None = None
    """File name as given."""
    line: int | None = None
    """Line number, from 1."""
    column: int | None = None
    """Column in characters, from 1."""
    help: str | None = None
    """Suggestion how to fix the error."""

    def __str__(self) -> str:
        place = f"{self.place}: " if self.place else ""
        advice = f" ({self.help})" if self.help else ""
        return f"{place}{self.severity}[{self.code}]: {self.message}{advice}"


def read(findings: list[dict[str, Any]]) -> list[Diagnostic]:
    """Convert diagnostics from the form of the library."""
    return [Diagnostic(**finding) for finding in findings]


class RevolveError(Exception):
    """Base class of the exceptions of this package."""

    diagnostics: list[Diagnostic]
    """Diagnostics of the deck; empty for other errors."""

    def __init__(self, message: str, findings: str = "[]") -> None:
        super().__init__(message)
        self._findings = findings
        self.diagnostics = read(json.loads(findings))

    def __reduce__(self) -> tuple[Any, ...]:
        return (type(self), (str(self), self._findings))


class DeckError(RevolveError):
    """A deck or a user subroutine file has errors."""


class StudyError(RevolveError):
    """A quantity, a study or an evaluation is invalid."""


class HaltedError(RevolveError):
    """A run halted; ``run`` has the results up to the last valid state."""

    run: Run | None

    def __init__(self, message: str, findings: str = "[]", run: Run | None = None) -> None:
        super().__init__(message, findings)
        self.run = run
