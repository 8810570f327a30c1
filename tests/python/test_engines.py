"""Programs that distribute work over processes give the table of a single process, even if a worker dies."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import revolve as rv
from revolve import _threads

ROOT = Path(__file__).resolve().parents[2]
DEPTH = "-1000*final(U2@REF)"


def test_dask_gives_the_same_bits_after_losing_a_worker() -> None:
    distributed = pytest.importorskip("dask.distributed")
    deck = rv.Deck(ROOT / "input" / "ogive.inp")
    speeds = np.random.default_rng(3).uniform(569.0, 900.0, 20_000)
    alone = deck.evaluate({"V": speeds}, [DEPTH]).values
    shot = rv.sampler(deck, ["V"], DEPTH, threads=1)
    options = {"n_workers": 2, "threads_per_worker": 1, "processes": True, "dashboard_address": None}
    with distributed.LocalCluster(**options) as cluster, distributed.Client(cluster) as client:
        workers = set(client.run(os.getpid).values())
        futures = client.map(shot, np.array_split(speeds, 40), pure=False)
        while sum(future.done() for future in futures) < 3:
            time.sleep(0.01)
        assert not all(future.done() for future in futures), "it dies in the middle"
        os.kill(next(iter(workers)), signal.SIGKILL)
        table = np.concatenate(client.gather(futures))
        assert client.submit(_threads.resolved, 0).result() == 1
        assert set(client.run(os.getpid).values()) != workers
    assert table.tobytes() == alone.tobytes()


def test_example_runs() -> None:
    pytest.importorskip("dask.distributed")
    script = ROOT / "examples" / "dask_sweep.py"
    said = subprocess.run([sys.executable, script, "4000"], check=True, capture_output=True, text=True).stdout
    assert said.startswith("4000 shots: depth ")
