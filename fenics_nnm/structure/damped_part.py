"""Stiffness, inertia and damping of a study in modal coordinates."""

from __future__ import annotations

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.hysteretic import HystereticPart
from fenics_nnm.mechanics.linear_part import LinearPart, RatedPart
from fenics_nnm.study import Study


def damped_part(study: Study, omega: Array, rate: Array, modes: int) -> LinearPart:
    """The linear part of the equations of motion.

    Args:
        study: Study.
        omega: Circular frequencies in rad/s of the modes, and of shapes added to them, shape (J,).
        rate: Damping matrix of dashpots and of a matrix, in 1/s, shape (J, J).
        modes: Number of modes.
    """
    if study.damping is None:
        return RatedPart(omega, rate)
    rated = RatedPart(omega, rate + study.damping.rate(omega, modes))
    loss = study.damping.loss(omega, modes)
    return HystereticPart(rated, loss) if loss.any() else rated
