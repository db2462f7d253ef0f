# %% [markdown]
# # NASA rotor 67: a fan blade that rubs its casing
#
# Sections and walls are NASA's tables. The blade is cut by the hub line and, at the running
# clearance, by the casing line, so that its tip follows the casing. The study is rotor67.toml.
#
# Run with `python3 demos/rotor67/rotor67.py`; results go to demos/rotor67/results.

# %%
from pathlib import Path

import numpy as np
from rich.console import Console

from fenics_nnm.output.gallery import make_pictures
from fenics_nnm.progress import progress
from fenics_nnm.run import run_study
from fenics_nnm.study import read_study

HERE = Path(__file__).parent
RESULTS = HERE / "results"
path = HERE / "rotor67.toml"
with progress(Console()) as stages:
    result = run_study(read_study(path), path.read_text(), RESULTS, stages=stages)
frequencies = result.summary["linear_frequencies_Hz"]
print(
    f"{result.summary['dofs']} degrees of freedom, first frequencies "
    f"{', '.join(f'{f:.1f}' for f in frequencies[:3])} Hz; {result.branch.reason}"
)
assert result.branch.complete

# %% [markdown]
# The tip rubs over more and more of its chord; the frequency rises with the energy.

# %%
points = result.branch.points
for point in points:
    count = np.count_nonzero(point.force.max(axis=0))
    print(
        f"gamma ratio {point.gamma_ratio:.2f}: {point.frequency:.2f} Hz, in contact "
        f"{point.contact_fraction:.0%} of the period, at {count} points"
    )
rising = [point.frequency for point in points if point.gamma_ratio >= 1]
assert np.all(np.diff(rising) > 0)
assert 1.03 < points[-1].frequency / points[0].frequency < 1.06

# %%
pictures = make_pictures(RESULTS, RESULTS / "pictures", formats=["png"])
print(f"{len(pictures)} pictures in {RESULTS}/pictures")
