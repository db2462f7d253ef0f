"""Nested dissection: separators come after what they separate, and factors solve as they did."""

from __future__ import annotations

import os

import numpy as np
import pytest
from dolfinx import fem
from dolfinx import mesh as dmesh
from mpi4py import MPI

from fenics_nnm.arrays import Indices
from fenics_nnm.fem import cutting, dissection
from fenics_nnm.fem.dissection import dissected, separated, worth_dissecting


def test_nodes_of_a_line_are_separated_by_its_middle_first() -> None:
    """Eight cells of two nodes: node 4 comes last, 2 and 6 after what they separate."""
    cells = np.stack([np.arange(8), np.arange(1, 9)], axis=1)
    assert separated(cells, np.arange(8), 3).tolist() == [0, 1, 3, 2, 5, 8, 7, 6, 4]


def test_parts_of_other_numbers_move_with_their_nodes() -> None:
    """Two cells that touch in a node, and the parts of both the other way round."""
    cells = np.array([[0, 1], [1, 2]])
    assert separated(cells, np.array([1, 0]), 1).tolist() == [2, 0, 1]


def _space(cells: int, degree: int = 2) -> fem.FunctionSpace:
    mesh = dmesh.create_unit_cube(MPI.COMM_SELF, cells, cells, cells)
    return fem.functionspace(mesh, ("Lagrange", degree, (3,)))


def _entries(space: fem.FunctionSpace, order: Indices) -> int:
    """Entries of the factors of a matrix of all nodes of cells, by elimination in an order."""
    place = np.empty(len(order), dtype=int)
    place[order] = np.arange(len(order))
    beside: list[set[int]] = [set() for _ in order]
    for cell in place[space.dofmap.list]:
        for one in cell:
            beside[one].update(int(other) for other in cell if other > one)
    total = 0
    for later in beside:
        total += len(later)
        if later:
            beside[min(later)].update(later - {min(later)})
    return total


@pytest.fixture
def needed() -> None:
    if cutting._partitioner is None:
        pytest.fail("dolfinx has no SCOTCH here, and large static states take longer")


@pytest.mark.usefixtures("needed")
def test_factors_have_fewer_entries_than_in_the_order_of_the_mesh() -> None:
    space = _space(5)
    order = dissected(space)
    assert np.array_equal(np.sort(order), np.arange(3 * 11**3))
    assert np.array_equal(order[1::3], order[::3] + 1)  # nodes stay together
    nodes = order[::3] // 3
    assert _entries(space, nodes) < 0.75 * _entries(space, np.arange(11**3))
    assert np.array_equal(dissected(space), order)  # always the same


@pytest.mark.usefixtures("needed")
def test_threads_of_the_user_stay(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SCOTCH_PTHREAD_NUMBER", "3")
    dissected(_space(2))
    assert os.environ["SCOTCH_PTHREAD_NUMBER"] == "3"


def test_few_cells_and_cells_of_few_nodes_are_not_worth_it(monkeypatch: pytest.MonkeyPatch) -> None:
    assert not worth_dissecting(_space(2))
    monkeypatch.setattr(dissection, "_WORTHWHILE", 48)
    assert worth_dissecting(_space(2))
    assert not worth_dissecting(_space(2, degree=1))
    monkeypatch.setattr(cutting, "_partitioner", None)
    assert not worth_dissecting(_space(2))
