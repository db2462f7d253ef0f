"""Linear part with structural damping: each harmonic loses a part of its strain energy a cycle."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.errors import ModelError
from fenics_nnm.mechanics.fourier import Series
from fenics_nnm.mechanics.linear_part import RatedOperator, RatedPart


@dataclass(frozen=True, slots=True)
class HystereticPart:
    """(Lambda + i D - n^2 omega^2 + i n omega C) x_n for n > 0, Lambda x_0 for the mean.

    The energy lost in a cycle does not depend on the frequency. This is a law of harmonics: there
    is no equation in time that it belongs to.

    Attributes:
        rated: Stiffness, inertia, and terms of the velocity.
        loss: D, the imaginary part of the stiffness in 1/s^2, shape (J, J).
    """

    rated: RatedPart
    loss: Array

    @property
    def separate(self) -> bool:
        """Terms of the velocity couple coordinates."""
        return False

    @property
    def in_time(self) -> bool:
        """It is a law of harmonics."""
        return False

    @property
    def reversible(self) -> bool:
        """It damps."""
        return False

    @property
    def rate(self) -> Array:
        """Refused.

        Raises:
            ModelError: always.
        """
        raise ModelError(
            "damping by a loss factor is a law of harmonics and has no equation in time: must be "
            "damping ratios, or another viscous damping, for motions in time"
        )

    @property
    def gyroscopic(self) -> Array:
        """The part of the terms of the velocity that does no work, shape (J, J)."""
        return self.rated.gyroscopic

    def at(self, series: Series, omega: float, drift: float = 0.0) -> RatedOperator:
        """The operator at a frequency and a drift.

        Raises:
            ValueError: if the series has cosines alone.
        """
        if not series.free_phase:
            raise ValueError("damping needs a general series, with sines")
        operator = self.rated.at(series, omega, drift)
        moving = (np.arange(series.harmonics + 1) > 0)[:, None, None]
        return replace(operator, blocks=operator.blocks + 1j * moving * self.loss)
