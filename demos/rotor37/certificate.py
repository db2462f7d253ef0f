# %% [markdown]
# # NASA rotor 37 with twenty harmonics: is every motion one of the model in time?
#
# Each motion of harmonic balance is integrated in time, exactly between changes of contact, over
# one and ten periods, and shot: Newton's iteration on the period map, to round-off. What shooting
# finds has Floquet multipliers, and so a stability. The model is the paper's, with linear
# kinematics; what these leave out (engine.py) is another question, so that doubt is set aside here.
#
# Run with `python3 demos/rotor37/certificate.py`; takes about two minutes.

# %%
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
from mpi4py import MPI

from fenics_nnm.backbone import point_numbers as numbers
from fenics_nnm.mechanics.second_order_effect import UNASKED
from fenics_nnm.structure.analysis import linear_analysis, nonlinear_mode
from fenics_nnm.study import study_from

STUDY = Path(__file__).parent / "rotor37.toml"

values = tomllib.loads(STUDY.read_text())
values["mode"].update(harmonics=20, samples=256)
study = study_from(values, STUDY)
linear = linear_analysis(study, MPI.COMM_SELF)
undoubted = replace(linear.reduction, choice=UNASKED)
branch = nonlinear_mode(study, linear.reduced_to(linear.modes, undoubted))

# %%
print(
    "| gamma ratio | frequency (Hz) | status | return error, 1 period "
    "| 10 periods | of the shot motion | energy drift |\n|---|---|---|---|---|---|---|"
)
for point in branch.points:
    print(
        f"| {point.gamma_ratio:.2f} | {point.motion.frequency:.4f} | {point.status} "
        f"| {numbers.return_error(point):.1e} | {numbers.return_error_10(point):.1e} "
        f"| {numbers.shot_return_error(point):.0e} | {numbers.energy_drift(point):.0e} |"
    )
print()
for bifurcation in branch.bifurcations.located:
    print(bifurcation)
statuses = [point.status for point in branch.points]
shot = np.array([numbers.shot_return_error(point) for point in branch.points])
missed = max(map(numbers.return_error, branch.points))
missed_10 = max(map(numbers.return_error_10, branch.points))
drift = max(map(numbers.energy_drift, branch.points))
print(
    f"docs: rotor37_certificate\nThe status is `verified` at {statuses.count('verified')} of "
    f"{len(statuses)} points. The largest [return error](glossary.md) is {missed:.1e} after one "
    f"period and {missed_10:.1e} after ten periods. Shooting finds exact motions from "
    f"{np.isfinite(shot).sum()} of {len(statuses)} points, with return errors of at most "
    f"{np.nanmax(shot):.0e}. Over ten periods, the energy changes by at most {drift:.0e} of its "
    f"value.\n"
)
assert branch.complete
assert set(statuses) <= {"verified", "converged"}
assert statuses.count("verified") >= 22
assert missed < 1e-2
assert np.nanmax(shot) < 1e-10
assert drift < 1e-6
