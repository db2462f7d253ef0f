"""Unit forces at a vertex or spread over facets, as columns at the degrees of freedom."""

from __future__ import annotations

import numpy as np
import ufl
from dolfinx import fem
from dolfinx import mesh as dmesh
from dolfinx.fem.petsc import assemble_vector
from petsc4py import PETSc

from fenics_nnm.arrays import Array
from fenics_nnm.errors import MeshError
from fenics_nnm.fem.attachment import Attachment
from fenics_nnm.fem.attachments import nearest_vertex
from fenics_nnm.fem.solid import Solid
from fenics_nnm.reduction.attached import AttachedPoints


def unit_rows(solid: Solid, attachment: Attachment) -> Array:
    """A unit force along each axis, shape (n_owned, dim); to be called on all ranks.

    Spread over facets it is even, so that the displacement that goes with it is their mean.

    Args:
        solid: Assembled body.
        attachment: Where: a point, or groups of facets.

    Raises:
        MeshError: if the point is not on the body or clamped, or a group is unknown.
    """
    dim = solid.tagged.dim
    if attachment.point:
        rows = np.zeros((solid.owned, dim))
        block = nearest_vertex(solid.space, solid.tagged, attachment, solid.clamped).block
        if block >= 0:
            rows[block * dim + np.arange(dim), np.arange(dim)] = 1.0
        return rows
    return np.column_stack([_spread(solid, attachment, axis) for axis in range(dim)])


def force_row(solid: Solid, force: Attachment) -> Array:
    """A unit force along a force, shape (n_owned,); to be called on all ranks.

    Raises:
        MeshError: as `unit_rows`, or if the force acts on what is clamped.
    """
    row = unit_rows(solid, force) @ force.values / np.linalg.norm(force.values)
    row[solid.clamped[solid.clamped < solid.owned]] = 0.0
    if not solid.tagged.mesh.comm.allreduce(int(row.any())):
        raise MeshError(f"{force.key}: acts on what is clamped: a {force.kind} there has no effect")
    return np.asarray(row)


def attached_points(solid: Solid) -> AttachedPoints:
    """Points of the springs that are not linear, along the axes; to be called on all ranks."""
    rows: list[Array] = [np.zeros((solid.owned, 0))]
    cubic: list[Array] = [np.zeros(0)]
    for each in solid.body.attachments:
        stiffnesses = np.array(each.cubic)
        if stiffnesses.any():
            chosen = np.flatnonzero(stiffnesses)
            rows.append(unit_rows(solid, each)[:, chosen])
            cubic.append(stiffnesses[chosen])
    return AttachedPoints(np.hstack(rows), np.concatenate(cubic))


def _spread(solid: Solid, attachment: Attachment, axis: int) -> Array:
    """A unit force along an axis, even over facets, shape (n_owned,)."""
    mesh, tagged = solid.tagged.mesh, solid.tagged
    facets = tagged.facets_of(attachment.facets, f"{attachment.key}.facets")
    tags = dmesh.meshtags(mesh, tagged.dim - 1, facets, np.ones(len(facets), dtype=np.int32))
    ds = ufl.Measure("ds", domain=mesh, subdomain_data=tags)(1)
    size = mesh.comm.allreduce(fem.assemble_scalar(fem.form(fem.Constant(mesh, 1.0) * ds)))
    test = ufl.TestFunction(solid.space)
    vector = assemble_vector(fem.form(fem.Constant(mesh, 1.0 / size) * test[axis] * ds))
    vector.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)
    row = np.array(vector.array[: solid.owned])
    row[solid.clamped[solid.clamped < solid.owned]] = 0.0
    vector.destroy()
    return row
