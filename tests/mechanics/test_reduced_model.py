"""Reduced models: units, truncation, and what is refused."""

import numpy as np
import pytest

from fenics_nnm.backbone.follow import EnergyContinuation, follow
from fenics_nnm.backbone.levels import HarmonicBalance
from fenics_nnm.errors import ModelError
from fenics_nnm.mechanics import model as model_module
from fenics_nnm.mechanics.contact_points import MASSIVE
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.reduction.massless import massless_model


def rod(modes: int) -> ReducedModel:
    """Clamped-free rod of unit length, wave speed, E A and gap; static flexibility 1."""
    j = np.arange(1, modes + 1)
    omega = (2 * j - 1) * np.pi / 2
    Phi = (np.sqrt(2) * (-1.0) ** (j + 1))[None, :]
    return massless_model(omega, Phi, np.array([[1.0]]), np.array([1.0]))


def test_residual_flexibility_of_the_rod_is_the_tail_of_a_known_series() -> None:
    # sum over all odd k of 8 / (pi k)^2 = 1, so R = 1 - 8 / pi^2 (1 + 1/9 + 1/25)
    expected = 1 - 8 / np.pi**2 * (1 + 1 / 9 + 1 / 25)
    assert rod(3).R[0, 0] == pytest.approx(expected, rel=1e-13)


def test_dropped_modes_go_to_the_residual_flexibility() -> None:
    kept = rod(12).with_modes(list(range(3)))
    np.testing.assert_allclose(kept.R, rod(3).R, rtol=1e-12)
    np.testing.assert_allclose(kept.omega, rod(3).omega)


def test_keeping_a_higher_mode_alone_leaves_the_static_flexibility() -> None:
    alone = rod(12).with_modes([1])
    static = alone.R + (alone.Phi / alone.omega) @ (alone.Phi / alone.omega).T
    assert static[0, 0] == pytest.approx(1.0, rel=1e-12)


def test_grazing_amplitude_is_set_by_the_first_point_to_touch() -> None:
    model = ReducedModel([2.0], [[0.5], [-3.0]], np.eye(2), [1.0, 0.3])
    assert model.grazing_amplitude() == pytest.approx(0.1)


def test_dimensionless_model_has_unit_frequency_and_grazes_at_unit_amplitude() -> None:
    model = ReducedModel([200.0, 900.0], [[0.5, 0.1], [-3.0, 1.0]], 1e-7 * np.eye(2), [1e-3, 3e-4])
    scaled, scales = model.dimensionless()
    assert scaled.omega[0] == 1
    assert scaled.grazing_amplitude() == pytest.approx(1.0)
    # displacement per force keeps its meaning: R force / length
    np.testing.assert_allclose(scaled.R * scales.length / scales.force, model.R)
    # energy of the linear mode that grazes: omega^2 q^2 / 2
    assert scales.energy / 2 == pytest.approx((200.0 * 1e-4) ** 2 / 2)


def test_dimensionless_units_of_a_higher_mode() -> None:
    model = ReducedModel([200.0, 900.0], [[0.5, 0.1]], [[1e-7]], [1e-3])
    scaled, _ = model.dimensionless(1)
    assert scaled.omega[1] == 1
    assert scaled.grazing_amplitude(1) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"omega": [0.0, 1.0]}, "omega must be positive"),
        ({"omega": [2.0, 1.0]}, "ascending"),
        ({"omega": [1.0, np.nan]}, "omega has entries that are not finite"),
        ({"gap": [np.inf]}, "gap has entries that are not finite"),
        ({"R": [[-1.0]]}, "eigenvalue -1"),
        ({"R": [1.0]}, r"R has shape \(1,\)"),
        ({"Phi": [[1.0]]}, r"Phi has shape \(1, 1\): must be \(1, 2\)"),
    ],
)
def test_inadmissible_models_are_refused(change: dict[str, list], words: str) -> None:
    values = {"omega": [1.0, 2.0], "Phi": [[1.0, 1.0]], "R": [[0.1]], "gap": [1.0], **change}
    with pytest.raises(ModelError, match=words):
        ReducedModel(**values)


def test_an_asymmetric_flexibility_is_refused() -> None:
    with pytest.raises(ModelError, match="not symmetric"):
        ReducedModel([1.0], [[1.0], [1.0]], [[1.0, 0.1], [0.2, 1.0]], [1.0, 1.0])


def test_a_mode_that_does_not_reach_the_obstacle_is_named() -> None:
    model = ReducedModel([1.0, 2.0], [[1.0, 0.0]], [[0.1]], [1.0])
    with pytest.raises(ModelError, match="mode 2 does not move any contact point"):
        model.grazing_amplitude(1)


def test_modes_that_span_the_contact_points_leave_no_flexibility() -> None:
    omega, Phi = np.array([1.0, 2.0]), np.array([[1.0, 1.0]])
    with pytest.raises(ModelError, match="fewer modes or fewer contact points"):
        massless_model(omega, Phi, np.array([[1.25]]), np.array([1.0]))


def test_modes_that_all_but_span_the_contact_points_are_refused() -> None:
    omega, Phi = np.array([1.0, 2.0]), np.array([[1.0, 1.0], [0.3, 0.9]])
    modal = (Phi / omega) @ (Phi / omega).T
    words = r"leave contact points 1\.0e-08 of their static .* use fewer modes"
    with pytest.raises(ModelError, match=words):
        massless_model(omega, Phi, modal / (1 - 1e-8), np.ones(2))
    kept = massless_model(omega, Phi, modal / (1 - 1e-5), np.ones(2))
    np.testing.assert_allclose(kept.R, 1e-5 * modal, rtol=1e-4)


def test_points_without_mass_need_residual_flexibility() -> None:
    with pytest.raises(ModelError, match="R is singular"):
        ReducedModel([1.0], [[1.0], [1.0]], [[0.1, 0.1], [0.1, 0.1]], [1.0, 1.0])
    massive = ReducedModel([1.0, 3.0], [[1.0, 0.5]], [[0.0]], [1.0], contact=MASSIVE)
    assert not massive.massless and massive.with_modes([0]).massless


def test_the_state_of_rest_is_computed_once(monkeypatch: pytest.MonkeyPatch) -> None:
    calls = []
    compute = model_module.rest_state
    monkeypatch.setattr(model_module, "rest_state", lambda m: calls.append(m) or compute(m))
    model = ReducedModel([1.0, 3.3], [[1.0, 0.8]], [[0.05]], [1.0])
    branch = follow(model, EnergyContinuation(0.9, 1.6, 0.05), HarmonicBalance(8, 64), mode=0)
    assert len(branch.points) == 15
    assert len(calls) == len({id(each) for each in calls}) <= 8  # the model, scaled, 6 levels
