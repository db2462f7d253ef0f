"""Whether two exact periodic motions are of one family: a walk along it, from one to the other."""

from __future__ import annotations

import numpy as np

from fenics_nnm.time_domain.family import Found, Steps, walk_to_energy
from fenics_nnm.time_domain.integrator import Integrator
from fenics_nnm.time_domain.period_map import Target, period_map
from fenics_nnm.time_domain.shooting import ShotMotion

#: The walk, as far as the energy of the other motion.
_WALK = Steps(walk=60, farthest=1.0)

#: The motion that it comes to is the other one to this part of its period, and of its amplitude.
_SAME = 1e-6


def joined(flow: Integrator, one: ShotMotion, other: ShotMotion, *, reversible: bool) -> bool:
    """Whether the family of a motion leads to another one.

    Args:
        flow: Integrator of their model, in SI units.
        one: Motion to begin at.
        other: Motion to come to.
        reversible: Whether both are time-reversible and start at rest.
    """
    target = Target(one.q, one.velocity, one.period, other.energy)
    equations = period_map(flow, target, reversible=reversible)
    start = equations.start
    found = walk_to_energy(equations, Found(start, equations.miss(start), 0), _WALK)
    if found.failure:
        return False
    q, velocity, period = equations.state(found.unknowns)
    missed = np.concatenate([flow.model.omega * (q - other.q), velocity - other.velocity])
    near = float(np.linalg.norm(missed)) <= _SAME * target.amplitude
    return near and abs(period / other.period - 1) <= _SAME
