"""Axisymmetric explicit finite-element code for ABAQUS-style decks with user subroutines.

>>> import revolve as rv
>>> deck = rv.Deck("input/ogive.inp")
>>> run = deck.run(V=821)
>>> run.final("U2@REF")  # doctest: +SKIP
-0.0698
"""

from __future__ import annotations

from ._deck import Deck
from ._errors import DeckError, Diagnostic, HaltedError, RevolveError, StudyError
from ._evaluate import Evaluation, sampler
from ._load import cfunc_signature
from ._report import Ledger
from ._revolve import __version__
from ._run import Frames, Run
from ._study import Limit, Study

__all__ = [
    "Deck",
    "DeckError",
    "Diagnostic",
    "Evaluation",
    "Frames",
    "HaltedError",
    "Ledger",
    "Limit",
    "RevolveError",
    "Run",
    "Study",
    "StudyError",
    "__version__",
    "cfunc_signature",
    "sampler",
]
