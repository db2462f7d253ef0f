"""Motions over one period, as arrays with their units in the names."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array, in_space
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.errors import OutputError
from fenics_nnm.face.arguments import whole
from fenics_nnm.face.loaded import Loaded
from fenics_nnm.results.stored_branch import StoredBranch
from fenics_nnm.results.stored_unknowns import stored_shapes

#: A place may be as far from the nearest node as this part of the largest extent of the body.
_BESIDE = 0.1

Place = Sequence[float] | Array
"""A place (x, y, z) in m; of a plane or a rod fewer coordinates, the others are 0."""


@dataclass(frozen=True, slots=True, eq=False)
class ContactHistory:
    """Contact over one period, at s instants and n_c contact points.

    Attributes:
        time_s: Instants in s from the beginning of the period, its end left out, shape (s,).
        force_N: Contact forces in N, not negative, shape (s, n_c).
        displacement_m: Displacement towards the obstacle in m, shape (s, n_c).
        velocity_m_per_s: Its derivative by time in m/s, shape (s, n_c).
        distance_m: Distance to the obstacle in m, shape (s, n_c).
    """

    time_s: Array
    force_N: Array
    displacement_m: Array
    velocity_m_per_s: Array
    distance_m: Array


@dataclass(frozen=True, slots=True, eq=False)
class MotionHistory:
    """Motion of k nodes of the mesh over one period, at s instants.

    Attributes:
        time_s: Instants in s from the beginning of the period, its end left out, shape (s,).
        places_m: Where the nodes are at rest without loads, in m, shape (k, 3).
        displacement_m: Displacement from rest in m, shape (s, k, 3).
        velocity_m_per_s: Velocity in m/s, shape (s, k, 3).
    """

    time_s: Array
    places_m: Array
    displacement_m: Array
    velocity_m_per_s: Array


def contact_history(loaded: Loaded, point: BranchPoint, instants: int) -> ContactHistory:
    """Contact of a point of a branch.

    Raises:
        ValueError: if there is not one instant at least.
    """
    phase, results = phases(instants), loaded.results
    displacement = results.contact_displacement(point, phase)
    return ContactHistory(
        time_s=phase / (2 * np.pi * point.motion.frequency),
        force_N=results.forces(point, phase),
        displacement_m=displacement,
        velocity_m_per_s=results.contact_velocity(point, phase),
        distance_m=results.model.gap - displacement,
    )


def motion_history(
    loaded: Loaded, point: BranchPoint, at: Sequence[Place] | None, instants: int
) -> MotionHistory:
    """Motion of the nodes nearest to some places; of the one that moves most if none are given.

    Raises:
        OutputError: if the results are of matrices, or a place is not on the body.
        ValueError: if a place is none, or there is not one instant at least.
    """
    body, phase = loaded.body("motion"), phases(instants)
    if at is not None and not len(at):
        raise ValueError("at = []: must be a place at least, as in [(0, 0, 0.1)]")
    nodes = np.array([loaded.results.tip] if at is None else [node_at(body, each) for each in at])
    shape = (len(phase), len(nodes), -1)
    moved, moving = (way(point, phase, nodes) for way in (body.displacement, body.velocity))
    return MotionHistory(
        time_s=phase / (2 * np.pi * point.motion.frequency),
        places_m=body.nodes[nodes],
        displacement_m=_in_space(moved).reshape(shape),
        velocity_m_per_s=_in_space(moving).reshape(shape),
    )


@dataclass(frozen=True, slots=True, eq=False)
class UnknownsHistory:
    """Displacement of all n unknowns of matrices over one period, at s instants.

    Attributes:
        time_s: Instants in s from the beginning of the period, its end left out, shape (s,).
        displacement_m: Displacement from rest in m, in the order of the matrices, shape (s, n).
    """

    time_s: Array
    displacement_m: Array


def unknowns_history(loaded: Loaded, point: BranchPoint, instants: int) -> UnknownsHistory:
    """Displacement of all unknowns of a point of a branch of matrices.

    Raises:
        OutputError: if the results are of a mesh, or cannot be read.
        ValueError: if there is not one instant at least.
    """
    phase, results = phases(instants), loaded.results
    if results.body is not None:
        raise OutputError("unknowns: are those of matrices: the study has a mesh, see motion")
    shapes = stored_shapes(loaded.folder / "branch.h5")
    q = results.series.basis_at(phase) @ point.motion.q
    return UnknownsHistory(
        time_s=phase / (2 * np.pi * point.motion.frequency),
        displacement_m=shapes.displaced(results.model, q, results.forces(point, phase)),
    )


def phases(instants: int) -> Array:
    """Phases omega t of instants of a period at equal steps, its end left out, shape (instants,).

    Raises:
        ValueError: if there is not one at least.
    """
    count = whole("instants", instants)
    return 2 * np.pi * np.arange(count) / count


def node_at(body: StoredBranch, place: Place) -> int:
    """The node nearest to a place in m.

    Raises:
        ValueError: if it is no place.
        OutputError: if it is far from the body: it may be in another unit.
    """
    try:
        given = np.asarray(place, dtype=float)
    except (TypeError, ValueError):
        given = np.empty(0)
    if given.ndim != 1 or not 1 <= len(given) <= 3 or not np.isfinite(given).all():
        raise ValueError(f"at = {place!r}: must be places (x, y, z) in m, as in [(0, 0, 0.1)]")
    given = np.pad(given, (0, 3 - len(given)))
    node = body.node_at(given)
    away, size = np.linalg.norm(body.nodes[node] - given), np.ptp(body.nodes, axis=0).max()
    if away > _BESIDE * size:
        raise OutputError(
            f"at = {tuple(map(float, given))} m: is {away:.3g} m from the nearest node, and the "
            f"body has {size:.3g} m: must be a place on the body in m"
        )
    return node


def _in_space(field: Array) -> Array:
    """Vectors (s, k, dim) with three components, shape (s k, 3)."""
    return in_space(field.reshape(-1, field.shape[2]))
