"""Approach of places to their obstacles: contact points themselves, and places between them."""

import numpy as np

from fenics_nnm.mechanics.approach import Approach, Places
from fenics_nnm.mechanics.model import ReducedModel


def model(gap: list[float]) -> ReducedModel:
    """Three modes and four points, coupled by their residual flexibility."""
    random = np.random.default_rng(5)
    Phi, root = random.normal(size=(4, 3)), random.normal(size=(4, 4))
    R = 1e-2 * (root @ root.T + np.eye(4))
    return ReducedModel(omega=np.array([1.0, 2.0, 4.0]), Phi=Phi, R=R, gap=np.array(gap))


def places(of: ReducedModel, point: list[int]) -> Places:
    return Places(of.Phi, of.R, of.gap, np.array(point))


def test_contact_points_come_as_near_as_their_model_says() -> None:
    free = model([0.3, 0.2, 0.5, 0.4])
    found = places(free, [0, 1, 2, 3]).approach(free.at_rest(), 1)
    np.testing.assert_array_equal(found.clearance, free.gap)
    np.testing.assert_array_equal(found.motion, free.Phi[:, 1])
    assert found.reach.min() == free.grazing_amplitude(1)
    assert np.argmin(found.reach) == free.at_rest().first(1)


def test_open_points_of_a_pressed_model_come_as_near_as_it_says() -> None:
    pressed = model([-0.2, 0.5, 0.6, 0.4])
    rest = pressed.at_rest()
    np.testing.assert_array_equal(rest.closed, [True, False, False, False])
    found = places(pressed, [0, 1, 2, 3]).approach(rest, 2)
    np.testing.assert_allclose(found.clearance[1:], rest.clearance[1:], rtol=1e-12)
    np.testing.assert_allclose(found.motion[1:], -rest.gradient[1:, 2], rtol=1e-12)
    assert found.clearance[0] == np.inf
    nearest = found.reach[1:].min()
    event = rest.amplitude(2)
    assert nearest == event or rest.at_one(2) == "lift-off"


def test_places_of_pressed_points_and_shallow_ones_meet_nothing_anew() -> None:
    pressed = model([-0.2, 0.5, 0.6, 0.4])
    rest = pressed.at_rest()
    beyond = rest.clearance[1] + np.array([1e-3, 0.19])
    gap = np.array([-0.2, *(0.5 - beyond)])
    rows = [0, 1, 1]
    near = Places(pressed.Phi[rows], pressed.R[rows], gap, np.array([0, 1, 2]))
    clearance = near.approach(rest, 0).clearance
    np.testing.assert_allclose(clearance, [np.inf, np.inf, -0.19])
    of_pressed = Places(pressed.Phi[rows], pressed.R[rows], gap, np.array([0, 0, 0]))
    assert np.all(np.isinf(of_pressed.approach(rest, 0).clearance))


def test_round_off_does_not_move_and_no_obstacle_is_never_met() -> None:
    Phi = np.array([[1.0, 1e-12], [2.0, 0.5], [0.0, 1.0]])
    found = Approach.of_mode(np.array([1.0, np.inf, 3.0]), Phi, 1)
    np.testing.assert_array_equal(found.reach, [np.inf, np.inf, 3.0])
    at_rest = Approach.at_rest(np.array([0.0, -1.0, 2.0]))
    np.testing.assert_array_equal(at_rest.clearance, [0.0, -1.0, np.inf])
    assert np.all(np.isinf(at_rest.reach))
