"""A branch by its length."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from itertools import takewhile

from fenics_nnm.backbone.arc_following import ArcFollowing, EnergyRange
from fenics_nnm.backbone.arc_start import ArcStart, ArcStarts, Begin
from fenics_nnm.backbone.cascade import Cascade
from fenics_nnm.backbone.grid import assert_ascending, grid
from fenics_nnm.backbone.outlook import Outlook
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.backbone.point_maker import PointMaker
from fenics_nnm.backbone.wanted import NEWTON, Followed, Progress, inside
from fenics_nnm.continuation.trace_options import ArcLength
from fenics_nnm.nonlinear.newton import Newton


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
    newton: Newton = NEWTON

    def __post_init__(self) -> None:
        assert_ascending(self.start, self.stop)

    @property
    def name(self) -> str:
        """Name of what bounds it."""
        return "gamma_ratio"

    @property
    def largest_ratio(self) -> float:
        """The highest ratio."""
        return self.stop

    @property
    def certain_ratios(self) -> tuple[float, ...]:
        """Energies to report."""
        return self.report_at

    def targets(self) -> list[float]:
        """Gamma ratios to hit at each passing."""
        if self.step is None:
            return sorted({self.start, self.stop, *self.report_at})
        return grid(self.start, self.stop, self.step, self.report_at)

    def lies_ahead(self, frequency_ratio: float) -> bool:
        """Any frequency may come."""
        return True

    def span(self, ahead: Callable[[], Outlook]) -> tuple[float, float]:
        """Lowest and highest ratio."""
        return self.start, self.stop

    def still_wanted(self, points: Iterable[BranchPoint]) -> tuple[BranchPoint, ...]:
        """Points up to where the branch leaves the range of energies."""
        within = takewhile(lambda p: inside(p.gamma_ratio, self.start, self.stop), points)
        return tuple(within)

    def follow(self, cascade: Cascade, maker: PointMaker, progress: Progress) -> Followed:
        """Follow the branch until it leaves the range of energies."""
        cascade.assert_any_condition("continuation by arc-length")
        energies = EnergyRange(self.start, self.stop, tuple(self.targets()), self.harmonic)
        known = sorted(progress.known, key=lambda point: point.position)
        branch = ArcFollowing(cascade, maker, energies, self.arc, progress.on_point, known)
        branch.run(self._beginning, progress.on_position)
        return branch.ended()

    def _beginning(self, starts: ArcStarts) -> ArcStart:
        """Where the branch begins, and which way it goes.

        Raises:
            NoStartError: if there is no motion.
        """
        if self.begin is not None:
            return starts.known(self.begin)
        if self.harmonic > 1 or starts.is_linear_at(self.start):
            return starts.linear(self.start, harmonic=self.harmonic)
        return starts.nonlinear(self.start)
