#!/usr/bin/env bash
# ccx2paraview 3.2.0 on a CalculiX result file (.frd) with one CAX4 element in tension and in shear.
# Guess: E_Mises, which the converter adds beside E, is the equivalent strain (2/3 e:e of the deviator)^(1/2): the axial strain of
#   a bar whose volume stays, and comparable with a plastic strain PEEQ. S_Principal and E_Principal have three components.
# Happens: E_Mises is the formula of the stress, with 3/2 in place of 2/3, on the components of strain: 1.5 times the equivalent
#   strain in every state; e1 - e2 in tension, 1.3e-3 at an axial strain of 1e-3 with Poisson's ratio .3 (equivalent: .867e-3).
#   The principal arrays have four components, the fourth is the one of largest magnitude, so that ParaView's "Magnitude" of
#   E_Principal counts it twice.
# Hurt: who compares strains, or plastic strains in the limit of no volume change, of CalculiX with another code in ParaView.
set -euo pipefail
t=$(mktemp -d); trap 'rm -rf "$t"' EXIT; cd "$t"
python3 -m venv v; v/bin/pip install -q ccx2paraview==3.2.0 vtk==9.7.2 numpy==2.4.4
# The file in the text form of CalculiX: strains are components of the tensor.
v/bin/python - <<'P'
def record(key, *values): return f" -1{key:10d}" + "".join(f"{v:12.5E}" for v in values)
nodes = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
strain = (-3e-4, 1e-3, -3e-4, 2e-4, 0.0, 0.0)
lines = ["    1C", "    2C                             4                                     1"]
lines += [record(i + 1, *map(float, n)) for i, n in enumerate(nodes)] + [" -3"]
lines += ["    3C                             1                                     1", " -1         1    9    0    1",
          " -2         1         2         3         4", " -3"]
lines += ["    1PSTEP                         1           1           1",
          "  100CL  101 1.000000000           4                     0    1           1", " -4  TOSTRAIN    6    1"]
pairs = [("EXX", 1, 1), ("EYY", 2, 2), ("EZZ", 3, 3), ("EXY", 1, 2), ("EYZ", 2, 3), ("EZX", 3, 1)]
lines += [f" -5  {n}         1    4    {i}    {j}" for n, i, j in pairs]
lines += [record(i + 1, *strain) for i in range(4)] + [" -3", " 9999"]
open("a.frd", "w").write("\n".join(lines) + "\n")
P
v/bin/ccx2paraview a.frd vtu >log 2>&1 || { cat log; exit 1; }
v/bin/python - <<'P'
import sys
import numpy as np, vtk
from vtk.util.numpy_support import vtk_to_numpy
reader = vtk.vtkXMLUnstructuredGridReader(); reader.SetFileName("a.vtu"); reader.Update()
data = reader.GetOutput().GetPointData()
array = lambda name: vtk_to_numpy(data.GetArray(name))[0]
xx, yy, zz, xy, yz, zx = array("E")
tensor = np.array([[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]])
deviator = tensor - np.trace(tensor) / 3 * np.eye(3)
equivalent = np.sqrt(2 / 3 * (deviator * deviator).sum())
principal = array("E_Principal")
print("E", array("E")); print("E_Mises", array("E_Mises"), "equivalent strain", equivalent, "ratio", array("E_Mises") / equivalent)
print("E_Principal", principal, "eigenvalues", np.linalg.eigvalsh(tensor))
sys.exit(not (abs(array("E_Mises") / equivalent - 1.5) < 1e-4 and len(principal) == 4 and principal[3] == max(principal[:3], key=abs)))
P
