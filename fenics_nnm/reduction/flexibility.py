"""Dynamic residual flexibility: what the modes left out of a reduced model do at a frequency."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.model import Scales

#: Largest error of a parabola, relative to the static flexibility of the contact points.
ACCURACY = 1e-11


@dataclass(frozen=True, slots=True)
class ResidualFlexibility:
    r"""Inertial part D of the residual flexibility, for harmonics n = 0..N about a frequency.

    The modes that a model leaves out have the flexibility, with s = (n omega)^2,

        R(s) = sum_{j > J} phi_j phi_j^T / (omega_j^2 - s) = R(0) + D(s).

    A model has the static part R(0). With X(s) the displacement of these modes under unit contact
    forces, the contact compliance B (K - s M)^-1 B^T is the modal part plus R(s), and

        D(s) = s X(0)^T M X(s),   D'(s) = X^T M X,   D''(s) / 2 = X^T M (K - s M)^-1 M X.

    Each harmonic keeps these three at a centre and is a parabola about it.

    Attributes:
        centre: s of each parabola in rad^2/s^2, shape (N + 1,).
        value: D at the centre in m/N, shape (N + 1, n_c, n_c).
        slope: D' there, shape (N + 1, n_c, n_c).
        curvature: D'' / 2 there, shape (N + 1, n_c, n_c).
    """

    centre: Array
    value: Array
    slope: Array
    curvature: Array

    @classmethod
    def static(cls, slope: Array, curvature: Array, harmonics: int) -> ResidualFlexibility:
        """Parabolas about s = 0, where D = 0.

        Args:
            slope: X^T M X of the static X, shape (n_c, n_c).
            curvature: X^T M K^-1 M X, shape (n_c, n_c).
            harmonics: Number of harmonics N.
        """
        rows = harmonics + 1
        return cls(
            centre=np.zeros(rows),
            value=np.zeros((rows, *slope.shape)),
            slope=np.tile(slope, (rows, 1, 1)),
            curvature=np.tile(curvature, (rows, 1, 1)),
        )

    def at(self, omega: float) -> tuple[Array, Array, Array]:
        """D, D' and D'' by s at the frequency omega, each of shape (N + 1, n_c, n_c)."""
        distance = self._distance(omega)[:, None, None]
        return (
            self.value + distance * (self.slope + distance * self.curvature),
            self.slope + 2 * distance * self.curvature,
            2 * self.curvature,
        )

    def error(self, omega: float) -> Array:
        """Estimate of the largest entry of D that the parabolas miss at omega, shape (N + 1,).

        The terms of D's series fall like a geometric one, whose ratio is that of the last two;
        infinite from a ratio of 1/2.
        """
        distance = np.abs(self._distance(omega))
        slope, curvature = (np.abs(part).max(axis=(1, 2)) for part in (self.slope, self.curvature))
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = np.nan_to_num(distance * curvature / slope, nan=0.0)
        missed = curvature * distance**2 * ratio / (1 - np.minimum(ratio, 0.5))
        return np.where(ratio < 0.5, missed, np.inf)

    def renewed(
        self, harmonic: int, centre: float, value: Array, slope: Array, curvature: Array
    ) -> ResidualFlexibility:
        """The same with another parabola for one harmonic."""
        parts = {"centre": centre, "value": value, "slope": slope, "curvature": curvature}
        changed = {}
        for name, part in parts.items():
            changed[name] = getattr(self, name).copy()
            changed[name][harmonic] = part
        return ResidualFlexibility(**changed)

    def with_static(self, R: Array) -> ResidualFlexibility:
        """R(s) instead of D(s), for a law that has no static part of its own."""
        return replace(self, value=self.value + R)

    def dimensionless(self, scales: Scales) -> ResidualFlexibility:
        """The same in the units of a dimensionless model."""
        flexibility, squared = scales.force / scales.length, scales.omega**2
        return ResidualFlexibility(
            centre=self.centre / squared,
            value=self.value * flexibility,
            slope=self.slope * (flexibility * squared),
            curvature=self.curvature * (flexibility * squared**2),
        )

    def _distance(self, omega: float) -> Array:
        return (np.arange(len(self.centre)) * omega) ** 2 - self.centre


FlexibilitySource = Callable[[float], ResidualFlexibility]
"""From a frequency to the residual flexibility D about it."""
