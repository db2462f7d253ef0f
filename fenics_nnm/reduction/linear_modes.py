"""Free vibration modes of a structure."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.errors import MissedModesError
from fenics_nnm.reduction.clusters import groups, unique_basis
from fenics_nnm.reduction.operators import Product

#: Squared frequencies nearer than this part of each other are one group.
_APART = 1e-6


@dataclass(frozen=True, slots=True)
class LinearModes:
    """Free vibration modes of a structure that is held.

    Attributes:
        omega: Circular frequencies in rad/s, ascending, shape (J,).
        shapes: Mass-normalised shapes (kg^-1/2) at the (owned) degrees of freedom, shape (n, J);
            the same on any number of ranks but for the sign.
        checked_below: The modes below s rad/s were counted by other means, such as the inertia of
            K - s^2 M, and none was missed; 0 if that was not done.
    """

    omega: Array
    shapes: Array
    checked_below: float

    @property
    def frequencies(self) -> Array:
        """Frequencies in Hz, shape (J,)."""
        return self.omega / (2 * np.pi)

    def unique(self, contact: Product) -> LinearModes:
        """The same with the unique basis of modes of equal frequency, see `reduction.clusters`.

        Args:
            contact: From displacements to those of the contact points.
        """
        if not any(True for _ in groups(self.omega)):
            return self
        return replace(self, shapes=self.shapes @ unique_basis(self.omega, contact(self.shapes)))

    def first(self, count: int) -> LinearModes:
        """The lowest modes alone."""
        return replace(self, omega=self.omega[:count], shapes=self.shapes[:, :count])


def counting_shift(squared: Array, count: int) -> tuple[float, int]:
    """Where to count modes: a place between two groups of frequencies, and the modes below it.

    Args:
        squared: Squared circular frequencies found, ascending.
        count: Number of modes wanted; the place lies above them if more were found.

    Returns:
        Squared circular frequency, and how many of `squared` lie below; (0, 0) if there is none.
    """
    gaps = np.flatnonzero(np.diff(squared) > _APART * squared[1:]) + 1
    inside = int(next((gap for gap in gaps if gap >= count), gaps[-1] if len(gaps) else 0))
    if inside == 0:
        return 0.0, 0
    return float((squared[inside - 1] + squared[inside]) / 2), inside


def counted(shift: float, inside: int, negative: int) -> float:
    """Circular frequency in rad/s below which no mode is missing.

    Args:
        shift: Squared circular frequency, as from `counting_shift`.
        inside: Modes found below it.
        negative: Negative pivots of K - shift M, as many as there are modes below it.

    Raises:
        MissedModesError: if a mode was missed.
    """
    if negative != inside:
        raise MissedModesError(
            f"eigensolver: {inside} modes below {np.sqrt(shift) / 2 / np.pi:.6g} Hz, but the "
            f"inertia of K - s^2 M counts {negative}: a mode was missed"
        )
    return float(np.sqrt(shift))
