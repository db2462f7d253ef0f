"""The largest stresses of a period, and where contact raises them."""

from __future__ import annotations

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.fields.body import FieldBody
from fenics_nnm.fields.invariants import principal, von_mises
from fenics_nnm.nonlinear.point import BranchPoint
from fenics_nnm.output.stored_branch import StoredBranch

#: Instants of a period at which the largest stress is sought, besides those of the frames.
_INSTANTS = 128


def peak_stress(
    branch: StoredBranch, body: FieldBody, point: BranchPoint, frames: int
) -> dict[str, Array]:
    """Largest von Mises and principal stress at each node of the grid, and when they occur.

    Contact forces are short, so the period is searched at 128 instants and at those of the frames.
    Beside the peak is that of the linear mode about the state of rest of the same energy
    E = (omega a)^2 / 2, and how far the motion is above it.

    Args:
        branch: Branch.
        body: Its body.
        point: Point of the branch.
        frames: Number of frames of its files.
    """
    instants = [np.arange(count) / count for count in (frames, _INSTANTS)]
    times = np.unique(np.concatenate(instants))
    mises, when_mises = np.full(body.grid.nodes, -np.inf), np.zeros(body.grid.nodes)
    tension, when_tension = mises.copy(), when_mises.copy()
    for time in times:
        (displacement,) = branch.displacement(point, np.array([2 * np.pi * time]))
        stress = body.stress(displacement)
        _raise(mises, when_mises, von_mises(stress), time)
        _raise(tension, when_tension, principal(stress)[:, 0], time)
    reversals = _linear_reversals(branch, point)
    linear = np.max([von_mises(body.stress(displacement)) for displacement in reversals], axis=0)
    return {
        "peak von Mises stress (Pa)": mises,
        "phase of peak von Mises stress (periods)": when_mises,
        "peak largest principal stress (Pa)": tension,
        "phase of peak largest principal stress (periods)": when_tension,
        "peak von Mises stress of the linear mode at this energy (Pa)": linear,
        "peak von Mises stress above that of the linear mode (Pa)": mises - linear,
    }


def _raise(peak: Array, when: Array, values: Array, time: float) -> None:
    """Put larger values in place of the peaks so far."""
    larger = values > peak
    peak[larger], when[larger] = values[larger], time


def _linear_reversals(branch: StoredBranch, point: BranchPoint) -> list[Array]:
    """Displacements in m at both reversals of the linear mode of the point's energy."""
    mode, rest = branch.header.mode - 1, branch.header.model.at_rest()
    amplitude = np.sqrt(2 * point.energy) / rest.omega[mode]
    return [
        branch.field(rest.q + a * rest.shapes[:, mode], rest.force + a * rest.pull[:, mode])
        for a in (amplitude, -amplitude)
    ]
