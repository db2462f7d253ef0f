"""Derivative of the harmonics of contact forces, instants of one set in contact together."""

import numpy as np

from fenics_nnm.mechanics.contact_law import Complementarity
from fenics_nnm.mechanics.contact_times import FreeMotion, forces_in_time
from fenics_nnm.mechanics.fourier import FourierSeries
from fenics_nnm.mechanics.tangent_by_sets import tangent_by_sets

R = np.array([[0.5, 0.2, 0.1], [0.2, 0.6, 0.15], [0.1, 0.15, 0.4]])
SERIES, LAW = FourierSeries(4, 32), Complementarity(R, np.array([0.6, 0.3, 0.9]))


def test_tangent_is_that_of_all_instants() -> None:
    rng = np.random.default_rng(1)
    forces = forces_in_time(FreeMotion.of(SERIES, rng.normal(size=(9, 3)), LAW))
    Phi = rng.normal(size=(3, 2))
    assert len(np.unique(forces.force > 0, axis=0)) > 2
    expected = forces.tangent(SERIES, Phi)
    assert np.abs(expected).max() > 0.1
    np.testing.assert_allclose(tangent_by_sets(SERIES, Phi, forces), expected, atol=1e-13)


def test_motion_without_contact_has_none() -> None:
    forces = forces_in_time(FreeMotion.of(SERIES, np.zeros((9, 3)), LAW))
    assert not tangent_by_sets(SERIES, np.ones((3, 2)), forces).any()
