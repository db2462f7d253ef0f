"""An independent check of converged motions: integration in time over one period.

Harmonic balance solves truncated equations; a motion whose higher harmonics matter can solve them
to round-off and still be no motion of the model. Integrated from its initial state, a motion
that is resolved comes back after a period, one that is not misses.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.nonlinear.contact_law import Complementarity
from fenics_nnm.nonlinear.fourier import Series
from fenics_nnm.nonlinear.point import BranchPoint
from fenics_nnm.reduction.model import ReducedModel

#: Step times the circular frequency of the stiffest contact; the scheme is stable below 2.
_STEP = 0.1

#: Largest number of steps of a period.
_MOST_STEPS = 20_000


def return_errors(model: ReducedModel, series: Series, points: Sequence[BranchPoint]) -> Array:
    """Distance of the state after one period from its start, relative in the energy norm.

    Strang splitting: half a kick by the contact forces, the exact linear flow, half a kick; all
    points at once. Second order in the step, so the error of the check is about 1e-3.

    Args:
        model: Reduced model in SI units.
        series: Series that the points are written in.
        points: Points of a branch of this model.

    Returns:
        One error a point, shape (len(points),); 0 is a perfect return, 1 as far away as the
        amplitude; nan where the contact is too stiff for 20 000 steps.
    """
    if not points:
        return np.empty(0)
    period = np.array([1 / point.frequency for point in points])
    steps = int(np.ceil(period.max() * _stiffest_contact(model) / _STEP))
    if steps > _MOST_STEPS / _STEP:
        return np.full(len(points), np.nan)
    position, rate = series.basis_at(np.zeros(1))[0], series.rate_at(np.zeros(1))[0]
    start = np.array([position @ point.q for point in points])
    speed = np.array([2 * np.pi * point.frequency * rate @ point.q for point in points])
    q, velocity = _integrated(model, start, speed, period, min(steps, _MOST_STEPS))
    gap = np.hypot(model.omega * (q - start), velocity - speed)
    whole = np.sqrt([2 * point.energy for point in points])
    return np.asarray(np.linalg.norm(gap, axis=1) / whole)


def _stiffest_contact(model: ReducedModel) -> float:
    """Circular frequency of all modes together on the contact flexibility: a bound on the kicks."""
    stiffness = np.linalg.solve(model.R, model.Phi @ model.Phi.T)
    highest = float(np.abs(np.linalg.eigvals(stiffness)).max())
    return max(float(np.sqrt(highest)), float(model.omega[-1]))


def _integrated(
    model: ReducedModel, q: Array, velocity: Array, period: Array, steps: int
) -> tuple[Array, Array]:
    """Coordinates and velocities after one period, each of shape (P, J)."""
    law = Complementarity(model.R, model.gap)
    step = period[:, None] / steps
    cosine, sine = np.cos(model.omega * step), np.sin(model.omega * step)
    kick = step / 2 * _contact_acceleration(model, law, q)
    for _ in range(steps):
        velocity = velocity + kick
        q, velocity = (
            cosine * q + sine / model.omega * velocity,
            cosine * velocity - sine * model.omega * q,
        )
        kick = step / 2 * _contact_acceleration(model, law, q)
        velocity = velocity + kick
    return q, velocity


def _contact_acceleration(model: ReducedModel, law: Complementarity, q: Array) -> Array:
    displacement = q @ model.Phi.T
    touching = (displacement > model.gap).any(axis=1)
    acceleration = np.zeros_like(q)
    if touching.any():
        acceleration[touching] = -law(displacement[touching]).force @ model.Phi
    return acceleration
