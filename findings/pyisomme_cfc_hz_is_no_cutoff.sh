#!/usr/bin/env bash
# pyisomme 1.1.0 (PyPI, crash-test channels of ISO/TS 13499): the channel filters cfc_hz(FREQUENCY) and its two methods.
# Guess: cfc_hz(100) is "an explicit cutoff frequency in Hz", so a sine of 100 Hz loses 3 dB; both methods (ISO-6487, the
#   default, and SAE-J211-1) keep a constant force; samples that are too coarse for the filter are an error.
# Happens: the argument is the channel frequency class. 100 Hz loses 0.4 dB (factor .950); the factor of 3 dB is reached at 166 Hz.
#   A constant of 26 stays 26 with ISO-6487. SAE-J211-1 runs from rest in both directions: it begins with 0 and 13.1 and ends
#   with 0, so the mean of 4 ms is 3.4 % low. With samples every 0.3 ms cfc_hz(1000) returns NaN with a warning of numpy
#   only; every 0.2 ms it works.
# Hurt: anyone who compares a filtered contact force of a simulation with a low-pass of the same frequency elsewhere: the curves
#   differ by a factor of 1.65 in frequency; impulses and mean forces of short records are low with the second method.
set -euo pipefail
t=$(mktemp -d); trap 'rm -rf "$t"' EXIT; cd "$t"
python3 -m venv v; v/bin/pip install -q pyisomme==1.1.0 numpy==1.26.4 pandas==2.2.3
v/bin/python - <<'P' 2>log
import importlib.metadata, sys
import numpy as np, pandas as pd
from pyisomme.channel import Channel
def channel(values, dt):
    return Channel("11HEAD0000H3ACXP", pd.DataFrame(values, index=dt * np.linspace(0, len(values) - 1, len(values))))
def gain(frequency, dt=1e-5, count=100_000):
    filtered = channel(np.sin(2 * np.pi * frequency * dt * np.linspace(0, count - 1, count)), dt).cfc_hz(100).get_data()
    return float(np.sqrt(2 * np.mean(np.asarray(filtered)[count // 4 : 3 * count // 4] ** 2)))
gains = {f: round(gain(f), 3) for f in (100, 166)}
constant = channel(np.full(4000, 26.0), 1e-6)
iso, sae = (np.asarray(constant.cfc_hz(1000, method=m).get_data()) for m in ("ISO-6487", "SAE-J211-1"))
coarse = [bool(np.isnan(channel(np.sin(0.1 * np.linspace(0, 1999, 2000)), dt).cfc_hz(1000).get_data()).any()) for dt in (2e-4, 3e-4)]
print("pyisomme", importlib.metadata.version("pyisomme"), " factor of cfc_hz(100) by frequency in Hz:", gains)
print("constant 26: ISO-6487", iso[0].round(3), iso.mean().round(3), iso[-1].round(3), " SAE-J211-1", sae[:2].round(2), sae.mean().round(2), sae[-1])
print("NaN with samples every 0.2 and 0.3 ms:", coarse)
sys.exit(not (gains == {100: 0.95, 166: 0.713} and abs(iso - 26).max() < 1e-6 and sae[0] == 0 and sae[-1] == 0
              and sae.mean() < 25.2 and coarse == [False, True]))
P
