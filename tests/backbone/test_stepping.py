"""Steps along a branch where motions are missing: how many are tried, and what is advised."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, cast

import pytest

from fenics_nnm.backbone.cascade_solution import CascadeSolution
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.backbone.point_maker import PointMaker
from fenics_nnm.backbone.stepping import Stepping
from fenics_nnm.nonlinear.solution import Solution


class Motion:
    def thinned(self) -> Motion:
        return self


@dataclass
class Hidden:
    """A solver without motions between two positions."""

    low: float
    high: float
    tried: list[float] = field(default_factory=list)

    def at(self, position: float, neighbour: CascadeSolution | None) -> CascadeSolution:
        self.tried.append(position)
        motion = None if self.low < position < self.high else cast(Solution, Motion())
        return CascadeSolution(position, position, (motion,), failure="" if motion else "hidden")

    def restored(self, position: float, finest: Solution) -> CascadeSolution:
        raise NotImplementedError


class Maker:
    def point(self, position: float, *arguments: Any, **named: Any) -> BranchPoint:
        return cast(BranchPoint, position)


def stepping(solver: Hidden, targets: list[float]) -> Stepping:
    points = Stepping(solver, cast(PointMaker, Maker()), "gamma_ratio", 0.005, lambda point: None)
    points.run(targets, lambda position: None)
    return points


def test_steps_over_a_position_that_was_missed_are_not_halved() -> None:
    targets = [round(1 + number / 10, 1) for number in range(21)]
    found = stepping(solver := Hidden(1.0, 3.0), targets)
    assert sorted(found.failures) == targets[1:-1]
    # upwards 21 targets, and half steps before the first one that is missed
    assert solver.tried[:6] == pytest.approx([1.0, 1.1, 1.05, 1.025, 1.0125, 1.00625])
    upwards = solver.tried[: solver.tried.index(3.0) + 1]
    assert len(upwards) == 21 + 4
    # downwards the same, from the other side, but for the target that has a point
    assert len(solver.tried) - len(upwards) == 19 + 4


def test_steps_that_had_to_be_halved_grow_again() -> None:
    @dataclass
    class Short(Hidden):
        """Steps over 0.03 fail up to 1.09; beyond they may be of any length."""

        def at(self, position: float, neighbour: CascadeSolution | None) -> CascadeSolution:
            far = neighbour is not None and position - neighbour.position > 0.03
            hidden = far and neighbour is not None and neighbour.position < 1.09
            self.low, self.high = (0.0, 9.0) if hidden else (9.0, 9.0)
            return Hidden.at(self, position, neighbour)

    found = stepping(solver := Short(9.0, 9.0), [1.0, 1.4])
    assert found.failures == {}
    expected = [1.0, 1.4, 1.2, 1.1, 1.05, 1.025, 1.05, 1.1, 1.075, 1.1, 1.15, 1.25, 1.4]
    assert solver.tried == pytest.approx(expected)


def test_a_target_is_given_up_after_many_attempts() -> None:
    @dataclass
    class Crawling(Hidden):
        """Steps lead ever less far."""

        def at(self, position: float, neighbour: CascadeSolution | None) -> CascadeSolution:
            far = neighbour is not None and position - neighbour.position > 0.009
            self.low, self.high = (0.0, 9.0) if far else (9.0, 9.0)
            return Hidden.at(self, position, neighbour)

    found = stepping(Crawling(9.0, 9.0), [1.0, 2.0])
    assert found.failures == {2.0: "given up after 16 attempts: hidden"}


def test_halved_steps_reach_a_target_beside_a_gap() -> None:
    @dataclass
    class Reluctant(Hidden):
        def at(self, position: float, neighbour: CascadeSolution | None) -> CascadeSolution:
            near = neighbour is None or abs(position - neighbour.position) < 0.03
            self.low, self.high = (9.0, 9.0) if near else (0.0, 9.0)
            return Hidden.at(self, position, neighbour)

    found = stepping(Reluctant(9.0, 9.0), [1.0, 1.1, 1.2])
    assert found.failures == {} and {1.0, 1.1, 1.2} <= set(found.points)
