"""Stresses of motions as sums of those of the shapes that they are made of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.fields.body import FieldBody
from fenics_nnm.nonlinear.point import BranchPoint
from fenics_nnm.output.stored_branch import StoredBranch


@dataclass(frozen=True, slots=True)
class StressBasis:
    """Recovered stress of each shape of a branch: stress is linear in displacement.

    A motion at many instants, or several motions, then cost a matrix product.

    Attributes:
        branch: Branch.
        stresses: Stress in Pa of the modes, of the residual shapes taken negative, and of what full
            order adds at the points of `inertia` one after the other, shape (shapes, nodes of the
            grid, 6).
        inertia: Positions of these points.
    """

    branch: StoredBranch
    stresses: Array
    inertia: tuple[float, ...]

    def coordinates(self, point: BranchPoint, phase: Array) -> Array:
        """Coordinates of a motion at phases omega t, shape (len(phase), shapes)."""
        branch = self.branch
        basis = branch.series.basis_at(phase)
        own = [basis if place == point.position else np.zeros_like(basis) for place in self.inertia]
        return np.hstack([branch.coordinates(point, phase), branch.forces(point, phase), *own])

    def of_shapes(self, q: Array, force: Array) -> Array:
        """Coordinates of modal coordinates (J,) and contact forces in N (n_c,), (shapes,)."""
        rest = np.zeros(len(self.stresses) - len(q) - len(force))
        return np.concatenate([q, force, rest])

    def stress(self, coordinates: Array, nodes: slice = slice(None)) -> Array:
        """Stress in Pa of coordinates (..., shapes) at nodes of the grid, (..., nodes, 6)."""
        return np.tensordot(coordinates, self.stresses[:, nodes], 1)


def stress_basis(
    branch: StoredBranch, body: FieldBody, points: Sequence[BranchPoint]
) -> StressBasis:
    """Recover the stresses of the shapes that some points of a branch are made of."""
    places = tuple(p.position for p in points if p.position in branch.inertia)
    modal, residual = body.stresses(branch.shapes), body.stresses(branch.residual_shapes)
    added = [body.stresses(branch.inertia[place]) for place in places]
    return StressBasis(branch, np.concatenate([modal, -residual, *added]), places)
