"""A driven structure: what its motion obeys, and where it is watched."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from fenics_nnm.arrays import Array, Complex
from fenics_nnm.mechanics.excitation import Excitation
from fenics_nnm.mechanics.force import Force
from fenics_nnm.mechanics.linear_part import LinearPart
from fenics_nnm.mechanics.mechanics import Mechanics
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.mechanics.moving_gap import STILL, GapMotion

#: Why contact points that move with the modes alone cannot touch.
NO_FLEXIBILITY = (
    "the modes leave the contact points no flexibility of their own, so that what they do in "
    "contact is not known: must be fewer modes, or forces beside the contact points"
)


@dataclass(frozen=True, slots=True)
class Drive:
    r"""Harmonic forces at some places, sum_p psi_p^T Re(F_p exp(i n_p omega t)).

    Attributes:
        shapes: psi, displacement of the excited places along their forces per modal coordinate,
            kg^-1/2, shape (p, J).
        amplitudes: F, complex amplitudes of the forces in N, 0-peak, shape (p,).
        harmonics: n, harmonics of the frequency of the motion, from 0, shape (p,).
    """

    shapes: Array
    amplitudes: Complex
    harmonics: tuple[int, ...]

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
            found.append(Excitation(n, force.real, -force.imag))
        return tuple(found)

    def scaled(self, level: float) -> Drive:
        """All forces times a factor."""
        return replace(self, amplitudes=level * self.amplitudes)


@dataclass(frozen=True, slots=True)
class Watched:
    """Places whose displacement is watched, x = psi q - R_w lambda.

    Those of the forces come first, then further ones, then the contact points.

    Attributes:
        names: Their names.
        shapes: psi, shape (w, J).
        residual: R_w in m/N, shape (w, n_c).
    """

    names: tuple[str, ...]
    shapes: Array
    residual: Array

    @classmethod
    def of(cls, model: ReducedModel, others: Mapping[str, tuple[Array, Array]]) -> Watched:
        """Some places by their names, each with its psi and R_w, and the contact points."""
        points = {f"contact {n + 1}": (model.Phi[n, :], model.R[n, :]) for n in range(model.points)}
        every = {**others, **points}
        shapes, residual = zip(*every.values(), strict=True)
        return cls(tuple(every), np.array(shapes), np.array(residual))

    @property
    def before_contact(self) -> int:
        """Number of places before the contact points."""
        return len(self.names) - self.residual.shape[1]


@dataclass(frozen=True, slots=True)
class DrivenStructure:
    r"""A damped structure under harmonic forces.

        q'' + C q' + Lambda q + f(q) + Phi^T lambda = p(t),      w = Phi q - R lambda

    Attributes:
        model: Reduced model, Lambda = diag(omega_j^2).
        linear: Stiffness, inertia and damping.
        drive: Harmonic forces.
        watched: Places whose displacement is watched.
        forces: f, forces that the motion determines besides those of contact.
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
        still = np.zeros(model.points)
        own = {name: (drive.shapes[n, :], still) for n, name in enumerate(names)}
        objection = "" if model.massless else NO_FLEXIBILITY
        return cls(model, linear, drive, Watched.of(model, own), forces, objection)

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
