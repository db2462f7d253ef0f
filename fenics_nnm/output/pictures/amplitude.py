"""How far a structure moves: at the node that moves most, or at its contact points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.nonlinear.point import BranchPoint
from fenics_nnm.output.pictures.results import Results
from fenics_nnm.output.stored_branch import StoredBranch

#: Instants of a period at which the largest displacement is looked for.
_INSTANTS = 48


@dataclass(frozen=True, slots=True)
class Amplitude:
    """Largest distance from rest over a period at each point of a branch.

    Attributes:
        values: In m, shape (points,).
        label: Label of an axis in mm.
        told: What it is, in words.
    """

    values: Array
    label: str
    told: str


def amplitude_of(results: Results) -> Amplitude:
    """The largest displacement of a body, or of the contact points of matrices."""
    phase = 2 * np.pi * np.arange(_INSTANTS) / _INSTANTS
    if results.body is None:
        values = [
            np.abs(results.contact_displacement(point, phase)).max() for point in results.points
        ]
        told = "the largest displacement of a contact point from rest over the period, in mm"
        return Amplitude(np.array(values), "largest displacement at contact  (mm)", told)
    body, tip = results.body, np.array([tip_of(results.body)])
    values = [
        np.linalg.norm(body.displacement(point, phase, tip), axis=2).max()
        for point in results.points
    ]
    x, y, z = 1e3 * body.nodes[tip[0]]
    told = (
        "the largest displacement from rest over the period, in mm, of the node that moves most, "
        f"at ({x:.4g}, {y:.4g}, {z:.4g}) mm"
    )
    return Amplitude(np.array(values), "largest displacement  (mm)", told)


def tip_of(body: StoredBranch) -> int:
    """The node that moves most at the last point."""
    return int(np.argmax(largest_displacements(body, body.points[-1])))


def largest_displacements(body: StoredBranch, point: BranchPoint) -> Array:
    """Largest displacement of each node over the period in m, shape (n,); instant by instant."""
    found = np.zeros(len(body.nodes))
    for phase in 2 * np.pi * np.arange(_INSTANTS) / _INSTANTS:
        field = body.displacement(point, np.array([phase]))[0]
        np.maximum(found, np.linalg.norm(field, axis=1), out=found)
    return found
