"""A motion of a driven structure, and what is known of it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from fenics_nnm.arrays import Array, Complex


class Status(StrEnum):
    """What is known of a motion."""

    EXACT = "exact"
    VERIFIED = "verified"
    CONVERGED = "converged"
    TOUCHES = "touches"
    FAILED = "failed"


@dataclass(frozen=True, slots=True)
class Displacements:
    """Displacements of the places that are watched; nan where no motion was found.

    Attributes:
        first: Complex amplitudes of the first harmonic in m, 0-peak, shape (w,).
        highest: Largest values over the period in m, shape (w,).
        lowest: Smallest values in m, shape (w,).
        contact: Shares of the period with contact: of a contact point its own, of other places
            that of any point, shape (w,).
        gap: Smallest remaining gap of each contact point over the period in m, shape (n_c,).
    """

    first: Complex
    highest: Array
    lowest: Array
    contact: Array
    gap: Array

    @classmethod
    def unknown(cls, places: int, points: int) -> Displacements:
        """Of no motion."""
        nothing = np.full(places, np.nan)
        return cls(nothing + 0j, nothing, nothing, nothing, np.full(points, np.nan))


@dataclass(frozen=True, slots=True)
class Judgement:
    """What another method says of a motion, such as integration in time.

    Attributes:
        status: Status that follows.
        reason: Why it is not verified, or nothing.
        largest_multiplier: Largest modulus of the Floquet multipliers; nan if unknown.
        stability: "stable", or the kind of instability; nothing if unknown.
    """

    status: Status
    reason: str = ""
    largest_multiplier: float = float("nan")
    stability: str = ""


@dataclass(frozen=True, slots=True)
class ResponsePoint:
    """A motion of a driven structure.

    Attributes:
        frequency: Frequency in Hz.
        judgement: What is known of the motion.
        displacements: Displacements of the places that are watched.
        residual: Relative residual of the harmonic equations.
        q: Coefficients of the motion, shape (c, J).
        level: Factor of the forces.
        branch: Number of the branch, from 1.
        imbalance: Work of the forces less dissipation, relative to the work.
        event: What happens there: a fold, a peak; or nothing.
        speed: Speed of rotation in rad/s that goes with the frequency; nan if they are not tied.
    """

    frequency: float
    judgement: Judgement
    displacements: Displacements
    residual: float
    q: Array
    level: float = 1.0
    branch: int = 1
    imbalance: float = 0.0
    event: str = ""
    speed: float = float("nan")

    @property
    def status(self) -> Status:
        """What is known of the motion."""
        return self.judgement.status

    @property
    def reason(self) -> str:
        """Why there are no amplitudes, or why the motion is not verified."""
        return self.judgement.reason

    def doubted(self, doubt: str) -> ResponsePoint:
        """The same, not verified where it is in contact and a doubt stands against that."""
        if not doubt or self.status is not Status.VERIFIED or not self.touches:
            return self
        judgement = replace(self.judgement, status=Status.CONVERGED, reason=doubt)
        return replace(self, judgement=judgement)

    @property
    def touches(self) -> bool:
        """Whether any point is in contact."""
        return bool(self.displacements.contact.max(initial=0.0) > 0)

    @property
    def found(self) -> bool:
        """Whether there are amplitudes."""
        return bool(np.isfinite(self.displacements.first).all())

    @property
    def refuted(self) -> bool:
        """Whether there are amplitudes of what is no motion of the structure."""
        return self.found and self.status is Status.FAILED

    @property
    def omega(self) -> float:
        """Circular frequency in rad/s."""
        return 2 * np.pi * self.frequency

    @property
    def gap(self) -> Array:
        """Smallest remaining gap of each contact point in m, shape (n_c,)."""
        return self.displacements.gap

    @property
    def amplitude(self) -> Array:
        """Amplitudes of the first harmonic in m, 0-peak, shape (w,)."""
        return np.abs(self.displacements.first)

    @property
    def phase(self) -> Array:
        """Lags of the first harmonic behind cos(omega t) in degrees, 0 to 360, shape (w,).

        Of an excited point whose force has no phase it is the lag behind the force, between 0 and
        180 for a single mode: 90 at phase resonance.
        """
        return np.asarray(np.rad2deg(-np.angle(self.displacements.first)) % 360.0)
