#!/usr/bin/env bash
# Writes the mesh files of this folder again, with the real tools in pinned versions.
# Usage: ./write.sh [FOLDER], default: the folder of this script.
# Python packages are installed in a temporary folder. Three programs must be installed before:
#   apt-get install --no-install-recommends calculix-cgx freecad-python3 faketime
# The versions of Debian 12 are: cgx 2.17+dfsg-2+b1, FreeCAD 0.20.2+dfsg1-4+deb12u1. faketime fixes the time stamps of .med files.
# Python 3.11 is recommended: the pinned packages have wheels for it. Duration: about 2 minutes, most of it the installation.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
target=$(mkdir -p "${1:-$here}" && cd "${1:-$here}" && pwd)
for program in cgx freecadcmd faketime; do
    command -v "$program" > /dev/null || { echo "$program is not installed, see the first lines of this script" >&2; exit 1; }
done
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# The versions of all packages that write a file. The others are their dependencies.
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install -q --disable-pip-version-check \
    gmsh==4.15.2 meshio==5.3.5 netgen-mesher==6.2.2608 netgen-occt==7.8.1 MeshPy==2026.1.1 pyvista==0.46.4 vtk==9.5.2 \
    medcoupling==9.15.0 pyNastran==1.4.1 pygmsh==7.1.17 numpy==1.26.4

python3 -m venv "$work/solvers"
"$work/solvers/bin/pip" install -q --disable-pip-version-check \
    ngsolve==6.2.2608 netgen-mesher==6.2.2608 netgen-occt==7.8.1 mfem==4.10.0.1 KratosMultiphysics==10.4.4 MeshPy==2026.1.1 \
    meshio==5.3.5

SOLVERS_PYTHON="$work/solvers/bin/python" "$work/venv/bin/python" "$here/write.py" "$target"

# Table: size and first line of each file.
printf '\n%-40s %8s  %s\n' file bytes 'first line'
total=0
for file in "$target"/*.{inp,msh,vtk,vtu,vtp,med,unv,sur}; do
    size=$(stat -c %s "$file")
    total=$((total + size))
    printf '%-40s %8d  %s\n' "$(basename "$file")" "$size" "$(head -c 50 "$file" | tr -d '\0' | head -n 1 | tr -cd '[:print:]')"
done
echo "total: $total bytes"
