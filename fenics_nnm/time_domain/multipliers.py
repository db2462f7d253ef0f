r"""Eigenvalues of the derivative M of a flow over a period, besides the two that are 1.

In the coordinates (sqrt(omega) q, p / sqrt(omega)), with momenta p = q' for constant inertia, M
obeys

    M^T Omega M = Omega,      Omega = [[0, 1], [-1, 0]],

so with mu it has the eigenvalues 1 / mu and their conjugates. Two of them are 1, for the shift in
time f = (v, a) = Omega grad H and for the change of energy: a Jordan block, of which rounding makes
1 +- 1e-8. M f = f and grad H^T M = grad H^T, and f is orthogonal to grad H; so in an orthonormal
basis that begins with f and ends with grad H the matrix is block triangular,

    [[1, *, *], [0, M_Q, *], [0, 0, 1]],

and the other 2 J - 2 eigenvalues are those of the block M_Q, without that loss.

A time-reversible motion is at rest after half a period, and goes back as it came: with P the
derivative over that half and rho the reversal of velocities,

    M = rho P^-1 rho P,      P^-1 = -Omega P^T Omega,      M^-1 = rho M rho.

So with the blocks A, B, D, A' of M_Q its inverse has A, -B, -D, A': half the sum of both is block
diagonal, and the eigenvalues of A, of half the size, are c = (mu + 1 / mu) / 2. Since mu is
c +- s with s^2 = c^2 - 1, pairs with real c from -1 to 1 are on the unit circle to round-off. With
A x = c x the direction of mu = c + s is (s x, D x).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import eig

from fenics_nnm.arrays import Array, Complex

_TINY = np.finfo(float).tiny


@dataclass(frozen=True, slots=True)
class Multipliers:
    """Floquet multipliers by falling modulus.

    Attributes:
        values: The 2 J - 2 multipliers besides the two that are 1.
        conditions: How much an error of M is larger in each of them.
        directions: Directions that they belong to, as unit columns in the canonical coordinates,
            without their parts along f and grad H, shape (2 J, 2 J - 2).
    """

    values: Complex
    conditions: Array
    directions: Complex

    @classmethod
    def of_motion(cls, M: Array, f: Array) -> Multipliers:
        """Those of any motion.

        Args:
            M: Derivative over a period in the canonical coordinates, shape (2 J, 2 J).
            f: Rate of the state there, shape (2 J,).
        """
        Q = _complement(np.column_stack([f, omega_times(f)]))
        values, conditions, vectors = _eigenvalues(Q.T @ M @ Q)
        return cls._sorted(values, conditions, Q @ vectors)

    @classmethod
    def of_reversible_motion(cls, M: Array, f: Array) -> Multipliers:
        """Those of a time-reversible motion that starts at rest; arguments as for `of_motion`."""
        modes = len(f) // 2
        Q = _complement(f[modes:, None])
        A, D = (Q.T @ block @ Q for block in (M[:modes, :modes], M[modes:, :modes]))
        c, conditions, x = _eigenvalues(A)
        s = np.sqrt((c - 1) * (c + 1))
        s = np.where(np.abs(c + s) < np.abs(c - s), -s, s)
        larger, slope = c + s, conditions / np.maximum(np.abs(s), _TINY)
        columns = [np.concatenate([sign * s * (Q @ x), Q @ (D @ x)]) for sign in (1, -1)]
        return cls._sorted(
            np.concatenate([larger, 1 / larger]),
            np.concatenate([slope * np.abs(larger), slope / np.abs(larger)]),
            np.hstack(columns),
        )

    @classmethod
    def _sorted(cls, values: Complex, conditions: Array, directions: Complex) -> Multipliers:
        order = np.argsort(-np.abs(values), kind="stable")
        unit = directions / np.maximum(np.linalg.norm(directions, axis=0), _TINY)
        return cls(values[order], conditions[order], unit[:, order])


def omega_times(vectors: Array) -> Array:
    """Omega times a vector, shape (2 J,), or the columns of a matrix."""
    upper, lower = np.split(vectors, 2)
    return np.concatenate([lower, -upper])


def there_and_back(P: Array) -> Array:
    """M = rho P^-1 rho P; rho Omega = -Omega rho, so it is Omega (P rho)^T Omega rho P."""
    rho = np.repeat([1.0, -1.0], len(P) // 2)
    return omega_times((P * rho).T @ omega_times(rho[:, None] * P))


def symplectic_error(M: Array) -> float:
    """|M^T Omega M - Omega| over |M|^2, of the Frobenius norm."""
    defect = M.T @ omega_times(M) - omega_times(np.eye(len(M)))
    return float(np.linalg.norm(defect) / np.linalg.norm(M) ** 2)


def _complement(columns: Array) -> Array:
    """Orthonormal basis of what is orthogonal to linearly independent columns."""
    basis, _ = np.linalg.qr(columns, mode="complete")
    return np.asarray(basis[:, columns.shape[1] :])


def _eigenvalues(matrix: Array) -> tuple[Complex, Array, Complex]:
    """Eigenvalues, condition numbers 1 / |left . right|, and eigenvectors."""
    if not matrix.size:
        return np.empty(0, dtype=complex), np.empty(0), np.empty((0, 0), dtype=complex)
    values, left, right = eig(matrix, left=True, right=True)
    cosine = np.abs(np.sum(left.conj() * right, axis=0))
    return values, 1 / np.maximum(cosine, _TINY), right
