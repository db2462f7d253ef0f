"""Coriolis forces of a rotating body, projected on its modes."""

from __future__ import annotations

import numpy as np
from dolfinx.fem import form
from dolfinx.fem.petsc import assemble_matrix

from fenics_nnm.arrays import Array
from fenics_nnm.fem.attachments import add_at_vertex, spread_form
from fenics_nnm.fem.block import product
from fenics_nnm.fem.loads import Rotation
from fenics_nnm.fem.solid import Solid, inertia_form


def gyroscopic_matrix(solid: Solid, rotation: Rotation, shapes: Array) -> Array:
    """G_ij = 2 Omega int rho phi_i . (e x phi_j) dx in 1/s, skew, shape (J, J); on all ranks.

    Args:
        solid: Assembled body.
        rotation: Rotation with the speed Omega and the unit vector e of its axis.
        shapes: Mass-normalised shapes at the owned degrees of freedom, shape (n_owned, J).
    """
    dim = solid.tagged.dim
    turned = np.einsum(
        "ab,nbj->naj", rotation.spin[:dim, :dim], shapes.reshape(-1, dim, shapes.shape[1])
    )
    pulled = _inertia(solid, turned.reshape(shapes.shape))
    G = 2 * rotation.speed * solid.tagged.mesh.comm.allreduce(shapes.T @ pulled)
    return np.asarray((G - G.T) / 2)


def _inertia(solid: Solid, columns: Array) -> Array:
    """M u with the mass of a body that nothing holds: e x u may point along a held direction."""
    body, space, none = solid.body, solid.space, np.empty(0, dtype=np.int32)
    matrix = assemble_matrix(form(inertia_form(space, body, solid.regions)))
    matrix.assemble()
    for each in body.attachments:
        if each.kind == "mass" and each.point:
            add_at_vertex(matrix, space, solid.vertices[each.key], each.values, none)
        elif each.kind == "mass":
            spread = form(spread_form(space, solid.tagged, each, none, body.extent))
            assemble_matrix(matrix, spread)
            matrix.assemble()
    found = product(matrix, columns)
    matrix.destroy()
    return found
