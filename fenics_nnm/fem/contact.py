"""Contact points of several patches: rows of displacement, directions, gaps, tributary areas."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from mpi4py import MPI
from scipy.sparse import csr_array, vstack

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.errors import ModelError
from fenics_nnm.fem.contact_patch import patch_points
from fenics_nnm.fem.contact_sites import Chosen, ContactSites, contact_sites
from fenics_nnm.fem.patch_sites import Patch
from fenics_nnm.fem.rows import along, along_axes
from fenics_nnm.fem.solid import Solid
from fenics_nnm.reduction.point_choice import spread

#: Contact rows whose cosine differs from 1 by less are the same.
_SAME_ROW = 1e-9


@dataclass(frozen=True, slots=True)
class ContactInterface:
    """Contact points, the same on all ranks: patch by patch, in the order of the mesh's nodes.

    The displacement of contact point c towards its obstacle is d_c . sum_i W_ci u_i over the
    displacement blocks i: that of a vertex, or the mean about it, or, where two patches face each
    other, the displacement of a vertex relative to the place opposite.

    Attributes:
        points: Coordinates in m, shape (n_c, dim).
        directions: Unit vectors d towards the obstacle, shape (n_c, dim).
        areas: Tributary areas in m^2, shape (n_c,).
        gap: Initial gaps in m, shape (n_c,).
        patch: Number of the patch of each point, from 0, shape (n_c,).
        names: Name of each patch.
        left_out: Number of vertices of each patch that have nothing opposite.
        weights: W of the blocks that this rank owns, shape (n_c, owned blocks).
        pressures: Pressure in Pa at the vertices that this rank owns under a unit force at each
            contact point, shape (owned vertices, n_c).
        sides: Local facets of each patch, and those opposite to it, which may be none.
        comm: Communicator.
        held: Owned degrees of freedom that are held, on which no force acts.
    """

    points: Array
    directions: Array
    areas: Array
    gap: Array
    patch: Indices
    names: tuple[str, ...]
    left_out: tuple[int, ...]
    weights: csr_array
    pressures: csr_array
    sides: tuple[tuple[Indices, Indices], ...]
    comm: MPI.Comm
    held: Indices = field(default_factory=lambda: np.empty(0, dtype=np.int32))

    @property
    def count(self) -> int:
        """Number of contact points n_c."""
        return len(self.gap)

    def displacement(self, local: Array) -> Array:
        """B u: displacements in the contact directions.

        Args:
            local: Columns of owned degrees of freedom, shape (n_owned, k).

        Returns:
            Shape (n_c, k), the same on all ranks.
        """
        return along(self.directions, self.weights, local, self.comm)

    def displacements(self, local: Array) -> Array:
        """W u: displacements along the axes, shape (n_c, dim, k), the same on all ranks.

        Args:
            local: Columns of owned degrees of freedom, shape (n_owned, k).
        """
        return along_axes(self.weights, local, self.points.shape[1], self.comm)

    def unit_forces(self, owned: int) -> Array:
        """B^T: a unit force in the contact direction at each point, shape (n_owned, n_c)."""
        dim = self.points.shape[1]
        forces = np.zeros((owned, self.count), order="F")
        whole = self.weights.copy()
        whole.sum_duplicates()
        entries = whole.tocoo()
        for axis in range(dim):
            along = entries.data * self.directions[entries.row, axis]
            forces[dim * entries.col + axis, entries.row] = along
        forces[self.held] = 0.0
        return forces

    def unit_forces_all_directions(self, owned: int) -> Array:
        """A unit force along each free axis at each point, shape (n_owned, <= k dim).

        Points of several patches at one vertex have the same such forces, and count once: k <= n_c.
        """
        dim = self.points.shape[1]
        pairs = _same(self._products())
        again = np.unique(pairs[:, 1])
        whole = np.delete(self.weights.toarray(), again, axis=0).T
        forces = np.zeros((owned, whole.shape[1] * dim))
        for axis in range(dim):
            forces[axis::dim, axis::dim] = whole
        forces[self.held] = 0.0
        acting = self.comm.allreduce(np.abs(forces).sum(axis=0)) > 0
        return forces[:, acting]

    def assert_independent(self, keys: Sequence[str]) -> None:
        """Refuse patches that share a contact point along the same line.

        Args:
            keys: Place of each patch in the study file.

        Raises:
            ModelError: if two contact rows are the same up to a factor.
        """
        pairs = _same(self._products() * (self.directions @ self.directions.T))
        if len(pairs):
            first, second = pairs[0]
            place = ", ".join(f"{x:.6g}" for x in self.points[second])
            raise ModelError(
                f"{keys[self.patch[second]]}: the point at ({place}) m is one of "
                f"{keys[self.patch[first]]} too, along the same line: patches that share a vertex "
                "must have different directions there, and two facing patches stand once"
            )

    def _products(self) -> Array:
        """Scalar products of the rows of W, shape (n_c, n_c)."""
        return np.asarray(self.comm.allreduce((self.weights @ self.weights.T).toarray()))


def contact_interface(solid: Solid, patches: Sequence[Patch]) -> ContactInterface:
    """Make contact points of evenly spread vertices of patches.

    Raises:
        MeshError: if facets are empty, inside the body or touch the clamp, or have fewer vertices
            than wanted.
        ModelError: if a direction is not defined somewhere, a point has no counterpart, or patches
            share a point along the same line.
        GeometryError: if a contact direction does not meet a casing.
    """
    sites = contact_sites(solid, patches)
    return interface_at(solid, sites, evenly_chosen(sites))


def evenly_chosen(sites: ContactSites) -> Chosen:
    """As many vertices of each patch as are asked for, evenly spread."""
    return tuple(spread(part.points, part.count) for part in sites.parts)


def interface_at(solid: Solid, sites: ContactSites, chosen: Chosen) -> ContactInterface:
    """Make contact points of some vertices of patches; called on all ranks.

    Args:
        solid: Assembled body.
        sites: Vertices of the patches.
        chosen: Which of them become contact points.

    Raises:
        ModelError: if patches share a point along the same line.
        GeometryError: if a contact direction does not meet a casing.
    """
    patches = [part.patch for part in sites.parts]
    found = [patch_points(solid, *each) for each in zip(sites.parts, chosen, strict=True)]
    counts = [len(part.gap) for part in found]
    interface = ContactInterface(
        points=np.concatenate([part.points for part in found]),
        directions=np.concatenate([part.directions for part in found]),
        areas=np.concatenate([part.areas for part in found]),
        gap=np.concatenate([part.gap for part in found]),
        patch=np.repeat(np.arange(len(found)), counts),
        names=tuple(patch.name for patch in patches),
        left_out=tuple(part.left_out for part in found),
        weights=csr_array(vstack([part.weights for part in found])),
        pressures=csr_array(vstack([part.pressures.T for part in found]).T),
        sides=tuple(_sides(patch) for patch in patches),
        comm=solid.tagged.mesh.comm,
        held=solid.clamped[solid.clamped < solid.owned],
    )
    interface.assert_independent([patch.key for patch in patches])
    return interface


def _sides(patch: Patch) -> tuple[Indices, Indices]:
    opposite = np.empty(0, dtype=np.int32) if patch.opposite is None else patch.opposite.facets
    return patch.facets, opposite


def _same(products: Array) -> Indices:
    """Pairs (i < j) of rows that are the same up to a factor, from their scalar products."""
    lengths = np.sqrt(np.diagonal(products))
    cosines = np.abs(products) / np.outer(lengths, lengths)
    return np.argwhere(np.triu(cosines > 1 - _SAME_ROW, 1))
