"""Facets that pressures act on, which may overlap, tagged for one form."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import ufl
from dolfinx import mesh as dmesh
from mpi4py import MPI

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.errors import MeshError
from fenics_nnm.fem.loads import Pressure
from fenics_nnm.fem.solid import Solid


def pressed(solid: Solid, pressures: Sequence[Pressure]) -> list[ufl.Measure]:
    """The measure of the facets of each pressure; to be called on all ranks.

    A form has one set of tags for all integrals over the surface. So facets have a tag for each
    set of pressures that act on some of them.

    Raises:
        MeshError: if a pressure acts inside the body, or on facets that are not there.
    """
    if not pressures:
        return []
    tagged = solid.tagged
    each = [_facets(solid, pressure) for pressure in pressures]
    facets = np.unique(np.concatenate(each))
    under = np.array([np.isin(facets, own) for own in each]).T
    tags, sets = _tags(under, tagged.mesh.comm)
    tagging = dmesh.meshtags(tagged.mesh, tagged.dim - 1, facets, tags)
    ds = ufl.Measure("ds", domain=tagged.mesh, subdomain_data=tagging)
    own = [tuple(tag for tag, one in enumerate(sets, 1) if one[k]) for k in range(len(each))]
    return [ds(tags if len(tags) > 1 else tags[0]) for tags in own]


def _tags(under: Array, comm: MPI.Intracomm) -> tuple[Indices, list[tuple[bool, ...]]]:
    """The tag of each facet, from 1, and which pressures each tag stands for, on any rank.

    Args:
        under: Whether each pressure acts on each facet, shape (facets, pressures).
        comm: Ranks.
    """
    rows = [tuple(map(bool, row)) for row in under]
    sets = sorted(set().union(*comm.allgather(set(rows))), reverse=True)
    number = {one: tag for tag, one in enumerate(sets, 1)}
    return np.array([number[row] for row in rows], dtype=np.int32), sets


def _facets(solid: Solid, pressure: Pressure) -> Indices:
    tagged, what = solid.tagged, f"{pressure.key}.facets"
    facets, mesh = tagged.facets_of(pressure.facets, what), tagged.mesh
    outside = np.isin(facets, dmesh.exterior_facet_indices(mesh.topology))
    owned = facets < mesh.topology.index_map(tagged.dim - 1).size_local
    inside = int(mesh.comm.allreduce(int(np.count_nonzero(owned & ~outside))))
    if inside:
        raise MeshError(f"{what}: {inside} facets lie inside the body: must be on its surface")
    return facets
