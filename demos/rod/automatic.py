# %% [markdown]
# # The rod with harmonics, samples and modes that the run finds itself
#
# `harmonics = "auto"`, `samples = "auto"`, `modes = "auto"` and a tolerance of 1e-3 on the
# frequency, against the exact mode. Energies are ratios, so another gap gives the same numbers.
#
# Run with `python3 demos/rod/automatic.py`; takes about a quarter of an hour.

# %%
import tempfile
import time
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
from exact_rod import frequency_ratio

from fenics_nnm.run import run_study
from fenics_nnm.study import study_from

FINE = Path(__file__).parent / "fine.toml"
TRUSTED = ("verified", "converged")


def run(elements: int, degree: int, step: float, **more: Any) -> tuple[np.ndarray, np.ndarray]:
    """Errors at unmarked and at marked points from gamma ratio 1.05 to 4; prints a row."""
    values = tomllib.loads(FINE.read_text())
    values["mesh"]["elements"] = elements
    values["body"]["degree"] = degree
    values["contact"].update(more)
    values["reduction"] = {"modes": "auto"}
    values["mode"] = {"harmonics": "auto", "samples": "auto", "tolerance": 1e-3}
    energies = {"from": 1.05, "to": 4.0, "step": step}
    values["continuation"] = {"energies": energies, "shooting": False}
    begin = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        result = run_study(study_from(values, FINE), "", Path(folder) / "results")
    points = result.branch.points
    exact = frequency_ratio(np.array([point.gamma_ratio for point in points]))
    error = np.abs(np.array([point.frequency_ratio for point in points]) / exact - 1)
    unmarked = np.array([point.status in TRUSTED for point in points])
    marked = error[~unmarked]
    print(
        f"| {elements} {'linear' if degree == 1 else 'quadratic'} | {result.message} "
        f"| {len(error)} | {len(marked)} | {f'{marked.max():.2%}' if len(marked) else ''} "
        f"| {error[unmarked].max():.2%} | {np.median(error[unmarked]):.2%} "
        f"| {len(result.branch.failures)} | {time.perf_counter() - begin:.0f} s |"
    )
    return error[unmarked], marked


# %%
print(
    "docs: rod_automatic\n| elements | message of the run | points | marked points "
    "| largest error of marked points | largest error of unmarked points "
    "| median error of unmarked points | gamma ratios without a motion | elapsed time |\n"
    "|---|---|---|---|---|---|---|---|---|"
)
unmarked, marked = run(100, 2, 0.05)
assert unmarked.max() < 3e-3
assert np.median(unmarked) < 1e-3
assert len(marked) <= (len(unmarked) + len(marked)) / 4

# %%
run(50, 2, 0.5, gap=3e-3)
