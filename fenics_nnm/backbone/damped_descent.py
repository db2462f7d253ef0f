"""From a motion with heavily damped other modes down to the one with the real damping.

In steps of the damping as far as they go, and from there by arc-length.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fenics_nnm.backbone.damped_arc import ArcWalk, arc_walk
from fenics_nnm.backbone.damped_model import DampedModel
from fenics_nnm.backbone.damped_path import Step, walk
from fenics_nnm.time_domain.damped_flow import DampedFlow
from fenics_nnm.time_domain.drive import Drive
from fenics_nnm.time_domain.resonant_map import ResonantMap
from fenics_nnm.time_domain.resonant_motion import (
    ResonantMotion,
    driven_by_push,
    resonant_motion,
)

#: Steps of s.
_DOWN = Step(0.06, 1e-3, jump=3e-3, leap=0.1)

#: Samples of a period of which energies by harmonic are taken.
_SAMPLES = 1024


def lowered(damped: DampedModel, gamma: float, heavy: ResonantMotion) -> ResonantMotion:
    """The motion with the real damping; one with a failure that says where the way ends, and why.

    Args:
        damped: Model with its damping.
        gamma: Modal energy coordinate in kg m^2.
        heavy: The motion with heavily damped other modes.
    """

    def at(s: float, guess: ResonantMotion) -> ResonantMotion:
        return resonant_motion(_flow(damped, s), damped.push, gamma, guess)

    found = walk(at, damped.model.omega, (1.0, heavy), 0.0, _DOWN)
    last = found.motions[-1]
    return by_arc(damped, gamma, (found.values[-1], last)) if found.failure else last


def by_arc(
    damped: DampedModel, gamma: float, begin: tuple[float, ResonantMotion]
) -> ResonantMotion:
    """The same by arc-length, from a motion on the way.

    Args:
        damped: Model with its damping.
        gamma: Modal energy coordinate in kg m^2.
        begin: Number s, and the motion there.
    """
    near = begin[1]

    def equations(s: float) -> ResonantMap:
        return ResonantMap(_flow(damped, s), damped.push, gamma, near.omega, near.level)

    way = arc_walk(equations, begin)
    return way.motion or replace(near, failure=_told(damped, way))


def _flow(damped: DampedModel, s: float) -> DampedFlow:
    return driven_by_push(damped.model, damped.rate_at(s), damped.push)


def _told(damped: DampedModel, way: ArcWalk) -> str:
    """Where a way ends, and what draws energy there."""
    place = min(way.folds, key=lambda fold: fold.s) if way.folds else way.last
    verb = "has a fold" if way.folds else "ends"
    ratio = 100 * damped.least_other_at(place.s)
    share = largest_share(_flow(damped, place.s), place.motion, damped.mode)
    grazes = "a contact begins or ends and " if place.grazes else ""
    return (
        f"the path of falling damping {verb} at a damping ratio of {ratio:.2f} %, where {grazes}"
        f"{share} of the kinetic energy: {way.failure}"
    )


def largest_share(flow: DampedFlow, motion: ResonantMotion, mode: int) -> str:
    """What has most of the kinetic energy besides the first harmonic of the followed mode.

    Args:
        flow: Flow of `driven_by_push`.
        motion: Motion in phase resonance.
        mode: Index of the followed mode.
    """
    driven = flow.driven_by(
        Drive(motion.omega, flow.drive.order, motion.level * flow.drive.amplitude)
    )
    period = 2 * np.pi / motion.omega
    times = period * np.arange(_SAMPLES) / _SAMPLES
    q = driven.run(motion.q, motion.velocity, period, times=times).q_at
    order = np.arange(_SAMPLES // 2 + 1)
    kinetic = order[:, None] ** 2 * np.abs(np.fft.rfft(q, axis=0)) ** 2
    total = float(kinetic.sum())
    kinetic[1, mode] = 0.0
    harmonic, other = np.unravel_index(int(np.argmax(kinetic)), kinetic.shape)
    share = float(kinetic[harmonic, other]) / total
    return f"mode {other + 1} in harmonic {harmonic} has {100 * share:.1f} %"
