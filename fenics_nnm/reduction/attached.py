r"""Points besides those of contact at which forces act: springs that are not linear, excitation.

Free modes alone bring the displacement of such a point slowly. The static displacement r under a
unit force at the point that the modes lack is added to them, as one more mode for each point:

    r = K^-1 b - Phi diag(1 / omega^2) Phi^T b

is orthogonal to the modes in K and in M, so it takes part as a mode of its own, above all of them,
and static displacements under forces at the point are exact. Where the modes bring all of it there
is nothing to add.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import eigh

from fenics_nnm.arrays import Array
from fenics_nnm.errors import ModelError
from fenics_nnm.mechanics.force import AddedForce, CubicSprings
from fenics_nnm.reduction.operators import Operators

#: Part of the static flexibility of points below which the modes bring all of it.
_NOTHING = 1e-9

#: Static flexibility of a point below this part of its own once others are held is none.
_DEPENDENT = 1e-10

#: Part of the mass of a shape below which it moves no mass: relative to that of K^-1 M K^-1.
_NO_MASS = 1e-14


@dataclass(frozen=True, slots=True)
class AttachedPoints:
    """Points, each with a direction, at which forces besides those of contact act.

    Attributes:
        rows: Unit forces at the points, shape (n, p).
        cubic: Cubic stiffness of a spring at each point in N/m^3, 0 for none, shape (p,).
    """

    rows: Array
    cubic: Array

    @classmethod
    def none(cls, size: int) -> AttachedPoints:
        """No points on n degrees of freedom."""
        return cls(np.zeros((size, 0)), np.zeros(0))

    def and_also(self, rows: Array) -> AttachedPoints:
        """Further points without springs, after these."""
        return AttachedPoints(
            np.hstack([self.rows, rows]), np.append(self.cubic, np.zeros(rows.shape[1]))
        )

    def forces(self, shapes: Array) -> tuple[AddedForce, ...]:
        """Forces of the springs.

        Args:
            shapes: Displacement of the points per modal coordinate, shape (p, J).
        """
        sprung = self.cubic != 0
        return (CubicSprings(shapes[sprung], self.cubic[sprung]),) if sprung.any() else ()


@dataclass(frozen=True, slots=True)
class EnrichedModes:
    """Free modes, and the shapes that were added to them.

    Attributes:
        omega: Circular frequencies in rad/s, ascending, shape (J + r,).
        shapes: Mass-normalised, shape (n, J + r).
        free: Number of free modes J.
    """

    omega: Array
    shapes: Array
    free: int


def enriched(omega: Array, shapes: Array, rows: Array, operators: Operators) -> EnrichedModes:
    """Free modes with what they lack of static displacements under forces at some points.

    Args:
        omega: Circular frequencies of the free modes in rad/s, shape (J,).
        shapes: Mass-normalised modes, shape (n, J).
        rows: Unit forces at the points, shape (n, p).
        operators: Products with the matrices of the structure.

    Raises:
        ModelError: if what is added moves no mass.
    """
    if not rows.shape[1]:
        return EnrichedModes(omega, shapes, len(omega))
    rows, static = _independent(rows, operators)
    lacking = static - (shapes / omega**2) @ operators.inner(shapes, rows)
    whole, flexibility = operators.gram(rows, static), operators.gram(rows, lacking)
    parts, combinations = eigh(flexibility, whole)
    chosen = lacking @ combinations[:, parts > _NOTHING]
    if not chosen.shape[1]:
        return EnrichedModes(omega, shapes, len(omega))
    K = operators.gram(chosen, operators.stiffness(chosen))
    M = operators.gram(chosen, operators.mass(chosen))
    if np.linalg.eigvalsh(M)[0] <= _NO_MASS * np.trace(K) / omega[-1] ** 2:
        raise ModelError(
            "a point with a spring or an excitation moves no mass of its own: must be a point of "
            "the structure that has mass"
        )
    squared, vectors = eigh(K, M)
    return EnrichedModes(
        np.concatenate([omega, np.sqrt(squared)]),
        np.hstack([shapes, chosen @ vectors]),
        len(omega),
    )


def _independent(rows: Array, operators: Operators) -> tuple[Array, Array]:
    """Rows that do not follow from rows before them, with their static displacements.

    A spring and an excitation at one point have the same row.
    """
    static = operators.static(rows)
    whole = operators.gram(rows, static)
    kept: list[int] = []
    for number, own in enumerate(np.diag(whole)):
        shared = whole[kept, number]
        left = own - shared @ np.linalg.solve(whole[np.ix_(kept, kept)], shared) if kept else own
        if left > _DEPENDENT * own:
            kept.append(number)
    return rows[:, kept], static[:, kept]
