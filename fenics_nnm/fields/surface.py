"""The contact surfaces as a grid of their own."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array, lil_array

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.fem.reference_cell import facet_parents, facet_type, reference_cell
from fenics_nnm.fields.vtu import GridFile, grid_file
from fenics_nnm.results.stored_branch import StoredBranch


@dataclass(frozen=True, slots=True)
class ContactSurface:
    """Facets that can touch, and what is known of their contact points spread over them.

    Nodes are there once for each patch, and once for each of its two sides. Both pressure and gap
    are linear between the vertices of a facet. A contact point c has the pressure lambda_c / A_c
    at its vertices, and A_c is the sum of the integrals of their hat functions, so that on each
    side the pressure has the integral sum(lambda).

    Attributes:
        grid: Grid of the files.
        nodes: Node of the branch's mesh at each of its nodes.
        pressures: Pressure in Pa at each node per N of each contact force, shape (nodes, n_c).
        shares: Share of each contact point in the gap at each node, shape (nodes, n_c); the
            sum of a row is below 1 where nothing is opposite.
    """

    grid: GridFile
    nodes: Indices
    pressures: csr_array
    shares: csr_array

    def pressure(self, forces: Array) -> Array:
        """Contact pressure in Pa at the nodes of forces (n_c,) in N."""
        return np.asarray(self.pressures @ forces)

    def gap(self, gaps: Array) -> Array:
        """Gap in m at the nodes of gaps (n_c,) of contact points; nan where nothing is opposite."""
        known = np.asarray(self.shares.sum(axis=1)) > 1 - 1e-9
        return np.where(known, self.shares @ gaps, np.nan)


def contact_surface(branch: StoredBranch) -> ContactSurface:
    """Prepare the contact surfaces of a branch."""
    dim, degree = branch.shapes.shape[2], reference_cell(branch.cell_type).degree
    side = 2 * branch.facet_patch + branch.facet_side
    listed = np.broadcast_to(side[:, None], branch.contact_facets.shape)
    pairs = np.stack([branch.contact_facets.ravel(), listed.ravel()])
    (nodes, sides), number = np.unique(pairs, axis=1, return_inverse=True)
    facets = number.reshape(branch.contact_facets.shape)
    kind = facet_type(dim, degree, facets.shape[1])
    vertices = _at_vertices(branch, nodes, sides)
    spread = _between_vertices(facets, facet_parents(kind), len(nodes))
    grid = grid_file(branch.nodes[nodes], facets, kind)
    return ContactSurface(grid, nodes, spread @ vertices, spread @ _shares(vertices))


def _at_vertices(branch: StoredBranch, nodes: Indices, sides: Indices) -> csr_array:
    """Pressure at each node of the surface that is a vertex, per contact force."""
    found = lil_array((len(nodes), len(branch.contact_points)))
    place = {(int(node), int(sides[row])): row for row, node in enumerate(nodes)}
    for node, point, pressure in branch.contact_pressures.T:
        patch = int(branch.contact_patches[int(point)])
        for side in (2 * patch, 2 * patch + 1):
            row = place.get((int(node), side))
            if row is not None:
                found[row, int(point)] = pressure
    return csr_array(found)


def _shares(vertices: csr_array) -> csr_array:
    """Equal shares of the contact points of each vertex."""
    counts = np.diff(vertices.indptr)
    shares = 1.0 / np.repeat(counts, counts)
    return csr_array((shares, vertices.indices, vertices.indptr), vertices.shape)


def _between_vertices(facets: Indices, parents: tuple[Indices, ...], count: int) -> csr_array:
    """Mean of the vertices of the edge or facet that each node lies in, shape (nodes, nodes)."""
    found = lil_array((count, count))
    for place, corners in enumerate(parents):
        for facet in facets:
            found[facet[place], facet[corners]] = 1.0 / len(corners)
    return csr_array(found)
