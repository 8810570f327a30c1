"""The Python package as users call it: decks, runs, loads, evaluations, studies."""

from __future__ import annotations

import json
import os
import pickle
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import revolve as rv

ROOT = Path(__file__).resolve().parents[2]
OGIVE = ROOT / "input" / "ogive.inp"
USER = ROOT / "input" / "ogive_user.inp"
CAVITY = ROOT / "input" / "vdload_cavity.f"


@pytest.fixture(scope="module")
def deck() -> rv.Deck:
    return rv.Deck(OGIVE)


def test_run_matches_the_program(deck: rv.Deck, tmp_path: Path) -> None:
    run = deck.run(V=821)
    subprocess.run(
        [sys.executable, "-m", "revolve", "run", OGIVE, "--set", "V=821", "--out", tmp_path, "-q"], check=True
    )
    lines = (tmp_path / "ogive_history.csv").read_text().splitlines()
    written = dict(zip(lines[0].split(","), map(float, lines[-1].split(","))))
    assert run.status == "completed"
    assert run.final("u2@ref") == written["U2@REF"]
    assert run.final("ETOTAL") == written["ETOTAL"]
    assert run.quantity("-1000*final(U2@REF)") == -1000 * written["U2@REF"]
    assert run.min("U2@REF") <= run.final("U2@REF") <= run.max("U2@REF")
    assert len(run.arrays["time"]) == len(lines) - 1
    assert run.arrays["U2@REF"][-1] == written["U2@REF"]
    with pytest.raises(KeyError, match="the columns are U2@REF"):
        run.final("U3@REF")


def test_histories_are_a_pandas_data_frame(deck: rv.Deck) -> None:
    pandas = pytest.importorskip("pandas")
    history = deck.run().history
    assert isinstance(history, pandas.DataFrame)
    assert history.index.name == "time"
    assert history["V2@REF"].iloc[0] == -569.0


def test_frames_are_pyvista_grids(deck: rv.Deck, tmp_path: Path) -> None:
    pyvista = pytest.importorskip("pyvista")
    kept = deck.run(n=8)
    written = deck.run(n=8, out=tmp_path)
    assert len(kept.frames) == len(written.frames) == 21
    assert np.allclose(kept.frames.times, written.frames.times)
    ours, theirs = kept.frames[-1], written.frames[-1]
    assert isinstance(ours, pyvista.UnstructuredGrid)
    assert ours.n_cells == theirs.n_cells == 8
    assert np.allclose(ours.points, theirs.points)
    assert np.allclose(ours.point_data["U"], theirs.point_data["U"][:, : ours.point_data["U"].shape[1]])
    assert np.allclose(ours.cell_data["PRESSURE"], theirs.cell_data["PRESSURE"])
    assert len(kept.frames[2:4]) == 2
    assert len(deck.run(frames=False).frames) == 0


def test_diagnostics_are_exceptions_and_lists() -> None:
    text = OGIVE.read_text().replace("*Rigid Body", "*Rigid Bdy")
    broken = rv.Deck(text=text, name="broken.inp")
    with pytest.raises(rv.DeckError) as caught:
        broken.run()
    first = caught.value.diagnostics[0]
    assert (first.severity, first.file, first.line) == ("error", "broken.inp", 44)
    assert "broken.inp:44" in str(caught.value)
    assert "*Rigid" in text.splitlines()[43]
    assert any(d.severity == "error" for d in broken.check())
    again = pickle.loads(pickle.dumps(caught.value))
    assert again.diagnostics == caught.value.diagnostics
    with pytest.raises(rv.DeckError, match="no parameter `W`"):
        rv.Deck(OGIVE).run(W=1)
    with pytest.raises(FileNotFoundError, match="no such"):
        rv.Deck("no such.inp")
    with pytest.raises(rv.StudyError, match="did you mean U2@REF"):
        rv.Deck(OGIVE).evaluate({"V": 500.0}, "final(U2@RFE)")


def test_halt_is_an_exception_with_the_run(deck: rv.Deck) -> None:
    def fails(coordinates, velocities, normals, time, pressures):
        pressures[:] = 1e6 if time < 1e-4 else np.nan

    with pytest.raises(rv.HaltedError, match="R201") as caught:
        rv.Deck(USER).run(load=fails)
    assert caught.value.run is not None
    assert caught.value.run.status == "halted"
    assert len(caught.value.run.arrays["time"]) > 5
    halted = rv.Deck(USER).run(load=fails, check=False)
    assert halted.reason == caught.value.run.reason == str(halted.halt)
    assert halted.halt is not None
    assert halted.halt.kind == "UserRoutine"
    assert halted.halt.code == "R201"
    assert halted.halt.step == 1
    assert halted.halt.time is not None
    assert halted.halt.time >= 1e-4
    assert halted.halt.place is not None


def cavity(coordinates, velocities, normals, time, pressures):
    """Apply the resistance of ``input/vdload_cavity.f``."""
    into = np.maximum(np.einsum("ij,ij->i", velocities, normals), 0.0)
    x = into * np.sqrt(2710.0 / 276e6)
    pressures[:] = np.where(into > 0.0, 276e6 * (5.0394 + 0.9830 * x * x), 0.0)


def test_large_local_arrays_run_on_all_threads(tmp_path: Path) -> None:
    """A local array of 4 MB fits the stack of one thread, of several, and of a small Python thread."""
    text = (ROOT / "input" / "vumat_hardening.f90").read_text()
    work = "  large(1:500000:512) = totalTime; if (sum(large(1:500000:512)) .lt. 0.d0) print *, large(1)\n"
    text = text.replace("  dimension s(6)\n", "  dimension s(6)\n  real(8) :: large(500000)\n", 1)
    source = tmp_path / "law.f90"
    source.write_text(text.replace("  twog =", f"{work}  twog =", 1))
    deck = rv.Deck(ROOT / "input" / "taylor_vumat.inp")
    results = [deck.run(user=source, threads=threads).final("U2@TIP") for threads in (1, 2)]
    for threads in (1, 2):
        results.append(deck.evaluate({"speed": [227.0]}, "final(U2@TIP)", user=source, threads=threads).values[0, 0])
    size = threading.stack_size(1 << 20)
    thread = threading.Thread(target=lambda: results.append(deck.run(user=source, threads=1).final("U2@TIP")))
    thread.start()
    thread.join()
    threading.stack_size(size)
    assert len(results) == 5
    assert set(results) == {results[0]}


def test_python_load_matches_fortran() -> None:
    deck = rv.Deck(USER)
    fortran = deck.run(user=CAVITY, V=600)
    python = deck.run(load=cavity, V=600)
    assert python.final("U2@REF") == pytest.approx(fortran.final("U2@REF"), rel=1e-12)
    assert len(python.arrays["time"]) == len(fortran.arrays["time"])


def test_numba_load_matches_python() -> None:
    numba = pytest.importorskip("numba")

    @numba.cfunc(rv.cfunc_signature())
    def load(n, time, coordinates, velocities, normals, pressures):
        v = numba.carray(velocities, (2, n))
        normal = numba.carray(normals, (2, n))
        p = numba.carray(pressures, n)
        for i in range(n):
            into = v[0, i] * normal[0, i] + v[1, i] * normal[1, i]
            p[i] = 276e6 * (5.0394 + 0.9830 * into * into * 2710.0 / 276e6) if into > 0.0 else 0.0

    deck = rv.Deck(USER)
    python = deck.run(load=cavity)
    for compiled in (load, load.address):
        assert deck.run(load=compiled).final("U2@REF") == pytest.approx(python.final("U2@REF"), rel=1e-12)
    speeds = np.array([500.0, 600.0, 700.0])
    table = deck.evaluate({"V": speeds}, "final(U2@REF)", load=load)
    assert table.values[:, 0].tolist() == [deck.run(V=v, load=load).final("U2@REF") for v in speeds]


def test_load_receives_coordinates_and_optionally_the_surface() -> None:
    seen = {}

    def load(coordinates, velocities, normals, time, pressures, surface):
        seen.update(surface=surface, shape=coordinates.shape, time=time)
        seen.setdefault("first", (coordinates.copy(), velocities.copy(), normals.copy(), pressures.copy()))
        pressures[:] = 0.0

    rv.Deck(USER).run(load=load, n=8)
    coordinates, velocities, normals, pressures = seen["first"]
    assert seen["surface"] == "NOSE"
    assert seen["shape"] == (8, 2)
    assert seen["time"] == pytest.approx(1e-3)
    assert (coordinates[:, 0] > 0).all() and (np.diff(coordinates[:, 1]) > 0).all()
    assert (velocities == [0.0, -569.0]).all()
    assert np.allclose(np.linalg.norm(normals, axis=1), 1.0)
    assert np.isnan(pressures).all()


def test_exceptions_of_a_load_are_raised() -> None:
    def load(coordinates, velocities, normals, time, pressures):
        raise ZeroDivisionError("in the load")

    with pytest.raises(ZeroDivisionError, match="in the load"):
        rv.Deck(USER).run(load=load)
    with pytest.raises(ZeroDivisionError, match="in the load"):
        rv.Deck(USER).evaluate({"V": [500.0]}, "final(U2@REF)", load=load)
    for wrong, kind in ((0, ValueError), ("x", TypeError)):
        with pytest.raises(kind, match="load:"):
            rv.Deck(USER).run(load=wrong)


def test_fortran_finds_host_routines(tmp_path: Path) -> None:
    source = tmp_path / "asks.f"
    source.write_text(
        """\
      subroutine vdload(nblock, ndim, stepTime, totalTime, amplitude,
     * curCoords, velocity, dirCos, jltyp, sname, value)
      include 'vaba_param.inc'
      dimension value(nblock)
      character*80 sname
      character*256 jobname
      integer i, length
      call vgetjobname(jobname, length)
      do i = 1, nblock
        value(i) = 1.e6 * length
      end do
      if (totalTime .gt. 5.e-4) stop 'enough'
      end
"""
    )
    run = rv.Deck(USER).run(user=[source], check=False)
    assert "vdload ended the analysis" in run.reason
    lengths = run.arrays["A2@REF"][0] / rv.Deck(USER).run(load=_even, check=False).arrays["A2@REF"][0]
    assert lengths == pytest.approx(len("ogive_user"))


def _even(coordinates, velocities, normals, time, pressures):
    pressures[:] = 1e6


def test_evaluate_matches_single_runs(deck: rv.Deck) -> None:
    rng = np.random.default_rng(1)
    speeds, friction = rng.uniform(400, 900, 40), rng.uniform(0, 0.1, 40)
    quantities = ["-1000*final(U2@REF)", "min(V2@REF)"]
    table = deck.evaluate({"V": speeds, "friction": friction}, quantities)
    assert table.shape == (40, 2)
    assert table.ok.all()
    runs = [deck.run(V=v, friction=f, frames=False) for v, f in zip(speeds, friction)]
    assert np.array_equal(table, [[run.quantity(q) for q in quantities] for run in runs])
    for threads in (1, 2, 5):
        again = deck.evaluate({"V": speeds, "friction": friction}, quantities, threads=threads)
        assert np.array_equal(table, again)
    halves = [deck.evaluate({"V": speeds[s], "friction": friction[s]}, quantities) for s in (slice(7), slice(7, None))]
    assert np.array_equal(table, np.vstack(halves))
    # With parameters of the geometry, and with scalars for all samples.
    samples = {"CRH": [2.0, 3.0, 4.5], "V": 700, "n": 12}
    runs = [deck.run(CRH=c, V=700, n=12).quantity(quantities[0]) for c in (2.0, 3.0, 4.5)]
    shapes = deck.evaluate(samples, quantities[0], in_increments=True)
    assert shapes.values[:, 0].tolist() == runs
    # Final values of rigid shots are solved by stages.
    staged = deck.evaluate(samples, quantities[0])
    assert np.allclose(staged.values[:, 0], runs, rtol=1e-4, atol=0.0)


def test_failed_samples_are_nan_with_a_reason(deck: rv.Deck) -> None:
    table = deck.evaluate({"mass": [0.02, -1.0, np.nan, 0.03]}, "final(U2@REF)")
    assert np.isnan(table.values[:, 0]).tolist() == [False, True, True, False]
    assert sorted(table.reasons) == [1, 2]
    assert "mass of *MASS must be at least 0, found -1" in table.reasons[1]
    assert table.ok.tolist() == [True, False, False, True]
    with pytest.raises(ValueError, match="different lengths"):
        deck.evaluate({"mass": [1.0, 2.0], "V": [1.0, 2.0, 3.0]}, "final(U2@REF)")
    with pytest.raises(rv.StudyError, match="did you mean V"):
        deck.evaluate({"v": [1.0]}, "final(U2@REF)")


def test_evaluate_with_fortran_matches_single_runs(deck: rv.Deck) -> None:
    user = rv.Deck(USER)
    table = user.evaluate({"V": [500.0, 600.0]}, "final(U2@REF)", user=CAVITY)
    assert table.values[:, 0].tolist() == [user.run(V=v, user=CAVITY).final("U2@REF") for v in (500.0, 600.0)]


def test_decks_and_samplers_can_be_pickled(deck: rv.Deck) -> None:
    joblib = pytest.importorskip("joblib")
    copy = pickle.loads(pickle.dumps(deck))
    assert copy.text == deck.text
    function = rv.sampler(copy, ["V", "friction"], ["final(U2@REF)"], threads=1)
    samples = np.column_stack([np.linspace(400, 800, 8), np.full(8, 0.02)])
    parts = joblib.Parallel(n_jobs=2)(joblib.delayed(function)(part) for part in np.split(samples, 4))
    assert np.array_equal(np.vstack(parts), function(samples))
    assert np.array_equal(function(samples[3]), function(samples)[3])
    with pytest.raises(ValueError, match="2 parameters"):
        function(samples[:, :1])


def test_salib_computes_sobol_indices(deck: rv.Deck) -> None:
    pytest.importorskip("SALib")
    from SALib.analyze import sobol
    from SALib.sample import sobol as sampling

    problem = {"num_vars": 2, "names": ["V", "friction"], "bounds": [[500, 900], [0.0, 0.04]]}
    samples = sampling.sample(problem, 64, calc_second_order=False, seed=1)
    depths = rv.sampler(deck, problem["names"], "-1000*final(U2@REF)")(samples)[:, 0]
    indices = sobol.analyze(problem, depths, calc_second_order=False, seed=1)
    assert indices["S1"][0] > 0.5 > indices["S1"][1] > 0.0


def test_scipy_gives_quasi_random_samples(deck: rv.Deck) -> None:
    qmc = pytest.importorskip("scipy.stats").qmc
    samples = qmc.scale(qmc.Sobol(2, seed=1).random(16), [500, 0.018], [900, 0.024])
    table = deck.evaluate({"V": samples[:, 0], "mass": samples[:, 1]}, "-1000*final(U2@REF)")
    depth = {tuple(s): d for s, d in zip(samples, table.values[:, 0])}
    fast = max(samples[:, 0])
    assert depth[next(s for s in depth if s[0] == fast)] > np.median(table.values)


def test_study_reports_its_error(deck: rv.Deck) -> None:
    study = deck.study({"n": [10, 20, 40]}, "-1000*final(U2@REF)")
    assert len(study.table) == 3
    fine = deck.run(n=320).quantity("-1000*final(U2@REF)")
    assert abs(study.limit - fine) <= study.uncertainty + 1e-4
    assert study.reached is None
    assert deck.study({"n": [10, 20, 40]}, "-1000*final(U2@REF)", target="1%").reached
    assert study.record["quantity"] == "-1000*final(U2@REF)"
    assert deck.study({"n": [10, 20]}, "-1000*final(U2@REF)", jitter=2).record["noise"]["runs"] == 2
    with pytest.raises(rv.StudyError, match="increasing"):
        deck.study({"n": [10, 40, 20]}, "final(U2@REF)")


def test_uncertainty_names_its_dominant_part(deck: rv.Deck) -> None:
    found = deck.uncertainty("-1000*final(U2@REF)", distributions={"V": "normal(800, 8)"})
    quantity = found["quantities"][0]
    assert quantity["dominant"] == "input"
    assert 0 < quantity["mesh"] < quantity["input"] < 0.1 * quantity["value"]
    assert found["conclusions"][0].startswith("-1000*final(U2@REF) = ")


def test_sensitivity_is_the_slope_of_the_depth(deck: rv.Deck) -> None:
    depth = "-1000*final(U2@REF)"
    (of_depth,) = deck.sensitivity(depth, ["V", "CRH"], V=600)["quantities"]
    near = deck.evaluate({"V": np.array([599.0, 601.0])}, depth)
    velocity, shape = of_depth["parameters"]
    assert (velocity["method"], shape["method"]) == ("stages", "differences")
    assert velocity["derivative"]["value"] == pytest.approx(0.5 * (near[1, 0] - near[0, 0]), rel=1e-5)
    assert shape["logarithmic"]["uncertainty"] < 1e-3 * shape["logarithmic"]["value"]
    with pytest.raises(rv.StudyError, match="no parameter speed"):
        deck.sensitivity(depth, "speed")


def test_limit_reports_outcomes() -> None:
    deck = rv.Deck(ROOT / "input" / "plate_6061.inp")
    found = deck.limit("V", (200, 900), 1.0, shots=6)
    assert found.velocity == pytest.approx(398.7, abs=1.0)
    assert [end for end, _, _ in found.bands] == ["embedded", "perforation"]
    assert all((end == "perforation") == (velocity > found.velocity) for velocity, _, end in found.shots)
    slow = deck.limit("V", (100, 300), 1.0, shots=2, threads=1)
    assert slow.velocity is None
    assert slow.bands == [("embedded", 100.0, 300.0)]
    with pytest.raises(rv.StudyError, match="between"):
        deck.limit("V", (900, 200), 1.0)


def printed(*words: str | Path) -> Any:
    command = [sys.executable, "-m", "revolve", *words, "--json"]
    return untimed(json.loads(subprocess.run(command, capture_output=True, check=True).stdout))


def untimed(record: dict[str, Any]) -> dict[str, Any]:
    """Return a record without its run time."""
    return {key: value for key, value in record.items() if key != "seconds"}


def test_studies_are_those_of_the_program(deck: rv.Deck, tmp_path: Path) -> None:
    depth, out = "-1000*final(U2@REF)", ("--out", tmp_path)
    scattered = deck.scatter({"V": "normal(569, 5)"}, depth, count=200, seed=3, CRH=3.5)
    words = ["-d", "V=normal(569, 5)", "--quantity", depth, "-c", "200", "--seed", "3", "-s", "CRH=3.5"]
    assert untimed(scattered) == printed("scatter", OGIVE, *words, *out)
    shots = ROOT / "input" / "reference" / "shots_6061.csv"
    fitted = deck.identify({"A": (2.0, 8.0)}, os.path.relpath(shots), {"depth": depth}, B=0.983, C=0.9402)
    words = ["--measured", "depth", "--quantity", depth, "--unknown", "A=2..8", "-s", "B=0.983", "-s", "C=0.9402"]
    assert untimed(fitted) == printed("identify", OGIVE, "--shots", shots, *words, *out)
    plates = ROOT / "input" / "plates_derived.inp"
    pressures = rv.Deck(plates).resistance(400.0, material="AL6061", shape="cylindrical")
    assert untimed(pressures) == printed(
        "resistance", plates, "--to", "400", "--material", "AL6061", "--type", "cylindrical"
    )
    taylor = ROOT / "input" / "taylor_copper.inp"
    curves = rv.Deck(taylor).material(rates=[1.0, 1e4], strain=0.2)
    assert untimed(curves) == printed("material", taylor, "--rates", "1,1e4", "--strain", "0.2", *out)
    with pytest.raises(rv.StudyError, match="no parameter"):
        deck.scatter({"speed": "1..2"}, depth)


def test_evaluations_are_data_frames_with_failures_and_units(deck: rv.Deck) -> None:
    pytest.importorskip("pandas")
    table = deck.evaluate({"mass": np.array([0.02, -1.0]), "V": 500.0}, "final(U2@REF)").to_pandas()
    assert list(table.columns) == ["mass", "V", "final(U2@REF)", "failure"]
    assert list(table["mass"]) == [0.02, -1.0]
    assert table["failure"].isna().tolist() == [True, False]
    assert table["final(U2@REF)"].isna().tolist() == [False, True]
    assert table.attrs["units"]["length"] == "m"


def test_a_run_is_repeated_from_its_folder(deck: rv.Deck, tmp_path: Path) -> None:
    deck.run(V=821, CRH="3.5", out=tmp_path / "first")
    command = [sys.executable, "-m", "revolve", "rerun", tmp_path / "first"]
    assert "that of the run" in subprocess.run(command, capture_output=True, text=True, check=True).stdout


def test_objects_have_notebook_representations(deck: rv.Deck) -> None:
    run = deck.run()
    page = run._repr_html_()
    assert page.count("<svg") == len(run.charts()) == 4
    assert "completed" in page
    assert "cavity expansion" in run.ledger._repr_html_()
    assert "share of run time" in run.ledger._repr_html_()
    assert "cavity expansion" in str(deck.ledger)
    assert "share of run time" not in deck.ledger._repr_html_()
    assert "CRH" in deck._repr_html_()
    assert "<svg" in deck.study({"n": [10, 20, 40]}, "final(U2@REF)")._repr_html_()
    unused = rv.Deck(text=OGIVE.read_text().replace("U2, V2, A2", "U2, V2, A2, S"), name="<b>.inp")
    assert "<b>.inp" not in unused._repr_html_().replace("<b>&lt;b&gt;.inp</b>", "")


SLOW = """\
*Node
 1, 0., 0.
 2, 0.1, 0.
 9, 0., 0.1
*Element, type=RAX2, elset=SIDE
 1, 1, 2
*Element, type=MASS, elset=POINT
 9, 9
*Mass, elset=POINT
 1.
*Rigid Body, ref node=9, elset=SIDE
*Parameter
v = 1.
*Initial Conditions, type=VELOCITY
 9, 2, <v>
*Step
*Dynamic, Explicit, direct user control
 1.e-9, 10.
*Output, history, number interval=10
*Energy Output
 ALLKE
*End Step
"""


@pytest.mark.parametrize("how", ["run", "evaluate", "many"])
def test_keyboard_interrupt_stops_the_call(how: str) -> None:
    slow = rv.Deck(text=SLOW)
    # A shell ignores SIGINT in background commands, so that Python would not receive it.
    previous = signal.signal(signal.SIGINT, signal.default_int_handler)
    timer = threading.Timer(0.5, lambda: os.kill(os.getpid(), signal.SIGINT))
    timer.start()
    begin = time.monotonic()
    try:
        with pytest.raises(KeyboardInterrupt):
            if how == "run":
                slow.run()
            else:
                slow.evaluate({"v": [1.0, 2.0]}, "final(ALLKE)", threads=2 if how == "many" else 1)
    finally:
        signal.signal(signal.SIGINT, previous)
    assert time.monotonic() - begin < 60


def test_progress_is_reported_and_may_stop_a_run() -> None:
    told = []

    def progress(fraction: float, words: str) -> None:
        told.append((fraction, words))
        if len(told) == 3:
            raise TimeoutError

    with pytest.raises(TimeoutError):
        rv.Deck(text=SLOW).run(progress=progress)
    assert len(told) >= 3
    assert 0 < told[0][0] < told[2][0] < 1
    assert "t = " in told[0][1]


def test_command_line_is_installed() -> None:
    script = Path(sys.executable).with_name("revolve")
    found = subprocess.run([script, "check", OGIVE], capture_output=True, text=True, check=True)
    assert "cavity expansion" in found.stdout
    refused = subprocess.run([script, "run", "no such.inp"], capture_output=True, text=True, check=False)
    assert refused.returncode == 2
    assert "D001" in refused.stderr
    assert (
        subprocess.run([script, "--version"], capture_output=True, text=True, check=True).stdout.split()[1]
        == rv.__version__
    )


def test_parquet_samples_match_csv(tmp_path: Path) -> None:
    pandas = pytest.importorskip("pandas")
    pytest.importorskip("pyarrow")
    script = Path(sys.executable).with_name("revolve")
    tables = [tmp_path / name for name in ("samples.csv", "samples.parquet")]
    for table in tables:
        # Negative masses give no result, and their cells are empty.
        draws = ["--distribution", "mass=-0.01..0.02", "--count", "40", "--quantity", "-1000*final(U2@REF)"]
        words = [script, "scatter", OGIVE, *draws, "--table", table, "--out", tmp_path, "--quiet"]
        assert subprocess.run(words, check=False).returncode == 1
    rows, columns = pandas.read_csv(tables[0], float_precision="round_trip"), pandas.read_parquet(tables[1])
    pandas.testing.assert_frame_equal(rows, columns, check_exact=True)
    assert len(rows) == 40
    assert 0 < rows.isna().to_numpy().sum() < 40


def test_live_view_shows_the_page_of_a_run_and_then_a_picture(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import IPython.display
    from revolve._view import NotebookView

    shown: list[object] = []

    class Handle:
        def update(self, value: object) -> None:
            shown.append(value)

    def display(value: object, display_id: bool) -> Handle:
        assert display_id
        shown.append(value)
        return Handle()

    monkeypatch.setattr(IPython.display, "display", display)
    rv.Deck("input/ogive.inp").run(out=tmp_path)
    told: list[float] = []
    view = NotebookView(tmp_path, 300, lambda fraction, _: told.append(fraction))
    while not shown:
        view(0.5, "")
    view.close()
    page, picture = shown
    assert page.src.startswith("http://127.0.0.1:")
    assert "<svg" in picture.data and "PRESSURE" in picture.data
    assert told and set(told) == {0.5}
    with pytest.raises(TypeError, match="out="):
        rv.Deck("input/ogive.inp").run(view=True)
