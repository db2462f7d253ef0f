"""Which motions of a branch are wanted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from fenics_nnm.errors import ModelError
from fenics_nnm.nonlinear.newton import Newton

_NEWTON = Newton(iterations=25)


@dataclass(frozen=True, slots=True)
class EnergyContinuation:
    """Which energies to visit; all are ratios gamma / gamma_grazing.

    Attributes:
        start: First ratio.
        stop: Last ratio.
        step: Largest step.
        smallest_step: A step that fails is halved down to this.
        report_at: Ratios that must be among the points.
        newton: Newton's configuration.
    """

    start: float
    stop: float
    step: float
    smallest_step: float = 0.005
    report_at: tuple[float, ...] = ()
    newton: Newton = field(default_factory=lambda: _NEWTON)

    def __post_init__(self) -> None:
        if not 0 < self.start < self.stop:
            raise ModelError(
                f"energies from {self.start:g} to {self.stop:g}: must be 0 < from < to"
            )
        outside = [ratio for ratio in self.report_at if not self.start <= ratio <= self.stop]
        if outside:
            raise ModelError(
                f"report_at = {outside[0]:g}: must lie between {self.start:g} and {self.stop:g}"
            )

    @property
    def name(self) -> str:
        """Name of what is stepped."""
        return "gamma_ratio"

    def targets(self) -> list[float]:
        """Ratios to visit, ascending: equal steps no larger than `step`, and `report_at`."""
        return grid(self.start, self.stop, self.step, self.report_at)


@dataclass(frozen=True, slots=True)
class FrequencyContinuation:
    """Which frequencies to visit; all are ratios to the frequency of the linear mode.

    Attributes:
        start: First ratio, above 1: contact closes a gap, which makes a structure stiffer.
        stop: Last ratio.
        step: Largest step.
        smallest_step: A step that fails is halved down to this.
        report_at: Gamma ratios that must be among the points where the branch passes them.
        newton: Newton's configuration.
    """

    start: float
    stop: float
    step: float
    smallest_step: float = 2e-4
    report_at: tuple[float, ...] = ()
    newton: Newton = field(default_factory=lambda: _NEWTON)

    def __post_init__(self) -> None:
        if not 1 < self.start < self.stop:
            raise ModelError(
                f"frequencies from {self.start:g} to {self.stop:g}: must be 1 < from < to"
            )

    @property
    def name(self) -> str:
        """Name of what is stepped."""
        return "frequency_ratio"

    def targets(self) -> list[float]:
        """Ratios to visit, ascending: equal steps no larger than `step`."""
        return grid(self.start, self.stop, self.step)


def grid(start: float, stop: float, step: float, among: Sequence[float] = ()) -> list[float]:
    """Equal steps no larger than `step` from `start` to `stop`, and the values `among` them."""
    count = int(np.ceil((stop - start) / step - 1e-9))
    even = start + (stop - start) * np.arange(count + 1) / count
    free = [value for value in even if all(abs(value - other) > 1e-9 * other for other in among)]
    return sorted({*(float(value) for value in free), *among})
