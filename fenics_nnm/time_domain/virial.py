"""The virial identity of an exact damped motion, as an independent check of it."""

from __future__ import annotations

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.time_domain.damped_flow import DampedFlow


def virial_error(flow: DampedFlow, q: Array, velocity: Array) -> float:
    """Relative error of <|q'|^2> = <q . (Lambda q + C q' + Phi^T lambda - p)> over a period.

    Both sides come from Gauss' rule between changes of contact; every periodic motion obeys it.

    Args:
        flow: Flow at the frequency and under the force of the motion.
        q: Modal coordinates at phase 0, shape (J,).
        velocity: Their velocities, shape (J,).
    """
    squares = works = 0.0
    for stretch in flow.stretches(q, velocity, 2 * np.pi / flow.drive.omega):
        panels = stretch.motion.panels(stretch.duration)
        places, speeds = stretch.motion.states(panels.times)
        phase = flow.drive.omega * (stretch.clock + panels.times)
        pull = flow.model.omega**2 * places + flow.forces(places, phase) @ flow.model.Phi
        pull = pull + speeds @ flow.rate.T - flow.drive.force(phase)
        squares += float(panels.weights @ np.sum(speeds**2, axis=1))
        works += float(panels.weights @ np.sum(places * pull, axis=1))
    return abs(works / squares - 1)
