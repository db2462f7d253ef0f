"""Vertices of all patches, of which some become contact points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from mpi4py import MPI
from scipy.sparse import csr_array, vstack

from fenics_nnm.arrays import Array, Indices, Mask
from fenics_nnm.fem.contact_patch import nearest_of
from fenics_nnm.fem.patch_sites import Patch, PatchSites, patch_sites
from fenics_nnm.fem.rows import along, along_axes, owned_rows
from fenics_nnm.fem.solid import Solid

Chosen = tuple[Indices, ...]
"""Which vertices of each patch become contact points, ascending."""


@dataclass(frozen=True, slots=True)
class ContactSites:
    """Vertices that can become contact points, patch by patch, the same on all ranks.

    Attributes:
        parts: Those of each patch.
        weights: Weights of the displacement blocks that this rank owns in the displacement of
            each vertex, shape (n, owned blocks).
        comm: Communicator.
    """

    parts: tuple[PatchSites, ...]
    weights: csr_array
    comm: MPI.Comm

    @property
    def points(self) -> Array:
        """Coordinates in m, shape (n, dim)."""
        return np.concatenate([part.points for part in self.parts])

    @property
    def directions(self) -> Array:
        """Unit vectors towards the obstacle, shape (n, dim)."""
        return np.concatenate([part.directions for part in self.parts])

    @property
    def gap(self) -> Array:
        """Initial gaps in m, infinite where there is nothing to be met, shape (n,)."""
        return np.concatenate([part.gap for part in self.parts])

    @property
    def ends(self) -> Indices:
        """Where the vertices of each patch but the last one end."""
        return np.cumsum([len(part.gap) for part in self.parts])[:-1]

    @property
    def limited(self) -> bool:
        """Whether some vertices are left out."""
        return any(part.count < len(part.gap) for part in self.parts)

    def displacement(self, local: Array) -> Array:
        """Displacements along the contact directions, as `ContactInterface.displacement`."""
        return along(self.directions, self.weights, local, self.comm)

    def displacements(self, local: Array) -> Array:
        """Displacements along the axes, as `ContactInterface.displacements`."""
        return along_axes(self.weights, local, self.directions.shape[1], self.comm)

    def taken(self, number: int, chosen: Chosen) -> Mask:
        """Which vertices of a patch are contact points of another one along the same line."""
        own = self.parts[number]
        taken = np.zeros(len(own.gap), dtype=bool)
        for part, some in zip(self.parts, chosen, strict=True):
            if part is not own:
                taken |= own.shared_with(part, some)
        return taken

    def point_of_each(self, chosen: Chosen) -> Indices:
        """The contact point nearest to each vertex, of its own patch, shape (n,)."""
        firsts = np.cumsum([0, *(len(some) for some in chosen)])
        parts = zip(firsts, self.parts, chosen, strict=False)
        return np.concatenate(
            [first + nearest_of(part.points, part.points[some]) for first, part, some in parts]
        )


def contact_sites(solid: Solid, patches: Sequence[Patch]) -> ContactSites:
    """Vertices of patches; called on all ranks.

    Raises:
        MeshError, ModelError: as `contact_interface`.
    """
    parts = tuple(patch_sites(solid, patch) for patch in patches)
    weights = [owned_rows(solid, part.entries, len(part.gap)) for part in parts]
    return ContactSites(parts, csr_array(vstack(weights)), solid.tagged.mesh.comm)
