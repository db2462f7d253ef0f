"""Second-order kinematics of rotor 37 against geometrically exact statics.

    python3 tests/bending_bodies.py

prints the table of docs/verification_bodies.md, and asserts what it shows.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from mpi4py import MPI
from rotating_bodies import ROTOR37, begin, say

from fenics_nnm.stages import Stages
from fenics_nnm.structure.mesh_structure import MeshLinear, MeshStructure
from fenics_nnm.structure.static_bending import (
    BentModel,
    radial_closing,
    statically_bent,
)
from fenics_nnm.study import MeshStudy, study_from

#: Largest allowed root-mean-square error of the closing in um, by the motion of the tip in mm.
ALLOWED = {2: 0.3, 4: 2.0, 6: 7.0}


def linear_of(speed: float) -> MeshLinear:
    """Rotor 37 at a speed, with all vertices of the tip as contact points."""
    values = {
        **ROTOR37,
        "body": {**ROTOR37["body"], "kinematics": "second-order"},
        "contact": {"facets": "tip", "direction": "radial", "axis": "x", "gap": 1e-3},
        "reduction": {"modes": 6},
        "continuation": {"energies": {"from": 1, "to": 2, "step": 1}},
        "rotation": {"axis": "x", "speed": speed},
    }
    chosen = study_from(values, Path("study.toml"))
    assert isinstance(chosen, MeshStudy)
    return MeshStructure(chosen).linear(MPI.COMM_WORLD, Stages())


def study(speed: float) -> None:
    """Closing at all tip nodes as the first mode's own inertial load bends the blade both ways."""
    linear = linear_of(speed)
    model = BentModel(linear.model)
    tips = linear.interface.displacements(linear.reduction.shapes[:, :1])[:, :, 0]
    largest = np.linalg.norm(tips, axis=1).max()
    square = linear.model.omega[0] ** 2
    for side in (1, -1):
        wanted = [side * millimetres * 1e-3 / largest for millimetres in ALLOWED]
        exact = statically_bent(linear, 0, wanted)
        for allowed, state in zip(ALLOWED.values(), exact, strict=True):
            q, closing = state.coordinate, radial_closing(linear, state.displacement)
            first, second = model.linear_closing(q), model.closing(q)
            errors = [1e6 * np.sqrt(np.mean((each - closing) ** 2)) for each in (first, second)]
            force = model.load(q)
            closings = " | ".join(f"{1e6 * each.max():.0f}" for each in (closing, first, second))
            ratios = " | ".join(f"{each / (square * q):.4f}" for each in (state.load, force))
            say(
                f"| {speed:g} | {1e3 * q * largest:+.2f} | {closings} | {errors[0]:.1f} | "
                f"{errors[1]:.2f} | {ratios} |"
            )
            assert errors[1] < allowed
            assert abs(force / state.load - 1) < 1e-3


if __name__ == "__main__":
    shown = (
        "motion of the tip (mm)",
        *(f"largest closing, {each} (um)" for each in ("exact", "linear", "second order")),
        *(f"rms error of the closing, {each} (um)" for each in ("linear", "second order")),
        *(f"force ratio, {each}" for each in ("exact", "second order")),
    )
    begin("docs: bending_rotor37", "speed (rad/s)", *shown)
    for each in (0.0, 1800.0):
        study(each)
    say("")
