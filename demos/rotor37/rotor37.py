# %% [markdown]
# # NASA rotor 37: a compressor blade that rubs its casing
#
# The blade is lofted through NASA's section table, clamped at the hub, and meets a rigid casing in
# the radial direction at 24 points of its tip. The study is rotor37.toml; how fine the mesh must
# be is measured by mesh_study.py.
#
# Run with `python3 demos/rotor37/rotor37.py`; results go to demos/rotor37/results. Open
# results/fields/motion_1.8.pvd in ParaView, warp by displacement, and play the period.

# %%
from pathlib import Path

import h5py
import numpy as np
from rich.console import Console

from fenics_nnm.progress import progress
from fenics_nnm.run import run_study
from fenics_nnm.study import read_study

HERE = Path(__file__).parent
path = HERE / "rotor37.toml"
with progress(Console()) as stages:
    result = run_study(read_study(path), path.read_text(), HERE / "results", stages=stages)
points = result.branch.points
print(
    f"{result.summary['dofs']} degrees of freedom, first frequency "
    f"{result.summary['linear_frequencies_Hz'][0]:.2f} Hz; {result.branch.reason}"
)

# %% [markdown]
# Contact begins where the first mode moves outwards most: at the leading edge.

# %%
with h5py.File(HERE / "results" / "branch.h5") as file:
    axial = file["contact/points"][:, 0]
touching = next(point for point in points if point.force.max() > 1e-6 * points[-1].force.max())
first = int(np.argmax(touching.force.max(axis=0)))
chord_position = (axial[first] - axial.min()) / np.ptp(axial)
print(f"contact begins at {chord_position:.0%} of the axial chord (0 % is the leading edge)")
assert min(chord_position, 1 - chord_position) < 0.05

# %% [markdown]
# The frequency rises with the energy as more of the tip rubs for longer.

# %%
for point in points:
    count = np.count_nonzero(point.force.max(axis=0))
    print(
        f"gamma ratio {point.gamma_ratio:.2f}: {point.frequency:.2f} Hz, in contact "
        f"{point.contact_fraction:.0%} of the period, at {count} points"
    )
contacting = [point.frequency for point in points if point.gamma_ratio >= 1]
assert np.all(np.diff(contacting) > 0)
assert result.branch.complete
