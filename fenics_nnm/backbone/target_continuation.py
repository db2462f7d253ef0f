"""Motions of a main branch at which its energy, or largest displacement, has given values."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from fenics_nnm.backbone.cascade import Cascade
from fenics_nnm.backbone.cascade_solution import CascadeSolution
from fenics_nnm.backbone.outlook import Outlook
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.backbone.point_maker import PointMaker
from fenics_nnm.backbone.stepping import Stepping
from fenics_nnm.backbone.wanted import NEWTON, Followed, Progress
from fenics_nnm.errors import ConvergenceError, ModelError
from fenics_nnm.mechanics.motion import Motion
from fenics_nnm.nonlinear.newton import Newton

#: Gamma ratios that show how the quantity grows.
_FIRST = (0.4, 0.5)

#: From this gamma ratio on the branch is followed in steps.
_STEPS_FROM = 0.7

#: Larger gamma ratios are not tried.
_LARGEST = 1e4

#: The last gamma ratio is raised so often at most, each time by this factor at least.
_ROUNDS, _RAISE = 12, 1.05

#: A wanted value is met to this part.
_MET = 1e-9


@dataclass(frozen=True, slots=True)
class TargetContinuation:
    """Which values of a quantity to visit; it grows along the branch.

    Attributes:
        targets: Values, positive and ascending. They are the positions of the points.
        quantity: The quantity of a motion in SI units, such as its energy.
        name: Name of the quantity.
        step: Largest step of the gamma ratio up to 1, from where on steps grow with it.
        smallest_step: A step that fails is halved down to this.
        newton: Newton's configuration.
    """

    targets: tuple[float, ...]
    quantity: Callable[[Motion], float]
    name: str
    step: float = 0.1
    smallest_step: float = 0.005
    newton: Newton = NEWTON

    def __post_init__(self) -> None:
        values = (0.0, *self.targets)
        if not self.targets or any(low >= high for low, high in pairwise(values)):
            raise ModelError(f"{self.name} {self.targets}: must be positive and ascend")

    @property
    def start(self) -> float:
        """Where the branch begins."""
        return 0.0

    @property
    def stop(self) -> float:
        """The last value."""
        return self.targets[-1]

    @property
    def harmonic(self) -> int:
        """The mode is written in the first harmonic."""
        return 1

    @property
    def largest_ratio(self) -> float:
        """Gamma ratio to look ahead to."""
        return _LARGEST

    @property
    def certain_ratios(self) -> list[float]:
        """None is known before."""
        return []

    def lies_ahead(self, frequency_ratio: float) -> bool:
        """Any frequency may come."""
        return True

    def span(self, ahead: Callable[[], Outlook]) -> tuple[float, float]:
        """Not known before."""
        return float("nan"), float("nan")

    def still_wanted(self, points: Iterable[BranchPoint]) -> tuple[BranchPoint, ...]:
        """Points at these values."""
        return tuple(p for p in points if p.position in self.targets)

    def follow(self, cascade: Cascade, maker: PointMaker, progress: Progress) -> Followed:
        """Step until the quantity is above all values, then solve for each of them."""
        plain = replace(maker, error=lambda _: None, series_error=lambda _: None)
        stepping = Stepping(cascade, plain, "gamma_ratio", self.smallest_step, lambda _: None)
        search = _Search(self, cascade, maker, stepping)
        search.pass_all()
        points, failures = list(progress.known), []
        known = {point.position for point in points}
        for target in (value for value in self.targets if value not in known):
            try:
                points.append(search.at(target))
                progress.on_point(points[-1])
            except ConvergenceError as error:
                failures.append((target, str(error)))
            progress.on_position(target)
        points.sort(key=lambda point: point.position)
        return Followed(tuple(points), tuple(failures), self._reason(failures))

    def _reason(self, failures: Sequence[tuple[float, str]]) -> str:
        if not failures:
            return f"reached {self.name} {self.stop:g}"
        missing = ", ".join(f"{value:g}" for value, _ in failures)
        return f"no point at {self.name} {missing}: {failures[0][1]}"


@dataclass(slots=True)
class _Search:
    """Run state: points in steps of the gamma ratio, between which values are sought.

    Attributes:
        wanted: Values of the quantity.
        cascade: Levels, and their motions of given gamma ratio.
        maker: Makes points of solutions.
        stepping: Points in steps, without error estimates.
    """

    wanted: TargetContinuation
    cascade: Cascade
    maker: PointMaker
    stepping: Stepping
    _values: dict[float, float] = field(default_factory=dict)

    def pass_all(self) -> None:
        """Step from below the first value to above the last one, as far as the branch can go."""
        self.stepping.run(_FIRST, lambda _: None)
        if len(self._passed()) < 2:
            return
        self._begin_below(self.wanted.targets[0])
        start = high = _FIRST[-1]
        for _ in range(_ROUNDS):
            ratios, values = zip(*self._passed(), strict=True)
            if values[-1] >= self.wanted.stop or ratios[-1] < high or high >= _LARGEST:
                return
            high = max(_RAISE * high, _RAISE * self._expected(self.wanted.stop))
            high = min(high, _LARGEST)
            self.stepping.run(self._steps(start, high), lambda _: None)
            start = high

    def _begin_below(self, target: float) -> None:
        """Have a point below a value."""
        for _ in range(_ROUNDS):
            lowest, value = self._passed()[0]
            if value <= target:
                return
            self.stepping.run([min(lowest, self._expected(target)) / _RAISE], lambda _: None)

    def at(self, target: float) -> BranchPoint:
        """The point at a value.

        Raises:
            ConvergenceError: if the branch does not come there, or a motion is not found.
        """
        low, high = self._around(target)

        def excess(ratio: float) -> float:
            return float(np.log(self._value(self._solved(ratio)) / target))

        from scipy.optimize import brentq  # takes 0.1 s, which `check` has no use for

        ratio = float(brentq(excess, low, high, xtol=_MET * low, rtol=_MET))
        found = self._solved(ratio)
        assert found.finest is not None
        return self.maker.point(
            target,
            found.gamma_ratio,
            found.finest.completed(self.maker.equations),
            skipped=found.skipped,
            slope_ratio=found.slope_ratio,
        )

    def _around(self, target: float) -> tuple[float, float]:
        """Gamma ratios of the first two neighbours that a value lies between."""
        passed = self._passed()
        for (low, below), (high, above) in pairwise(passed):
            if below <= target <= above:
                return low, high
        name, failures = self.wanted.name, self.stepping.failures
        where = f"{name} {passed[-1][1]:.6g} is the largest" if passed else f"there is no {name}"
        tried = f"gamma ratio {passed[-1][0]:.6g}" if passed else "its beginning"
        why = f": {failures[max(failures)]}" if failures else ""
        raise ConvergenceError(f"{where} that the branch comes to, at {tried}{why}")

    def _solved(self, ratio: float) -> CascadeSolution:
        """The motion of a gamma ratio.

        Raises:
            ConvergenceError: if none is found.
        """
        solutions = self.stepping.solutions
        nearest = solutions[min(solutions, key=lambda other: abs(other - ratio))]
        if nearest.position == ratio:
            return nearest
        found = self.cascade.at(ratio, nearest)
        if found.finest is None:
            raise ConvergenceError(f"gamma ratio {ratio:.6g}: {found.failure}")
        return found

    def _value(self, found: CascadeSolution) -> float:
        assert found.finest is not None
        return self.wanted.quantity(self.maker.motion(found.finest))

    def _passed(self) -> list[tuple[float, float]]:
        """Gamma ratios that have a point, ascending, and the quantity there."""
        for ratio, point in self.stepping.points.items():
            if ratio not in self._values:
                self._values[ratio] = self.wanted.quantity(point.motion)
        return sorted(self._values.items())

    def _expected(self, target: float) -> float:
        """Gamma ratio of a value, by the power that the last two points lie on."""
        passed = self._passed()
        (g, v), (above, w) = passed[:2] if target < passed[0][1] else passed[-2:]
        power = np.log(w / v) / np.log(above / g)
        if not power > 0:
            return above
        return float(above * np.exp(np.clip(np.log(target / w) / power, -30, 30)))

    def _steps(self, start: float, stop: float) -> list[float]:
        """Gamma ratios from one to another, ascending."""
        found, at = [start], max(start, _STEPS_FROM)
        while at < stop:
            found.append(at)
            at += self.wanted.step * max(1.0, 2 * at - 1)
        return sorted({*found, stop})
