"""What one rank reads of a mesh."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fenics_nnm.arrays import Array, Indices


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
    """

    cell_type: int
    dim: int
    points: Array
    cells: Indices
    facets: Mapping[str, Indices]
    groups: Mapping[str, Indices]


def write_raw(path: Path, raw: RawMesh) -> None:
    """Write a mesh to a .npz file without Python objects.

    Raises:
        OSError: if it cannot be written.
    """
    names = json.dumps([list(raw.facets), list(raw.groups)])
    arrays: dict[str, Any] = {
        "kind": np.array([raw.cell_type, raw.dim]),
        "points": raw.points,
        "cells": raw.cells,
        "names": np.frombuffer(names.encode(), dtype=np.uint8),
    }
    for number, part in enumerate([*raw.facets.values(), *raw.groups.values()]):
        arrays[f"part{number}"] = part
    np.savez(path, **arrays)


def read_written(path: Path) -> RawMesh:
    """Read what `write_raw` wrote.

    Raises:
        OSError, ValueError, KeyError: if it is something else.
    """
    with np.load(path, allow_pickle=False) as file:
        facets, groups = json.loads(file["names"].tobytes())
        parts = [file[f"part{number}"] for number in range(len(facets) + len(groups))]
        cell_type, dim = (int(x) for x in file["kind"])
        return RawMesh(
            cell_type,
            dim,
            file["points"],
            file["cells"],
            dict(zip(facets, parts, strict=False)),
            dict(zip(groups, parts[len(facets) :], strict=True)),
        )
