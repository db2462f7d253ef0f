"""Harmonics and time samples."""

import numpy as np
import pytest

from fenics_nnm.errors import ModelError
from fenics_nnm.mechanics.fourier import CosineSeries


@pytest.mark.parametrize("samples", [11, 12, 64, 65])
def test_analysis_undoes_synthesis(samples: int) -> None:
    series = CosineSeries(5, samples)
    coefficients = np.random.default_rng(1).normal(size=(6, 3))
    back = series.analysis @ (series.synthesis @ coefficients)
    np.testing.assert_allclose(back, coefficients, atol=1e-14)


@pytest.mark.parametrize("samples", [15, 16])
def test_half_the_samples_give_the_full_discrete_transform(samples: int) -> None:
    series = CosineSeries(4, samples)
    time = 2 * np.pi * np.arange(samples) / samples
    values = np.exp(np.cos(time))  # even, with all harmonics
    transform = np.fft.rfft(values).real / samples
    expected = np.append(transform[0], 2 * transform[1:5])
    np.testing.assert_allclose(series.analysis @ values[: samples // 2 + 1], expected, rtol=1e-13)


def test_mean_over_the_period_is_the_weighted_sum() -> None:
    series = CosineSeries(3, 32)
    squares = (series.synthesis @ np.array([0.5, 1.0, 0.0, 2.0])) ** 2
    assert series.weight @ squares == pytest.approx(0.25 + 0.5 + 2.0)


def test_rate_is_the_derivative_of_the_basis() -> None:
    series, phase, step = CosineSeries(3, 8), np.array([0.3, 2.0]), 1e-6
    slope = (series.basis_at(phase + step) - series.basis_at(phase - step)) / (2 * step)
    np.testing.assert_allclose(series.rate_at(phase), slope, atol=1e-8)


def test_other_truncations_are_cut_or_filled() -> None:
    coefficients = np.arange(6.0).reshape(3, 2)
    np.testing.assert_array_equal(CosineSeries(1, 3).fitted(coefficients), coefficients[:2])
    filled = CosineSeries(3, 7).fitted(coefficients)
    np.testing.assert_array_equal(filled[:3], coefficients)
    assert not filled[3].any()


def test_too_few_samples_are_refused() -> None:
    with pytest.raises(ModelError, match=r"samples = 20 with harmonics = 10: .* 21"):
        CosineSeries(10, 20)
