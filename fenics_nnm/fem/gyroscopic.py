"""Coriolis forces of a rotating body, projected on its modes."""

from __future__ import annotations

from functools import partial

import numpy as np
from dolfinx.fem import form
from dolfinx.fem.petsc import assemble_matrix

from fenics_nnm.arrays import Array
from fenics_nnm.fem.attachments import add_at_vertex, add_spread_mass, spread_form
from fenics_nnm.fem.block import product
from fenics_nnm.fem.loads import Rotation
from fenics_nnm.fem.mass import mass_matrix
from fenics_nnm.fem.solid import Solid
from fenics_nnm.reduction.gyroscopic import coriolis_frequencies as frequencies_with
from fenics_nnm.reduction.linear_modes import LinearModes
from fenics_nnm.reduction.operators import Operators


def coriolis_forces(solid: Solid, rotation: Rotation, shapes: Array) -> Array:
    """2 Omega int rho v . (e x phi_j) dx, shape (n_owned, J), zero where the body is held.

    They are the Coriolis forces, but for their sign, per unit rate of shapes; on all ranks.

    Args:
        solid: Assembled body.
        rotation: Rotation with the speed Omega and the unit vector e of its axis.
        shapes: Mass-normalised shapes at the owned degrees of freedom, shape (n_owned, J).
    """
    dim = solid.tagged.dim
    turned = np.einsum(
        "ab,nbj->naj", rotation.spin[:dim, :dim], shapes.reshape(-1, dim, shapes.shape[1])
    )
    forces = 2 * rotation.speed * inertia_of_free_body(solid, turned.reshape(shapes.shape))
    forces[solid.clamped[solid.clamped < solid.owned]] = 0.0
    return np.asarray(forces)


def coriolis_frequencies(
    solid: Solid,
    rotation: Rotation,
    modes: LinearModes,
    operators: Operators,
    count: int | None = None,
) -> Array:
    """Circular frequencies with Coriolis forces in rad/s; on all ranks.

    Args:
        solid: Assembled body.
        rotation: Rotation.
        modes: Modes without Coriolis forces.
        operators: Products of the body.
        count: As `reduction.gyroscopic.coriolis_frequencies`.

    Raises:
        ModelError: if a shape that is added moves no mass.
    """
    forces = partial(coriolis_forces, solid, rotation)
    return frequencies_with(modes, forces, operators, count)


def inertia_of_free_body(solid: Solid, columns: Array) -> Array:
    """M u with the mass of a body that nothing holds: e x u may point along a held direction."""
    body, space, none = solid.body, solid.space, np.empty(0, dtype=np.int32)
    matrix = mass_matrix(space, solid.regions, body.extent)
    for each in body.attachments:
        if each.kind == "mass" and each.point:
            add_at_vertex(matrix, space, solid.vertices[each.key], each.values, none)
        elif each.kind == "mass":
            spread = form(spread_form(space, solid.tagged, each, none, body.extent))
            add_spread_mass(matrix, assemble_matrix(spread))
    found = product(matrix, columns)
    matrix.destroy()
    return found
