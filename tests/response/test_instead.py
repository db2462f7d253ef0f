"""Where no stable motion is known: which frequencies these are, and what happens there in time."""

from dataclasses import replace

import numpy as np
import pytest

from fenics_nnm.mechanics.fourier import FourierSeries
from fenics_nnm.mechanics.linear_part import RatedPart
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.response.instead import instead, without_stable
from fenics_nnm.response.levels import Response, response
from fenics_nnm.response.point import ResponsePoint
from fenics_nnm.response.structure import Drive, DrivenStructure


def structure() -> DrivenStructure:
    """x'' + 0.1 x' + x + 20 x_+ = cos(omega t): a mass that lies at a stop."""
    model = ReducedModel(np.ones(1), np.ones((1, 1)), np.array([[0.05]]), np.zeros(1))
    linear = RatedPart(np.ones(1), np.array([[0.1]]))
    return DrivenStructure.of(model, linear, Drive.simple(np.ones((1, 1)), np.array([1.0 + 0j])))


@pytest.fixture(scope="module")
def found() -> Response:
    """Its response beyond the resonance, where its period doubles."""
    frequencies = np.linspace(2.3, 3.6, 3) / (2 * np.pi)
    return response(structure(), FourierSeries(10, 64), frequencies)


def test_period_doubles_in_time_where_the_multiplier_leaves_the_circle(found: Response) -> None:
    """Followed without harmonics, by small steps of the equation of motion alone."""
    (what,) = instead(structure(), 1.0, found.points)
    unstable = [p for p in found.points if "doubling" in p.judgement.stability]
    assert what.low == min(point.frequency for point in unstable)
    assert what.high == max(point.frequency for point in found.points) == found.points[0].frequency
    assert what.low < what.frequency < what.high and what.periods <= 400
    highest = by_small_steps(2 * np.pi * what.frequency, what.periods)
    assert what.repeats == 2 and "repeats after 2 periods" in str(what)
    np.testing.assert_allclose(what.highest, highest, rtol=2e-3)
    assert highest[1] > 1.03 * highest[0]


def by_small_steps(omega: float, periods: int, steps: int = 2000) -> tuple[float, float]:
    """Least and largest highest displacement of the last periods, from rest, by Stoermer-Verlet."""
    h = 2 * np.pi / omega / steps
    x, v, heights = 0.0, 0.0, []
    for period in range(periods):
        top = x
        for step in range(steps):
            push = np.cos(omega * h * (period * steps + step))
            v += h * (push - 0.1 * v - x - 20 * max(x, 0.0))
            x += h * v
            top = max(top, x)
        heights.append(top)
    return min(heights[-40:]), max(heights[-40:])


def test_ranges_are_those_that_no_stable_piece_covers(found: Response) -> None:
    def at(frequency: float, stability: str, branch: int = 1) -> ResponsePoint:
        point = found.points[0]
        known = replace(point.judgement, stability=stability)
        return replace(point, frequency=frequency, judgement=known, branch=branch)

    kinds = ["stable", "stable", "a", "a", "stable", "a", "", "a", "a"]
    points = [at(1.0 + n, kind) for n, kind in enumerate(kinds)]
    assert list(without_stable(points)) == [(3.0, 4.0), (8.0, 9.0)]
    other = [at(8.2, "stable", 3), at(8.6, "stable", 3)]
    assert list(without_stable([*points, *other])) == [(3.0, 4.0), (8.0, 8.2), (8.6, 9.0)]
    assert not list(without_stable(points[:2])) and not list(without_stable([]))
