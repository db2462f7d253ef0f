"""Motions of a main branch at which a quantity, such as the largest stress, has a given value."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from fenics_nnm.backbone.cascade_solution import CascadeSolution
from fenics_nnm.backbone.quantities import UNITS, Measures, Sought
from fenics_nnm.backbone.stepping import Stepping
from fenics_nnm.errors import ConvergenceError

#: Gamma ratios are found to this part, and values met to this one.
_FOUND, _MET = 1e-8, 1e-5

#: The branch is followed further by factors up to this one, so often at most.
_LONGEST, _ROUNDS = 2.0, 16

#: Larger gamma ratios are not tried.
_LARGEST = 1e4


@dataclass(slots=True)
class Seeker:
    """Run state of the search along a branch that is followed in steps of the gamma ratio.

    Attributes:
        stepping: The branch so far.
        measures: Quantities of motions.
        step: Largest step of the gamma ratio up to 1, from where on steps grow with it.
    """

    stepping: Stepping
    measures: Measures
    step: float
    _values: dict[tuple[str, float], float] = field(default_factory=dict)
    _latest: CascadeSolution | None = None

    def find(self, sought: Sequence[Sought]) -> tuple[tuple[float, str], ...]:
        """Have points at all values; frequencies come last, which the branch may never reach.

        Returns:
            The gamma ratios that were tried last for values without a point, with the reasons.
        """
        for ratio, point in self.stepping.points.items():  # of an earlier run
            self.stepping.points[ratio] = replace(point, notes=replace(point.notes, asked=""))
        failures = []
        for each in sorted(sought, key=lambda each: each.quantity == "frequency"):
            try:
                self._find(each)
            except ConvergenceError as error:
                failures.append((self._passed(each)[-1][0], f"{each}: {error}"))
        return tuple(failures)

    def _find(self, sought: Sought) -> None:
        """Have a point at every crossing of a value.

        Raises:
            ConvergenceError: if the branch has none, or a motion there is not found.
        """
        if not self.stepping.points or np.isnan(self._passed(sought)[0][1]):
            raise ConvergenceError(f"{sought.quantity} is not known of this structure")
        self._go_there(sought)
        crossings = self._crossings(sought)
        if not crossings:
            low, high = min(self._of(sought)), max(self._of(sought))
            raise ConvergenceError(
                f"has no motion: the branch that was found has {low:.6g} to {high:.6g} "
                f"{UNITS[sought.quantity]}"
            )
        for number, ends in enumerate(crossings, start=1):
            which = f", {number} of {len(crossings)}" if len(crossings) > 1 else ""
            ratio = self._crossing(sought, ends)
            if sought.reported:
                self._mark(ratio, f"{sought}{which}")

    def _mark(self, ratio: float, asked: str) -> None:
        point = self.stepping.points[ratio]
        listed = "; ".join(text for text in (point.notes.asked, asked) if text)
        self.stepping.points[ratio] = replace(point, notes=replace(point.notes, asked=listed))

    def _crossing(self, sought: Sought, ends: tuple[float, float]) -> float:
        """Gamma ratio of a point that has a value, made if there is none.

        Raises:
            ConvergenceError: if the motion is not found, or the branch jumps over the value.
        """
        if ends[0] == ends[1]:
            return ends[0]

        def excess(ratio: float) -> float:
            if ratio in ends:
                return float(np.log(self._value(sought, ratio) / sought.value))
            return float(np.log(self._measured(sought, ratio)[1] / sought.value))

        from scipy.optimize import brentq  # takes 0.1 s, which `check` has no use for

        ratio = float(brentq(excess, *ends, xtol=_FOUND * ends[0], rtol=_FOUND))
        solved, value = self._measured(sought, ratio)
        if self._off(sought, value) > _MET:
            raise ConvergenceError(
                f"the branch jumps over it at gamma ratio {ratio:.6g}, where it has {value:.6g} "
                f"{UNITS[sought.quantity]}"
            )
        self.stepping.accept(solved)
        return ratio

    def _measured(self, sought: Sought, ratio: float) -> tuple[CascadeSolution, float]:
        """The motion of a gamma ratio and its quantity.

        Raises:
            ConvergenceError: if none is found.
        """
        solved = self._latest
        if solved is None or solved.position != ratio:
            self._latest = solved = self._solved(ratio)
        assert solved.finest is not None
        motion = self.stepping.maker.motion(solved.finest)
        return solved, self.measures[sought.quantity](motion)

    def _solved(self, ratio: float) -> CascadeSolution:
        """The motion of a gamma ratio.

        Raises:
            ConvergenceError: if none is found.
        """
        solutions = self.stepping.solutions
        nearest = solutions[min(solutions, key=lambda other: abs(other - ratio))]
        found = self.stepping.solver.at(ratio, nearest)
        if found.finest is None:
            raise ConvergenceError(f"gamma ratio {ratio:.6g}: {found.failure}")
        return found

    def _crossings(self, sought: Sought) -> list[tuple[float, float]]:
        """Gamma ratios of neighbours that a value lies between; twice that of a point with it."""
        passed = self._passed(sought)
        hits = {ratio for ratio, value in passed if self._off(sought, value) <= _MET}
        found = [
            (low, high)
            for (low, below), (high, above) in pairwise(passed)
            if min(below, above) < sought.value < max(below, above) and not hits & {low, high}
        ]
        return sorted(found + [(ratio, ratio) for ratio in hits])

    def _go_there(self, sought: Sought) -> None:
        """Follow the branch further, down or up, until it passes a value that grows with energy."""
        if sought.quantity == "frequency":
            return
        for _ in range(_ROUNDS):
            passed = self._passed(sought)
            if passed[-1][0] >= _LARGEST:
                return
            if passed[0][1] > sought.value:
                start, stop = self._expected(sought, passed[:2]), passed[0][0]
                steps = [max(start, stop / _LONGEST)]
            elif max(self._of(sought)) < sought.value:
                start, stop = passed[-1][0], self._expected(sought, passed[-2:])
                steps = self._steps(start, min(stop, start * _LONGEST))
            else:
                return
            failed = dict(self.stepping.failures)
            self.stepping.run(steps, lambda _: None)
            self.stepping.failures = failed  # nobody asked for these energies
            if len(self._passed(sought)) == len(passed):
                return

    def _expected(self, sought: Sought, ends: Sequence[tuple[float, float]]) -> float:
        """Gamma ratio beyond a value, by the power that two points lie on; of one, a root."""
        (low, below), (high, above) = ends[0], ends[-1]
        power = np.log(above / below) / np.log(high / low) if high > low else 0.5
        up = sought.value > above
        if not power > 0.05:
            return high * _LONGEST if up else low / _LONGEST
        ratio = high * (sought.value / above) ** (1 / power)
        return float(ratio * 1.02 if up else ratio / 1.02)

    def _steps(self, start: float, stop: float) -> list[float]:
        """Gamma ratios from one, left out, to another, ascending."""
        found, at = [], start
        while at < stop:
            at = min(stop, at + self.step * max(1.0, 2 * at - 1))
            found.append(at)
        return found

    def _of(self, sought: Sought) -> list[float]:
        return [value for _, value in self._passed(sought)]

    def _passed(self, sought: Sought) -> list[tuple[float, float]]:
        """Gamma ratios that have a point, ascending, and the quantity there."""
        return [(ratio, self._value(sought, ratio)) for ratio in sorted(self.stepping.points)]

    def _value(self, sought: Sought, ratio: float) -> float:
        key = sought.quantity, ratio
        if key not in self._values:
            motion = self.stepping.points[ratio].motion
            self._values[key] = self.measures[sought.quantity](motion)
        return self._values[key]

    @staticmethod
    def _off(sought: Sought, value: float) -> float:
        """How far a value is from that sought, relative to it."""
        return abs(value / sought.value - 1)
