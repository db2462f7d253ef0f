"""Second-order kinematics against a body whose potential is known in full, and differences."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from bent_body import BentBody

from fenics_nnm.arrays import Array
from fenics_nnm.errors import ModelError
from fenics_nnm.mechanics.contact_law import Complementarity
from fenics_nnm.mechanics.force import SampledMotion
from fenics_nnm.mechanics.fourier import CosineSeries, FourierSeries, Series
from fenics_nnm.mechanics.mechanics import Mechanics
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.mechanics.second_order import SecondOrder
from fenics_nnm.nonlinear.border import Border
from fenics_nnm.nonlinear.condensed import pays
from fenics_nnm.nonlinear.conditions import FixedEnergy
from fenics_nnm.nonlinear.equations import HarmonicEquations
from fenics_nnm.nonlinear.newton import solve
from fenics_nnm.nonlinear.unknowns import Unknowns

MASTERS = np.array([0, 2])
BODY = BentBody.random(6, 2, seed=3)
MODEL = BODY.reduction(4, MASTERS).model
RNG = np.random.default_rng(8)


def energies(model: ReducedModel, q: Array, velocity: Array) -> tuple[float, float]:
    """Potential and kinetic energy without contact."""
    stiffness, inertia = model.kinematics.forces
    potential = np.sum((model.omega * q) ** 2) / 2 + stiffness.energy_at(q, velocity)
    return float(potential), float(velocity @ velocity / 2 + inertia.energy_at(q, velocity))


def displacement(q: Array) -> Array:
    """U = phi q + 1/2 theta q q of the body, theta as they are, shape (n,)."""
    theta, u = BODY.derivatives(MASTERS), np.zeros(6)
    u[:4] = q
    return u + np.einsum("njk,j,k->n", theta, q[MASTERS], q[MASTERS]) / 2


def in_model(q: Array) -> Array:
    """Coordinates of the model, whose theta are free of its modes."""
    shared = BODY.derivatives(MASTERS)[:4]
    return q + np.einsum("ajk,j,k->a", shared, q[MASTERS], q[MASTERS]) / 2


def test_energies_and_closing_are_those_of_the_body_up_to_fourth_order() -> None:
    q, v, step = RNG.normal(size=4), RNG.normal(size=4), 1e-6
    for size in (1e-2, 1e-3):
        # cubic terms of several modes that are no masters are left out: of fifth order here
        small = np.where(np.isin(np.arange(4), MASTERS), size, size**2)
        at, rate = small * q, small * v
        u = displacement(at)
        moving = (displacement(at + step * rate) - displacement(at - step * rate)) / (2 * step)
        speed = (in_model(at + step * rate) - in_model(at - step * rate)) / (2 * step)
        potential, kinetic = energies(MODEL, in_model(at), speed)
        assert abs(potential - BODY.potential(u)) < 50 * size**5
        assert kinetic == pytest.approx(moving @ moving / 2, rel=1e-9)
        closing = MODEL.kinematics.closing.displaced(
            (MODEL.Phi @ in_model(at))[None], np.ones((1, 1)), in_model(at)[None]
        )
        np.testing.assert_allclose(closing[0], BODY.B @ u, atol=1e-14)


def test_modes_that_are_left_out_follow_statically() -> None:
    kept = np.array([0, 2, 3])
    part, record = MODEL.with_modes(kept), MODEL.kinematics.tensors
    q, v = RNG.normal(size=4), RNG.normal(size=4)
    own, rate, square = q[MASTERS], v[MASTERS], MODEL.omega[1] ** 2
    q[1] = -own @ record["alpha"][1] @ own / square
    v[1] = -2 * own @ record["alpha"][1] @ rate / square
    np.testing.assert_allclose(energies(part, q[kept], v[kept]), energies(MODEL, q, v), rtol=1e-12)
    whole, fewer = (
        model.kinematics.closing.displaced((model.Phi @ at)[None], np.ones((1, 1)), at[None])
        for model, at in ((MODEL, q), (part, q[kept]))
    )
    np.testing.assert_allclose(fewer, whole, rtol=1e-12)
    with pytest.raises(ModelError, match="mode 3 is a master"):
        MODEL.with_modes([0, 1])


@pytest.mark.parametrize("series", [CosineSeries(3, 16), FourierSeries(3, 16)])
def test_jacobian_and_slopes_of_the_equations_against_differences(series: Series) -> None:
    law = Complementarity(MODEL.R, 0.2 * MODEL.gap)
    equations = HarmonicEquations(Mechanics.of(MODEL), series, law)
    q = 0.3 * RNG.normal(size=equations.shape)
    at = Unknowns.of(q, 1.3).completed(len(equations.parameters))
    forces, step = equations.forces(at), 1e-6
    assert 2 < np.count_nonzero(forces.force.any(axis=1)) < len(series.phase)

    def residual(change: Array, omega: float = 0.0) -> Array:
        moved = Unknowns(q + change.reshape(q.shape), at.parameters + omega * first)
        return equations.residual(moved, equations.forces(moved)).ravel()

    first = np.eye(len(at.parameters))[0]
    jacobian = equations.jacobian(at, forces)
    columns = [(residual(d) - residual(-d)) / (2 * step) for d in step * np.eye(q.size)]
    np.testing.assert_allclose(jacobian, np.transpose(columns), atol=1e-6 * np.abs(jacobian).max())
    nothing = np.zeros(q.size)
    slope = (residual(nothing, step) - residual(nothing, -step)) / (2 * step)
    found = equations.slopes(at, forces)[0].ravel()
    np.testing.assert_allclose(found, slope, atol=1e-7 * np.abs(found).max())


@pytest.mark.parametrize("series", [CosineSeries(3, 16), FourierSeries(3, 16)])
def test_condensed_systems_have_the_dense_solution(series: Series) -> None:
    equations = HarmonicEquations(
        Mechanics.of(MODEL), series, Complementarity(MODEL.R, 0.3 * MODEL.gap)
    )
    at = Unknowns.of(0.2 * RNG.normal(size=equations.shape), 1.3)
    at = at.completed(len(equations.parameters))
    border = Border(
        columns=RNG.normal(size=(2, *equations.shape)),
        rows=RNG.normal(size=(2, *equations.shape)),
        corner=RNG.normal(size=(2, 2)),
        right=RNG.normal(size=equations.shape),
        below=RNG.normal(size=2),
    )
    for law in (equations.law, Complementarity(MODEL.R, 100 * MODEL.gap)):
        of = equations.with_law(law)
        forces = of.forces(at)
        assert pays(forces, at.q.size)
        dense = border.dense_solution(of.jacobian(at, forces), np.ones(of.shape))
        found = of.solved(at, forces, border)
        np.testing.assert_allclose(found, dense, atol=1e-10 * np.abs(dense).max())


@pytest.mark.parametrize("kind", [CosineSeries, FourierSeries])
def test_forces_are_those_at_many_samples(kind: type[Series]) -> None:
    series, order = kind(3, 200), MODEL.kinematics
    motion = SampledMotion(kind(3, 13), RNG.normal(size=(len(series.order), 4)), 0.7)
    many = SampledMotion(series, motion.q, 0.7)
    stiffness, inertia = order.forces
    q, v = many.displacement, many.velocity
    found = series.analysis @ stiffness.at(q, v)
    np.testing.assert_allclose(stiffness.harmonics(motion), found, atol=1e-12)
    own, rate, rise = (each[:, order.masters] for each in (q, v, many.acceleration))
    moving = np.einsum("sj,sl->sjl", rise, own) + np.einsum("sj,sl->sjl", rate, rate)
    force = np.einsum("ikjl,sk,sjl->si", order.tensors["D"], own, moving)
    found = inertia.harmonics(motion)[:, order.masters]
    np.testing.assert_allclose(found, series.analysis @ force, atol=1e-12)
    for each in (stiffness, inertia):
        mean = series.weight @ each.energy_at(q, v)
        assert each.mean_energy(motion) == pytest.approx(mean, rel=1e-12)
        virial = np.sum(motion.series.mean_square[:, None] * motion.q * each.harmonics(motion))
        assert each.mean_virial(motion) == pytest.approx(virial, rel=1e-12)
        with pytest.raises(ModelError, match="samples = 12 with harmonics = 3"):
            each.harmonics(SampledMotion(kind(3, 12), motion.q, 0.7))


def test_virial_identity_in_contact_with_all_terms() -> None:
    scaled, _ = MODEL.dimensionless()
    equations = HarmonicEquations(
        Mechanics.of(scaled), CosineSeries(8, 64), Complementarity(scaled.R, scaled.gap)
    )
    q = np.zeros(equations.shape)
    q[1, 0] = 1.0
    found = solve(equations, FixedEnergy(0.25 * 1.5), Unknowns.of(q, 1.0))
    assert found.converged and found.forces.force.any()
    energies = found.energies
    assert abs(energies.other_virial) > 0.1 * energies.stiffness
    assert energies.virial_error(found.omega) < 1e-9


def test_dimensionless_model_moves_alike() -> None:
    scaled, units = MODEL.dimensionless()
    q, v = RNG.normal(size=4), RNG.normal(size=4)
    moved, moving = q * units.amplitude, v * units.amplitude * units.omega
    in_joule = energies(MODEL, moved, moving)
    np.testing.assert_allclose(
        np.array(energies(scaled, q, v)) * units.energy, in_joule, rtol=1e-12
    )
    closing = [
        model.kinematics.closing.shapes_at(model.Phi, at)
        for model, at in ((scaled, q), (MODEL, moved))
    ]
    np.testing.assert_allclose(closing[0] * units.length / units.amplitude, closing[1], rtol=1e-12)


def test_gap_is_reached_where_the_quadratic_closing_meets_it() -> None:
    record = SecondOrder([0], [[[-3.0]]], [[[0.0]]], [[[[0.0]]]], [[[[2.0]]]])
    model = ReducedModel([1.0], [[2.0]], [[0.1]], [0.4], kinematics=record)
    a = model.grazing_amplitude()
    assert 2.0 * a - 1.5 * a**2 == pytest.approx(0.4, rel=1e-14)
    assert model.at_rest().at_one(0) == "static first contact"
    closes = replace(model, kinematics=replace(record, Theta=-record.Theta), Phi=[[-2.0]])
    b = closes.grazing_amplitude()
    assert 2.0 * b + 1.5 * b**2 == pytest.approx(0.4, rel=1e-14)  # on the side of -q
    still = replace(closes, Phi=[[0.0]])
    assert still.grazing_amplitude() == pytest.approx(np.sqrt(0.8 / 3))
    far = replace(model, gap=[0.7])  # the closest it comes is 2^2 / (2 3) = 2/3 at 2/3
    assert far.grazing_amplitude() == pytest.approx(2 / 3)
    assert far.at_rest().at_one(0) == "nearest approach"


def test_what_is_no_second_order_is_refused() -> None:
    good = dict(MODEL.kinematics.tensors)
    for name, change, message in (
        ("Theta", np.zeros((2, 2, 1)), "Theta has shape"),
        ("alpha", good["alpha"] + np.arange(2), "alpha is not symmetric"),
        ("beta", good["beta"] + np.arange(2), "beta is not symmetric"),
        ("D", -good["D"], "D has the eigenvalue"),
        ("D", np.full((2, 2, 2, 2), np.nan), "D has entries that are not finite"),
    ):
        with pytest.raises(ModelError, match=message):
            SecondOrder(masters=MASTERS, **{**good, name: change})
    with pytest.raises(ModelError, match="masters are modes 1 to 5"):
        SecondOrder(masters=[0, 4], **good)
    record = SecondOrder(masters=MASTERS, **good)
    with pytest.raises(ModelError, match="Theta has 2 matrices: must be 1"):
        ReducedModel(MODEL.omega, MODEL.Phi[:1], MODEL.R[:1, :1], MODEL.gap[:1], kinematics=record)
    with pytest.raises(ModelError, match="must be positive with second-order kinematics"):
        replace(MODEL, gap=-MODEL.gap).at_rest()
