"""Nodes at one place that move alike, made one node."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from fenics_nnm.arrays import Indices
from fenics_nnm.fem.constraints import Equation
from fenics_nnm.fem.foreign_mesh import KINDS, ForeignMesh

#: Distance over the size of the body within which two nodes are at one place.
_SAME_PLACE = 1e-9


def merged(foreign: ForeignMesh, row: Indices) -> ForeignMesh:
    """A mesh with some nodes in the place of others.

    Args:
        foreign: Mesh.
        row: Row of the point that each point becomes.
    """
    return replace(
        foreign,
        cells={kind: row[nodes] for kind, nodes in foreign.cells.items()},
        node_sets={name: np.unique(row[nodes]) for name, nodes in foreign.node_sets.items()},
        facets={
            name: np.where(corners >= 0, row[corners], -1)
            for name, corners in foreign.facets.items()
        },
        constraints=foreign.constraints.renumbered(row),
    )


def merged_by_equations(foreign: ForeignMesh) -> ForeignMesh:
    """A mesh whose nodes at one place that equations give one displacement are one node.

    This is what such equations mean, and holds between the nodes of the file as well.
    """
    dim = max((KINDS[kind][0] for kind in foreign.cells), default=0)
    size = float(np.ptp(foreign.points, axis=0).max(initial=0.0))
    axes: dict[tuple[int, int], set[int]] = {}
    for each in foreign.constraints.equations:
        pair = _pair(each)
        if pair and np.linalg.norm(np.subtract(*foreign.points[list(pair)])) <= _SAME_PLACE * size:
            axes.setdefault(pair, set()).add(each.terms[0][1])
    pairs = {pair for pair, found in axes.items() if found >= set(range(dim))}
    if not pairs:
        return foreign
    left = tuple(each for each in foreign.constraints.equations if _pair(each) not in pairs)
    kept = replace(foreign, constraints=replace(foreign.constraints, equations=left))
    note = f"equations: {len(pairs)} nodes are merged with those at their places"
    return replace(merged(kept, _rows(len(foreign.points), pairs)), notes=(*foreign.notes, note))


def _pair(equation: Equation) -> tuple[int, int] | None:
    """The two nodes of the mesh that an equation gives one displacement along an axis, if any."""
    if len(equation.terms) != 2:
        return None
    (first, axis, one), (second, other, two) = equation.terms
    if axis != other or one != -two or min(first, second) < 0 or first == second:
        return None
    return min(first, second), max(first, second)


def _rows(count: int, pairs: set[tuple[int, int]]) -> Indices:
    """The lowest row of all that are joined with each."""
    first, second = np.array(sorted(pairs)).T
    graph = coo_array((np.ones(len(first)), (first, second)), shape=(count, count))
    number, label = connected_components(graph, directed=False)
    lowest = np.full(number, count, dtype=np.int64)
    np.minimum.at(lowest, label, np.arange(count))
    return lowest[label]
