"""From what a mesh file holds to one body of one kind of cells, with notes on what was changed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.errors import MeshError
from fenics_nnm.fem.cell_shapes import FacetTable, facet_table, shape_of
from fenics_nnm.fem.foreign_mesh import KINDS, ForeignMesh
from fenics_nnm.fem.middle_nodes import assert_middles
from fenics_nnm.fem.overlaps import assert_single
from fenics_nnm.fem.splitting import SplitCells, divided, split
from fenics_nnm.fem.strays import without_strays

#: Kinds that dolfinx has no cells of, or none with named facets.
_SPLIT = ("wedge", "pyramid")


def one_body(name: str, foreign: ForeignMesh) -> ForeignMesh:
    """A mesh whose cells of the highest dimension are a body, of one kind.

    Skins and lines that are no facets are left out; cells of several kinds, prisms, pyramids and
    cells with nodes that stand twice are split into simplices.

    Args:
        name: What is read, for messages.
        foreign: What was read.

    Raises:
        MeshError: if it holds no cells, cells stand twice or overlap, or cannot be split.
    """
    if not foreign.cells:
        raise MeshError(f"{name}: holds no cells")
    _assert_finite(name, foreign.points)
    dim = max(KINDS[kind][0] for kind in foreign.cells)
    if dim == 0:
        return foreign
    cells = {kind: rows for kind, rows in foreign.cells.items() if KINDS[kind][0] == dim}
    numbers = np.concatenate([foreign.numbers_of(kind) for kind in cells])
    assert_middles(name, cells, numbers)
    table = facet_table(cells)
    foreign = _without_stray_sides(without_strays(name, foreign, dim, table), table)
    assert_single(name, foreign.points, cells, numbers, table)
    if not _must_be_split(cells):
        return foreign
    _assert_one_order(name, cells)
    found = split(name, foreign.points, cells, numbers)
    _assert_whole(name, table, found, numbers)
    return _carried_over(foreign, dim, table, found)


def _assert_finite(name: str, points: Array) -> None:
    """Refuse coordinates that are no numbers."""
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(bad):
        place = ", ".join(f"{x:g}" for x in points[bad[0]])
        raise MeshError(f"{name}: node {bad[0] + 1} of it lies at ({place}): must be finite")


def _without_stray_sides(foreign: ForeignMesh, table: FacetTable) -> ForeignMesh:
    """Named surfaces without the sides that are no facets of the body, with a note on them."""
    facets, notes = {}, []
    for name, corners in foreign.facets.items():
        rows = table.find(corners[:, : table.corners.shape[1]])
        wide = (corners[:, table.corners.shape[1] :] >= 0).any(axis=1)
        kept = rows[(rows >= 0) & ~wide]
        facets[name] = table.corners[kept]
        if len(kept) < len(corners):
            left = len(corners) - len(kept)
            notes.append(f'{left} sides of "{name}" are no facets of the body: left out')
    return replace(foreign, facets=facets, notes=(*foreign.notes, *notes))


def _must_be_split(cells: dict[str, Indices]) -> bool:
    shrunk = any(
        (np.diff(np.sort(rows[:, : shape_of(kind).corners], axis=1), axis=1) == 0).any()
        for kind, rows in cells.items()
    )
    return len(cells) > 1 or shrunk or next(iter(cells)).startswith(_SPLIT)


def _assert_one_order(name: str, cells: dict[str, Indices]) -> None:
    counts = {"1": 0, "2": 0}
    for kind, rows in cells.items():
        counts["2" if rows.shape[1] > shape_of(kind).corners else "1"] += len(rows)
    if all(counts.values()):
        raise MeshError(
            f"{name}: mixes {counts['1']} elements of order 1 and {counts['2']} of order 2, which "
            "do not fit each other: must be of one order"
        )


def _assert_whole(name: str, table: FacetTable, found: SplitCells, numbers: Indices) -> None:
    """Refuse quadrangles on two triangles that are not those the quadrangles are divided into."""
    rows = table.outer
    if table.corners.shape[1] < 4:
        return
    flat = table.corners[rows, 3] < 0
    square = rows[~flat]
    alone = facet_table({found.kind: found.cells})
    for left_out in range(4):
        three = np.delete(table.corners[square], left_out, axis=1)
        partner = table.find(three)
        meeting = np.flatnonzero(partner >= 0)
        split_row = alone.find(three[meeting])
        cracked = meeting[(split_row < 0) | (alone.times[split_row] == 1)]
        if len(cracked):
            pair = table.cell[square[cracked[0]]], table.cell[partner[cracked[0]]]
            raise MeshError(
                f"{name}: {len(cracked)} quadrangles meet two triangles that do not fit them, one "
                f"between the elements {int(numbers[pair[0]])} and {int(numbers[pair[1]])}: needs "
                "pyramids in between"
            )


def _carried_over(
    foreign: ForeignMesh, dim: int, table: FacetTable, found: SplitCells
) -> ForeignMesh:
    """The mesh of simplices with all sets of the one it was split from."""
    cells = {kind: rows for kind, rows in foreign.cells.items() if KINDS[kind][0] == dim}
    starts = dict(zip(cells, np.cumsum([0, *map(len, cells.values())]), strict=False))
    sets: dict[str, dict[str, Indices]] = {}
    for name, kinds in foreign.sets.items():
        members = [starts[kind] + rows for kind, rows in kinds.items() if kind in starts]
        if members:
            inside = np.isin(found.parent, np.concatenate(members))
            sets[name] = {found.kind: np.flatnonzero(inside)}
    rows_of = facet_rows(foreign, dim, table)
    facets = {name: _simplex_facets(table.corners[rows]) for name, rows in rows_of.items()}
    numbers = np.concatenate([foreign.numbers_of(kind) for kind in cells])
    counts = " and ".join(f"{len(rows)} {KINDS[kind][2]}" for kind, rows in cells.items())
    note = f"{counts} are split into {len(found.cells)} {KINDS[found.kind][2]}"
    return replace(
        foreign,
        points=found.points,
        cells={found.kind: found.cells},
        numbers={found.kind: numbers[found.parent]},
        sets=sets,
        node_sets={
            name: _with_middles(nodes, facets[name], found)
            for name, nodes in foreign.node_sets.items()
        },
        facets=facets,
        constraints=foreign.constraints.widened(
            lambda nodes: _with_middles(nodes, _facets_of(foreign, dim, table, nodes), found)
        ),
        notes=(*foreign.notes, note),
    )


def _facets_of(foreign: ForeignMesh, dim: int, table: FacetTable, nodes: Indices) -> Indices:
    """Corners of the simplex facets between some nodes."""
    alone = replace(foreign, node_sets={"": nodes}, sets={}, facets={})
    return _simplex_facets(table.corners[facet_rows(alone, dim, table)[""]])


def facet_rows(foreign: ForeignMesh, dim: int, table: FacetTable) -> dict[str, Indices]:
    """Rows of the table of each set of nodes, set of flat cells, and named surface."""
    groups: dict[str, Indices] = {}
    for name, nodes in foreign.node_sets.items():
        held = np.append(np.isin(np.arange(len(foreign.points)), nodes), True)  # -1 is nothing
        inside = held[table.corners].all(axis=1) & held[table.middles].all(axis=1)
        groups[name] = np.flatnonzero(inside & (table.times == 1))
    named: dict[str, list[Indices]] = {}
    for name, corners in foreign.facets.items():
        named.setdefault(name, []).append(table.find(corners))
    for name, kinds in foreign.sets.items():
        for kind, rows in kinds.items():
            if KINDS[kind][0] == dim - 1:
                corners = foreign.cells[kind][rows][:, : shape_of(kind).corners]
                named.setdefault(name, []).append(table.find(corners))
    for name, parts in named.items():
        found = np.unique(np.concatenate(parts))
        groups[name] = found[found >= 0]
    return groups


def _simplex_facets(corners: Indices) -> Indices:
    """Corners of the triangles of facets; edges as they are."""
    return divided(corners)[0] if corners.shape[1] > 2 else corners


def _with_middles(nodes: Indices, facets: Indices, found: SplitCells) -> Indices:
    """A set of nodes with the new middle nodes on the diagonals of its facets."""
    shape = shape_of(found.kind)
    if found.cells.shape[1] == shape.corners or not len(facets):
        return nodes
    edges = found.cells[:, np.array(shape.edges)].reshape(-1, 2)
    sides = np.concatenate([np.roll(facets, -i, axis=1)[:, :2] for i in range(facets.shape[1])])
    both = np.sort(np.concatenate([sides, edges]), axis=1)
    _, place = np.unique(both, axis=0, return_inverse=True)
    on_facets = np.isin(place.ravel()[len(sides) :], place.ravel()[: len(sides)])
    return np.union1d(nodes, found.cells[:, shape.corners :].ravel()[on_facets])
