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
nearly zero, in resonance, are not eliminated but kept among y. A drift d adds d rot to Z, whose
inverse is (Z - d rot) / (Z^2 + n^2 d^2).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.mechanics.contact_law import ContactForces
from fenics_nnm.nonlinear.equations import HarmonicEquations

#: With more pairs in contact than this part of the unknowns, their equations are no cheaper.
_FEW = 0.6

#: Coordinates with a smaller |omega_j^2 - n^2 omega^2|, over the sum of the two, are kept.
_RESONANT = 1e-2


@dataclass(frozen=True, slots=True)
class Border:
    """Columns and rows that border the Jacobian of the equations, and the right-hand sides.

    Attributes:
        columns: Derivatives of the equations by the b unknowns besides q, shape (b, N + 1, J).
        rows: Derivatives of the b further equations by q, shape (b, N + 1, J).
        corner: Derivatives of these by the further unknowns, shape (b, b).
        right: Right-hand sides of the equations, shape (N + 1, J).
        below: Right-hand sides of the further equations, shape (b,).
    """

    columns: Array
    rows: Array
    corner: Array
    right: Array
    below: Array


def pays(equations: HarmonicEquations, forces: ContactForces) -> bool:
    """Whether the pairs of samples and points in contact are few beside the unknowns."""
    forces.assert_complete()
    return int(np.count_nonzero(forces.used)) < _FEW * int(np.prod(equations.shape))


def condensed_solution(
    equations: HarmonicEquations,
    omega: float,
    forces: ContactForces,
    border: Border,
    drift: float = 0.0,
) -> Array:
    """Solution of the bordered system of the Jacobian, q first, shape ((N + 1) J + b,).

    Args:
        equations: Harmonic equations.
        omega: Frequency.
        forces: Contact forces.
        border: Further unknowns and equations, and right-hand sides.
        drift: Drift of a general series.

    Raises:
        numpy.linalg.LinAlgError: if the system is singular.
    """
    return _Condensation.of(equations, omega, forces, drift).solution(border)


@dataclass(frozen=True, slots=True)
class _Condensation:
    """What the elimination works with.

    Attributes:
        equations: Harmonic equations.
        forces: Contact forces.
        stiffness: Z, shape (N + 1, J).
        drift: Drift.
        kept: Coordinates that are not eliminated, shape (N + 1, J).
        touched: Points in contact at any sample, shape (n_a,).
        sample: Place of each pair among the samples in contact, shape (P,).
        point: Place of its point among those touched, shape (P,).
    """

    equations: HarmonicEquations
    forces: ContactForces
    stiffness: Array
    drift: float
    kept: NDArray[np.bool_]
    touched: Indices
    sample: Indices
    point: Indices

    @classmethod
    def of(
        cls, equations: HarmonicEquations, omega: float, forces: ContactForces, drift: float
    ) -> _Condensation:
        stiffness = equations.dynamic_stiffness(omega)
        touched, place = np.unique(forces.points[forces.used], return_inverse=True)
        return cls(
            equations=equations,
            forces=forces,
            stiffness=stiffness,
            drift=drift,
            kept=np.abs(stiffness) < _RESONANT * equations.row_scale(omega),
            touched=touched,
            sample=np.nonzero(forces.used)[0],
            point=place,
        )

    def solution(self, border: Border) -> Array:
        """Solution of the bordered system, q first."""
        kept, count = self.kept, int(np.count_nonzero(self.kept))
        unit = np.zeros((count, *kept.shape))
        unit[np.arange(count), *np.nonzero(kept)] = 1.0
        applied = np.concatenate([border.right[None], np.zeros_like(unit), -border.columns])
        followed = self.eliminated(applied) + np.concatenate(
            [np.zeros_like(applied[:1]), unit, np.zeros_like(border.columns)]
        )
        pairs = np.linalg.solve(self.flexibility(), self.moved(followed).T).T
        pushed = applied - self.pushed(pairs)
        followed += self.eliminated(pushed - applied)
        # what is left: the equations of the coordinates kept, and those of the border
        left = pushed[:, kept] - self.times_stiffness(followed)[:, kept]
        below = np.einsum("rnj,cnj->cr", border.rows, followed)
        below[1 + count :] += border.corner.T
        right = np.concatenate([left[0], border.below - below[0]])
        matrix = np.hstack([-left[1:], below[1:]]).T
        weights = np.linalg.solve(matrix, right)
        q = followed[0] + np.tensordot(weights, followed[1:], 1)
        return np.concatenate([q.ravel(), weights[count:]])

    def eliminated(self, right: Array) -> Array:
        """Z^-1 on the coordinates eliminated, 0 on those kept, shape (.., N + 1, J)."""
        turned, square = self._turned(right), self._square
        return np.where(self.kept, 0.0, (self.stiffness * right - turned) / square)

    def times_stiffness(self, q: Array) -> Array:
        """Z q, shape (.., N + 1, J)."""
        return self.stiffness * q + self._turned(q)

    def moved(self, q: Array) -> Array:
        """V q: free displacements of the pairs, shape (.., P)."""
        harmonics = q @ self._shapes.T
        at_samples = self.equations.series.synthesis[self.forces.samples] @ harmonics
        return np.asarray(at_samples[:, self.sample, self.point])

    def pushed(self, pairs: Array) -> Array:
        """U lambda: what forces of the pairs do to the equations, shape (.., N + 1, J)."""
        forces = np.zeros((len(pairs), len(self.forces.samples), len(self.touched)))
        forces[:, self.sample, self.point] = pairs
        harmonics = self.equations.series.analysis[:, self.forces.samples] @ forces
        return np.asarray(harmonics @ self._shapes)

    def flexibility(self) -> Array:
        """F + M, shape (P, P)."""
        series, samples = self.equations.series, self.forces.samples[self.sample]
        table, points = self._table(), len(self.touched)
        row = points**2
        first = (row * samples + points * self.point)[:, None] + self.point
        # differences in -m .. m - 1: those below zero count from the end of the table
        found = sum(
            table.take(first - row * (samples if sign > 0 else series.samples - samples))
            for sign in series.images
        )
        matrix = np.asarray(found * (series.weight[samples] / len(series.images)))
        number = np.cumsum(self.forces.used).reshape(self.forces.used.shape) - 1
        both = self.forces.used[:, :, None] & self.forces.used[:, None, :]
        rows = np.broadcast_to(number[:, :, None], both.shape)[both]
        matrix[rows, np.broadcast_to(number[:, None, :], both.shape)[both]] += (
            self.forces.flexibility[both]
        )
        return matrix

    def _table(self) -> Array:
        """Dynamic flexibility by the time difference in samples, shape (m, n_a^2)."""
        series, Phi = self.equations.series, self._shapes
        order = np.arange(series.harmonics + 1)
        rows, square = slice(len(order)), np.broadcast_to(self._square, self.kept.shape)
        inverse = np.where(self.kept, 0.0, 1 / square)[rows] / series.mean_square[rows, None]
        angle = np.outer(2 * np.pi / series.samples * np.arange(series.samples), order)
        even = (Phi * (inverse * self.stiffness[rows])[:, None]) @ Phi.T
        table = np.cos(angle) @ even.reshape(len(order), -1)
        if self.drift:
            odd = (Phi * inverse[:, None]) @ Phi.T
            table += (self.drift * order * np.sin(angle)) @ odd.reshape(len(order), -1)
        return np.asarray(table)

    @property
    def _shapes(self) -> Array:
        return self.equations.model.Phi[self.touched]

    @property
    def _square(self) -> Array:
        order = self.equations.series.order[:, None]
        square = self.stiffness**2 + (self.drift * order) ** 2
        return np.where(self.kept, 1.0, square)

    def _turned(self, q: Array) -> Array:
        if not self.drift:
            return np.zeros_like(q)
        return np.asarray(self.drift * (self.equations.series.rotation() @ q))
