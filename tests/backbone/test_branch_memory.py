"""What a long branch keeps in memory."""

from __future__ import annotations

import numpy as np
import pytest

from fenics_nnm.backbone.cascade import Lift
from fenics_nnm.backbone.levels import HarmonicBalance, levels
from fenics_nnm.backbone.march import March
from fenics_nnm.backbone.memory import forget_oldest
from fenics_nnm.backbone.point_maker import PointMaker
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.nonlinear.newton import Newton

POINTS = 8


def tip() -> ReducedModel:
    s = (np.arange(POINTS) + 0.5) / POINTS
    order = np.arange(3)
    return ReducedModel(
        omega=np.sqrt(1 + (1.7321 * order) ** 2),
        Phi=np.cos(np.pi * order * s[:, None]) * np.where(order == 0, 1.0, 0.7),
        R=2 * np.exp(-np.abs(s[:, None] - s) / 0.15),
        gap=1 + 0.3 * (2 * s - 1) ** 2,
    )


def test_only_the_latest_motions_are_kept_with_all_that_they_were_found_with() -> None:
    model, scales = tip().dimensionless()
    stacked = levels(model, HarmonicBalance(3, 32), mode=0)
    lift = Lift(stacked, 0, Newton())
    equations = stacked[-1].equations
    maker = PointMaker(equations, scales, lambda found: None, lambda found: None)
    march = March(lift, maker, "gamma_ratio", 0.005, lambda point: None)
    march.run([1.2 + 0.01 * step for step in range(70)], lambda place: None)
    assert len(march.points) == 70 and not march.failures
    whole = lift.at(1.2, None).solutions[-1]
    assert whole is not None and whole.forces.flexibility.size > 0
    kept = list(march.stacks.values())
    for stack in kept:
        assert all(found.forces.local is None for found in stack.solutions if found)
    with_levels = [stack for stack in kept if all(stack.solutions)]
    assert with_levels == kept[-60:]
    thinned = with_levels[-1].finest
    assert thinned is not None
    with pytest.raises(ValueError, match="without their derivative"):
        equations.jacobian(thinned.at, thinned.forces)
    for stack in kept[:-60]:
        assert stack.finest is not None and not any(stack.solutions[:-1])
    assert len(lift._alone) <= 8


def test_the_oldest_entries_are_forgotten_first() -> None:
    known = {3.0: "a", 1.0: "b", 2.0: "c"}
    forget_oldest(known, 2)
    assert known == {1.0: "b", 2.0: "c"}
    forget_oldest(known, 5)
    assert len(known) == 2
