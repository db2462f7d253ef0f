"""The largest stresses of a period, and where contact raises them."""

from __future__ import annotations

import numpy as np

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.fields.invariants import principal, von_mises
from fenics_nnm.fields.stress_basis import StressBasis
from fenics_nnm.nonlinear.point import BranchPoint

#: Instants of a period at which the largest stress is sought, besides those of the frames.
_INSTANTS = 128

#: A bound within this part of the largest one counts as reached.
_ROUND_OFF = 1e-12

#: Nodes whose stress at all instants is held in memory at once.
_NODES_AT_ONCE = 2_000


def peak_stress(basis: StressBasis, point: BranchPoint, frames: int) -> dict[str, Array]:
    """Largest von Mises and principal stress at each node of the grid, and when they occur.

    Contact forces are short, so the period is searched at 128 instants and at those of the frames.
    Beside the peak is that of the linear mode about the state of rest of the same energy
    E = (omega a)^2 / 2, and how far the motion is above it.

    Args:
        basis: Stresses of the shapes of the branch.
        point: Point of the branch.
        frames: Number of frames of its files.
    """
    instants = [np.arange(count) / count for count in (frames, _INSTANTS)]
    times = np.unique(np.concatenate(instants))
    moved = basis.coordinates(point, 2 * np.pi * times)
    reversals = _linear_reversals(basis, point)
    nodes = basis.stresses.shape[1]
    parts = [
        _peaks(basis.stress(moved, part), basis.stress(reversals, part))
        for part in (slice(i, i + _NODES_AT_ONCE) for i in range(0, nodes, _NODES_AT_ONCE))
    ]
    mises, mises_at, tension, tension_at, linear = (
        np.concatenate(values) for values in zip(*parts, strict=True)
    )
    return {
        "peak von Mises stress (Pa)": mises,
        "phase of peak von Mises stress (periods)": times[mises_at],
        "peak largest principal stress (Pa)": tension,
        "phase of peak largest principal stress (periods)": times[tension_at],
        "peak von Mises stress of the linear mode at this energy (Pa)": linear,
        "peak von Mises stress above that of the linear mode (Pa)": mises - linear,
    }


def _peaks(stress: Array, linear: Array) -> tuple[Array, Indices, Array, Indices, Array]:
    """Peaks of stresses (instants, nodes, 6), their instants, and the peak of the linear mode."""
    mises = von_mises(stress)
    tension, when = largest_tension(stress, mises)
    return mises.max(axis=0), mises.argmax(axis=0), tension, when, von_mises(linear).max(axis=0)


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


def _linear_reversals(basis: StressBasis, point: BranchPoint) -> Array:
    """Coordinates at both reversals of the linear mode of the point's energy, shape (2, shapes)."""
    header = basis.branch.header
    mode, rest = header.mode - 1, header.model.at_rest()
    amplitude = np.sqrt(2 * point.energy) / rest.omega[mode]
    motions = (
        (rest.q + a * rest.shapes[:, mode], rest.force + a * rest.pull[:, mode])
        for a in (amplitude, -amplitude)
    )
    return np.array([basis.of_shapes(q, force) for q, force in motions])
