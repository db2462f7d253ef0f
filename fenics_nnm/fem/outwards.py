"""How contact directions leave the body: their angles to its outward normals."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from mpi4py import MPI
from scipy.spatial import KDTree

from fenics_nnm.arrays import Array
from fenics_nnm.fem.contact import ContactInterface
from fenics_nnm.fem.patch_vertices import PatchVertices
from fenics_nnm.fem.solid import Solid


@dataclass(frozen=True, slots=True)
class Leaving:
    """How the contact directions of a patch leave the body.

    Attributes:
        mean: Mean angle to the outward normals in degrees, weighted by area: 0 along the normals,
            180 against them.
        lowest: Smallest angle of a contact point.
        highest: Largest angle of a contact point.
        length: Length of the patch along its mean direction in m.
        beyond: How far the body goes on from there along the mean direction, in m.
    """

    mean: float
    lowest: float
    highest: float
    length: float
    beyond: float


def leavings(solid: Solid, interface: ContactInterface) -> tuple[Leaving, ...]:
    """How the directions of each patch leave the body; to be called on all ranks."""
    return tuple(_leaving(solid, interface, number) for number in range(len(interface.names)))


def _leaving(solid: Solid, interface: ContactInterface, number: int) -> Leaving:
    mine = interface.patch == number
    points, directions = interface.points[mine], interface.directions[mine]
    vertices = PatchVertices.of(solid, interface.sides[number][0], "", "")
    nearest = KDTree(vertices.points).query(points)[1]
    cosines = np.einsum("ij,ij->i", _unit(vertices.normals[nearest]), directions)
    angles = np.degrees(np.arccos(np.clip(cosines, -1.0, 1.0)))
    mean = _unit(directions.mean(axis=0))
    along = vertices.points @ mean
    return Leaving(
        mean=float(np.average(angles, weights=interface.areas[mine])),
        lowest=float(angles.min()),
        highest=float(angles.max()),
        length=float(np.ptp(along)),
        beyond=_farthest(solid, mean) - float(along.max()),
    )


def _unit(vectors: Array) -> Array:
    """Unit vectors along vectors, zero where they are."""
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(np.divide(vectors, lengths, out=np.zeros_like(vectors), where=lengths > 0))


def _farthest(solid: Solid, direction: Array) -> float:
    """Largest coordinate of the body along a direction in m; the same on all ranks."""
    tagged = solid.tagged
    here = (tagged.mesh.geometry.x[:, : tagged.dim] @ direction).max(initial=-np.inf)
    return float(tagged.mesh.comm.allreduce(here, op=MPI.MAX))
