"""``python -m revolve``: runs the command line."""

from __future__ import annotations

import sys

from ._command import main

sys.exit(main())
