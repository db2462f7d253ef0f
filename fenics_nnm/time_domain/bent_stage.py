r"""Damped, driven motion between two changes of contact with second-order kinematics.

Numbers z of the linear, damped, driven motion of `damped_stage` move by themselves, but for a push
by the remainder of `time_domain.remainder`,

    z' = d z + (drive) + (inward) u,      q'' = -K_A (q - rest) - C q' + p(t) + n,

in which w_j is all that accelerates a master linearly, K_A (q - rest) + C q' - p(t), and g_jk has
what moving gaps and forces that turn with the motion add to it:

    g_jk(t) = g_jk - Theta_jk . R_AA^-1 g1_A(t) - T_jk(t).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array, Complex, Mask
from fenics_nnm.errors import ModelError
from fenics_nnm.mechanics.mechanics import Mechanics
from fenics_nnm.time_domain.damped_stage import DampedMotion, DampedStage
from fenics_nnm.time_domain.drive import Drive
from fenics_nnm.time_domain.kept import bytes_of
from fenics_nnm.time_domain.master_pairs import tensors_of
from fenics_nnm.time_domain.smooth_stage import SmoothStage

#: At critical damping there is no basis of damped modes; with so much more of it there is one.
_BESIDE_CRITICAL = 1e-6


@dataclass(frozen=True, slots=True)
class Given:
    """What the remainder sees of the drive, Re(sum_f G_f exp(i nu_f t)).

    Attributes:
        amplitude: G, shape (3 k + P, F).
        rates: nu in rad/s, shape (F,).
    """

    amplitude: Complex
    rates: Array

    def at(self, times: Array) -> Array:
        """It at times, shape (3 k + P, t)."""
        waves = np.exp(1j * np.multiply.outer(self.rates, times))
        return np.asarray((self.amplitude @ waves).real)


@dataclass(frozen=True, slots=True)
class BentStage:
    """Equations of motion while the points in contact stay the same.

    Attributes:
        smooth: The stage without damping and drive: remainder and margins.
        damped: The stage with linear kinematics.
        exponents: d in 1/s, shape (K,).
        sees: What the remainder sees by z, but for what is at rest and given, (3 k + P, K).
        inward: What pushes do to z', shape (K, P + k).
        bent_by_gap: g by changes of gaps, shape (P, n_c).
    """

    smooth: SmoothStage
    damped: DampedStage
    exponents: Complex
    sees: Complex
    inward: Complex
    bent_by_gap: Array

    @classmethod
    def of(cls, mechanics: Mechanics, active: Mask) -> BentStage:
        """The stage with the given points in contact, shape (n_c,).

        Raises:
            ModelError: if damped modes are no basis.
        """
        model, rate = mechanics.model, mechanics.linear.rate
        smooth, damped = SmoothStage.of(mechanics, active), DampedStage.of(model, rate, active)
        if not damped.propagator.exponents.size:
            damped = DampedStage.of(model, (1 + _BESIDE_CRITICAL) * rate, active)
        exponents, pairs = damped.propagator.exponents, smooth.remainder.pairs
        if not exponents.size:
            raise ModelError("damping: its modes are no basis: must not be critical in several")
        Theta = tensors_of(model)[0]
        return cls(
            smooth=smooth,
            damped=damped,
            exponents=exponents,
            sees=_seen(smooth, damped, rate),
            inward=damped.inverse[:, model.modes :] @ smooth.remainder.directions,
            bent_by_gap=-Theta[:, pairs.first, pairs.second].T @ smooth.give,
        )

    @property
    def active(self) -> Mask:
        """Which points are in contact, shape (n_c,)."""
        return self.smooth.active

    @property
    def nbytes(self) -> int:
        """Bytes of its arrays."""
        own = self.exponents, self.sees, self.inward, self.bent_by_gap
        return self.smooth.nbytes + self.damped.nbytes + bytes_of(*own)

    def margins(self, q: Array, moved: Array) -> Array:
        """Margins in m at coordinates (J,) and changes of the gaps (n_c,), shape (n_c,)."""
        excess = self.smooth.excess(q[None])[0] - moved
        return np.asarray(self.smooth.margin @ excess)

    def motion(self, q: Array, velocity: Array, drive: Drive, phase: float) -> DampedMotion:
        """The motion from a state without the remainder, at a phase of the force."""
        return self.damped.motion(q, velocity, drive, phase)

    def given(self, drive: Drive, phase: float) -> Given:
        """What the remainder sees of the drive from a phase on."""
        masters = self.smooth.mechanics.model.kinematics.masters
        force, gaps = drive.turned(phase), drive.gap_turned(phase, len(self.active))
        by_gap = self.damped.pull_by_gap @ gaps
        nothing = np.zeros((len(masters), force.shape[1] + gaps.shape[1]))
        pairs = self.smooth.remainder.pairs
        turned = drive.turned_pairs(phase, pairs.first, pairs.second)
        rows = [
            nothing,
            -np.hstack([force[masters], by_gap[masters]]),
            np.hstack([-turned, self.bent_by_gap @ gaps]),
            nothing,
        ]
        return Given(np.concatenate(rows), np.concatenate([drive.rates, drive.gap_rates]))


def _seen(smooth: SmoothStage, damped: DampedStage, rate: Array) -> Complex:
    """What the remainder sees by z, see `BentStage`."""
    linear, remainder = damped.linear, smooth.remainder
    masters = smooth.mechanics.model.kinematics.masters
    place, speed = np.split(damped.basis, 2)
    place = place / linear.nu[:, None]
    position = remainder.position @ place
    position[len(masters) : 2 * len(masters)] += rate[masters] @ linear.V @ speed
    return np.concatenate([position, remainder.rate @ speed])
