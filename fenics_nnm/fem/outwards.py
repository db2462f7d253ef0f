"""Whether contact directions leave the body: their angles to its outward normals."""

from __future__ import annotations

import numpy as np
from scipy.spatial import KDTree

from fenics_nnm.arrays import Array
from fenics_nnm.fem.contact import ContactInterface
from fenics_nnm.fem.patch_vertices import PatchVertices
from fenics_nnm.fem.solid import Solid


def mean_angles(solid: Solid, interface: ContactInterface) -> tuple[float, ...]:
    """Mean angle of each patch between contact directions and outward normals, in degrees.

    The mean over the contact points, weighted by their areas; 0 along the normal, 180 against it.
    To be called on all ranks.
    """
    normals = np.concatenate(
        [_normals(solid, interface, number) for number in range(len(interface.names))]
    )
    cosines = np.einsum("ij,ij->i", normals, interface.directions)
    angles = np.degrees(np.arccos(np.clip(cosines, -1.0, 1.0)))
    return tuple(
        float(np.average(angles[mine], weights=interface.areas[mine]))
        for mine in (interface.patch == number for number in range(len(interface.names)))
    )


def _normals(solid: Solid, interface: ContactInterface, number: int) -> Array:
    """Outward unit normals of the facets of a patch at its contact points, shape (n, dim)."""
    vertices = PatchVertices.of(solid, interface.sides[number][0], "", "")
    points = interface.points[interface.patch == number]
    normals = vertices.normals[KDTree(vertices.points).query(points)[1]]
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.asarray(np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0))
