"""Numbers of points: damping that an unstable motion needs, and a stable one does not."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from fenics_nnm.backbone.point_numbers import damping_needed
from fenics_nnm.commands.run import stability_line
from fenics_nnm.time_domain.stability import COMPLEX, STABLE


def point(kind: str, multiplier: float) -> Any:
    stability = SimpleNamespace(kind=kind, largest_multiplier=multiplier)
    return SimpleNamespace(stability=stability, sustained=None)


def test_stable_points_need_no_damping_and_are_not_counted() -> None:
    """A multiplier that is off the unit circle by round-off is that of a stable motion."""
    points = [point(STABLE, 1 + 2.2e-16), point(COMPLEX, 1.1), point(COMPLEX, 1.05)]
    assert [damping_needed(each) for each in points] == pytest.approx(
        [0.0, np.log(1.1) / (2 * np.pi), np.log(1.05) / (2 * np.pi)], rel=1e-12
    )
    assert stability_line(points) == (
        "2 of 3 motions are unstable without damping; 1.5 % of critical damping "
        "(ln |mu| / 2 pi) holds all of them"
    )
    assert stability_line(points[:1]) == ""
