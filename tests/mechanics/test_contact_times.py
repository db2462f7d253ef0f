"""Times of contact in a period, and exact integrals of contact forces between them."""

import numpy as np
import pytest

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.contact_law import Complementarity
from fenics_nnm.mechanics.contact_times import FreeMotion, forces_in_time
from fenics_nnm.mechanics.fourier import FourierSeries
from fenics_nnm.mechanics.instants import Quadrature

R = np.array([[0.5, 0.2, 0.1], [0.2, 0.6, 0.15], [0.1, 0.15, 0.4]])
GAP = np.array([0.6, 0.3, 0.9])


def harmonics_of(motion: FreeMotion) -> tuple[Quadrature, Array]:
    """The rule, and coefficients of the forces that it integrates."""
    found = forces_in_time(motion)
    rule = found.instants
    assert isinstance(rule, Quadrature)
    return rule, found.harmonics(motion.series)


@pytest.mark.parametrize("seed", range(4))
def test_harmonics_are_those_of_very_many_samples(seed: int) -> None:
    """Three coupled points; a million samples leave an error of 1e-11 of the harmonics."""
    series, law = FourierSeries(6, 48), Complementarity(R, GAP)
    decay = 1 / (1 + np.arange(13) % 7)[:, None]
    harmonics = np.random.default_rng(seed).normal(size=(13, 3)) * decay
    rule, found = harmonics_of(FreeMotion.of(series, harmonics, law))
    many = FourierSeries(6, 200_000)
    expected = many.analysis @ law(many.synthesis @ harmonics).force
    assert np.abs(expected).max() > 0.05
    np.testing.assert_allclose(found, expected, atol=1e-9)
    assert rule.share.sum() < 1


@pytest.mark.parametrize("seed", [12, 13, 18, 89])
def test_changes_of_several_points_between_two_samples_are_found(seed: int) -> None:
    """A point touches for a moment between two samples at which the others change, too."""
    series, many = FourierSeries(6, 14), FourierSeries(6, 20_000)
    law = Complementarity(R, GAP)
    harmonics = np.random.default_rng(seed).normal(size=(13, 3)) * 0.5
    _, found = harmonics_of(FreeMotion.of(series, harmonics, law))
    expected = many.analysis @ law(many.synthesis @ harmonics).force
    np.testing.assert_allclose(found, expected, atol=1e-6)


def test_points_that_close_together_cost_one_search() -> None:
    """Four points that move alike change at the same phases, as one."""
    series, alike = FourierSeries(3, 24), Complementarity(0.3 * np.eye(4), np.full(4, 0.5))
    harmonics = np.zeros((7, 4))
    harmonics[1] = 1.0
    found = forces_in_time(FreeMotion.of(series, harmonics, alike))
    assert (found.force > 0).all()
    one = Complementarity(np.array([[0.3]]), np.array([0.5]))
    alone = forces_in_time(FreeMotion.of(series, harmonics[:, :1], one))
    np.testing.assert_allclose(found.instants.phase, alone.instants.phase, atol=1e-12)


def test_force_of_one_point_is_the_closed_form() -> None:
    """p = cos against a gap of cos(a): mean force (sin a - a cos a) / (pi R)."""
    a, series = 0.4, FourierSeries(3, 16)
    harmonics = np.zeros((7, 1))
    harmonics[1] = 1.0
    law = Complementarity(np.array([[0.25]]), np.array([np.cos(a)]))
    rule, found = harmonics_of(FreeMotion.of(series, harmonics, law))
    assert found[0, 0] == pytest.approx((np.sin(a) - a * np.cos(a)) / (np.pi * 0.25), rel=1e-14)
    assert rule.share.sum() == pytest.approx(2 * a / (2 * np.pi), rel=1e-14)


def test_contact_between_two_samples_is_found() -> None:
    """The top lies in the middle between two of 16 samples, and neither of them touches."""
    series, a = FourierSeries(3, 16), 0.02
    shift = np.pi / 16
    harmonics = np.zeros((7, 1))
    harmonics[1], harmonics[4] = np.cos(shift), np.sin(shift)
    law = Complementarity(np.array([[1.0]]), np.array([np.cos(a)]))
    assert not law(series.synthesis @ harmonics).force.any()
    _, found = harmonics_of(FreeMotion.of(series, harmonics, law))
    assert found[0, 0] == pytest.approx((np.sin(a) - a * np.cos(a)) / np.pi, rel=1e-9)


def test_lift_off_between_two_samples_is_found() -> None:
    """A pressed point that lifts off for a moment."""
    series, a, shift = FourierSeries(3, 16), 0.02, np.pi / 16
    harmonics = np.zeros((7, 1))
    harmonics[1], harmonics[4] = -np.cos(shift), -np.sin(shift)
    law = Complementarity(np.array([[1.0]]), np.array([-np.cos(a)]))
    assert (law(series.synthesis @ harmonics).force > 0).all()
    rule, _ = harmonics_of(FreeMotion.of(series, harmonics, law))
    assert rule.share.sum() == pytest.approx(1 - a / np.pi, rel=1e-12)


def test_two_points_may_close_at_one_instant() -> None:
    series = FourierSeries(3, 16)
    harmonics = np.zeros((7, 2))
    harmonics[1] = 1.0
    law = Complementarity(np.diag([1.0, 2.0]), np.array([0.5, 0.5]))
    rule, found = harmonics_of(FreeMotion.of(series, harmonics, law))
    assert found[0, 0] == pytest.approx(2 * found[0, 1], rel=1e-8)
    assert rule.share.sum() == pytest.approx(1 / 3, rel=1e-8)


def test_points_that_stay_closed_have_the_whole_period() -> None:
    series = FourierSeries(3, 16)
    harmonics = np.zeros((7, 1))
    harmonics[:3, 0] = 2.0, 0.5, 0.3
    rule, found = harmonics_of(
        FreeMotion.of(series, harmonics, Complementarity(np.array([[0.5]]), np.array([1.0])))
    )
    assert rule.share.sum() == pytest.approx(1.0)
    np.testing.assert_allclose(found[:4, 0], [2.0, 1.0, 0.6, 0.0], atol=1e-13)


def test_motion_that_keeps_clear_has_no_points() -> None:
    series = FourierSeries(3, 16)
    rule, found = harmonics_of(FreeMotion.of(series, np.zeros((7, 3)), Complementarity(R, GAP)))
    assert not len(rule.phase) and not found.any()
