"""The mesh of the current gmsh model, cells of any kind and named groups or none, as it was read.

A file without a group of its cells of the highest dimension has these cells for its body.
"""

from __future__ import annotations

import gmsh
import numpy as np

from fenics_nnm.arrays import Indices
from fenics_nnm.errors import MeshError
from fenics_nnm.fem.foreign_body import one_body
from fenics_nnm.fem.foreign_mesh import GMSH_ORDER, KINDS, ForeignMesh, raw_mesh
from fenics_nnm.fem.gmsh_mesh import extracted
from fenics_nnm.fem.raw_mesh import RawMesh

_NAMES = {number: kind for kind, (_, number, _) in KINDS.items()}

Rows = dict[str, dict[str, Indices]]


def raw_of_model(name: str) -> RawMesh:
    """The body of the current gmsh model, split into simplices where its cells are mixed.

    Args:
        name: What was read, for messages.

    Raises:
        MeshError: if its cells cannot be used.
    """
    foreign, read = _foreign(name)
    dims = [KINDS[kind][0] for kind in foreign.cells]
    dim = max(dims, default=0)
    named = any(KINDS[kind][0] == dim for kinds in foreign.sets.values() for kind in kinds)
    body = one_body(name, foreign)
    kinds = {kind: len(rows) for kind, rows in body.cells.items() if KINDS[kind][0] == dim}
    as_read = kinds == {kind: read[kind] for kind in read if KINDS[kind][0] == dim}
    if dim == 0 or (named and as_read):
        return extracted(name)
    gmsh.model.remove()
    gmsh.model.add(name)
    return raw_mesh(name, body)


def _foreign(name: str) -> tuple[ForeignMesh, dict[str, int]]:
    """All cells of the model, or those of named groups where such hold cells of the body.

    Returns:
        Mesh in which each cell is once, and how many cells of each kind the model has.
    """
    tags, x, _ = gmsh.model.mesh.getNodes()
    order = np.argsort(tags)
    row = np.full(int(tags.max()) + 1, -1, dtype=np.int64)
    row[tags[order].astype(np.int64)] = np.arange(len(tags))
    groups = _groups()
    parts: dict[str, list[Indices]] = {}
    numbers: dict[str, list[Indices]] = {}
    owners: dict[str, list[Indices]] = {}
    for dim, entity in _entities(groups):
        kinds = gmsh.model.mesh.getElements(dim, entity)
        for number, elements, nodes in zip(*kinds, strict=True):
            kind = _kind(name, int(number))
            cells = nodes.reshape(len(elements), -1).astype(np.int64)
            if cells.max() >= len(row) or (row[cells] < 0).any():
                raise MeshError(f"{name}: an element has a node that is not there")
            parts.setdefault(kind, []).append(row[cells][:, _vtk_order(kind, cells.shape[1])])
            numbers.setdefault(kind, []).append(elements.astype(np.int64))
            owners.setdefault(kind, []).append(np.full(len(elements), entity))
    points = x.reshape(-1, 3)[order]
    found = _once(
        {kind: np.concatenate(rows) for kind, rows in parts.items()},
        {kind: np.concatenate(rows) for kind, rows in numbers.items()},
        {kind: np.concatenate(rows) for kind, rows in owners.items()},
        groups,
    )
    counts = {kind: sum(map(len, rows)) for kind, rows in parts.items()}
    return ForeignMesh(points, found[0], found[2], numbers=found[1]), counts


def _kind(name: str, number: int) -> str:
    if number not in _NAMES:
        shape, _, order, *_ = gmsh.model.mesh.getElementProperties(number)
        raise MeshError(
            f"{name}: has elements of the type {shape}, of order {order}: must be of order 1 or 2, "
            "with facets of 3 or 4 corners"
        )
    return _NAMES[number]


def _vtk_order(kind: str, width: int) -> Indices:
    """Place in gmsh's order of each node in VTK's."""
    return np.argsort(GMSH_ORDER[kind]) if kind in GMSH_ORDER else np.arange(width)


def _groups() -> dict[tuple[int, str], Indices]:
    """Entities of each physical group by its dimension and name."""
    groups: dict[tuple[int, str], Indices] = {}
    for dim, tag in gmsh.model.getPhysicalGroups():
        key = dim, gmsh.model.getPhysicalName(dim, tag) or str(tag)
        entities = np.asarray(gmsh.model.getEntitiesForPhysicalGroup(dim, tag), dtype=np.int64)
        groups[key] = np.union1d(groups.get(key, entities), entities)
    return groups


def _entities(groups: dict[tuple[int, str], Indices]) -> list[tuple[int, int]]:
    """Entities with cells or facets: cells of named groups alone, if there are any such."""
    held = [
        (int(dim), int(entity))
        for dim, entity in gmsh.model.getEntities()
        if sum(map(len, gmsh.model.mesh.getElements(dim, entity)[1]))
    ]
    top = max((dim for dim, _ in held), default=0)
    named = {int(e) for (dim, _), entities in groups.items() if dim == top for e in entities}
    named &= {entity for dim, entity in held if dim == top}
    return [
        (dim, entity)
        for dim, entity in held
        if dim == top - 1 or (dim == top and (not named or entity in named))
    ]


def _once(
    cells: dict[str, Indices],
    numbers: dict[str, Indices],
    owners: dict[str, Indices],
    groups: dict[tuple[int, str], Indices],
) -> tuple[dict[str, Indices], dict[str, Indices], Rows]:
    """Cells, their numbers and the groups of them, where format 2.2 lists a cell once a group."""
    sets: Rows = {}
    kept_cells, kept_numbers = {}, {}
    for kind, rows in cells.items():
        keys = np.sort(rows, axis=1)
        _, first, place, times = np.unique(
            keys, axis=0, return_index=True, return_inverse=True, return_counts=True
        )
        member = {
            name: np.isin(owners[kind], entities)
            for (dim, name), entities in groups.items()
            if dim == KINDS[kind][0]
        }
        of_first = np.zeros(len(first), dtype=np.int64)
        for inside in member.values():
            of_first += np.bincount(place.ravel()[inside], minlength=len(first)) > 0
        kept = np.ones(len(rows), dtype=bool)
        merged = (times > 1) & ((times <= of_first) | (KINDS[kind][0] < 2))
        again = merged[place.ravel()] & (first[place.ravel()] != np.arange(len(rows)))
        kept[again] = False
        new = np.cumsum(kept) - 1
        target = np.where(again, first[place.ravel()], np.arange(len(rows)))
        for name, inside in member.items():
            if inside.any():
                sets.setdefault(name, {})[kind] = np.unique(new[target[inside]])
        kept_cells[kind], kept_numbers[kind] = rows[kept], numbers[kind][kept]
    return kept_cells, kept_numbers, sets
