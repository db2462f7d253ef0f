"""A branch over its energy."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

from fenics_nnm.backbone.cascade import Cascade
from fenics_nnm.backbone.grid import assert_ascending, grid
from fenics_nnm.backbone.outlook import Outlook
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.backbone.point_maker import PointMaker
from fenics_nnm.backbone.quantities import Sought
from fenics_nnm.backbone.sought import Seeker
from fenics_nnm.backbone.stepping import Stepping
from fenics_nnm.backbone.wanted import NEWTON, Followed, Progress, inside
from fenics_nnm.errors import ModelError
from fenics_nnm.nonlinear.newton import Newton


@dataclass(frozen=True, slots=True)
class EnergyContinuation:
    """Which energies to visit; all are ratios gamma / gamma_grazing.

    Attributes:
        start: First ratio.
        stop: Last ratio.
        step: Largest step.
        smallest_step: A step that fails is halved down to this.
        report_at: Ratios that must be among the points.
        sought: Values of other quantities that must have points, too, within these energies or
            beyond them.
        newton: Newton's configuration.
    """

    start: float
    stop: float
    step: float
    smallest_step: float = 0.005
    report_at: tuple[float, ...] = ()
    newton: Newton = NEWTON
    sought: tuple[Sought, ...] = ()

    def __post_init__(self) -> None:
        assert_ascending(self.start, self.stop)
        outside = [ratio for ratio in self.report_at if not self.start <= ratio <= self.stop]
        if outside:
            raise ModelError(
                f"report_at = {outside[0]:g}: must lie between {self.start:g} and {self.stop:g}"
            )

    @property
    def name(self) -> str:
        """Name of what is stepped."""
        return "gamma_ratio"

    @property
    def harmonic(self) -> int:
        """The mode is written in the first harmonic."""
        return 1

    @property
    def largest_ratio(self) -> float:
        """The last ratio."""
        return self.stop

    @property
    def certain_ratios(self) -> list[float]:
        """All of them."""
        return self.targets()

    def targets(self) -> list[float]:
        """Ratios to visit, ascending: equal steps no larger than `step`, and `report_at`."""
        return grid(self.start, self.stop, self.step, self.report_at)

    def lies_ahead(self, frequency_ratio: float) -> bool:
        """Any frequency may come."""
        return True

    def span(self, ahead: Callable[[], Outlook]) -> tuple[float, float]:
        """First and last ratio."""
        return self.start, self.stop

    def still_wanted(self, points: Iterable[BranchPoint]) -> tuple[BranchPoint, ...]:
        """Points between these; all of them where values of other quantities are sought."""
        if self.sought:
            return tuple(points)
        return tuple(p for p in points if inside(p.position, self.start, self.stop))

    def follow(self, cascade: Cascade, maker: PointMaker, progress: Progress) -> Followed:
        """Step from one energy to the next."""
        stepping = Stepping(cascade, maker, self.name, self.smallest_step, progress.on_point)
        stepping.take_over(progress.known)
        downwards = cascade.belonging.lifts_off
        stepping.run(self.targets(), progress.on_position, downwards=downwards)
        if not self.sought:
            return replace(stepping.ended(self.stop), of_energies=True)
        missing = Seeker(stepping, progress.measures, self.step).find(self.sought)
        last = max(stepping.points, default=self.stop)
        return stepping.ended(max(last, self.stop)).without(missing)
