# %% [markdown]
# # A blade from a STEP file
#
# A twisted, tapered blade is lofted by OpenCASCADE and exported as STEP, as a CAD program would.
# `blade.toml` takes that file from there: it picks the root, the tip and a pad on one side of the
# blade by where they lie, makes smaller elements at the pad, and follows the first bending mode
# against a stop beside the pad.
#
# Run `python3 demos/step/blade.py`, which writes demos/step/results/blade.step, then
# `fenics-nnm run demos/step/blade.toml`; or `fenics-nnm response demos/step/driven.toml`, the same
# blade damped and driven at its tip.

# %%
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import gmsh
import numpy as np

RESULTS = Path(__file__).parent / "results"

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


@contextmanager
def quiet() -> Iterator[None]:
    """Drop what OpenCASCADE writes to standard output past Python."""
    sys.stdout.flush()
    before, nothing = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nothing, 1)
    try:
        yield
    finally:
        os.dup2(before, 1)
        os.close(before)
        os.close(nothing)


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
    with quiet():
        gmsh.write(str(path))
    gmsh.finalize()


RESULTS.mkdir(exist_ok=True)
write_step(RESULTS / "blade.step")
