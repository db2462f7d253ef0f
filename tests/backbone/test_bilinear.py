"""Bilinear oscillator: closed-form frequency over energy."""

import importlib.util
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from fenics_nnm.backbone.follow import EnergyContinuation, follow
from fenics_nnm.backbone.levels import HarmonicBalance
from fenics_nnm.mechanics.model import ReducedModel


@pytest.fixture(scope="module")
def demo() -> ModuleType:
    path = Path(__file__).parents[2] / "demos" / "bilinear" / "bilinear.py"
    spec = importlib.util.spec_from_file_location("bilinear", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize(("harmonics", "worst"), [(5, 1.2e-3), (9, 2e-4), (21, 1e-5)])
def test_frequency_over_two_decades_of_energy(
    demo: ModuleType, harmonics: int, worst: float
) -> None:
    # bounds: what NLvib and tmdsimpy reach with as many harmonics
    assert demo.worst_error(harmonics) < worst


def test_closed_form_has_its_two_limits(demo: ModuleType) -> None:
    # at grazing the linear oscillator; far above half a period of each spring
    linear, both = np.sqrt(10.0), np.sqrt(60.0)
    grazing = demo.exact_frequency(demo.GRAZING_ENERGY * (1 + 1e-12))
    assert grazing == pytest.approx(linear / (2 * np.pi), rel=1e-5)
    far = 2 / (2 * np.pi / linear + 2 * np.pi / both)
    assert demo.exact_frequency(1e8 * demo.GRAZING_ENERGY) == pytest.approx(far, rel=1e-3)


def test_linear_below_grazing(demo: ModuleType) -> None:
    model = ReducedModel([np.sqrt(10.0)], [[1.0]], [[1 / demo.STOP]], [demo.GAP])
    branch = follow(model, EnergyContinuation(0.2, 1.0, 0.2), HarmonicBalance(5, 64), mode=0)
    for point in branch.points:
        assert point.motion.frequency == pytest.approx(np.sqrt(10) / 2 / np.pi, rel=1e-12)
        assert point.motion.energy == pytest.approx(
            point.gamma_ratio * demo.GRAZING_ENERGY, rel=1e-12
        )
        assert point.motion.contact_fraction <= 1 / 64
