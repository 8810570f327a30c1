"""Command line of the package; it is the same as that of the program."""

from __future__ import annotations

import sys

from . import _revolve


def main() -> int:
    """Run the command line of this process and return the exit status."""
    return _revolve.main(["revolve", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
