"""A cantilever that bends far, against the motion in time of its geometrically exact elements."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from bending_cantilever import LENGTH, Cantilever, frequency_in_time

from fenics_nnm.arrays import Array
from fenics_nnm.backbone.follow import EnergyContinuation, follow
from fenics_nnm.backbone.levels import HarmonicBalance
from fenics_nnm.backbone.point import VERIFIED, BranchPoint
from fenics_nnm.reduction.reduction import Reduction


@cache
def body(elements: int) -> Cantilever:
    return Cantilever(elements)


@cache
def reduction() -> Reduction:
    return body(3).reduced(3, np.array([0]))


def points_at(lifts: list[float]) -> tuple[BranchPoint, ...]:
    """Points whose tip moves across the axis by about these amplitudes in m."""
    model, lift = reduction().model, float(body(3).lift @ reduction().shapes[:, 0])
    ratios = tuple((each / lift / model.grazing_amplitude()) ** 2 for each in lifts)
    wanted = EnergyContinuation(ratios[0], ratios[-1], 9.0, report_at=ratios)
    found = follow(model, wanted, HarmonicBalance(12, 128), mode=0, shooting=True)
    assert found.complete, found.reason
    return found.points


def at_rest(point: BranchPoint) -> Array:
    """Displacement of the whole cantilever at the start of the period."""
    return reduction().displacement(point.motion.q.sum(axis=0), point.motion.force[0])


def test_derivatives_of_the_elements_are_those_of_their_energy() -> None:
    """As the force is a polynomial of third degree its terms are all there is."""
    of = body(3)
    _, shapes = of.modes(2)
    u = 1e-3 * shapes @ [1.0, 0.2] / np.abs(shapes).max()
    terms = of.K @ u + of.second(u, u) / 2 + of.third(u, u, u) / 6
    np.testing.assert_allclose(terms, of.force(u), atol=1e-11 * np.abs(terms).max())
    one, two = (of.energy(u * (1 + h)) - of.energy(u * (1 - h)) for h in (0.1, 0.2))
    slope = (8 * one - two) / 1.2  # exact, as the energy is of fourth degree
    assert slope == pytest.approx(of.force(u) @ u, rel=1e-9)


def test_foreshortening_of_three_modes() -> None:
    """0.5810, 4.052, 9.662 a^2 / L, whether axial modes are kept or not."""
    of = body(8)
    for mode, expected in enumerate((0.5810, 4.052, 9.662)):
        for modes in (3, 8):
            found = of.reduced(modes, np.array([mode]))
            kept = found.first_modes(3).bent_shapes if modes == 8 else found.bent_shapes
            lift = float(of.lift @ found.shapes[:, mode])
            assert -of.draw @ kept[:, 0] / 2 / lift**2 * LENGTH == pytest.approx(expected, rel=0.01)


def test_frequencies_are_those_of_the_motion_in_time_with_contact_and_without() -> None:
    """Linear kinematics is 2.5 % off in contact, and calls 7 mm a contact."""
    points = points_at([4e-3, 7.98e-3])
    assert [point.motion.contact_fraction > 0 for point in points] == [False, True]
    rows = reduction().shapes[:, 0] @ body(3).M
    for point in points:
        assert point.verdict is not None and point.verdict.status == VERIFIED, point.verdict
        assert point.balance.virial_error < 1e-9
        frequency, drift = frequency_in_time(
            body(3), at_rest(point), rows, step=1 / point.motion.frequency / 100, periods=1
        )
        assert drift < 1e-9
        assert point.motion.frequency == pytest.approx(frequency, rel=3e-4)
