"""Steps along a branch where motions are missing: how many are tried, and what is advised."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, cast

import pytest

from fenics_nnm.backbone.advice import advice
from fenics_nnm.backbone.cascade import Stack
from fenics_nnm.backbone.march import March
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.backbone.point_maker import PointMaker
from fenics_nnm.backbone.targets import (
    ArcContinuation,
    Continuation,
    EnergyContinuation,
    FrequencyContinuation,
)
from fenics_nnm.mechanics.fourier import CosineSeries
from fenics_nnm.nonlinear.solution import Solution


class Motion:
    def thinned(self) -> Motion:
        return self


@dataclass
class Hidden:
    """A course without motions between two places."""

    low: float
    high: float
    tried: list[float] = field(default_factory=list)

    def at(self, place: float, neighbour: Stack | None) -> Stack:
        self.tried.append(place)
        motion = None if self.low < place < self.high else cast(Solution, Motion())
        return Stack(place, place, (motion,), failure="" if motion else "hidden")

    def restored(self, place: float, finest: Solution) -> Stack:
        raise NotImplementedError


class Maker:
    def point(self, place: float, *arguments: Any, **named: Any) -> BranchPoint:
        return cast(BranchPoint, place)


def march(course: Hidden, targets: list[float]) -> March:
    points = March(course, cast(PointMaker, Maker()), "gamma_ratio", 0.005, lambda point: None)
    points.run(targets, lambda place: None)
    return points


def test_steps_over_a_place_that_was_missed_are_not_halved() -> None:
    targets = [round(1 + number / 10, 1) for number in range(21)]
    found = march(course := Hidden(1.0, 3.0), targets)
    assert sorted(found.failures) == targets[1:-1]
    # upwards 21 targets, and half steps before the first one that is missed
    assert course.tried[:6] == pytest.approx([1.0, 1.1, 1.05, 1.025, 1.0125, 1.00625])
    upwards = course.tried[: course.tried.index(3.0) + 1]
    assert len(upwards) == 21 + 4
    # downwards the same, from the other side, but for the target that has a point
    assert len(course.tried) - len(upwards) == 19 + 4


def test_halved_steps_reach_a_target_beside_a_gap() -> None:
    @dataclass
    class Reluctant(Hidden):
        def at(self, place: float, neighbour: Stack | None) -> Stack:
            near = neighbour is None or abs(place - neighbour.place) < 0.03
            self.low, self.high = (9.0, 9.0) if near else (0.0, 9.0)
            return Hidden.at(self, place, neighbour)

    found = march(Reluctant(9.0, 9.0), [1.0, 1.1, 1.2])
    assert found.failures == {} and {1.0, 1.1, 1.2} <= set(found.points)


@pytest.mark.parametrize(
    ("continuation", "samples", "words"),
    [
        (EnergyContinuation(0.8, 2.0, 0.1), 7, "raise mode.samples = 7,"),
        (EnergyContinuation(0.8, 2.0, 0.1), 64, "mode.harmonics, or fewer reduction.modes"),
        (FrequencyContinuation(1.1, 1.5, 0.1), 128, "to all continuation.frequencies; another"),
        (FrequencyContinuation(1.1, 1.5, 0.1), 9, "to all continuation.frequencies; raise mode"),
        (ArcContinuation(0.8, 2.0), 128, "keys of continuation.arc_length"),
    ],
)
def test_keys_are_named_where_motions_are_missing(
    continuation: Continuation, samples: int, words: str
) -> None:
    assert words in advice(continuation, CosineSeries(3, samples))
