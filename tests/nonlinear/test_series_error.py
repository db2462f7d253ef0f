"""Errors of the series in time against motions of finer series."""

import numpy as np
import pytest

from fenics_nnm.arrays import Array
from fenics_nnm.backbone.follow import EnergyContinuation, FullOrder, follow
from fenics_nnm.backbone.levels import HarmonicBalance
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.mechanics.contact_points import MASSIVE
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.nonlinear.series_error import HOLDS
from fenics_nnm.reduction.flexibility import ResidualFlexibility

#: The bilinear oscillator, and three modes with two contact points that interact.
BILINEAR = ReducedModel([np.sqrt(10.0)], [[1.0]], [[1 / 50]], [0.01])
THREE = ReducedModel(
    omega=[1.0, 2.62, 6.31],
    Phi=[[1.0, -0.6, 0.5], [0.7, 0.4, -0.8]],
    R=[[0.06, 0.02], [0.02, 0.05]],
    gap=[1.0, 0.9],
)


def beyond_grazing(
    model: ReducedModel, harmonics: int, samples: int, **more: bool
) -> list[BranchPoint]:
    energies = EnergyContinuation(1.02, 1.92, 0.3)
    branch = follow(model, energies, HarmonicBalance(harmonics, samples, **more), mode=0)
    assert branch.complete and len(branch.points) == 4
    return list(branch.points)


def frequencies(points: list[BranchPoint]) -> Array:
    return np.array([point.motion.frequency for point in points])


@pytest.mark.parametrize(
    ("model", "harmonics", "samples"), [(BILINEAR, 5, 64), (BILINEAR, 9, 256), (THREE, 8, 128)]
)
def test_prediction_is_the_change_to_a_finer_series(
    model: ReducedModel, harmonics: int, samples: int
) -> None:
    coarse = beyond_grazing(model, harmonics, samples)
    dense = frequencies(beyond_grazing(model, harmonics, 4 * samples))
    fine = frequencies(beyond_grazing(model, 3 * harmonics, 4 * samples))
    by_samples = frequencies(coarse) / dense - 1
    by_harmonics = dense / fine - 1
    assert max(point.expected.series.remainder for point in coarse) < HOLDS
    _assert_near([point.expected.series.samples for point in coarse], by_samples)
    _assert_near([point.expected.series.harmonics for point in coarse], by_harmonics)


def _assert_near(predicted: list[float], true: Array) -> None:
    """Each within a quarter of the largest, and the largest within a quarter of itself."""
    assert np.abs(true).max() > 1e-6
    assert np.abs(predicted - true).max() < np.abs(true).max() / 4


def test_general_series_has_the_errors_of_the_time_reversible_one() -> None:
    reversible = beyond_grazing(THREE, 5, 64)
    general = beyond_grazing(THREE, 5, 64, general=True)
    for one, other in zip(reversible, general, strict=True):
        assert one.expected.series.harmonics == pytest.approx(
            other.expected.series.harmonics, rel=1e-6
        )
        assert one.expected.series.samples == pytest.approx(other.expected.series.samples, rel=1e-6)
        assert one.expected.series.remainder == pytest.approx(
            other.expected.series.remainder, rel=1e-4
        )


def test_no_error_without_contact_and_none_known_of_points_with_mass() -> None:
    below = follow(THREE, EnergyContinuation(0.8, 0.9, 0.1), HarmonicBalance(5, 64), mode=0)
    for point in below.points:
        assert (
            point.expected.series.harmonics,
            point.expected.series.samples,
            point.expected.series.remainder,
        ) == (0, 0, 0)
    carrying = ReducedModel(THREE.omega, THREE.Phi[:1], [[0.0]], THREE.gap[:1], contact=MASSIVE)
    found = follow(carrying, EnergyContinuation(0.8, 1.2, 0.4), HarmonicBalance(3, 64), mode=0)
    assert found.points
    for point in found.points:
        assert point.expected.series is None


def test_at_full_order() -> None:
    """Three explicit modes, and one above all harmonics that brings half of R."""
    square, shape = 40.0**2, 40.0 * np.sqrt([0.03, 0.025])

    def points(harmonics: int, samples: int) -> list[BranchPoint]:
        def source(omega: float) -> ResidualFlexibility:
            s = (np.arange(harmonics + 1) * omega) ** 2
            parts = [1 / (square - s) - 1 / square, 1 / (square - s) ** 2, 1 / (square - s) ** 3]
            blocks = [part[:, None, None] * np.outer(shape, shape) for part in parts]
            return ResidualFlexibility(s, *blocks)

        energies = EnergyContinuation(1.02, 1.92, 0.3)
        balance = HarmonicBalance(harmonics, samples)
        return list(follow(THREE, energies, balance, mode=0, order=FullOrder(source)).points)

    coarse, fine = points(8, 64), points(16, 256)
    true = frequencies(coarse) / frequencies(fine) - 1
    _assert_near(
        [point.expected.series.harmonics + point.expected.series.samples for point in coarse], true
    )
