# %% [markdown]
# # NASA rotor 37 with twenty harmonics: is every motion one of the model in time?
#
# Each motion of harmonic balance is integrated in time, exactly between changes of contact, over
# one and ten periods, and shot: Newton's iteration on the period map, to round-off. What shooting
# finds has Floquet multipliers, and so a stability.
#
# Run with `python3 demos/rotor37/certificate.py`; takes about two minutes.

# %%
import tomllib
from pathlib import Path

import numpy as np
from mpi4py import MPI

from fenics_nnm.analysis import linear_analysis, nonlinear_mode
from fenics_nnm.study import study_from

STUDY = Path(__file__).parent / "rotor37.toml"

values = tomllib.loads(STUDY.read_text())
values["mode"].update(harmonics=20, samples=256)
study = study_from(values, STUDY)
branch = nonlinear_mode(study, linear_analysis(study, MPI.COMM_SELF))

# %%
print("gamma ratio  frequency (Hz)  status     return, 1 and 10 periods  shot return  drift")
for point in branch.points:
    print(
        f"{point.gamma_ratio:11.2f}  {point.frequency:14.4f}  {point.status:9}  "
        f"{point.return_error:11.1e} {point.return_error_10:12.1e}  "
        f"{point.shot_return_error:11.0e}  {point.energy_drift:5.0e}"
    )
for bifurcation in branch.bifurcations.located:
    print(bifurcation)
statuses = [point.status for point in branch.points]
shot = np.array([point.shot_return_error for point in branch.points])
print(
    f"{statuses.count('verified')} of {len(statuses)} verified; largest return error "
    f"{max(point.return_error for point in branch.points):.1e}, of shot motions "
    f"{np.nanmax(shot):.0e}; {np.isnan(shot).sum()} without a shot motion; largest drift "
    f"{max(point.energy_drift for point in branch.points):.0e}"
)
assert branch.complete
assert set(statuses) <= {"verified", "converged"}
assert statuses.count("verified") >= 22
assert max(point.return_error for point in branch.points) < 1e-2
assert np.nanmax(shot) < 1e-10
assert max(point.energy_drift for point in branch.points) < 1e-6
