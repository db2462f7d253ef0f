"""An order of the degrees of freedom in which a stiffness has sparse factors: nested dissection.

A. George, SIAM J. Numer. Anal. 10 (1973) 345-363. Cells are halved again and again until a few are
left. The nodes that both halves share separate them, and come after those inside of either. SCOTCH
halves the cells, as dolfinx has it for meshes on several ranks: cells that share facets are far
fewer than degrees of freedom that share entries, so that this is a small part of CHOLMOD's own
ordering (benchmarks/README.md).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from dolfinx import fem
from dolfinx import mesh as dmesh

from fenics_nnm.arrays import Indices
from fenics_nnm.fem.cutting import can_cut, cut, pairs_listed
from fenics_nnm.fem.unrolled import unrolled

#: With fewer cells the order of a solver is found as fast. Halves of halves have about so many.
_WORTHWHILE, _LEAST = 4000, 4

#: Halves may differ in size by this part, so that their border is small.
_IMBALANCE = 0.4


def worth_dissecting(space: fem.FunctionSpace) -> bool:
    """Whether nested dissection is faster than the order that a solver finds, for this rank.

    It is not for few cells, nor for more cells than nodes (linear tetrahedra), and it needs SCOTCH
    and cells that no other rank has a copy of.
    """
    cells, nodes = len(space.dofmap.list), space.dofmap.index_map.size_local
    mesh = space.mesh
    if mesh.topology.index_map(mesh.topology.dim).num_ghosts:
        return False
    return can_cut() and _WORTHWHILE <= cells <= nodes


def dissected(space: fem.FunctionSpace) -> Indices:
    """Degrees of freedom of a space on one rank in the order of nested dissection, shape (n,).

    To be called where it is worth it: it needs SCOTCH.
    """
    return unrolled(nodes_dissected(space), space.dofmap.index_map_bs).astype(np.int32)


def nodes_dissected(space: fem.FunctionSpace) -> Indices:
    """Nodes of the cells of this rank in the order of nested dissection, local, shape (n,).

    As `dissected`.
    """
    cells = space.dofmap.list
    levels = int(np.log2(len(cells) / _LEAST))
    part = cut(_neighbours(space.mesh), 2**levels, _IMBALANCE)
    return separated(cells, part, levels)


def separated(cells: Indices, part: Indices, levels: int) -> Indices:
    """Nodes in the order in which parts of cells separate them.

    Args:
        cells: Nodes of the cells, shape (cells, nodes a cell).
        part: Part of each cell, from 0; parts 2 k and 2 k + 1 are halves of one part, and so on.
        levels: How often cells were halved, so that there are 2^levels parts.

    Returns:
        A permutation of the nodes, shape (nodes,).
    """
    first, last = np.full(cells.max() + 1, 2**levels), np.zeros(cells.max() + 1, dtype=int)
    np.minimum.at(first, cells, part[:, None])
    np.maximum.at(last, cells, part[:, None])
    height = np.frexp((first ^ last).astype(float))[1]  # halvings above the smallest part with all
    end = ((first >> height) + 1) << height
    return np.lexsort((height, end))


def _neighbours(mesh: dmesh.Mesh) -> Any:
    """The cells that each cell shares a facet with, as a list of dolfinx's."""
    dim = mesh.topology.dim
    mesh.topology.create_connectivity(dim - 1, dim)
    facets = mesh.topology.connectivity(dim - 1, dim)
    shared = facets.offsets[:-1][np.diff(facets.offsets) == 2]
    both = np.stack([facets.array[shared], facets.array[shared + 1]], axis=1)
    return pairs_listed(both, mesh.topology.index_map(dim).size_local)
