"""Contact points: evenly spread, with those that come to the obstacle first always among them."""

import numpy as np
import pytest

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.approach import Approach
from fenics_nnm.reduction.point_choice import PointChoice, spread

LINE = np.linspace(0, 1, 101)[:, None]
NONE = np.zeros(101, dtype=bool)


def improved(motion: Array, count: int = 5, gap: float = 1e-3) -> Array:
    """Places on the line that are chosen."""
    approach = Approach(np.full(101, gap), motion)
    return LINE[PointChoice.evenly(LINE, count).improved(LINE, approach, NONE).chosen, 0]


def test_spread_points_cover_a_line_evenly() -> None:
    np.testing.assert_allclose(LINE[spread(LINE, 5), 0], [0, 0.25, 0.5, 0.75, 1], atol=0.01)


def test_equal_distances_are_told_apart_by_coordinates_not_by_numbers() -> None:
    places = np.stack(np.meshgrid(range(5), range(3)), axis=-1).reshape(-1, 2) * 0.1
    order = np.random.default_rng(3).permutation(len(places))
    noise = 1e-13 * np.random.default_rng(4).normal(size=places.shape)
    motion = np.where((places[:, 0] == 0.2) & (places[:, 1] != 0.1), 2.0, 1.0)
    for count in (1, 2, 4):
        found = []
        for points, moved in ((places, motion), ((places + noise)[order], motion[order])):
            even = PointChoice.evenly(points, count)
            choice = even.improved(points, Approach(np.ones(15), moved), np.zeros(15, dtype=bool))
            found.append({tuple(np.round(point, 9)) for point in points[choice.chosen]})
        assert found[0] == found[1]
        assert (0.2, 0.0) in found[0]


@pytest.mark.parametrize("count", [1, 2, 3, 5])
def test_what_comes_first_is_chosen_on_either_side(count: int) -> None:
    found = improved(np.where(LINE[:, 0] < 0.7, 1.0, -0.5) * np.exp(-((LINE[:, 0] - 0.37) ** 2)), 5)
    assert {0.37, 0.7} <= set(np.round(found, 9))
    assert len(found) == 5
    alone = improved(np.exp(-((LINE[:, 0] - 0.37) ** 2)), count)
    assert 0.37 in np.round(alone, 9)
    assert len(alone) == count
    rest = np.sort(np.abs(np.diff(alone)))
    assert count < 3 or rest[0] > 0.1  # the others are spread


def test_a_choice_that_is_as_near_within_a_thousandth_stays() -> None:
    even = LINE[spread(LINE, 5), 0]
    for excess, same in ((0.9e-3, True), (1.1e-3, False)):
        motion = np.full(101, 1e-3)
        motion[37], motion[0] = 1.0 + excess, 1.0
        assert np.array_equal(improved(motion), even) is same


def test_what_touches_at_rest_comes_before_what_moves() -> None:
    clearance = np.ones(101)
    clearance[61], clearance[63] = -1e-4, -2e-4
    motion = np.where(np.arange(101) == 37, 1.0, 0.1)
    choice = PointChoice.evenly(LINE, 1).improved(LINE, Approach(clearance, motion), NONE)
    np.testing.assert_array_equal(choice.chosen, [63])
    choice = PointChoice.evenly(LINE, 3).improved(LINE, Approach(clearance, motion), NONE)
    assert {37, 63} <= set(choice.chosen.tolist())


def test_what_is_needed_is_kept_and_what_is_taken_is_left() -> None:
    motion = np.where(np.arange(101) == 37, 1.0, 0.1)
    first = PointChoice.evenly(LINE, 3).improved(LINE, Approach(np.ones(101), motion), NONE)
    motion = np.where(np.arange(101) == 81, 1.0, 0.1)
    taken = np.arange(101) == 0
    second = first.improved(LINE, Approach(np.ones(101), motion).without(taken), taken)
    assert {37, 81} <= set(second.chosen.tolist())
    assert not taken[second.chosen].any()
