"""Commands of the program that Python runs in a process of their own, with their results as JSON."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import _threads
from ._errors import StudyError

if TYPE_CHECKING:
    from ._deck import Deck

Option = tuple[str, Any]
"""Name of an option without hyphens, and its value: text, number or list; true for a flag, none or false to omit it."""


def record(deck: Deck, command: str, options: Iterable[Option], *, writes: bool = True) -> dict[str, Any]:
    """Run a command on a deck and return the object that it prints with ``--json``.

    Relative paths in the deck refer to the folder of the deck, those of options to the working folder. The files of
    commands that write any go to a temporary folder.
    """
    words = [sys.executable, "-m", "revolve", command, "-", "--json", *_words(options)]
    folder = Path(deck.name).parent
    with tempfile.TemporaryDirectory() as results:
        if writes:
            words += ["--out", results]
        ended = subprocess.run(
            words,
            check=False,
            input=deck.text,
            capture_output=True,
            encoding="utf-8",
            cwd=folder if folder.is_dir() else None,
        )
    if not ended.stdout:
        raise StudyError(ended.stderr.strip())
    return json.loads(ended.stdout)


def _words(options: Iterable[Option]) -> list[str]:
    words = []
    for name, value in options:
        if value is None or value is False:
            continue
        words.append(f"--{name}" if value is True else f"--{name}={_text(value)}")
    return words


def _text(value: Any) -> str:
    if isinstance(value, os.PathLike):
        return str(Path(value).absolute())
    if isinstance(value, str):
        return value
    return ",".join(map(_text, value)) if isinstance(value, Sequence) else repr(value)


def common(parameters: Sequence[tuple[str, str]], user: Any, threads: int | None) -> list[Option]:
    """Return the options for parameters of the deck, user subroutines and threads."""
    files = [] if user is None else [user] if isinstance(user, (str, os.PathLike)) else list(user)
    options: list[Option] = [("set", f"{name}={value}") for name, value in parameters]
    options += [("user", Path(file)) for file in files]
    count = _threads.resolved(threads)
    return [*options, ("threads", count)] if count else options


def pairs(option: str, values: Mapping[str, Any]) -> list[Option]:
    """Return an option ``--option=name=value`` for each pair; a pair of numbers is an interval."""
    return [(option, f"{name}={_interval(value)}") for name, value in values.items()]


def _interval(value: Any) -> str:
    return "..".join(map(_text, value)) if isinstance(value, tuple) else _text(value)
