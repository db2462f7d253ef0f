"""Bilinear oscillator: closed-form frequency over energy."""

import numpy as np
import pytest

from fenics_nnm.nonlinear.continuation import EnergyContinuation, follow
from fenics_nnm.reduction.model import ReducedModel

MASS, SPRING, STOP, GAP = 1.0, 10.0, 50.0, 0.01
GRAZING_ENERGY = SPRING * GAP**2 / 2


def exact_frequency(energy: float) -> float:
    """m x'' + k x + K (x - e)_+ = 0; free part and contact part of the period."""
    free = 2 * np.sqrt(MASS / SPRING) * np.arccos(-GAP * np.sqrt(SPRING / (2 * energy)))
    both = SPRING + STOP
    contact = np.sqrt(2 * energy * both - STOP * SPRING * GAP**2)
    closed = 2 * np.sqrt(MASS / both) * np.arccos(GAP * SPRING / contact)
    return float(1 / (free + closed))


@pytest.mark.parametrize(("harmonics", "worst"), [(5, 1.2e-3), (9, 2e-4), (21, 1e-5)])
def test_frequency_over_two_decades_of_energy(harmonics: int, worst: float) -> None:
    # bounds: what NLvib and tmdsimpy reach with as many harmonics
    model = ReducedModel([np.sqrt(SPRING / MASS)], [[MASS**-0.5]], [[1 / STOP]], [GAP])
    near = (1.02, 1.03, 1.05, 1.1, 1.2, 1.35)
    continuation = EnergyContinuation(1.01, 60.0, 0.5, report_at=near)
    branch = follow(model, continuation, mode=0, harmonics=harmonics, samples=1024)
    assert branch.complete
    ratios = np.array([point.energy / GRAZING_ENERGY for point in branch.points])
    inside = [p for p, r in zip(branch.points, ratios, strict=True) if 1.02 <= r <= 100]
    assert ratios.max() > 100
    assert len(inside) > 50
    error = [abs(point.frequency / exact_frequency(point.energy) - 1) for point in inside]
    assert max(error) < worst


def test_linear_below_grazing() -> None:
    model = ReducedModel([np.sqrt(SPRING / MASS)], [[MASS**-0.5]], [[1 / STOP]], [GAP])
    branch = follow(model, EnergyContinuation(0.2, 1.0, 0.2), mode=0, harmonics=5, samples=64)
    for point in branch.points:
        assert point.frequency == pytest.approx(np.sqrt(10) / 2 / np.pi, rel=1e-12)
        assert point.energy == pytest.approx(point.gamma_ratio * GRAZING_ENERGY, rel=1e-12)
        assert point.contact_fraction <= 1 / 64
