"""The contact surface as a grid of its own."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.fem.reference_cell import facet_parents, facet_type, reference_cell
from fenics_nnm.fields.vtu import GridFile, grid_file
from fenics_nnm.output.stored_branch import StoredBranch


@dataclass(frozen=True, slots=True)
class ContactSurface:
    """Facets that can touch, and values at the contact points spread over them.

    At a vertex there is the value of the contact point that stands for it, and facets are linear
    between their vertices, so that the pressure p = lambda / A, with the tributary area A of a
    contact point, has the integral sum(lambda) over the surface: A is the sum of the integrals of
    the hat functions of the point's vertices.

    Attributes:
        grid: Grid of the files.
        nodes: Node of the branch's mesh at each of its nodes.
        weights: Share of each contact point in the value at each node, shape (nodes, n_c).
    """

    grid: GridFile
    nodes: Indices
    weights: Array

    def spread(self, values: Array) -> Array:
        """Values at the nodes of the surface, shape (nodes,), of those at contact points (n_c,)."""
        return np.asarray(self.weights @ values)


def contact_surface(branch: StoredBranch) -> ContactSurface:
    """Prepare the contact surface of a branch."""
    dim, degree = branch.shapes.shape[2], reference_cell(branch.cell_type).degree
    nodes, number = np.unique(branch.contact_facets, return_inverse=True)
    facets = number.reshape(branch.contact_facets.shape)
    kind = facet_type(dim, degree, facets.shape[1])
    stands_for = np.full(len(nodes), -1)
    contact, points = branch.contact_patch
    stands_for[np.searchsorted(nodes, contact)] = points
    weights = np.zeros((len(nodes), len(branch.contact_points)))
    for place, parents in enumerate(facet_parents(kind)):
        # several facets say the same of a node that they share
        node, first = np.unique(facets[:, place], return_index=True)
        weights[node] = 0.0
        for parent in parents:
            weights[node, stands_for[facets[first, parent]]] += 1.0 / len(parents)
    return ContactSurface(grid_file(branch.nodes[nodes], facets, kind), nodes, weights)
