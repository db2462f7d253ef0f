"""The largest stresses of a period, and where contact raises them."""

from __future__ import annotations

import numpy as np

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.fields.invariants import principal, von_mises
from fenics_nnm.fields.shapes import MotionShapes
from fenics_nnm.results.stored_branch import PlacedMotion

#: Fields of the largest stresses.
PEAKS = (
    "peak von Mises stress (Pa)",
    "phase of peak von Mises stress (periods)",
    "peak largest principal stress (Pa)",
    "phase of peak largest principal stress (periods)",
)

#: Those beside the linear mode of the same energy.
ABOVE_LINEAR = (
    "peak von Mises stress of the linear mode at this energy (Pa)",
    "peak von Mises stress above that of the linear mode (Pa)",
)

#: A bound within this part of the largest one counts as reached.
_ROUND_OFF = 1e-12


def peaks(times: Array, stress: Array, mises: Array) -> Array:
    """Largest von Mises and principal stress at each node, and when they occur first.

    Contact forces are short, so that many instants are searched.

    Args:
        times: Instants as parts of the period, shape (t,).
        stress: Stress in Pa at these, shape (t, nodes, 6).
        mises: Its von Mises stress, shape (t, nodes).

    Returns:
        The fields of `PEAKS`, shape (4, nodes).
    """
    tension, when = largest_tension(stress, mises)
    return np.array([mises.max(axis=0), times[mises.argmax(axis=0)], tension, times[when]])


def above_linear(mises: Array, linear: Array) -> Array:
    """Peak of the linear mode of the same energy, and how far a motion is above it.

    The mode is that about the state of rest, of the amplitude a with E = (omega a)^2 / 2.

    Args:
        mises: Von Mises stress of the motion in Pa, shape (t, nodes).
        linear: Stress in Pa at both reversals of the linear mode, shape (2, nodes, 6).

    Returns:
        The fields of `ABOVE_LINEAR`, shape (2, nodes).
    """
    of_linear = von_mises(linear).max(axis=0)
    return np.array([of_linear, mises.max(axis=0) - of_linear])


def largest_tension(stress: Array, mises: Array) -> tuple[Array, Indices]:
    """Largest principal stress in Pa over all instants, and its instant, each of shape (nodes,).

    The largest principal stress is at most the mean one and 2/3 of von Mises' (Lode angle zero),
    so that principal stresses are sought only where this is above the largest one known.

    Args:
        stress: Stresses in Pa, shape (instants, nodes, 6).
        mises: Their von Mises stresses, shape (instants, nodes).
    """
    bound = stress[..., :3].sum(axis=-1) / 3 + 2 / 3 * mises
    every = np.arange(stress.shape[1])
    first = principal(stress[bound.argmax(axis=0), every])[:, 0]
    instant, node = np.nonzero(bound >= first - _ROUND_OFF * np.abs(bound).max(axis=0))
    found = np.full(mises.shape, -np.inf)
    found[instant, node] = principal(stress[instant, node])[:, 0]
    return found.max(axis=0), found.argmax(axis=0)


def linear_reversals(shapes: MotionShapes, point: PlacedMotion) -> Array:
    """Amounts of shapes at both reversals of the linear mode of a point's energy, (2, shapes)."""
    header = shapes.branch.header
    mode, rest = header.mode - 1, header.model.at_rest()
    amplitude = np.sqrt(2 * point.motion.energy) / rest.omega[mode]
    motions = (
        (rest.q + a * rest.shapes[:, mode], rest.force + a * rest.pull[:, mode])
        for a in (amplitude, -amplitude)
    )
    return np.array([shapes.of(q, force) for q, force in motions])
