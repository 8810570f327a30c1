"""The command line of the package: the program's own."""

from __future__ import annotations

import sys

from . import _revolve


def main() -> int:
    """Carry out the arguments of the process; the exit status."""
    return _revolve.main(["revolve", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
