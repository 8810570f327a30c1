"""Live view of a run in a notebook: the page of ``revolve view`` while it runs, a picture of its last frame afterwards."""

from __future__ import annotations

import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

_FIELDS = ("MISES", "S_MISES", "PEEQ", "PRESSURE", "V2")
"""Fields of the picture; the first one that the frames have is drawn."""


class NotebookView:
    """Progress callback that shows a result folder below a notebook cell.

    The page is served by another process, which begins at the first report of the run: result files exist then.
    """

    def __init__(self, folder: Path, height: int, told: Callable[[float, str], None] | None) -> None:
        self._folder = folder
        self._height = height
        self._told = told
        self._process: subprocess.Popen[str] | None = None
        self._address: str | None = None
        self._handle: Any = None

    def __call__(self, fraction: float, words: str) -> None:
        if self._process is None:
            self._process = _command("view", self._folder, "--no-browser", stdout=subprocess.PIPE)
            # The run does not wait for the other process.
            threading.Thread(target=self._read_address, args=(self._process,), daemon=True).start()
        if self._handle is None and self._address is not None:
            from IPython.display import IFrame, display

            self._handle = display(IFrame(self._address, width="100%", height=self._height), display_id=True)
        if self._told is not None:
            self._told(fraction, words)

    def _read_address(self, process: subprocess.Popen[str]) -> None:
        """Read the address that the process prints first."""
        line = process.stdout.readline() if process.stdout else ""
        if line.startswith("view "):
            self._address = line.removeprefix("view ").strip()

    def close(self) -> None:
        """End the page and show the picture in its place."""
        if self._process is not None:
            self._process.terminate()
            self._process.wait()
        if self._handle is not None:
            from IPython.display import HTML

            self._handle.update(HTML(picture(self._folder)))


def _command(*words: str | Path, stdout: int = subprocess.DEVNULL) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "revolve", *map(str, words)]
    return subprocess.Popen(command, stdout=stdout, stderr=subprocess.DEVNULL, stdin=subprocess.DEVNULL, text=True)


def picture(folder: Path) -> str:
    """Return the picture of the last frame in a result folder as SVG; empty without a field that can be drawn."""
    with tempfile.TemporaryDirectory() as scratch:
        file = Path(scratch) / "frame.svg"
        for field in _FIELDS:
            if _command("chart", folder, "--field", field, "--out", file).wait() == 0:
                return file.read_text(encoding="utf-8")
    return ""
