"""A branch over its frequency."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from fenics_nnm.backbone.cascade import Cascade
from fenics_nnm.backbone.frequency_sweep import FrequencySweep
from fenics_nnm.backbone.grid import grid
from fenics_nnm.backbone.outlook import Outlook
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.backbone.point_maker import PointMaker
from fenics_nnm.backbone.resonance import passing
from fenics_nnm.backbone.stepping import Stepping
from fenics_nnm.backbone.wanted import NEWTON, Followed, Progress, inside
from fenics_nnm.errors import ModelError
from fenics_nnm.nonlinear.newton import Newton

#: An outlook ends at this gamma ratio at the latest.
_LARGEST_RATIO = 1e4


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
    newton: Newton = NEWTON

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

    @property
    def harmonic(self) -> int:
        """The mode is written in the first harmonic."""
        return 1

    @property
    def largest_ratio(self) -> float:
        """It ends in frequency, so this is far away."""
        return _LARGEST_RATIO

    @property
    def certain_ratios(self) -> tuple[float, ...]:
        """Energies to report."""
        return self.report_at

    def targets(self) -> list[float]:
        """Ratios to visit, ascending: equal steps no larger than `step`."""
        return grid(self.start, self.stop, self.step)

    def lies_ahead(self, frequency_ratio: float) -> bool:
        """Whether the branch has not come to the frequency that is farthest from the mode's."""
        if self.start < 1:
            return frequency_ratio > self.start
        return frequency_ratio < self.stop

    def span(self, ahead: Callable[[], Outlook]) -> tuple[float, float]:
        """Energies where the followed mode alone has these frequencies."""
        branch = ahead()
        ends = (
            passing(ratio, branch.gamma_ratio, branch.frequency_ratio)
            for ratio in (self.start, self.stop)
        )
        first, last = sorted(ends)
        return first, last

    def still_wanted(self, points: Iterable[BranchPoint]) -> tuple[BranchPoint, ...]:
        """Points between these."""
        return tuple(p for p in points if inside(p.position, self.start, self.stop))

    def follow(self, cascade: Cascade, maker: PointMaker, progress: Progress) -> Followed:
        """Step from one frequency to the next; then add the energies to report."""
        sweep = FrequencySweep(cascade)
        stepping = Stepping(sweep, maker, self.name, self.smallest_step, progress.on_point)
        stepping.take_over(progress.known)
        stepping.run(self.targets(), progress.on_position)
        stepping.pass_energies(self.report_at, sweep.at_energy)
        return stepping.ended(self.stop)
