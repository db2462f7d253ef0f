"""Rod with an absorbing end against an obstacle, driven; prints its motions beside the exact ones.

python3 tests/absorbing_rod.py

The obstacle is at one end; the other end has the dashpot z of the rod's impedance and a force
F0 + F1 cos(omega t). A soft spring of 1e-3 z omega there holds the rod, and takes its part of F0.
"""

from __future__ import annotations

import csv
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from fenics_nnm.mechanics.contact_law import Complementarity
from fenics_nnm.mechanics.fourier import FourierSeries
from fenics_nnm.nonlinear.timed import TimedEquations
from fenics_nnm.response.first_motion import first_motion
from fenics_nnm.structure.driven import driven_structure
from fenics_nnm.study import study_from

REFERENCE = Path(__file__).parent / "reference" / "b_absorbing_rod_signorini_forced.csv"

#: Circular frequency; length, impedance and speed of waves are 1.
OMEGA = 1.0
SPRING = 1e-3 * OMEGA

#: Harmonics N and modes J of each F0 / F1.
SIZES = {0.2: ((20, 10), (30, 15)), 0.5: ((20, 10), (40, 20)), 0.8: ((40, 20), (80, 36))}

#: Instants of a period at which the motion is looked at.
_INSTANTS = 36_000


@dataclass(frozen=True, slots=True)
class Found:
    """A motion of the tip.

    Attributes:
        lift: Phase omega (t - L / c) at which it leaves the obstacle for good, in degrees.
        touchdown: Phase at which it comes back, in degrees.
        opening: Smallest displacement of the tip less that of the obstacle, over F1 / (z omega).
        mean: Mean contact force, and that of the spring, over F1.
    """

    lift: float
    touchdown: float
    opening: float
    mean: float


def study(force: float, harmonics: int, modes: int) -> dict[str, Any]:
    """Values of a study with F1 = 1."""
    low = OMEGA / (2 * np.pi)
    return {
        "mesh": {"model": "rod", "length": 1.0, "elements": max(2 * modes, 100)},
        "body": {"theory": "rod", "area": 1.0, "degree": 2},
        "material": {"density": 1.0, "young": 1.0},
        "spring": {"at": [0.0], "stiffness": [SPRING]},
        "contact": {"facets": "right", "direction": [1.0], "gap": 0.0},
        "reduction": {"modes": modes},
        "mode": {"harmonics": harmonics, "samples": max(4 * harmonics, 64)},
        "dashpot": {"at": [0.0], "damping": [1.0]},
        "excitation": [
            {"at": [0.0], "force": [1.0]},
            {"at": [0.0], "force": [force], "harmonic": 0},
        ],
        "response": {"frequencies": {"from": low, "to": 1.01 * low, "step": low}},
    }


def motion(force: float, harmonics: int, modes: int) -> Found:
    """The motion of the finite-element rod."""
    read = study_from(study(force, harmonics, modes), Path("study.toml"))
    structure = driven_structure(read, MPI.COMM_SELF)
    series, model = FourierSeries(harmonics, max(4 * harmonics, 64)), structure.model
    equations = TimedEquations.of(structure.mechanics, series)
    solution = first_motion(structure, equations, OMEGA)
    assert not solution.failure, solution.failure
    phase = 2 * np.pi * np.arange(_INSTANTS) / _INSTANTS
    free = series.basis_at(phase) @ solution.free
    contact = Complementarity(model.R, model.gap)(free).force
    tip = (free - contact @ model.R)[:, 0]
    touching, turned = contact[:, 0] > 0, np.rad2deg(phase - OMEGA) % 360
    lifts = turned[touching & ~np.roll(touching, -1)]
    touchdowns = turned[touching & ~np.roll(touching, 1)]
    weight = solution.forces.instants.weight(series)
    spring = SPRING * float(structure.drive.shapes[0] @ solution.q[0])
    return Found(
        lift=float(lifts[np.argmin(np.abs(lifts - 120))]),
        touchdown=float(touchdowns[np.argmin(np.abs((touchdowns - 310 + 180) % 360 - 180))]),
        opening=float(tip.min()) * OMEGA,
        mean=float(weight @ solution.forces.force[:, 0]) + spring,
    )


def exact() -> dict[float, tuple[float, float, float]]:
    """Lift-off, touchdown and opening by F0 / F1."""
    lines = (line for line in REFERENCE.read_text().splitlines() if not line.startswith("#"))
    return {
        float(row["F0"]): (
            float(row["theta1_deg"]),
            float(row["theta2_deg"]),
            float(row["opening_min"]),
        )
        for row in csv.DictReader(lines)
    }


def main() -> None:
    """Print phases, opening and mean force beside the exact ones; fail beyond the bounds."""
    lines = [
        "docs: absorbing_rod",
        "| F0 / F1 | harmonics N, modes J | phase of lift-off (deg) | phase of touchdown (deg) "
        "| opening | (mean force - F0) / F1 |",
        "|---|---|---|---|---|---|",
    ]
    for force, (lift, touchdown, opening) in exact().items():
        lines.append(
            f"| {force:g} | exact solution | {lift:.2f} | {touchdown % 360:.2f} | {opening:.5f} | |"
        )
        for harmonics, modes in SIZES[force]:
            found = motion(force, harmonics, modes)
            missing = found.mean - force
            lines.append(
                f"| {force:g} | {harmonics}, {modes} | {found.lift:.2f} | {found.touchdown:.2f} | "
                f"{found.opening:.5f} | {missing:.0e} |"
            )
        assert abs(found.lift - lift) < 1 and abs(found.touchdown - touchdown % 360) < 1
        assert abs(found.opening / opening - 1) < 0.01 and abs(missing) < 1e-6
    sys.stdout.write("\n".join([*lines, ""]))


if __name__ == "__main__":
    main()
