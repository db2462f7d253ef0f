# %% [markdown]
# # How fine must the mesh of the rotor 37 blade be?
#
# The first five frequencies on meshes of halved element size. Run with
# `python3 demos/rotor37/mesh_study.py`; takes a minute.

# %%
from pathlib import Path

import numpy as np
from mpi4py import MPI

from fenics_nnm.structure.analysis import linear_analysis
from fenics_nnm.study import read_study

study = read_study(Path(__file__).parent / "rotor37.toml")
before = None
print(
    "docs: rotor37_mesh\n| element size | degrees of freedom | f1 (Hz) | f2 (Hz) | f3 (Hz) "
    "| f4 (Hz) | f5 (Hz) | largest change of a frequency |\n|---|---|---|---|---|---|---|---|"
)
for size in (6e-3, 3e-3, 1.5e-3):
    mesh = study.mesh.model_copy(update={"element_size": size})
    analysis = linear_analysis(study.model_copy(update={"mesh": mesh}), MPI.COMM_WORLD)
    frequencies = analysis.modes.frequencies[:5]
    change = None if before is None else np.abs(before / frequencies - 1).max()
    assert change is None or change < 0.01
    listed = " | ".join(f"{value:.2f}" for value in frequencies)
    shown = "" if change is None else f"{change:.2%}"
    print(f"| {size * 1e3:.1f} mm | {analysis.solid.dofs} | {listed} | {shown} |")
    before = frequencies
print()
