"""Which motions of a branch are wanted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.continuation.trace_options import ArcLength
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
        _assert_ascending(self.start, self.stop)
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
        start: Lowest ratio; above 1 where contact closes a gap, which makes a structure stiffer.
        stop: Highest ratio; below 1 where a closed contact lifts off.
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
        if not (1 < self.start < self.stop or 0 < self.start < self.stop < 1):
            raise ModelError(
                f"frequencies from {self.start:g} to {self.stop:g}: must be 1 < from < to, or "
                "from < to < 1 where a closed contact lifts off"
            )

    @property
    def name(self) -> str:
        """Name of what is stepped."""
        return "frequency_ratio"

    def targets(self) -> list[float]:
        """Ratios to visit, ascending: equal steps no larger than `step`."""
        return grid(self.start, self.stop, self.step)


@dataclass(frozen=True, slots=True)
class Begin:
    """A known motion that a branch begins at.

    Attributes:
        point: Motion, of the model and in the series of the branch.
        along: Its neighbours on the branch that is known, where the other branch that crosses
            it there is wanted; else None.
        downwards: Whether to set out towards lower energies, or to the second side of a crossing.
    """

    point: BranchPoint
    along: tuple[BranchPoint, BranchPoint] | None = None
    downwards: bool = False


@dataclass(frozen=True, slots=True)
class ArcContinuation:
    """A branch that is followed by its length, through folds and internal resonances.

    Attributes:
        start: Lowest gamma ratio; the branch ends where it comes back to it.
        stop: Highest gamma ratio; the branch ends there.
        step: Energies this far apart are hit at each passing; only `report_at` if None.
        report_at: Gamma ratios that are hit at each passing.
        arc: Steps along the branch.
        harmonic: Harmonic k that the linear mode is written in at first: subharmonic branches
            are those of k > 1. The gamma ratio is then over k^2 times the gamma of grazing, and
            frequencies are over that of the mode divided by k.
        begin: Motion to begin at, or None for the linear mode.
        newton: Newton's configuration for the motion to begin at.
    """

    start: float
    stop: float
    step: float | None = None
    report_at: tuple[float, ...] = ()
    arc: ArcLength = field(default_factory=ArcLength)
    harmonic: int = 1
    begin: Begin | None = None
    newton: Newton = field(default_factory=lambda: _NEWTON)

    def __post_init__(self) -> None:
        _assert_ascending(self.start, self.stop)

    @property
    def name(self) -> str:
        """Name of what bounds it."""
        return "gamma_ratio"

    def targets(self) -> list[float]:
        """Gamma ratios to hit at each passing."""
        if self.step is None:
            return sorted({self.start, self.stop, *self.report_at})
        return grid(self.start, self.stop, self.step, self.report_at)


Continuation = EnergyContinuation | FrequencyContinuation | ArcContinuation
"""Which motions of a branch are wanted."""


def _assert_ascending(start: float, stop: float) -> None:
    if not 0 < start < stop:
        raise ModelError(f"energies from {start:g} to {stop:g}: must be 0 < from < to")


def grid(start: float, stop: float, step: float, among: Sequence[float] = ()) -> list[float]:
    """Equal steps no larger than `step` from `start` to `stop`, and the values `among` them."""
    count = max(1, int(np.ceil((stop - start) / step - 1e-9)))
    even = start + (stop - start) * np.arange(count + 1) / count
    free = [value for value in even if all(abs(value - other) > 1e-9 * other for other in among)]
    return sorted({*(float(value) for value in free), *among})
