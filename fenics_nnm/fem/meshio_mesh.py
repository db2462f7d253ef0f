"""Meshes that meshio reads: MED of Salome, VTK, XDMF, Exodus and others."""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from typing import Any

import meshio
import numpy as np

from fenics_nnm.arrays import Indices
from fenics_nnm.errors import Code, MeshError
from fenics_nnm.fem.file_kinds import not_read
from fenics_nnm.fem.foreign_mesh import KINDS, ForeignMesh

#: Most values of an array of whole numbers on cells that are taken for names of groups.
_MOST_VALUES = 1000

Rows = dict[str, dict[str, Indices]]
"""Rows of the cells of each named set, by kind of cell."""


def read_meshio(path: Path) -> ForeignMesh:
    """Read a mesh with its sets.

    Groups are the sets of points and cells, the families of a MED file, and of other files arrays
    of whole numbers on the cells: the group "ARRAY=VALUE" for each value.

    Raises:
        MeshError: if meshio cannot read the file, or it has cells of an unknown kind.
    """
    mesh = _read(path)
    starts: dict[str, int] = {}
    blocks = []
    for block in mesh.cells:
        if block.type not in KINDS:
            raise MeshError(
                f"mesh file {path}: has {len(block.data)} cells of the type {block.type}: must "
                "be of order 1 or 2, with straight or curved faces of 3 or 4 corners",
                code=Code.MESH_FILE,
            )
        blocks.append((block.type, starts.get(block.type, 0)))
        starts[block.type] = blocks[-1][1] + len(block.data)
    points = np.zeros((len(mesh.points), 3))
    points[:, : mesh.points.shape[1]] = mesh.points
    sets: Rows = {}
    for name, index, rows in _sets(mesh):
        kind, start = blocks[index]
        parts = sets.setdefault(name, {})
        parts[kind] = np.union1d(parts.get(kind, np.empty(0, dtype=np.int64)), rows + start)
    return ForeignMesh(
        points=points,
        cells={
            kind: np.concatenate([b.data for b in mesh.cells if b.type == kind]) for kind in starts
        },
        sets=sets,
        node_sets=_node_sets(mesh),
    )


def _read(path: Path) -> Any:
    """What meshio reads; it tells of a failure on the terminal and leaves the program."""
    printed = io.StringIO()
    try:
        with redirect_stdout(printed), redirect_stderr(printed):
            return meshio.read(path)
    except (Exception, SystemExit) as error:
        reason = " ".join(printed.getvalue().split()) or f"{type(error).__name__}: {error}"
        raise not_read(path, reason) from error


def _sets(mesh: Any) -> Iterator[tuple[str, int, Indices]]:
    """Name, number of the block, and rows in it of each part of a set of cells."""
    for name, parts in mesh.cell_sets.items():
        for index, rows in enumerate(parts):
            if rows is not None and len(rows):
                yield name, index, np.asarray(rows, dtype=np.int64)
    for array, values in mesh.cell_data.items():
        if not all(v.ndim == 1 and np.issubdtype(v.dtype, np.integer) for v in values):
            continue
        known = np.unique(np.concatenate(values))
        families = getattr(mesh, "cell_tags", None) if array == "cell_tags" else None
        if families is None and len(known) > _MOST_VALUES:
            continue
        for value in known:
            names = [f"{array}={value}"] if families is None else families.get(value, [])
            for index, of_block in enumerate(values):
                rows = np.flatnonzero(of_block == value)
                yield from ((name, index, rows) for name in names if len(rows))


def _node_sets(mesh: Any) -> dict[str, Indices]:
    """Sets of points, and the families of points of a MED file."""
    sets: dict[str, Indices] = {
        name: np.asarray(rows, dtype=np.int64) for name, rows in mesh.point_sets.items()
    }
    tags = mesh.point_data.get("point_tags")
    for family, names in getattr(mesh, "point_tags", {}).items():
        for name in names:
            rows = np.flatnonzero(tags == family)
            sets[name] = np.union1d(sets.get(name, np.empty(0, dtype=np.int64)), rows)
    return sets
