"""Second-order kinematics of rotor 37 against geometrically exact statics.

    python3 tests/bending_bodies.py

prints the table of docs/verification_bodies.md, and asserts what it shows.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from mpi4py import MPI
from rotating_bodies import ROTOR37, begin, say

from fenics_nnm.fem.block import product, solved
from fenics_nnm.fem.factorisation import factorise, use_mumps
from fenics_nnm.fem.loaded_residual import LoadedResidual
from fenics_nnm.fem.loads import Loads
from fenics_nnm.fem.solid import Solid
from fenics_nnm.stages import Stages
from fenics_nnm.structure.large_deflection import with_modal_derivatives
from fenics_nnm.structure.mesh_structure import MeshLinear, MeshStructure
from fenics_nnm.study import MeshStudy, study_from

#: Largest allowed root-mean-square error of the closing in um, by the motion of the tip in mm.
ALLOWED = {2: 0.3, 4: 2.0, 6: 7.0}


def linear_of(speed: float) -> tuple[MeshLinear, Solid]:
    """Rotor 37 at a speed, with all vertices of the tip as contact points, and the bare body."""
    values = {
        **ROTOR37,
        "contact": {"facets": "tip", "direction": "radial", "axis": "x", "gap": 1e-3},
        "reduction": {"modes": 6},
        "continuation": {"energies": {"from": 1, "to": 2, "step": 1}},
    }
    bare = study_from(values, Path("study.toml"))
    spinning = study_from({**values, "rotation": {"axis": "x", "speed": speed}}, Path("study.toml"))
    assert isinstance(bare, MeshStudy) and isinstance(spinning, MeshStudy)
    comm, stages = MPI.COMM_WORLD, Stages()
    solid = MeshStructure(bare).assembled(comm, stages).solid
    return MeshStructure(spinning).linear(comm, stages), solid


def exact(residual: LoadedResidual, force: np.ndarray, begin_at: np.ndarray) -> np.ndarray:
    """Displacement under a dead force besides the loads, by Newton's method from a start."""
    from petsc4py import PETSc

    residual.move(begin_at)
    ksp = PETSc.KSP().create(residual.tangent.comm)
    ksp.setOptionsPrefix("nnm_static_")
    use_mumps(ksp)
    for _ in range(30):
        ksp.setOperators(residual.assemble())
        factorise(ksp)
        change = solved(ksp, (force - residual.value())[:, None])[:, 0]
        residual.move(residual.owned + change)
        if residual.norm(change) < 1e-9 * residual.norm(residual.owned):
            break
    ksp.destroy()
    return residual.owned.copy()


def study(speed: float) -> None:
    """Closing at all tip nodes as the first mode's own inertial load bends the blade both ways."""
    linear, bare = linear_of(speed)
    bent, _ = with_modal_derivatives(linear, np.array([0]))
    order = bent.model.kinematics
    solid, phi = linear.solid, linear.reduction.shapes[:, 0]
    rest = solid.state.owned(solid.owned) if solid.state else np.zeros(solid.owned)
    residual = LoadedResidual(bare, solid.state.loads if solid.state else Loads())
    residual.apply(1.0)
    inertia = product(solid.mass, phi[:, None])[:, 0]
    tips = linear.interface.displacements(phi[:, None])[:, :, 0]
    largest = np.linalg.norm(tips, axis=1).max()
    square = linear.model.omega[0] ** 2

    def radius(u: np.ndarray) -> np.ndarray:
        places = linear.interface.points + linear.interface.displacements(u[:, None])[:, :, 0]
        return np.hypot(places[:, 1], places[:, 2])

    for side in (1, -1):
        u = rest.copy()
        for millimetres in (2, 4, 6):
            wanted = side * millimetres * 1e-3 / largest
            linear_force = square * wanted
            u = exact(residual, linear_force * inertia, u)
            q = float(inertia @ (u - rest))
            closing = radius(u) - radius(rest)
            # the other modes follow the quadratic force on them
            others = -order.alpha[1:, 0, 0] * q**2 / linear.model.omega[1:] ** 2
            first = linear.model.Phi[:, 0] * q
            second = first + order.Theta[:, 0, 0] * q**2 / 2 + linear.model.Phi[:, 1:] @ others
            errors = [1e6 * np.sqrt(np.mean((each - closing) ** 2)) for each in (first, second)]
            force = square * q + order.alpha[0, 0, 0] * q**2 + order.beta[0, 0, 0, 0] * q**3
            force += 2 * q * float(order.alpha[1:, 0, 0] @ others)
            moved = 1e3 * q * largest
            closings = " | ".join(f"{1e6 * each.max():.0f}" for each in (closing, first, second))
            ratios = " | ".join(f"{each / (square * q):.4f}" for each in (linear_force, force))
            say(
                f"| {speed:g} | {moved:+.2f} | {closings} | {errors[0]:.1f} | {errors[1]:.2f} | "
                f"{ratios} |"
            )
            assert errors[1] < ALLOWED[millimetres]
            assert abs(force / linear_force - 1) < 1e-3


if __name__ == "__main__":
    shown = ("exact (um)", "linear", "second order", "rms error of linear", "of second order")
    stiff = ("force over linear, exact", "second order")
    begin("docs: bending_rotor37", "speed (rad/s)", "tip (mm)", *shown, *stiff)
    for each in (0.0, 1800.0):
        study(each)
    say("")
