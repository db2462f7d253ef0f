"""What one process reads of a mesh, and hands on."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.fem.attachment import Attachment
from fenics_nnm.fem.constraints import NO_CONSTRAINTS, LinearConstraints, from_json, to_json


@dataclass(frozen=True, slots=True)
class RawMesh:
    """A mesh of one cell type as rank 0 reads it; empty on the other ranks.

    Attributes:
        cell_type: gmsh's number of the element type.
        dim: Dimension of the body.
        points: Coordinates in the unit of the input, shape (nodes, dim).
        cells: Rows of `points` of each cell in gmsh's order, shape (cells, nodes a cell).
        facets: Nodes of each facet of a named group, in gmsh's order of the facet.
        groups: Rows of `cells` of each named group.
        nodes: Rows of `points` of each named set of nodes.
        attached: Masses and springs, in the units of the file, which must be SI units.
        constraints: Constraints on rows of `points`, in the units of the file.
        notes: What was left out or changed on reading, a line each.
    """

    cell_type: int
    dim: int
    points: Array
    cells: Indices
    facets: Mapping[str, Indices]
    groups: Mapping[str, Indices]
    nodes: Mapping[str, Indices] = field(default_factory=dict)
    attached: tuple[Attachment, ...] = ()
    constraints: LinearConstraints = NO_CONSTRAINTS
    notes: tuple[str, ...] = ()


def arrays_of(raw: RawMesh) -> dict[str, Any]:
    """A mesh as arrays of numbers, by names that are the same for each mesh."""
    named = raw.facets, raw.groups, raw.nodes
    parts = [np.asarray(part) for each in named for part in each.values()]
    words = {
        "names": [list(each) for each in named],
        "shapes": [part.shape for part in parts],
        "attached": [asdict(each) for each in raw.attached],
        "constraints": to_json(raw.constraints),
        "notes": raw.notes,
    }
    none: Indices = np.empty(0, dtype=np.int64)
    return {
        "kind": np.array([raw.cell_type, raw.dim]),
        "points": raw.points,
        "cells": raw.cells,
        "parts": np.concatenate([none, *(part.ravel() for part in parts)]),
        "words": np.frombuffer(json.dumps(words).encode(), dtype=np.uint8),
    }


def raw_of(arrays: Mapping[str, Any]) -> RawMesh:
    """The mesh of arrays that `arrays_of` made, or a file that has them by these names.

    Raises:
        ValueError, KeyError, IndexError, TypeError: if they are something else.
    """
    words = json.loads(arrays["words"][:].tobytes())
    ends = np.cumsum([0, *(math.prod(shape) for shape in words["shapes"])])
    flat = np.split(_whole(arrays["parts"][:]), ends[1:-1])
    parts = (part.reshape(shape) for part, shape in zip(flat, words["shapes"], strict=False))
    facets, groups, nodes = ({name: next(parts) for name in each} for each in words["names"])
    cell_type, dim = (int(x) for x in arrays["kind"][:])
    raw = RawMesh(
        cell_type,
        dim,
        arrays["points"][:],
        _whole(arrays["cells"][:]),
        facets,
        groups,
        nodes,
        tuple(_attachment(each) for each in words["attached"]),
        from_json(words["constraints"]),
        tuple(words["notes"]),
    )
    _assert_rows(raw)
    return raw


def write_raw(path: Path, raw: RawMesh) -> None:
    """Write a mesh to a .npz file without Python objects.

    Raises:
        OSError: if it cannot be written.
    """
    np.savez(path, **arrays_of(raw))


def read_written(path: Path) -> RawMesh:
    """Read what `write_raw` wrote.

    Raises:
        OSError, or as `raw_of`: if it is something else.
    """
    with np.load(path, allow_pickle=False) as file:
        return raw_of(file)


def _whole(numbers: Any) -> Indices:
    return np.asarray(numbers, dtype=np.int64)


def _assert_rows(raw: RawMesh) -> None:
    """Refuse rows of points or cells that are not there.

    Raises:
        IndexError: if there are some.
    """
    raw.constraints.assert_rows(len(raw.points))
    of_points = [raw.cells, *raw.facets.values(), *raw.nodes.values()]
    of_cells = [*raw.groups.values()]
    for count, parts in ((len(raw.points), of_points), (len(raw.cells), of_cells)):
        for rows in parts:
            if rows.size and not 0 <= rows.min() <= rows.max() < count:
                raise IndexError(f"a mesh has a row outside of 0 to {count - 1}")


def _attachment(values: dict[str, Any]) -> Attachment:
    """An attachment from JSON, which knows no tuples."""
    fields: dict[str, Any] = {k: tuple(v) if isinstance(v, list) else v for k, v in values.items()}
    return Attachment(**fields)
