"""Second order beside a spring that is not linear: its shape is no mode, but moves like one."""

from __future__ import annotations

import numpy as np
import pytest
from bent_body import BentBody, dense_operators, flat

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.errors import ModelError
from fenics_nnm.reduction.attached import AttachedPoints
from fenics_nnm.reduction.massless import massless_reduction
from fenics_nnm.reduction.modal_derivatives import with_second_order
from fenics_nnm.reduction.reduction import Reduction

BODY, MODES = BentBody.random(6, 2, seed=3), 3
MASTERS = np.array([0, 2])
RNG = np.random.default_rng(11)
SPRING = RNG.normal(size=(6, 1))


def sprung(masters: Indices) -> Reduction:
    """The body with a cubic spring to the ground."""
    operators = dense_operators(np.diag(BODY.omega**2), np.eye(6), BODY.B)
    static = (BODY.B / BODY.omega**2).T
    points = AttachedPoints(SPRING, np.array([1.0]))
    shapes = np.eye(6)[:, :MODES]
    linear = massless_reduction(BODY.omega[:MODES], shapes, static, np.ones(2), operators, points)
    return with_second_order(linear, masters, operators, flat(BODY.second, BODY.third, operators))


def errors(reduction: Reduction, q: Array, velocity: Array) -> tuple[float, float]:
    """What potential and kinetic energy of the model lack of those of the body."""
    none, model, step = np.zeros(2), reduction.model, 1e-6
    stiffness, inertia = model.kinematics.forces
    potential = np.sum((model.omega * q) ** 2) / 2 + stiffness.energy_at(q, velocity)
    kinetic = velocity @ velocity / 2 + inertia.energy_at(q, velocity)
    ends = [reduction.displacement(q + sign * step * velocity, none) for sign in (1, -1)]
    moving = (ends[0] - ends[1]) / (2 * step)
    exact = BODY.potential(reduction.displacement(q, none)), moving @ moving / 2
    return abs(potential - exact[0]), abs(kinetic - exact[1])


def test_energies_are_those_of_the_body_up_to_fourth_order() -> None:
    """The shape of the spring follows the square of the masters, as modes that are no masters."""
    reduction = sprung(MASTERS)
    assert reduction.model.modes == 4 and reduction.free == 3
    q, v = RNG.normal(size=4), RNG.normal(size=4)
    for size in (1e-2, 1e-3):
        small = np.where(np.isin(np.arange(4), MASTERS), size, size**2)
        of_potential, of_kinetic = errors(reduction, small * q, small * v)
        assert of_potential < 100 * size**5
        assert of_kinetic < 1e-9 * size**2
    alpha = reduction.model.kinematics.tensors["alpha"][3]
    of_a_mode = (
        np.einsum("i,ijk->jk", reduction.shapes[:, 3], BODY.f2)[np.ix_(MASTERS, MASTERS)] / 2
    )
    assert np.abs(alpha - of_a_mode).max() > 0.01 * np.abs(alpha).max()


def test_the_shape_of_a_spring_is_no_master() -> None:
    with pytest.raises(ModelError, match=r"mode 4 is a shape of a spring .* among the 3 modes"):
        sprung(np.array([0, 3]))
