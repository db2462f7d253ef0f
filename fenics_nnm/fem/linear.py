"""All that is linear of an analysis, in one record."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from mpi4py import MPI

from fenics_nnm.arrays import Array
from fenics_nnm.errors import ModelError
from fenics_nnm.fem.block import SOLVED_AT_ONCE, groups, product
from fenics_nnm.fem.contact import ContactInterface
from fenics_nnm.fem.modal_solver import ModalSolver
from fenics_nnm.fem.point_rows import attached_points
from fenics_nnm.fem.solid import Solid
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.reduction.craig_bampton import craig_bampton_reduction
from fenics_nnm.reduction.linear_modes import LinearModes
from fenics_nnm.reduction.massless import massless_reduction
from fenics_nnm.reduction.operators import Operators, Product
from fenics_nnm.reduction.reduction import Reduction

#: Least flexibility of contact points over the largest.
_DEPENDENT = 1e-12


@dataclass(frozen=True, slots=True)
class LinearAnalysis:
    """All that is linear: the body, its contact points, its modes and the reduced model.

    Attributes:
        solid: Assembled body.
        interface: Contact points.
        modes: Linear modes.
        reduction: Reduced model, and the way back at the owned degrees of freedom.
    """

    solid: Solid
    interface: ContactInterface
    modes: LinearModes
    reduction: Reduction

    @property
    def model(self) -> ReducedModel:
        """Reduced model."""
        return self.reduction.model

    def largest_displacement(self, q: Array, force: Array) -> float:
        """Largest displacement of any node in m, of coordinates in kg^1/2 m and forces in N.

        To be called on all ranks.
        """
        moved = self.reduction.displacement(q, force).reshape(-1, self.solid.tagged.dim)
        here = np.linalg.norm(moved, axis=1).max(initial=0.0)
        return float(self.solid.tagged.mesh.comm.allreduce(here, op=MPI.MAX))


def massless_reduced(
    solid: Solid,
    interface: ContactInterface,
    modes: LinearModes,
    solver: ModalSolver,
    report: Callable[[float], None] = lambda done: None,
) -> Reduction:
    """Massless-boundary model of a body.

    Args:
        solid: Assembled body.
        interface: Contact points.
        modes: Linear modes.
        solver: Solver of the stiffness.
        report: Called with the part that is done, from 0 to 1.

    Raises:
        ModelError: if the body cannot be reduced with so many modes or points.
    """
    # the static displacements of the contact points, and those under their inertia
    static = _Reported(solver.static, 2 * interface.count, report)
    forces = interface.unit_forces(solid.owned)
    attachments = static(forces)
    _assert_apart(solid, forces, attachments)
    operators = replace(operators_of(solid, interface, solver), static=static)
    points = attached_points(solid)
    return massless_reduction(
        modes.omega, modes.shapes, attachments, interface.gap, operators, points
    )


@dataclass(slots=True)
class _Reported:
    """Static displacements, some columns at a time, with reports in between.

    Attributes:
        static: From columns of forces to static displacements.
        total: Columns that are to come.
        report: Called with the part that is done.
    """

    static: Product
    total: int
    report: Callable[[float], None]
    _done: int = 0

    def __call__(self, forces: Array) -> Array:
        """Displacements of columns of forces."""
        if forces.shape[1] <= SOLVED_AT_ONCE:
            return self._solved(forces)
        found = np.empty(forces.shape, order="F")
        for few in groups(forces.shape[1], SOLVED_AT_ONCE):
            found[:, few] = self._solved(forces[:, few])
        return found

    def _solved(self, forces: Array) -> Array:
        found = self.static(forces)
        self._done += forces.shape[1]
        self.report(min(1.0, self._done / self.total))
        return found


def craig_bampton_reduced(
    solid: Solid, interface: ContactInterface, forces: Array, count: int, solver: ModalSolver
) -> Reduction:
    """Craig-Bampton model of a body, in modal form.

    The attachment solutions span the same space as the constraint modes, which are these
    solutions combined to unit displacements of one interface coordinate at a time.

    Args:
        solid: Assembled body.
        interface: Contact points.
        forces: Unit forces of the interface coordinates that are retained, (n_owned, i).
        count: Number of modes with the interface held.
        solver: Solver of the stiffness, by factors.

    Raises:
        ModelError: if the basis vectors depend on each other, or the solver has no factors.
        ConvergenceError: if the eigensolver fails.
    """
    attachments = solver.static(forces)
    _assert_apart(solid, forces, attachments)
    basis = np.hstack([attachments, solver.fixed_interface_modes(forces, attachments, count)])
    return craig_bampton_reduction(basis, interface.gap, operators_of(solid, interface, solver))


def _assert_apart(solid: Solid, forces: Array, attachments: Array) -> None:
    """Refuse contact points whose motions depend on each other by constraints."""
    if not solid.system.keys:
        return
    flexibility = solid.tagged.mesh.comm.allreduce(forces.T @ attachments)
    strengths = np.linalg.eigvalsh((flexibility + flexibility.T) / 2)
    if strengths[0] <= _DEPENDENT * strengths[-1]:
        raise ModelError(
            f"{', '.join(solid.system.keys[:3])}: {len(strengths)} contact motions depend on each "
            "other, as contact points lie on nodes that move together: must be fewer points, or "
            "points beside these nodes"
        )


def operators_of(solid: Solid, interface: ContactInterface, solver: ModalSolver) -> Operators:
    """Products of a body, which a reduction asks for."""
    comm = solid.tagged.mesh.comm
    return Operators(
        stiffness=lambda columns: product(solid.stiffness, columns),
        mass=lambda columns: product(solid.mass, columns),
        static=solver.static,
        contact=interface.displacement,
        inner=lambda left, right: np.asarray(comm.allreduce(left.T @ right)),
    )
