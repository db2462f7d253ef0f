r"""Linear systems of Newton's iteration, condensed on the points and samples in contact.

The Jacobian of the harmonic equations is a diagonal and a contact part of low rank: with p the
pairs (sample k, point c) in contact and F their flexibility, block-diagonal over the samples,

    Z dq + U dlambda + C y = f,      F dlambda = V dq,      B dq + E y = g,
    Z_nj = omega_j^2 - n^2 omega^2,  U_nj,p = A_nk Phi_cj,   V_p,nj = S_kn Phi_cj,

with y the frequency and what else borders the equations. Eliminating dq leaves one equation a pair,

    (F + M) dlambda = V Z^-1 (f - C y),      M_pp' = sum_n S_kn A_nk' (Phi Z_n^-1 Phi^T)_cc',

where products of two cosines make M a matrix of Toeplitz and Hankel blocks: the dynamic flexibility
that one point at one time has for a force at another. It is tabulated over the m time differences
of a period and looked up; neither J nor N enters the size of what is solved. Coordinates whose Z is
nearly zero, in resonance, are not eliminated but kept among y. What Z is, and its inverse, the
linear part tells, see `mechanics.linear_part`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.mechanics.contact_law import ContactForces
from fenics_nnm.mechanics.fourier import Series
from fenics_nnm.mechanics.linear_part import HarmonicOperator
from fenics_nnm.nonlinear.border import Border

#: With more pairs in contact than this part of the unknowns, their equations are no cheaper.
_FEW = 0.6


def pays(forces: ContactForces, unknowns: int) -> bool:
    """Whether the pairs of samples and points in contact are few beside the unknowns."""
    forces.assert_complete()
    return int(np.count_nonzero(forces.used)) < _FEW * unknowns


def condensed_solution(
    operator: HarmonicOperator, series: Series, Phi: Array, forces: ContactForces, border: Border
) -> Array:
    """Solution of the bordered system of the Jacobian, q first, shape (c J + b,).

    Args:
        operator: Linear part at the frequency.
        series: Series in time.
        Phi: Displacement of the contact points per modal coordinate, shape (n_c, J).
        forces: Contact forces.
        border: Further unknowns and equations, and right-hand sides.

    Raises:
        numpy.linalg.LinAlgError: if the system is singular.
    """
    return eliminated(Condensation.of(operator, series, Phi, forces), border)


class Elimination(Protocol):
    """What of the Jacobian is eliminated: Z of the coordinates that are not kept, U, V, F + M."""

    @property
    def operator(self) -> HarmonicOperator:
        """Z of what is eliminated, and which coordinates are kept."""

    def coupled(self, q: Array) -> Array:
        """What acts on q besides Z, shape (.., c, J)."""

    def acted(self, q: Array) -> Array:
        """Z q of all coordinates, and what acts besides, shape (.., c, J)."""

    def moved(self, q: Array) -> Array:
        """V q: free displacements of the pairs, shape (.., P)."""

    def pushed(self, pairs: Array) -> Array:
        """U lambda: what forces of the pairs do to the equations, shape (.., c, J)."""

    def flexibility(self) -> Array:
        """F + M, shape (P, P)."""


def eliminated(system: Elimination, border: Border) -> Array:
    """Solution of the bordered system, q first, shape (c J + b,).

    Args:
        system: What is eliminated.
        border: Further unknowns and equations, and right-hand sides.

    Raises:
        numpy.linalg.LinAlgError: if the system is singular.
    """
    operator = system.operator
    kept = operator.kept
    count = int(np.count_nonzero(kept))
    unit = np.zeros((count, *kept.shape))
    unit[np.arange(count), *np.nonzero(kept)] = 1.0
    nothing, of_border = np.zeros_like(border.right[None]), np.zeros_like(border.columns)
    applied = np.concatenate([border.right[None], -system.coupled(unit), -border.columns])
    followed = operator.solve(applied) + np.concatenate([nothing, unit, of_border])
    pairs = np.linalg.solve(system.flexibility(), system.moved(followed).T).T
    pushed = system.pushed(pairs)
    followed += operator.solve(-pushed)
    # what is left: the equations of the coordinates kept, and those of the border
    given = np.concatenate([border.right[None], np.zeros_like(unit), -border.columns])
    left = (given - pushed - system.acted(followed))[:, kept]
    below = np.einsum("rnj,cnj->cr", border.rows, followed)
    below[1 + count :] += border.corner.T
    right = np.concatenate([left[0], border.below - below[0]])
    matrix = np.hstack([-left[1:], below[1:]]).T
    weights = np.linalg.solve(matrix, right)
    q = followed[0] + np.tensordot(weights, followed[1:], 1)
    return np.concatenate([q.ravel(), weights[count:]])


@dataclass(frozen=True, slots=True)
class Condensation:
    """What the elimination works with.

    Attributes:
        operator: Z.
        series: Series in time.
        forces: Contact forces.
        shapes: Phi of the points in contact at any sample, shape (n_a, J).
        sample: Place of each pair among the samples in contact, shape (P,).
        point: Place of its point among those touched, shape (P,).
    """

    operator: HarmonicOperator
    series: Series
    forces: ContactForces
    shapes: Array
    sample: Indices
    point: Indices

    @classmethod
    def of(
        cls, operator: HarmonicOperator, series: Series, Phi: Array, forces: ContactForces
    ) -> Condensation:
        """What there is to eliminate with contact forces."""
        touched, place = np.unique(forces.points[forces.used], return_inverse=True)
        return cls(operator, series, forces, Phi[touched], np.nonzero(forces.used)[0], place)

    def coupled(self, q: Array) -> Array:
        """Nothing."""
        return np.zeros_like(q)

    def acted(self, q: Array) -> Array:
        """Z q."""
        return self.operator.times(q)

    def moved(self, q: Array) -> Array:
        """V q: free displacements of the pairs, shape (.., P)."""
        basis = self.forces.instants.synthesis(self.series)[self.forces.samples]
        at_samples = basis @ (q @ self.shapes.T)
        return np.asarray(at_samples[:, self.sample, self.point])

    def pushed(self, pairs: Array) -> Array:
        """U lambda: what forces of the pairs do to the equations, shape (.., c, J)."""
        forces = np.zeros((len(pairs), len(self.forces.samples), len(self.shapes)))
        forces[:, self.sample, self.point] = pairs
        analysis = self.forces.instants.analysis(self.series)
        harmonics = analysis[:, self.forces.samples] @ forces
        return np.asarray(harmonics @ self.shapes)

    def flexibility(self) -> Array:
        """F + M, shape (P, P)."""
        series, samples = self.series, self.forces.samples[self.sample]
        table, points = self.operator.flexibility(self.shapes), len(self.shapes)
        row = points**2
        first = (row * samples + points * self.point)[:, None] + self.point
        # differences in -m .. m - 1: those below zero count from the end of the table
        found = sum(
            table.take(first - row * (samples if sign > 0 else series.samples - samples))
            for sign in series.images
        )
        matrix = np.asarray(found * (series.weight[samples] / len(series.images)))
        return self.with_local(matrix)

    def with_local(self, matrix: Array) -> Array:
        """M with the flexibility F of the pairs of each sample added to it, shape (P, P)."""
        number = np.cumsum(self.forces.used).reshape(self.forces.used.shape) - 1
        both = self.forces.used[:, :, None] & self.forces.used[:, None, :]
        rows = np.broadcast_to(number[:, :, None], both.shape)[both]
        matrix[rows, np.broadcast_to(number[:, None, :], both.shape)[both]] += (
            self.forces.flexibility[both]
        )
        return matrix
