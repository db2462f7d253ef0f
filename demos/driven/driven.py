# %% [markdown]
# # Two masses that are shaken
#
# A chain of two masses with damping ratios, under a harmonic force at the first one; the second
# has a stop beside it, and keeps clear of it. Amplitude and phase are known in closed form: with
# the modes of the chain the complex amplitudes are
#
#     x = sum_j phi_j phi_j^T F / (omega_j^2 - omega^2 + 2 i zeta_j omega_j omega).
#
# The study file is `driven.toml`; `fenics-nnm response driven.toml` does the same from the command
# line once the matrices are there.
#
# Run with `python3 demos/driven/driven.py`; takes some seconds.

# %%
import csv
import os
from pathlib import Path

import numpy as np
from scipy.linalg import eigh

from fenics_nnm.cli import main

HERE = Path(__file__).parent
K = np.array([[3000.0, -1000.0], [-1000.0, 2000.0]])
M = np.diag([1.0, 0.5])
RATIOS, FORCE = np.array([0.01, 0.02]), 10.0


def closed_form(frequency: np.ndarray) -> np.ndarray:
    """Complex amplitudes of both masses in m, shape (f, 2)."""
    squared, shapes = eigh(K, M)
    omega = 2 * np.pi * frequency[:, None]
    push = shapes[0] * FORCE
    modal = push / (squared - omega**2 + 2j * RATIOS * np.sqrt(squared) * omega)
    return np.asarray(modal @ shapes.T)


# %%
results = HERE / "results"
results.mkdir(exist_ok=True)
np.savez(results / "chain.npz", K=K, M=M, B=np.array([[0.0, 1.0]]))
assert main(["response", "--output", str(results), os.path.relpath(HERE / "driven.toml")]) == 0

# %%
with (results / "response.csv").open() as file:
    rows = list(csv.DictReader(file))
for column, monitor in enumerate(("excitation", "contact 1")):
    found = [row for row in rows if row["monitor"] == monitor]
    exact = closed_form(np.array([float(row["frequency_Hz"]) for row in found]))[:, column]
    amplitude = np.array([float(row["amplitude_m"]) for row in found])
    lag = np.array([float(row["phase_deg"]) for row in found])
    np.testing.assert_allclose(amplitude, abs(exact), rtol=1e-9)
    np.testing.assert_allclose(np.exp(-1j * np.deg2rad(lag)), exact / abs(exact), atol=1e-9)
