"""Random shots on several processes with Dask.

    pip install . "dask[distributed]"
    python examples/dask_sweep.py [SHOTS] [SCHEDULER]

Without the address of a scheduler it starts local processes. Each chunk of samples is sent to a worker, which returns its
table. Chunks of a failed worker are run again by others, with the same result.
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
    """Return depths in millimetres, in the order of the speeds."""
    # The function contains the deck, which is read again for each chunk (a fraction of a millisecond).
    shot = rv.sampler(rv.Deck(DECK), ["V"], "-1000*final(U2@REF)", threads=1)
    chunks = np.array_split(speeds, max(1, len(speeds) // CHUNK))
    return np.concatenate(client.gather(client.map(shot, chunks, pure=False)))[:, 0]


def main() -> None:
    """Sample speeds, run the shots, print the results."""
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
