"""From the arrays of an unstructured grid of VTK to a mesh with groups."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.errors import Code, MeshError
from fenics_nnm.fem.cell_shapes import shape_of
from fenics_nnm.fem.foreign_mesh import ForeignMesh

#: Most values of an array of whole numbers on cells that are taken for names of groups.
_MOST_VALUES = 1000

#: Kind by VTK's number of the type of a cell.
_KINDS = {
    **{1: "vertex", 3: "line", 5: "triangle", 8: "quad", 9: "quad", 10: "tetra"},
    **{11: "hexahedron", 12: "hexahedron", 13: "wedge", 14: "pyramid", 21: "line3"},
    **{22: "triangle6", 23: "quad8", 24: "tetra10", 25: "hexahedron20", 26: "wedge15"},
    **{27: "pyramid13", 28: "quad9", 29: "hexahedron27", 32: "wedge18"},
}

#: Kind by VTK's number of a Lagrange cell, of any order, and its number of nodes.
_LAGRANGE = {
    **{(68, 2): "line", (68, 3): "line3", (69, 3): "triangle", (69, 6): "triangle6"},
    **{(70, 4): "quad", (70, 9): "quad9", (71, 4): "tetra", (71, 10): "tetra10"},
    **{(72, 8): "hexahedron", (73, 6): "wedge", (74, 5): "pyramid"},
}

#: Cells of points and lines that have no fixed number of nodes, which are left out.
_LOOSE = (2, 4)

#: Pixels and voxels, which count their corners along the axes.
_REORDERED = {8: [0, 1, 3, 2], 11: [0, 1, 3, 2, 4, 5, 7, 6]}

#: Array of cells that other pieces have too, in its lowest bit.
_GHOSTS = "vtkGhostType"


@dataclass(frozen=True, slots=True)
class Grid:
    """An unstructured grid.

    Attributes:
        points: Coordinates, shape (nodes, 3).
        connectivity: Nodes of all cells, one after the other.
        ends: Where the nodes of each cell end in it.
        types: VTK's number of the type of each cell.
        cell_data: Arrays on the cells by their names.
    """

    points: Array
    connectivity: Indices
    ends: Indices
    types: Indices
    cell_data: Mapping[str, Any] = field(default_factory=dict)


def foreign_of_grid(path: Path, grid: Grid) -> ForeignMesh:
    """Cells by kind; whole numbers on cells are groups "ARRAY=VALUE".

    Args:
        path: File, for messages.
        grid: Grid.

    Raises:
        MeshError: if its arrays do not fit each other, or a cell is of a type that is not known.
    """
    counts = np.diff(grid.ends, prepend=0)
    _check(path, grid, counts)
    ghost = np.asarray(grid.cell_data.get(_GHOSTS, np.zeros(len(grid.types))), dtype=np.int64) & 1
    cells: dict[str, list[Indices]] = {}
    rows: dict[str, list[Indices]] = {}
    for kind, width in np.unique(np.column_stack([grid.types, counts]), axis=0).tolist():
        found = np.flatnonzero((grid.types == kind) & (counts == width) & (ghost == 0))
        if kind in _LOOSE or not len(found):
            continue
        named = _named(path, kind, width, len(found))
        starts = grid.ends[found] - width
        nodes = grid.connectivity[starts[:, None] + np.arange(width)]
        cells.setdefault(named, []).append(nodes[:, _REORDERED.get(kind, list(range(width)))])
        rows.setdefault(named, []).append(found)
    numbers = {kind: np.concatenate(found) for kind, found in rows.items()}
    return ForeignMesh(
        grid.points,
        {kind: np.concatenate(parts) for kind, parts in cells.items()},
        _sets(grid, numbers),
        numbers={kind: found + 1 for kind, found in numbers.items()},
    )


def _check(path: Path, grid: Grid, counts: Indices) -> None:
    whole = len(grid.ends) == len(grid.types) and (counts >= 0).all()
    last = int(grid.ends[-1]) if len(grid.ends) else 0
    nodes = grid.connectivity
    if not whole or last > len(nodes):
        raise MeshError(
            f"mesh file {path}: its cells, their ends and their types do not fit each other",
            code=Code.MESH_FILE,
        )
    if len(nodes) and not 0 <= nodes.min() <= nodes.max() < len(grid.points):
        raise MeshError(
            f"mesh file {path}: a cell has a node that is not there", code=Code.MESH_FILE
        )


def _named(path: Path, kind: int, width: int, count: int) -> str:
    known = _KINDS.get(kind) or _LAGRANGE.get((kind, width))
    if known is None or _nodes(known) != width:
        raise MeshError(
            f"mesh file {path}: has {count} cells of the type {kind} of VTK with {width} nodes: "
            "must be of order 1 or 2, with straight or curved faces of 3 or 4 corners",
            code=Code.MESH_FILE,
        )
    return known


def _nodes(kind: str) -> int:
    """Number of nodes of a kind of cell: its digits, or its corners."""
    digits = "".join(letter for letter in kind if letter.isdigit())
    if digits:
        return int(digits)
    return 1 if kind == "vertex" else shape_of(kind).corners


def _sets(grid: Grid, numbers: Mapping[str, Indices]) -> dict[str, dict[str, Indices]]:
    """Groups of cells of equal whole numbers."""
    sets: dict[str, dict[str, Indices]] = {}
    for array, values in grid.cell_data.items():
        if array == _GHOSTS or values.ndim != 1 or not np.issubdtype(values.dtype, np.integer):
            continue
        known = np.unique(values)
        if len(known) > _MOST_VALUES or len(values) != len(grid.types):
            continue
        for value in known:
            for kind, found in numbers.items():
                rows = np.flatnonzero(values[found] == value)
                if len(rows):
                    sets.setdefault(f"{array}={value}", {})[kind] = rows
    return sets
