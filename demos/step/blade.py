# %% [markdown]
# # A blade from a STEP file
#
# A twisted, tapered blade is lofted by OpenCASCADE and exported as STEP, as a CAD program would.
# `blade.toml` takes that file from there: it picks the root, the tip and a pad on one side of the
# blade by where they lie, makes smaller elements at the pad, and follows the first bending mode
# against a stop beside the pad.
#
# Run with `python3 demos/step/blade.py`; results go to demos/step/results.

# %%
from pathlib import Path

import gmsh
import numpy as np
from rich.console import Console

from fenics_nnm.progress import progress
from fenics_nnm.run import run_study
from fenics_nnm.study import read_study

HERE = Path(__file__).parent
RESULTS = HERE / "results"

# %% [markdown]
# Sections in mm: span, chord, largest thickness, and twist in degrees.

# %%
SECTIONS = [(0, 40, 5.0, 0), (35, 37, 4.6, 7), (70, 34, 4.3, 14), (100, 32, 4.0, 20)]


def outline(span: float, chord: float, thickness: float, twist: float) -> np.ndarray:
    """Corners and splines of a symmetric lens of parabolic thickness, shape (2, 9, 3)."""
    x = np.linspace(-0.5, 0.5, 9)
    half = (thickness * (1 - 4 * x**2) + 0.8 * 4 * x**2) / 2  # edges are 0.8 mm thick
    sides = np.stack([np.stack([chord * x, sign * half], axis=1) for sign in (1, -1)])
    angle = np.deg2rad(twist)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return np.concatenate([sides @ turn.T, np.full((2, 9, 1), span)], axis=2)


def write_step(path: Path) -> None:
    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    occ = gmsh.model.occ
    wires = []
    for section in SECTIONS:
        upper, lower = ([occ.addPoint(*p) for p in side] for side in outline(*section))
        curves = [occ.addSpline(upper), occ.addLine(upper[-1], lower[-1])]
        curves += [occ.addSpline(lower[::-1]), occ.addLine(lower[0], upper[0])]
        wires.append(occ.addWire(curves))
    (solid,) = (e for e in occ.addThruSections(wires) if e[0] == 3)
    occ.remove([e for e in occ.getEntities() if e[0] < 3], recursive=True)
    occ.synchronize()
    print(f"blade.step: volume {occ.getMass(*solid):.0f} mm^3")
    gmsh.write(str(path))
    gmsh.finalize()


RESULTS.mkdir(exist_ok=True)
write_step(RESULTS / "blade.step")

# %%
study = HERE / "blade.toml"
with progress(Console()) as stages:
    result = run_study(read_study(study), study.read_text(), RESULTS / "blade", stages=stages)
