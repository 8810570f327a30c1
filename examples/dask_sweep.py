"""Shots at random over processes, by Dask.

    pip install . "dask[distributed]"
    python examples/dask_sweep.py [SHOTS] [SCHEDULER]

Without the address of a scheduler it starts processes of its own on this machine. A chunk of samples goes to a worker, its
table comes back; a worker that dies costs its chunks, which others then take up, and no digit of the table.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import revolve as rv
from dask.distributed import Client, LocalCluster

DECK = Path(__file__).resolve().parents[1] / "input" / "ogive.inp"
CHUNK = 2000


def depths(client: Client, speeds: np.ndarray) -> np.ndarray:
    """Depths in millimetres, in the order of the speeds."""
    # The function carries the deck, which is read anew for each chunk: a fraction of a millisecond.
    shot = rv.sampler(rv.Deck(DECK), ["V"], "-1000*final(U2@REF)", threads=1)
    chunks = np.array_split(speeds, max(1, len(speeds) // CHUNK))
    return np.concatenate(client.gather(client.map(shot, chunks, pure=False)))[:, 0]


def main() -> None:
    """Draws speeds, runs the shots, says what came out."""
    shots = int(sys.argv[1]) if len(sys.argv) > 1 else 20_000
    speeds = np.random.default_rng(7).uniform(569.0, 900.0, shots)
    if len(sys.argv) > 2:
        with Client(sys.argv[2]) as client:
            table = depths(client, speeds)
    else:
        with LocalCluster(threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
            table = depths(client, speeds)
    low, middle, high = np.percentile(table, [5, 50, 95])
    print(f"{shots} shots: depth {middle:.1f} mm, between {low:.1f} and {high:.1f} mm for nine in ten")


if __name__ == "__main__":
    main()
