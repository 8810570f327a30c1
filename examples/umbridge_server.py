"""Shots as a model of UM-Bridge, for samplers and optimisers in any language.

    pip install . umbridge
    python examples/umbridge_server.py [PORT]

Input: velocity in m/s and friction coefficient. Output: depth in millimetres; -1e6 for a failed shot. The gradient is
exact: shots by stages are differentiated.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import revolve as rv
import umbridge

DECK = Path(__file__).resolve().parents[1] / "input" / "ogive.inp"
NAMES, DEPTH = ["V", "friction"], "-1000*final(U2@REF)"
SHOT = rv.sampler(rv.Deck(DECK), NAMES, DEPTH)


class Depth(umbridge.Model):
    """Depth of penetration over velocity and friction."""

    def get_input_sizes(self, config: dict) -> list[int]:
        """Return the lengths of the inputs."""
        return [2]

    def get_output_sizes(self, config: dict) -> list[int]:
        """Return the lengths of the outputs."""
        return [1]

    def supports_evaluate(self) -> bool:
        """Return that the model can be evaluated."""
        return True

    def __call__(self, parameters: list[list[float]], config: dict) -> list[list[float]]:
        """Run a shot. UM-Bridge sends JSON, which has no NaN."""
        return [np.nan_to_num(SHOT(parameters[0]), nan=-1e6).tolist()]

    def supports_gradient(self) -> bool:
        """Return that the model has gradients."""
        return True

    def gradient(
        self, out_wrt: int, in_wrt: int, parameters: list[list[float]], sens: list[float], config: dict
    ) -> list[float]:
        """Return the derivatives of the depth by velocity and friction, times the factor ``sens``."""
        values = dict(zip(NAMES, parameters[0], strict=True))
        (depth,) = rv.Deck(DECK).sensitivity(DEPTH, NAMES, **values)["quantities"]
        return [sens[0] * of["derivative"]["value"] for of in depth["parameters"]]


if __name__ == "__main__":
    umbridge.serve_models([Depth("depth")], int(sys.argv[1]) if len(sys.argv) > 1 else 4242)
