"""What to ask of the tracing of a branch: steps, ranges and targets."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum

from fenics_nnm.errors import ModelError
from fenics_nnm.nonlinear.conditions import Quantity
from fenics_nnm.nonlinear.newton import Newton


class Predictor(StrEnum):
    """Where the next point is looked for: along the tangent, or on from the last two points."""

    TANGENT = "tangent"
    SECANT = "secant"


@dataclass(frozen=True, slots=True)
class ArcLength:
    """Configuration; lengths are relative changes of the motion, see `continuation.arc_length`.

    Attributes:
        step: First step.
        smallest_step: A step that fails is halved down to this.
        largest_step: Largest step.
        points: Largest number of steps.
        predictor: How the next point is predicted.
        wanted_iterations: Steps grow where Newton's iteration takes fewer, and shrink where more.
        growth: Largest factor by which a step grows.
        largest_turn: Bound in degrees on the angle between a step and its prediction.
        event_tolerance: Length to which folds and branch points are located.
        newton: Newton's configuration. The tolerance is tight: where natural frequencies are
            multiples of the frequency, to 1e-8 on a rod, only that little holds the branch.
    """

    step: float = 0.02
    smallest_step: float = 1e-5
    largest_step: float = 0.1
    points: int = 1000
    predictor: Predictor = Predictor.TANGENT
    wanted_iterations: int = 4
    growth: float = 1.5
    largest_turn: float = 30.0
    event_tolerance: float = 1e-8
    newton: Newton = field(
        default_factory=lambda: Newton(tolerance=1e-13, round_off=1e-10, iterations=12)
    )

    def __post_init__(self) -> None:
        if not 0 < self.smallest_step <= self.step <= self.largest_step:
            raise ModelError(
                f"arc-length steps of {self.smallest_step:g}, {self.step:g}, {self.largest_step:g}:"
                " must be 0 < smallest_step <= step <= largest_step"
            )
        if not 0 < self.largest_turn < 90:
            raise ModelError(f"largest_turn = {self.largest_turn:g}: must be in (0, 90) degrees")


@dataclass(frozen=True, slots=True)
class Range:
    """Values of a quantity to stay within, and those to hit exactly.

    The ends of the range are hit, too: there the branch ends.
    """

    low: float = 0.0
    high: float = float("inf")
    targets: tuple[float, ...] = ()

    def between(self, first: float, second: float) -> list[float]:
        """Values to hit on the way from a first value, left out, to a second."""
        ahead = 1 if second > first else -1
        wanted = {self.low, self.high, *self.targets}
        passed = [value for value in wanted if ahead * first < ahead * value <= ahead * second]
        return sorted(passed, key=lambda value: ahead * value)

    def left_at(self, value: float, slope: float) -> bool:
        """Whether the range is left at a value that changes with this slope."""
        return (value == self.high and slope > 0) or (value == self.low and slope < 0)


@dataclass(frozen=True, slots=True)
class Bound:
    """A quantity and the range that a branch stays in.

    Attributes:
        quantity: Quantity.
        range: Range of its values, with targets.
    """

    quantity: Quantity
    range: Range

    def leaving(self, value: float, rising: float) -> str:
        """That the range is left at a value that changes with this slope, or nothing."""
        left = self.range.left_at(value, rising)
        return f"{self.quantity.name} leaves its range at {value:g}" if left else ""
