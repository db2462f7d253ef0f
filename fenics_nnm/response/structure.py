"""A driven structure: what its motion obeys, and where it is watched."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from fenics_nnm.arrays import Array, Complex, Mask
from fenics_nnm.mechanics.excitation import Excitation
from fenics_nnm.mechanics.force import Force
from fenics_nnm.mechanics.linear_part import LinearPart
from fenics_nnm.mechanics.mechanics import Mechanics
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.mechanics.moving_gap import STILL, GapMotion
from fenics_nnm.reduction.gyroscopic import gyroscopic_frequencies
from fenics_nnm.response.watched import Place, Watched

#: Why contact points that move with the modes alone cannot touch.
NO_FLEXIBILITY = (
    "the modes leave the contact points no flexibility of their own, so that what they do in "
    "contact is not known: must be fewer modes, or forces beside the contact points"
)


#: Forces cancel each other if this part of them at most is left, which is round-off.
_CANCELLED = 1e-10


@dataclass(frozen=True, slots=True)
class Drive:
    r"""Harmonic forces at some places, sum_p (psi_p + theta_p q)^T Re(F_p exp(i n_p omega t)).

    Attributes:
        shapes: psi, displacement of the excited places along their forces per modal coordinate,
            kg^-1/2, shape (p, J).
        amplitudes: F, complex amplitudes of the forces in N, 0-peak, shape (p,).
        harmonics: n, harmonics of the frequency of the motion, from 0, shape (p,).
        bent: Second derivatives theta of the displacements by the masters of second-order
            kinematics, in 1/(kg m), shape (p, k, k); with k = 0 forces do not turn.
    """

    shapes: Array
    amplitudes: Complex
    harmonics: tuple[int, ...]
    bent: Array = field(default_factory=lambda: np.zeros((0, 0, 0)))

    @classmethod
    def simple(cls, shapes: Array, amplitudes: Complex) -> Drive:
        """Forces at the frequency of the motion."""
        return cls(shapes, amplitudes, (1,) * len(shapes))

    @property
    def excitations(self) -> tuple[Excitation, ...]:
        """The modal forces of each harmonic."""
        found = []
        for n in sorted(set(self.harmonics)):
            own = np.array(self.harmonics) == n
            force = self.amplitudes[own] @ self.shapes[own]
            found.append(Excitation(n, force.real, -force.imag, self._turning(own)))
        return tuple(found)

    @property
    def cancels(self) -> bool:
        """Whether no harmonic has a force, though places have."""
        alone = np.abs(self.amplitudes) @ np.abs(self.shapes)
        left = [np.hypot(each.cosine, each.sine) for each in self.excitations]
        return bool(alone.any()) and all((each <= _CANCELLED * alone).all() for each in left)

    def _turning(self, own: Mask) -> Array:
        """What second-order kinematics add to some of the forces, shape (2, k, k)."""
        if not self.bent.size:
            return np.zeros((2, 0, 0))
        force = np.tensordot(self.amplitudes[own], self.bent[own], 1)
        return np.array([force.real, -force.imag])

    def scaled(self, level: float) -> Drive:
        """All forces times a factor."""
        return replace(self, amplitudes=level * self.amplitudes)


@dataclass(frozen=True, slots=True)
class DrivenStructure:
    r"""A damped structure under harmonic forces.

        q'' + C q' + Lambda q + f(q) + Phi^T lambda = p(t),      w = Phi q - R lambda

    or what second-order kinematics make of it, see `mechanics.second_order`, damped as it is here.

    Attributes:
        model: Reduced model, Lambda = diag(omega_j^2).
        linear: Stiffness, inertia and damping.
        drive: Harmonic forces.
        watched: Places whose displacement is watched.
        forces: f, forces that the motion determines besides those of contact, those of
            second-order kinematics among them.
        objection: Why its contact points cannot touch anything, or nothing.
        gap_motion: How gaps move at level 1.
    """

    model: ReducedModel
    linear: LinearPart
    drive: Drive
    watched: Watched
    forces: tuple[Force, ...] = ()
    objection: str = ""
    gap_motion: GapMotion = STILL

    @classmethod
    def of(
        cls, model: ReducedModel, linear: LinearPart, drive: Drive, forces: tuple[Force, ...] = ()
    ) -> DrivenStructure:
        """A structure that is watched at the excited places and contact points.

        Excited places are taken to move with the modes alone.
        """
        names = numbered("excitation", len(drive.shapes))
        still, k = np.zeros(model.points), len(model.kinematics.masters)
        bent = drive.bent if drive.bent.size else np.zeros((len(names), k, k))
        own = {name: Place(drive.shapes[n, :], still, bent[n]) for n, name in enumerate(names)}
        objection = "" if model.massless else NO_FLEXIBILITY
        every = (*model.kinematics.forces, *forces)
        return cls(model, linear, drive, Watched.of(model, own), every, objection)

    @property
    def mechanics(self) -> Mechanics:
        """What its motion obeys."""
        return Mechanics(
            self.model,
            self.model.at_rest(),
            self.linear,
            self.forces,
            self.drive.excitations,
            self.gap_motion,
        )

    @property
    def bends(self) -> bool:
        """Whether it has second-order kinematics."""
        return len(self.model.kinematics.masters) > 0

    @property
    def natural(self) -> Array:
        """Natural circular frequencies in rad/s, and those with Coriolis forces besides."""
        omega, turning = self.model.omega, self.linear.gyroscopic
        if not turning.any():
            return omega
        return np.sort([*omega, *gyroscopic_frequencies(omega, turning)])

    @property
    def harmonics(self) -> tuple[int, ...]:
        """Harmonics of the frequency at which it is driven, ascending."""
        return tuple(sorted({*self.drive.harmonics, *self.gap_motion.harmonics}))

    @property
    def highest_harmonic(self) -> int:
        """The highest harmonic at which it is driven."""
        return max(self.harmonics, default=0)

    @property
    def smallest_gap(self) -> float:
        """Smallest gap in m while nothing moves but the gaps; negative where they press."""
        return float((self.model.gap + self.gap_motion.lowest).min(initial=np.inf))

    @property
    def monitors(self) -> tuple[str, ...]:
        """Names of the places that are watched."""
        return self.watched.names

    def at_level(self, level: float) -> DrivenStructure:
        """The same with all forces, and the motions of gaps, times a factor."""
        return replace(
            self, drive=self.drive.scaled(level), gap_motion=self.gap_motion.scaled(level)
        )


def numbered(name: str, count: int) -> tuple[str, ...]:
    """A name for each of several, without a number where there is only one."""
    return (name,) if count == 1 else tuple(f"{name} {n + 1}" for n in range(count))
