"""A random system with springs that are not linear; `tests/random_bent.py` runs many of them."""

from __future__ import annotations

import numpy as np
import pytest
from random_bent import LARGEST_ERROR, Model, ends


def test_verified_frequencies_are_those_of_the_masses() -> None:
    """The third model, which has quadratic and cubic springs, and a second family of motions."""
    errors = np.array([error for status, error in ends(3) if status == "verified"])
    assert len(errors) == 8
    assert errors.max() < LARGEST_ERROR


def test_acceleration_is_the_slope_of_the_energy() -> None:
    """The reference by itself, also where stops are pressed."""
    masses = Model.random(np.random.default_rng(3)).masses
    u = 2e-3 * np.random.default_rng(1).standard_normal((20, len(masses.mass)))
    step = 1e-9 * np.eye(len(masses.mass))
    for at in u:
        slope = [(masses.energy(at + d) - masses.energy(at - d)) / 2e-9 for d in step]
        force = masses.mass * masses.acceleration(at)
        assert force == pytest.approx(-np.array(slope), rel=1e-5, abs=1e-5 * np.abs(force).max())
