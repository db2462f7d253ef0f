"""What a structure does at frequencies where no stable motion of the response is known.

There the motion that repeats after each period of the force is not what a test shows. A simulation
from rest says what it shows instead: a motion that repeats after several periods, one that does not
repeat within those looked at (quasi-periodic, chaotic, or still on its way), or after all a stable
motion that the curves have not passed.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from fenics_nnm.response.judge import JudgeInTime
from fenics_nnm.response.point import ResponsePoint
from fenics_nnm.response.simulation import settled, simulation
from fenics_nnm.response.structure import DrivenStructure
from fenics_nnm.time_domain.driven_flow import driven_flow, has_equations_in_time

#: The motion from rest has decayed to this part of its size when it is looked at.
_DECAYED = 1e-3

#: Fewest and most periods of a simulation, and those at its end that are looked at.
_FEWEST, _MOST, _LOOKED_AT = 200, 400, 40

#: Most ranges of frequencies of a level that are simulated: the widest ones.
_RANGES = 3


@dataclass(frozen=True, slots=True)
class Instead:
    """What a structure does where no stable motion of the response is known.

    Attributes:
        level: Factor of the forces.
        low: Lowest frequency in Hz of the range without a stable motion.
        high: Highest one.
        frequency: Frequency of the simulation in Hz.
        periods: Number of its periods.
        repeats: Periods of the force after which its motion repeats; 0 if it does not.
        highest: Least and largest of the highest displacements in the last periods in m, of the
            first place that is watched.
        failure: Why it was given up, or nothing.
    """

    level: float
    low: float
    high: float
    frequency: float
    periods: int
    repeats: int
    highest: tuple[float, float]
    failure: str = ""

    def __str__(self) -> str:
        return (
            f"level {self.level:g}, {self.low:.6g} to {self.high:.6g} Hz: no motion that repeats "
            f"after each period of the force is known to be stable; {self._does}"
        )

    @property
    def _does(self) -> str:
        """What it does, in words."""
        begun = f"from rest at {self.frequency:.6g} Hz the structure"
        if self.failure:
            return f"the simulation from rest at {self.frequency:.6g} Hz was {self.failure}"
        if self.repeats == 1:
            return (
                f"{begun} comes to a stable one all the same, which the curves have not passed, of "
                f"{self.highest[1]:.4g} m"
            )
        if self.repeats:
            return (
                f"{begun} comes to a stable motion that repeats after {self.repeats} periods, of "
                f"{self.highest[1]:.4g} m"
            )
        return (
            f"{begun} has not come to a motion that repeats within {self.periods} periods; its "
            f"largest displacement in a period is {self.highest[0]:.4g} to {self.highest[1]:.4g} m"
        )


def instead(
    structure: DrivenStructure,
    level: float,
    points: Sequence[ResponsePoint],
) -> tuple[Instead, ...]:
    """Simulations from rest in the widest ranges of a level without a stable motion.

    Args:
        structure: Driven structure at level 1.
        level: Factor of the forces.
        points: Motions of the level.

    Returns:
        None where motions cannot be followed in time.
    """
    driven = structure.at_level(level)
    ranges = sorted(without_stable(points), key=lambda each: each[0] - each[1])[:_RANGES]
    if not ranges or not has_equations_in_time(driven.mechanics):
        return ()
    judge = JudgeInTime(driven.mechanics)
    return tuple(_simulated(driven, judge, level, ends) for ends in sorted(ranges))


def without_stable(points: Sequence[ResponsePoint]) -> Iterator[tuple[float, float]]:
    """Ranges of frequencies in Hz at which each motion is known to be unstable, ascending.

    Between two neighbours on a curve motions are taken to be stable, unless both are unstable.
    """
    pairs = list(_neighbours(points))
    covered = sorted(_range(*pair) for pair in pairs if not all(map(_unstable, pair)))
    ends = [_range(*pair) for pair in pairs]
    low, high = min((e[0] for e in ends), default=0.0), max((e[1] for e in ends), default=0.0)
    reached = low
    for begin, end in [*covered, (high, high)]:
        if begin > reached:
            yield reached, begin
        reached = max(reached, end)


def _neighbours(
    points: Sequence[ResponsePoint],
) -> Iterator[tuple[ResponsePoint, ResponsePoint]]:
    for first, second in itertools.pairwise(points):
        if first.branch == second.branch and first.found and second.found:
            yield first, second


def _range(first: ResponsePoint, second: ResponsePoint) -> tuple[float, float]:
    frequencies = first.frequency, second.frequency
    return min(frequencies), max(frequencies)


def _unstable(point: ResponsePoint) -> bool:
    return point.judgement.stability not in ("", "stable")


def _simulated(
    driven: DrivenStructure, judge: JudgeInTime, level: float, ends: tuple[float, float]
) -> Instead:
    """What the structure does from rest in the middle of a range."""
    frequency, flow = sum(ends) / 2, driven_flow(driven.mechanics, 1.0)
    decay = -judge.slowest / frequency
    periods = int(np.clip(-np.log(_DECAYED) / decay, _FEWEST, _MOST)) if decay > 0 else _MOST
    rest = np.zeros(len(driven.model.omega))
    found = simulation(flow, driven.watched, np.full(periods, frequency), (rest, rest))
    heights = [float(period.largest[0]) for period in found.periods[-_LOOKED_AT:]] or [float("nan")]
    repeats = 0
    if not found.failure:
        repeats = settled(flow, found.q, found.velocity, frequency).periods
    return Instead(
        level=level,
        low=ends[0],
        high=ends[1],
        frequency=frequency,
        periods=len(found.periods),
        repeats=repeats,
        highest=(min(heights), max(heights)),
        failure=found.failure,
    )
