"""Derivatives of equations with exact integrals of contact forces against differences."""

from __future__ import annotations

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.nonlinear.timed import TimedEquations
from fenics_nnm.nonlinear.unknowns import Unknowns


def assert_derivatives(of: TimedEquations, motion: Array, omega: float) -> None:
    """By the motion, harmonics of shape (h, J), and by the frequency in rad/s."""
    step, at = 1e-6, Unknowns.of(motion, omega)
    assert len(of.forces(at).samples) > 10

    def residual(q: Array, omega: float) -> Array:
        there = Unknowns.of(q, omega)
        return of.residual(there, of.forces(there)).ravel()

    changes = step * np.eye(motion.size).reshape(-1, *motion.shape)
    columns = [residual(motion + d, omega) - residual(motion - d, omega) for d in changes]
    difference = np.array(columns).T / (2 * step)
    jacobian = of.jacobian(at, of.forces(at))
    assert np.abs(jacobian - difference).max() < 1e-7 * np.abs(jacobian).max()
    slope = (residual(motion, omega + step) - residual(motion, omega - step)) / (2 * step)
    found = of.slopes(at, of.forces(at))[0].ravel()
    assert np.abs(found - slope).max() < 1e-7 * np.abs(slope).max()
