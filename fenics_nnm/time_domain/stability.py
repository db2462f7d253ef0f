r"""Stability of a periodic motion: Floquet multipliers of the shot motion.

M is the derivative of the flow over the period, a plain product of the derivatives of linear
stages, since the vector field is continuous. In the coordinates (sqrt(omega) q, q' / sqrt(omega))
it obeys

    M^T Omega M = Omega,      Omega = [[0, 1], [-1, 0]],

so with mu it has the multipliers 1 / mu and their conjugates. Two of them are 1, for the shift in
time f = (v, a) = Omega grad H and for the change of energy: a Jordan block, of which rounding makes
1 +- 1e-8. M f = f and grad H^T M = grad H^T, and f is orthogonal to grad H; so in an orthonormal
basis that begins with f and ends with grad H the matrix is block triangular,

    [[1, *, *], [0, M_Q, *], [0, 0, 1]],

and the other 2 J - 2 multipliers are the eigenvalues of the block M_Q, without that loss.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import eig

from fenics_nnm.arrays import Array, Complex
from fenics_nnm.time_domain.flow import Flow
from fenics_nnm.time_domain.shooting import ShotMotion

#: Multipliers within this distance of the unit circle are on it.
_ON_CIRCLE = 1e-6

#: Of a stable motion.
STABLE = "stable"

#: Kinds of instability, by the largest multiplier.
REAL = "real multiplier above 1: fold or symmetry breaking"
DOUBLING = "real multiplier below -1: period doubling"
COMPLEX = "complex multipliers off the unit circle: collision of two modes (Krein)"


@dataclass(frozen=True, slots=True)
class Stability:
    """Floquet multipliers of a periodic motion, and what follows from them.

    Attributes:
        multipliers: The 2 J - 2 multipliers besides the two that are 1, by falling modulus.
        trivial_error: |M f - f| / |f| in the canonical coordinates: 0 for a periodic motion.
        symplectic_error: |M^T Omega M - Omega| over |M|^2.
        pair_error: Largest distance of mu times its best partner from 1.
        error: Estimated error of the multipliers: what is wrong with M, times their conditions,
            and no more than its square root, as for a double multiplier.
        directions: Directions that the multipliers belong to, as unit columns in the canonical
            coordinates, without their parts along f and grad H, shape (2 J, 2 J - 2).
        kinds: Kind of instability of each multiplier; empty for one on or inside the circle.
        failure: Empty, or why there are no multipliers.
    """

    multipliers: Complex
    trivial_error: float
    symplectic_error: float
    pair_error: float
    error: float
    directions: Complex
    kinds: tuple[str, ...]
    failure: str = ""

    @property
    def kind(self) -> str:
        """Kind of instability of the largest multiplier; empty where stable."""
        return self.kinds[0] if self.kinds else ""

    @property
    def stable(self) -> bool:
        """Whether all multipliers are on the unit circle, as far as can be told."""
        return not self.kind and not self.failure

    @property
    def largest(self) -> float:
        """Largest modulus; 1 if there are none besides the two that are 1, nan if unknown."""
        if self.failure:
            return float("nan")
        return float(np.abs(self.multipliers).max(initial=1.0))


def stability(flow: Flow, shot: ShotMotion, *, on_circle: float = _ON_CIRCLE) -> Stability:
    """Floquet multipliers of a shot motion.

    Args:
        flow: Flow that the motion was shot with.
        shot: A converged motion.
        on_circle: Multipliers within this distance of the unit circle, or within the estimated
            error if that is more, count as on it.
    """
    if shot.failure:
        return _unknown(shot.failure)
    return stability_of(flow, shot.q, shot.velocity, shot.period, on_circle=on_circle)


def stability_of(
    flow: Flow, q: Array, velocity: Array, period: float, *, on_circle: float = _ON_CIRCLE
) -> Stability:
    """Floquet multipliers of a periodic motion given by its initial state and its period.

    Args:
        flow: Flow of the model.
        q: Modal coordinates at the start in kg^1/2 m, shape (J,).
        velocity: Their velocities, shape (J,).
        period: Period in s.
        on_circle: As for `stability`.
    """
    whole = flow.run(q, velocity, period, along=np.eye(2 * len(q)))
    if whole.failure or whole.transition is None:
        return _unknown(whole.failure)
    omega = flow.model.omega
    scale = np.concatenate([np.sqrt(omega), 1 / np.sqrt(omega)])
    M = scale[:, None] * whole.transition / scale
    rate = scale * np.concatenate([velocity, flow.acceleration(q)])
    rate /= np.linalg.norm(rate)
    Q = _complement(rate, -_omega_times(rate))
    multipliers, conditions, vectors = _eigenvalues(Q.T @ M @ Q)
    trivial = float(np.linalg.norm(M @ rate - rate))
    symplectic = _symplectic_error(M)
    wrong = max(symplectic, np.finfo(float).eps) * float(np.linalg.norm(M, 2)) + trivial
    error = min(wrong * float(conditions.max(initial=1.0)), float(np.sqrt(wrong)))
    return Stability(
        multipliers=multipliers,
        trivial_error=trivial,
        symplectic_error=symplectic,
        pair_error=_pair_error(multipliers),
        error=error,
        directions=Q @ vectors,
        kinds=tuple(_kind(multiplier, max(on_circle, error)) for multiplier in multipliers),
    )


def _unknown(failure: str) -> Stability:
    nan, none = float("nan"), np.empty(0, dtype=complex)
    return Stability(none, nan, nan, nan, nan, none.reshape(0, 0), (), failure)


def _omega_times(vectors: Array) -> Array:
    """Omega times a vector, shape (2 J,), or the columns of a matrix."""
    upper, lower = np.split(vectors, 2)
    return np.concatenate([lower, -upper])


def _complement(first: Array, second: Array) -> Array:
    """Orthonormal basis of what is orthogonal to two orthonormal vectors, shape (2 J, 2 J - 2)."""
    basis, _ = np.linalg.qr(np.column_stack([first, second]), mode="complete")
    return basis[:, 2:]


def _eigenvalues(matrix: Array) -> tuple[Complex, Array, Complex]:
    """Eigenvalues by falling modulus, condition numbers 1 / |left . right|, and eigenvectors."""
    if not matrix.size:
        return np.empty(0, dtype=complex), np.empty(0), np.empty((0, 0), dtype=complex)
    values, left, right = eig(matrix, left=True, right=True)
    cosine = np.abs(np.sum(left.conj() * right, axis=0))
    order = np.argsort(-np.abs(values), kind="stable")
    return values[order], 1 / np.maximum(cosine[order], np.finfo(float).tiny), right[:, order]


def _symplectic_error(M: Array) -> float:
    defect = M.T @ _omega_times(M) - _omega_times(np.eye(len(M)))
    return float(np.linalg.norm(defect, 2) / np.linalg.norm(M, 2) ** 2)


def _pair_error(multipliers: Complex) -> float:
    """Largest distance |mu mu' - 1| of a multiplier from its best partner mu'."""
    if not multipliers.size:
        return 0.0
    products = np.abs(np.outer(multipliers, multipliers) - 1)
    np.fill_diagonal(products, np.inf)
    return float(products.min(axis=1).max())


def _kind(multiplier: complex, tolerance: float) -> str:
    """Kind of instability that a multiplier makes, or nothing."""
    if abs(multiplier) <= 1 + tolerance:
        return ""
    if abs(multiplier.imag) > tolerance * abs(multiplier):
        return COMPLEX
    return REAL if multiplier.real > 0 else DOUBLING
