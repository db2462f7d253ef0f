"""Which mode with a point held has the shape of a free one: by likeness, or none has."""

import numpy as np
import pytest

from fenics_nnm.errors import ModelError
from fenics_nnm.mechanics.held_mode import held_mode
from fenics_nnm.mechanics.model import ReducedModel

#: Circular frequencies in rad/s, motions of the point, and flexibility of its stop in m/N.
OMEGA, PHI, R = np.array([1.0, 3.0, 3.2, 3.4]), np.array([1.0, 0.3, 0.4, 0.5]), 0.02


def test_a_pressed_mode_has_another_number_and_others_none() -> None:
    """The stop lifts mode 1 above the others, which it mixes: mode 3 keeps no shape."""
    rest = ReducedModel(OMEGA, PHI[None], [[R]], [-0.1]).at_rest()
    likeness = np.linalg.eigh(np.diag(OMEGA**2) + np.outer(PHI, PHI) / R)[1] ** 2
    most = likeness.max(axis=1)
    assert np.flatnonzero(most <= 0.5).tolist() == [2]
    assert [held_mode(rest, mode) for mode in (0, 1, 3)] == [3, 1, 2]
    assert likeness.argmax(axis=1)[[0, 1, 3]].tolist() == [3, 1, 2]
    words = r"mode 3 without contact is no single mode at rest, where 1 contact points are closed"
    with pytest.raises(ModelError, match=rf"{words}: mode 3.* likeness of {most[2]:.2f}: must"):
        held_mode(rest, 2)


def test_without_closed_points_each_mode_is_itself() -> None:
    rest = ReducedModel(OMEGA, PHI[None], [[R]], [0.1]).at_rest()
    assert [held_mode(rest, mode) for mode in range(4)] == [0, 1, 2, 3]
