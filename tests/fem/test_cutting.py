"""Cells that share facets, and parts of cells with few facets between them."""

from __future__ import annotations

import basix
import numpy as np
import pytest
from dolfinx import mesh as dmesh
from mpi4py import MPI

from fenics_nnm.arrays import Indices
from fenics_nnm.fem.cutting import cut, pairs_listed, sharing_facets


def cells_of(name: str) -> tuple[dmesh.Mesh, Indices, Indices]:
    """A mesh of a cube, vertices of its cells, and the pairs of them that share facets."""
    mesh = dmesh.create_unit_cube(MPI.COMM_SELF, 3, 3, 2, getattr(dmesh.CellType, name))
    mesh.topology.create_connectivity(3, 0)
    count = mesh.topology.index_map(3).size_local
    cells = np.array([mesh.topology.connectivity(3, 0).links(cell) for cell in range(count)])
    return mesh, cells, sharing_facets(cells, basix.topology(basix.CellType[name])[2])


@pytest.mark.parametrize("name", ["tetrahedron", "hexahedron"])
def test_cells_share_the_facets_that_dolfinx_finds(name: str) -> None:
    mesh, _, found = cells_of(name)
    mesh.topology.create_connectivity(2, 3)
    facets = mesh.topology.connectivity(2, 3)
    links = [facets.links(facet) for facet in range(facets.num_nodes)]
    expected = {tuple(sorted(both)) for both in links if len(both) == 2}
    assert len(found) == len(expected)
    assert {tuple(sorted(both)) for both in found.tolist()} == expected


def test_prisms_share_triangles_and_quadrangles() -> None:
    """36 prisms in two layers: 18 triangles between these, and 21 quadrangles in each."""
    _, cells, found = cells_of("prism")
    shared = [len(np.intersect1d(cells[one], cells[other])) for one, other in found]
    assert np.bincount(shared).tolist() == [0, 0, 0, 18, 42]


def test_a_long_bar_is_cut_across() -> None:
    """40 x 2 x 2 hexahedra in two parts: four facets between them are the fewest."""
    number = np.arange(160).reshape(40, 2, 2)
    pairs = np.concatenate(
        [
            np.stack([number[:-1].ravel(), number[1:].ravel()], axis=1),
            np.stack([number[:, :-1].ravel(), number[:, 1:].ravel()], axis=1),
            np.stack([number[:, :, :-1].ravel(), number[:, :, 1:].ravel()], axis=1),
        ]
    )
    part = cut(pairs_listed(pairs, 160), 2, 0.05)
    assert np.count_nonzero(part[pairs[:, 0]] != part[pairs[:, 1]]) == 4
    assert np.bincount(part).min() >= 72
    assert np.array_equal(part, cut(pairs_listed(pairs, 160), 2, 0.05))
