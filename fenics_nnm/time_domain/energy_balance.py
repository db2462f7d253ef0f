"""Energy of a damped, driven motion in time: work of force and moving gaps, dissipation, change."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.time_domain.damped_flow import DampedFlow, Stretch

_TINY = np.finfo(float).tiny


@dataclass(frozen=True, slots=True)
class EnergyBalance:
    """What a motion took in and gave away.

    Attributes:
        work: Work of the harmonic forces, and of contact forces at gaps that move, in J.
        dissipated: Energy that damping took in J; negative where it drives the motion.
        change: Change of kinetic and potential energy in J.
        turned_over: Integral of the absolute power of forces and damping in J.
    """

    work: float
    dissipated: float
    change: float
    turned_over: float

    @property
    def error(self) -> float:
        """Work - dissipated - change, relative to what was turned over."""
        missing = self.work - self.dissipated - self.change
        return abs(missing) / max(self.turned_over, abs(self.change), _TINY)


def energy_balance(
    flow: DampedFlow, q: Array, velocity: Array, span: float, phase: float = 0.0
) -> EnergyBalance:
    """The balance of the motion from a state for a time.

    Args:
        flow: Flow of the model.
        q: Modal coordinates, shape (J,).
        velocity: Their velocities, shape (J,).
        span: Time in s.
        phase: Phase of the force at the start.
    """
    start, totals = flow.energy(q, velocity, phase), np.zeros(3)
    for stretch in flow.stretches(q, velocity, span, phase):
        totals += _powers(flow, stretch, phase)
        q, velocity = stretch.motion.state(stretch.duration)
    work, dissipated, turned_over = map(float, totals)
    end = flow.energy(q, velocity, phase + flow.drive.omega * span)
    return EnergyBalance(work, dissipated, end - start, turned_over)


def _powers(flow: DampedFlow, stretch: Stretch, phase: float) -> Array:
    """Work, dissipation, and the integral of both powers' sizes, over a stretch."""
    panels = stretch.motion.panels(stretch.duration)
    q, velocity = stretch.motion.states(panels.times)
    turned = phase + flow.drive.omega * (stretch.clock + panels.times)
    given = np.sum(flow.drive.force(turned) * velocity, axis=1)
    if flow.drive.gap.moves:
        rate = flow.drive.omega * flow.drive.gap.rate(turned)
        given = given - np.sum(flow.forces(q, turned) * rate, axis=1)
    taken = np.sum((velocity @ flow.rate.T) * velocity, axis=1)
    return np.array([given, taken, np.abs(given) + np.abs(taken)]) @ panels.weights
