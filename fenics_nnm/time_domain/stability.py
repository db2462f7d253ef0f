"""Stability of a periodic motion: Floquet multipliers of the shot motion.

They are the eigenvalues of the derivative of the flow over the period, a plain product of the
derivatives of linear stages, since the vector field is continuous; see `time_domain.multipliers`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array, Complex
from fenics_nnm.time_domain.integrator import Integrator
from fenics_nnm.time_domain.multipliers import (
    Multipliers,
    symplectic_error,
    there_and_back,
)
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
        symplectic_error: |M^T Omega M - Omega| over |M|^2, of the Frobenius norm.
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
    def instabilities(self) -> frozenset[str]:
        """Kinds of instability that it has."""
        return frozenset(self.kinds) - {""}

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


def damping_needed(multiplier: float) -> float:
    """Damping ratio, as a part of critical damping, that makes up for a growth by |mu| a period.

    With all modes damped alike, q'' + 2 zeta omega q' + .. = 0 about the frequency omega of the
    motion, every multiplier is smaller by exp(-2 pi zeta), for zeta << 1:

        zeta = ln |mu| / (2 pi)

    Args:
        multiplier: Largest modulus |mu| of the multipliers of the undamped motion.

    Returns:
        0 for a stable motion, nan if the multiplier is not known.
    """
    return float(np.log(np.maximum(multiplier, 1.0)) / (2 * np.pi))


def stability(
    flow: Integrator, shot: ShotMotion, *, reversible: bool = False, on_circle: float = _ON_CIRCLE
) -> Stability:
    """Floquet multipliers of a shot motion.

    Args:
        flow: Integrator that the motion was shot with.
        shot: A converged motion.
        reversible: Whether it was shot from rest to rest.
        on_circle: Multipliers within this distance of the unit circle, or within the estimated
            error if that is more, count as on it.
    """
    if shot.failure:
        return _unknown(shot.failure)
    state = shot.q, shot.velocity, shot.period
    return stability_of(flow, *state, reversible=reversible, on_circle=on_circle)


def stability_of(
    flow: Integrator,
    q: Array,
    velocity: Array,
    period: float,
    *,
    reversible: bool = False,
    on_circle: float = _ON_CIRCLE,
) -> Stability:
    """Floquet multipliers of a periodic motion given by its initial state and its period.

    Args:
        flow: Integrator of the model.
        q: Modal coordinates at the start in kg^1/2 m, shape (J,).
        velocity: Their velocities, shape (J,).
        period: Period in s.
        reversible: Whether the motion is at rest at the start and after half a period.
        on_circle: As for `stability`.
    """
    span = period / 2 if reversible else period
    inertia = flow.model.kinematics.inertia
    along = inertia.from_momenta(q, velocity, np.eye(2 * len(q)))
    after = flow.run(q, velocity, span, along=along)
    if after.failure or after.transition is None:
        return _unknown(after.failure)
    omega = flow.model.omega
    scale = np.concatenate([np.sqrt(omega), 1 / np.sqrt(omega)])
    carried = inertia.to_momenta(after.q, after.velocity, after.transition)
    M = scale[:, None] * carried / scale
    moving = np.concatenate([velocity, flow.acceleration(q, velocity)])
    rate = scale * inertia.to_momenta(q, velocity, moving)
    rate /= np.linalg.norm(rate)
    if reversible:
        M = there_and_back(M)
        found = Multipliers.of_reversible_motion(M, rate)
    else:
        found = Multipliers.of_motion(M, rate)
    trivial = float(np.linalg.norm(M @ rate - rate))
    symplectic = symplectic_error(M)
    wrong = max(symplectic, np.finfo(float).eps) * float(np.linalg.norm(M)) + trivial
    error = min(wrong * float(found.conditions.max(initial=1.0)), float(np.sqrt(wrong)))
    return Stability(
        multipliers=found.values,
        trivial_error=trivial,
        symplectic_error=symplectic,
        pair_error=_pair_error(found.values),
        error=error,
        directions=found.directions,
        kinds=tuple(_kind(multiplier, max(on_circle, error)) for multiplier in found.values),
    )


def _unknown(failure: str) -> Stability:
    nan, none = float("nan"), np.empty(0, dtype=complex)
    return Stability(none, nan, nan, nan, nan, none.reshape(0, 0), (), failure)


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
