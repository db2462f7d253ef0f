"""What a long branch keeps in memory."""

from __future__ import annotations

import numpy as np
import pytest

from fenics_nnm.backbone.cascade import Cascade
from fenics_nnm.backbone.levels import HarmonicBalance, levels
from fenics_nnm.backbone.memory import forget_oldest
from fenics_nnm.backbone.point_maker import PointMaker
from fenics_nnm.backbone.stepping import Stepping
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
    cascade = Cascade(stacked, 0, Newton())
    equations = stacked[-1].equations
    maker = PointMaker(equations, scales, lambda found: None, lambda found: None)
    stepping = Stepping(cascade, maker, "gamma_ratio", 0.005, lambda point: None)
    stepping.run([1.2 + 0.01 * step for step in range(70)], lambda position: None)
    assert len(stepping.points) == 70 and not stepping.failures
    whole = cascade.at(1.2, None).solutions[-1]
    assert whole is not None and whole.forces.flexibility.size > 0
    kept = list(stepping.solutions.values())
    for each in kept:
        assert all(found.forces.local is None for found in each.solutions if found)
    with_levels = [each for each in kept if all(each.solutions)]
    assert with_levels == kept[-60:]
    thinned = with_levels[-1].finest
    assert thinned is not None
    with pytest.raises(ValueError, match="without their derivative"):
        equations.jacobian(thinned.at, thinned.forces)
    for each in kept[:-60]:
        assert each.finest is not None and not any(each.solutions[:-1])
    assert len(cascade._alone) <= 8


def test_the_oldest_entries_are_forgotten_first() -> None:
    known = {3.0: "a", 1.0: "b", 2.0: "c"}
    forget_oldest(known, 2)
    assert known == {1.0: "b", 2.0: "c"}
    forget_oldest(known, 5)
    assert len(known) == 2
