"""What a contact point is: with mass or without. The reduction chooses; nothing asks R for it.

Points without mass obey Signorini's conditions at each instant, so that their motion is unique and
can be followed in time (Monjaraz-Tec, Gross, Krack, Comput. Struct. 260 (2022) 106698). Points with
mass have R = 0: forces on them are found at given harmonics alone, and what follows an impact needs
a law of impact.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.contact_law import Complementarity
from fenics_nnm.mechanics.definite import largest_at_most, surely_above
from fenics_nnm.mechanics.fourier import Series

#: R with a smaller ratio of eigenvalues than this is singular.
_SINGULAR = 1e-10


class ContactPoints(Protocol):
    """A kind of contact points."""

    @property
    def massless(self) -> bool:
        """Whether they carry no mass."""

    def objection(self, R: Array) -> str:
        """Why they cannot have this residual flexibility, or nothing."""

    def of_part(self, R: Array) -> ContactPoints:
        """Kind of the points of a part of the model, which has more residual flexibility."""

    def forces_at(self, R: Array, gap: Array, motion: ContactMotion) -> Array:
        """Contact forces in N at phases of a motion, shape (p, n_c)."""

    def force_rates_at(self, R: Array, gap: Array, motion: ContactMotion) -> Array:
        """Derivatives of the contact forces by the phase in N, shape (p, n_c)."""


@dataclass(frozen=True, slots=True)
class ContactMotion:
    """What contact forces at any time follow from.

    Attributes:
        series: Series in time.
        displacement: Free displacement of the contact points at the phases in m, shape (p, n_c).
        rates: Its derivatives by the phase, shape (p, n_c).
        force: Contact forces at the samples in N, shape (s, n_c).
        phase: Phases omega t, shape (p,).
    """

    series: Series
    displacement: Array
    rates: Array
    force: Array
    phase: Array


@dataclass(frozen=True, slots=True)
class Massless:
    """Points without mass: forces follow from the motion alone, by Signorini's conditions."""

    @property
    def massless(self) -> bool:
        """They carry no mass."""
        return True

    def objection(self, R: Array) -> str:
        """R must be positive definite."""
        if _definite(R):
            return ""
        return "R is singular: contact points without mass need residual flexibility of their own"

    def of_part(self, R: Array) -> ContactPoints:
        """Points without mass stay so."""
        return self

    def forces_at(self, R: Array, gap: Array, motion: ContactMotion) -> Array:
        """Contact forces in N at phases of a motion, shape (p, n_c)."""
        return Complementarity(R, gap)(motion.displacement).force

    def force_rates_at(self, R: Array, gap: Array, motion: ContactMotion) -> Array:
        """They follow from the slope of the law, and jump where a point opens or closes."""
        return Complementarity(R, gap)(motion.displacement).change(motion.rates)


@dataclass(frozen=True, slots=True)
class Massive:
    """Points with mass: of their forces the harmonics 0..N act, those above are not determined."""

    @property
    def massless(self) -> bool:
        """They carry mass."""
        return False

    def objection(self, R: Array) -> str:
        """Any R will do."""
        return ""

    def of_part(self, R: Array) -> ContactPoints:
        """Points that move with modes which follow statically have no mass in the part."""
        return MASSLESS if _definite(R) else self

    def forces_at(self, R: Array, gap: Array, motion: ContactMotion) -> Array:
        """Contact forces in N at phases of a motion, shape (p, n_c)."""
        harmonics = motion.series.analysis @ motion.force
        return np.asarray(motion.series.basis_at(motion.phase) @ harmonics)

    def force_rates_at(self, R: Array, gap: Array, motion: ContactMotion) -> Array:
        """Derivatives of the contact forces by the phase in N, shape (p, n_c)."""
        harmonics = motion.series.analysis @ motion.force
        return np.asarray(motion.series.rate_at(motion.phase) @ harmonics)


MASSLESS, MASSIVE = Massless(), Massive()


def _definite(R: Array) -> bool:
    """Whether R is positive definite, apart from round-off."""
    if surely_above(R, _SINGULAR * largest_at_most(R)):
        return True
    eigenvalues = np.linalg.eigvalsh(R)
    return bool(eigenvalues[0] > _SINGULAR * eigenvalues[-1])
