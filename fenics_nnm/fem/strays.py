"""Cells of lower dimension in a mesh file: skins and lines that do not belong to its body."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fenics_nnm.arrays import Indices, Mask
from fenics_nnm.errors import MeshError
from fenics_nnm.fem.cell_shapes import FacetTable, shape_of
from fenics_nnm.fem.foreign_mesh import KINDS, ForeignMesh


def without_strays(name: str, foreign: ForeignMesh, dim: int, table: FacetTable) -> ForeignMesh:
    """Leave out what is neither a cell nor a facet of the body, with a note on it.

    Skins of triangles on quadrangles, lines along edges of cells and whatever does not touch the
    body have no effect on it.

    Args:
        name: What is read, for messages.
        foreign: Mesh.
        dim: Dimension of the body.
        table: Facets of the body.

    Raises:
        MeshError: if a shell or line hangs on the body, which it would hold or join.
    """
    bodies = {k: rows for k, rows in foreign.cells.items() if KINDS[k][0] == dim}
    kept: dict[str, Indices] = {kind: np.arange(len(rows)) for kind, rows in foreign.cells.items()}
    used = np.zeros(len(foreign.points), dtype=bool)
    for rows in bodies.values():
        used[rows] = True
    notes = []
    for kind, rows in foreign.cells.items():
        corners = rows[:, : shape_of(kind).corners] if KINDS[kind][0] else rows
        if KINDS[kind][0] == dim:
            continue
        if KINDS[kind][0] == dim - 1:
            kept[kind] = np.flatnonzero(table.find(corners) >= 0)
        else:
            kept[kind] = np.empty(0, dtype=np.int64)
        strays = np.setdiff1d(np.arange(len(rows)), kept[kind])
        _refuse_hanging(name, foreign, kind, strays, used, bodies)
        if len(strays) and KINDS[kind][0]:
            notes.append(_note(foreign, kind, strays))
    return _with_rows(foreign, kept, tuple(notes))


def _refuse_hanging(
    name: str,
    foreign: ForeignMesh,
    kind: str,
    strays: Indices,
    used: Indices,
    bodies: dict[str, Indices],
) -> None:
    """Refuse strays that are no skin and no line along an edge, and yet touch the body."""
    inside = used[foreign.cells[kind][strays]]
    hanging = inside.any(axis=1) & ~inside.all(axis=1)
    if KINDS[kind][0] == 1:
        hanging = inside.any(axis=1) & ~_along_edges(foreign.cells[kind][strays, :2], bodies)
    if hanging.any():
        numbers = foreign.numbers_of(kind)[strays[hanging]]
        raise MeshError(
            f"{name}: {len(numbers)} {KINDS[kind][2]} hang on the body without being a part of its "
            f"surface, the first is element {int(numbers[0])}: shells, beams and trusses beside "
            "solids cannot be followed"
        )


def _along_edges(lines: Indices, bodies: dict[str, Indices]) -> Mask:
    """Which lines join the two ends of an edge of a cell."""
    edges = [
        np.sort(rows[:, np.array(shape_of(kind).edges)].reshape(-1, 2), axis=1)
        for kind, rows in bodies.items()
    ]
    own = np.unique(np.concatenate(edges), axis=0)
    both = np.concatenate([own, np.sort(lines, axis=1)])
    _, place = np.unique(both, axis=0, return_inverse=True)
    place = place.ravel()
    return np.asarray(np.isin(place[len(own) :], place[: len(own)]))


def _note(foreign: ForeignMesh, kind: str, strays: Indices) -> str:
    named = [
        f'"{name}"'
        for name, kinds in foreign.sets.items()
        if len(np.intersect1d(kinds.get(kind, ()), strays))
    ]
    of = f" of {', '.join(named[:5])}" if named else ""
    return f"{len(strays)} {KINDS[kind][2]}{of} are no facets of the body: left out"


def _with_rows(
    foreign: ForeignMesh, kept: dict[str, Indices], notes: tuple[str, ...]
) -> ForeignMesh:
    """Some of the cells of each kind alone, and the sets of these."""
    if all(len(kept[kind]) == len(rows) for kind, rows in foreign.cells.items()):
        return foreign
    sets: dict[str, dict[str, Indices]] = {}
    for name, kinds in foreign.sets.items():
        for kind, rows in kinds.items():
            found = np.flatnonzero(np.isin(kept[kind], rows))
            if len(found):
                sets.setdefault(name, {})[kind] = found
    return replace(
        foreign,
        cells={k: rows[kept[k]] for k, rows in foreign.cells.items() if len(kept[k])},
        numbers={k: foreign.numbers_of(k)[kept[k]] for k in kept},
        sets=sets,
        notes=(*foreign.notes, *notes),
    )
