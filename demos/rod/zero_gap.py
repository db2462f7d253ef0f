# %% [markdown]
# # The rod that touches its obstacle
#
# Without a gap the problem is homogeneous: a motion scaled by any factor is a motion, so the
# frequency does not depend on energy. The exact first mode is the bounce of a rod (the test of
# dynamic contact in GetFEM by Y. Renard, after F. Chouly): clamped at one end and let go from rest
# with a stretch of 1/2, lengths in L, times in L/c, forces in EA. For 1 a wave front runs to
# the obstacle, for exactly 1 the rod is in contact with the force 1/2, for 1 it flies back. The
# period is exactly 3 L/c.
#
# This motion is one of many. With u = F(t + x) - F(t - x), x from the clamp, F' changes its sign
# under a shift by 2 while the tip is free and keeps it in contact; where the period is 3, three
# shifts lead back, so on the third of the period that is contact the force can have any course. All
# these motions have the period 3 and a contact of 1; their energy is at least 9/2 (mean force)^2
# L / EA, which the bounce has. Harmonic balance finds a smooth one.
#
# Run with `python3 demos/rod/zero_gap.py`; takes half a minute.

# %%
import tomllib
from itertools import pairwise
from pathlib import Path

import numpy as np
from mpi4py import MPI

from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.structure.analysis import harmonic_balance, linear_analysis, nonlinear_mode
from fenics_nnm.study import study_from

FINE = Path(__file__).parent / "fine.toml"
LENGTH, AREA, YOUNG, DENSITY = 1.0, 9e-4, 2.1e11, 7800.0

#: Frequency of the exact motion in Hz.
EXACT = np.sqrt(YOUNG / DENSITY) / (3 * LENGTH)

ONE = {"from": 1.0, "to": 1.1, "step": 1.0}


def motions(
    modes: int, harmonics: int, energies: dict[str, float], *, elements: int = 100, degree: int = 2
) -> tuple[tuple[BranchPoint, ...], list[float]]:
    """Points of a branch, and their energies over that of a bounce with the same mean force."""
    values = tomllib.loads(FINE.read_text())
    values["mesh"]["elements"], values["body"]["degree"] = elements, degree
    values["contact"] |= {"gap": 0.0, "reference_displacement": 1e-3}
    values["reduction"] = {"modes": modes}
    values["mode"] = {"harmonics": harmonics, "samples": 512}
    values["continuation"] = {"energies": energies, "shooting": False}
    study = study_from(values, FINE)
    points = nonlinear_mode(study, linear_analysis(study, MPI.COMM_SELF)).points
    weight = harmonic_balance(study).series.weight
    forces = [float(weight @ point.motion.force.sum(axis=1)) for point in points]
    return points, [
        point.motion.energy * YOUNG * AREA / (4.5 * LENGTH * force**2)
        for point, force in zip(points, forces, strict=True)
    ]


if __name__ == "__main__":
    # %% [markdown]
    # Two decades of energy.

    # %%
    points, _ = motions(12, 8, {"from": 0.1, "to": 10.0, "step": 1.1})
    frequencies = np.array([point.motion.frequency for point in points])
    change = np.ptp(frequencies) / EXACT
    apart = max(
        abs(point.motion.rayleigh_frequency / point.motion.frequency - 1) for point in points
    )
    print(
        f"docs: zero_gap\nThe relative change of the frequency between gamma ratios 0.1 and 10 is "
        f"{change:.1e}. The largest relative difference between the frequency and the "
        f"[Rayleigh frequency](glossary.md) is {apart:.1e}.\n"
    )
    assert len(points) == 10 and change < 1e-8 and apart < 1e-8

    # %% [markdown]
    # Errors over the numbers of modes and harmonics, and over the number of linear elements.

    # %%
    print(
        "docs: zero_gap_series\n| modes J, harmonics N | relative error of the frequency "
        "| time of contact in a period, in L/c (exact: 1) |\n|---|---|---|"
    )
    errors = []
    for modes, harmonics in ((3, 3), (8, 5), (12, 8), (20, 10), (40, 20)):
        points, energies = motions(modes, harmonics, ONE)
        errors.append(abs(points[0].motion.frequency / EXACT - 1))
        contact = 3 * points[0].motion.contact_fraction
        print(f"| {modes}, {harmonics} | {errors[-1]:.1e} | {contact:.3f} |")
    print(f"\nenergy {energies[0]:.2f} of that of a bounce")
    assert all(finer < coarser for coarser, finer in pairwise(errors))
    assert errors[-1] < 5e-7 and energies[0] >= 1
    assert abs(3 * points[0].motion.contact_fraction - 1) < 3 / 512

    print(
        "docs: zero_gap_elements\n| number of linear elements (J = 12, N = 8) "
        "| relative error of the frequency |\n|---|---|"
    )
    errors = []
    for elements in (20, 40, 80, 160):
        points, _ = motions(12, 8, ONE, elements=elements, degree=1)
        errors.append(abs(points[0].motion.frequency / EXACT - 1))
        print(f"| {elements} | {errors[-1]:.1e} |")
    assert errors[1] < errors[0] / 3
