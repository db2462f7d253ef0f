# %% [markdown]
# # The rod on other grids of energies, on other meshes, and in other modes
#
# How near to the exact mode does the branch stay, and how many of its points are marked? The
# frequencies of a coarse mesh are not the odd multiples of the first any more, so its resonances
# are others, and wider. Higher modes meet the same frequencies with fewer harmonics below them.
#
# Run with `python3 demos/rod/discretisations.py`; takes some minutes.

# %%
import tomllib
from pathlib import Path

import numpy as np
from exact_rod import frequency_ratio
from mpi4py import MPI

from fenics_nnm.structure.analysis import linear_analysis, nonlinear_mode
from fenics_nnm.study import study_from

FINE = Path(__file__).parent / "fine.toml"


def errors(
    elements: int, degree: int, modes: int, step: float, mode: int = 1
) -> tuple[np.ndarray, np.ndarray]:
    """Errors at unmarked and at marked points from gamma ratio 1.05 to 4; prints a row."""
    values = tomllib.loads(FINE.read_text())
    values["mesh"]["elements"] = elements
    values["body"]["degree"] = degree
    values["reduction"]["modes"] = modes
    values["mode"]["number"] = mode
    energies = {"from": 1.05, "to": 4.0, "step": step}
    values["continuation"] = {"energies": energies, "shooting": False}
    study = study_from(values, FINE)
    branch = nonlinear_mode(study, linear_analysis(study, MPI.COMM_SELF))
    exact = frequency_ratio(np.array([point.gamma_ratio for point in branch.points]), mode)
    error = np.array([point.frequency_ratio for point in branch.points]) / exact - 1
    trusted = ("verified", "converged")
    unmarked = np.array([p.status in trusted and not p.resonance for p in branch.points])
    marked = np.abs(error[~unmarked])
    print(
        f"| {elements} {'linear' if degree == 1 else 'quadratic'} | {modes} | {mode} | {step:g} "
        f"| {len(error)} | {len(marked)} | {f'{marked.max():.2%}' if len(marked) else ''} "
        f"| {np.abs(error[unmarked]).max():.2%} | {np.median(np.abs(error[unmarked])):.2%} "
        f"| {len(branch.failures)} |"
    )
    return error[unmarked], error[~unmarked]


print(
    "docs: rod_discretisations\n| elements | modes of the model | followed mode "
    "| step of the gamma ratio | points | marked points | largest error of marked points "
    "| largest error of unmarked points | median error of unmarked points "
    "| gamma ratios without a motion |\n"
    "|---|---|---|---|---|---|---|---|---|---|"
)
unmarked, marked = errors(100, 2, 40, 0.05)
assert np.abs(unmarked).max() < 3e-3
assert np.median(np.abs(unmarked)) < 1e-3
assert len(marked) <= (len(unmarked) + len(marked)) / 4
for mesh in ((100, 2, 20), (50, 2, 30), (200, 1, 40), (40, 1, 20), (20, 1, 10)):
    errors(*mesh, 0.1)
for mode in (2, 3):
    unmarked, marked = errors(100, 2, 40, 0.25, mode)
    assert np.abs(unmarked).max() < 3e-3
