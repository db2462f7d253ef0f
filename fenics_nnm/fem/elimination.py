"""Linear equations between displacements solved for as many of them: u_dependent = T u_independent.

Coordinates of points outside of the mesh, which have no stiffness of their own, are eliminated
first, from the equations that determine them best; what is left are equations between nodes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from scipy.linalg import qr
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from fenics_nnm.arrays import Array, Indices, Mask
from fenics_nnm.errors import MeshError

#: Coefficients below this part of the largest of their equation are zero.
_ZERO = 1e-10

#: A singular direction of the coordinates outside of the mesh, over the largest.
_SINGULAR = 1e-9

#: Most entries of a dense matrix of equations and coordinates outside that are joined.
_MOST_ENTRIES = 50_000_000

#: The preferred dependent is taken if its coefficient is at least this part of the largest.
_PREFERRED = 0.1

Expression = dict[int, float]
"""A linear expression: coefficients by column."""


@dataclass(frozen=True, slots=True)
class Equations:
    """Equations C v = 0.

    Attributes:
        matrix: C, columns of the mesh first, then those of points outside of it.
        inside: Number of columns of the mesh.
        preferred: Column of the mesh that each equation should be solved for, or -1.
    """

    matrix: csr_array
    inside: int
    preferred: Indices


@dataclass(frozen=True, slots=True)
class Elimination:
    """Columns as linear expressions of those that are left.

    Attributes:
        dependent: Expression of each dependent column of the mesh; empty: it does not move.
        outside: Expression of each column outside that the mesh determines.
        loose: Columns outside that it does not.
    """

    dependent: Mapping[int, Expression] = field(default_factory=dict)
    outside: Mapping[int, Expression] = field(default_factory=dict)
    loose: frozenset[int] = frozenset()


def eliminated(equations: Equations) -> Elimination:
    """Solve equations for as many columns as they determine.

    Raises:
        MeshError: if too many columns outside are joined.
    """
    C = _scaled(equations.matrix)
    C_out = C[:, equations.inside :]
    touching = np.diff(C_out.indptr) > 0
    left: list[tuple[Expression, int]] = [
        (_row(C, i), int(equations.preferred[i])) for i in np.flatnonzero(~touching)
    ]
    outside: dict[int, Expression] = {}
    loose: set[int] = set()
    for rows, columns in _groups(C_out, np.flatnonzero(touching)):
        solved = _solved_outside(C, equations.inside, rows, columns)
        left += [(row, int(equations.preferred[i])) for row, i in solved.left]
        outside |= solved.outside
        loose |= solved.loose
    dependent = _solved_inside(left)
    outside = {key: _substituted(row, dependent) for key, row in outside.items()}
    return Elimination(dependent, outside, frozenset(loose))


@dataclass(frozen=True, slots=True)
class _Outside:
    """Columns outside by those of the mesh, and the equations that are left with their numbers."""

    outside: dict[int, Expression]
    loose: set[int]
    left: list[tuple[Expression, int]]


def _solved_outside(C: csr_array, inside: int, rows: Indices, columns: Indices) -> _Outside:
    """Solve the equations of some columns outside for these.

    Rows and columns are chosen by QR with pivoting: those that determine them best.

    Raises:
        MeshError: if there are too many.
    """
    if len(rows) * len(columns) > _MOST_ENTRIES:
        raise MeshError(
            f"constraints join {len(columns)} coordinates of reference points by {len(rows)} "
            f"equations: must be fewer: their product at most {_MOST_ENTRIES}"
        )
    whole = C[rows]
    own = whole[:, inside + columns].toarray()
    size = np.abs(own).max(axis=0)
    size[size == 0] = 1.0
    own = own / size
    _, R, order = qr(own.T, mode="economic", pivoting=True)
    pivots = np.abs(np.diag(R))
    rank = int(np.count_nonzero(pivots > _SINGULAR * pivots[0]))
    chosen, rest = order[:rank], np.sort(order[rank:])
    _, _, columns_order = qr(own[chosen], mode="economic", pivoting=True)
    kept, free = columns_order[:rank], columns_order[rank:]
    B = own[np.ix_(chosen, kept)]
    mesh = whole[:, :inside]
    used, solution = _solution(mesh[chosen], B)
    bound = np.abs(np.linalg.solve(B, own[np.ix_(chosen, free)])) > _SINGULAR
    unsure = {int(inside + columns[kept[i]]) for i in np.flatnonzero(bound.any(axis=1))}
    outside = {
        int(inside + columns[k]): _expression(used, row / size[k])
        for k, row in zip(kept, solution, strict=True)
    }
    added = own[np.ix_(rest, kept)] @ solution
    left = [
        (_added(_row(mesh, row), used, extra), int(rows[row]))
        for row, extra in zip(rest, added, strict=True)
    ]
    return _Outside(
        {key: row for key, row in outside.items() if key not in unsure},
        unsure | {int(inside + columns[k]) for k in free},
        left,
    )


def _solution(chosen: csr_array, B: Array) -> tuple[Indices, Array]:
    """Columns that the chosen rows have, and -B^-1 times these."""
    used = np.unique(chosen.indices)
    return used, np.linalg.solve(B, -chosen[:, used].toarray())


def _solved_inside(left: list[tuple[Expression, int]]) -> dict[int, Expression]:
    """Solve equations between nodes one by one, each for its preferred column if that is large."""
    dependent: dict[int, Expression] = {}
    users: dict[int, set[int]] = {}
    for given, preferred in left:
        row = _substituted(given, dependent)
        if not row:
            continue
        pivot = _pivot(row, preferred)
        factor = row.pop(pivot)
        expression = {column: -value / factor for column, value in row.items()}
        for user in users.pop(pivot, set()):
            dependent[user] = _replaced(dependent[user], pivot, expression)
            for column in expression:
                users.setdefault(column, set()).add(user)
        dependent[pivot] = expression
        for column in expression:
            users.setdefault(column, set()).add(pivot)
    return dependent


def _pivot(row: Expression, preferred: int) -> int:
    largest = max(row, key=lambda column: abs(row[column]))
    if abs(row.get(preferred, 0.0)) >= _PREFERRED * abs(row[largest]):
        return preferred
    return largest


def _substituted(row: Expression, dependent: Mapping[int, Expression]) -> Expression:
    """A row in columns that are not dependent, without coefficients of round-off."""
    found: Expression = {}
    largest = max(map(abs, row.values()), default=0.0)
    for column, value in row.items():
        if column not in dependent:
            found[column] = found.get(column, 0.0) + value
            continue
        for other, factor in dependent[column].items():
            found[other] = found.get(other, 0.0) + value * factor
    return {column: value for column, value in found.items() if abs(value) > _ZERO * largest}


def _replaced(row: Expression, column: int, expression: Expression) -> Expression:
    return _substituted(row, {column: expression})


def _scaled(matrix: csr_array) -> csr_array:
    """Rows with coefficients of at most 1, without zeros."""
    C = csr_array(matrix, copy=True)
    C.sum_duplicates()
    row = np.repeat(np.arange(C.shape[0]), np.diff(C.indptr))
    largest = np.zeros(C.shape[0])
    np.maximum.at(largest, row, np.abs(C.data))
    C.data = C.data / np.where(largest > 0, largest, 1.0)[row]
    C.data[np.abs(C.data) < _ZERO] = 0.0
    C.eliminate_zeros()
    return C


def _groups(C_out: csr_array, rows: Indices) -> list[tuple[Indices, Indices]]:
    """Rows and columns outside that are joined by no others."""
    if not len(rows):
        return []
    part = abs(C_out[rows])
    graph = part.T @ part
    _, label = connected_components(graph, directed=False)
    first = part.indices[part.indptr[:-1]]
    used: Mask = np.diff(part.tocsc().indptr) > 0
    return [
        (rows[label[first] == group], np.flatnonzero(used & (label == group)))
        for group in np.unique(label[used])
    ]


def _row(matrix: csr_array, number: int) -> Expression:
    own = slice(matrix.indptr[number], matrix.indptr[number + 1])
    return dict(zip(matrix.indices[own].tolist(), matrix.data[own].tolist(), strict=True))


def _expression(columns: Indices, values: Array) -> Expression:
    kept = np.abs(values) > _ZERO * np.abs(values).max(initial=0.0)
    return dict(zip(columns[kept].tolist(), values[kept].tolist(), strict=True))


def _added(row: Expression, columns: Indices, values: Array) -> Expression:
    for place in np.flatnonzero(values):
        column = int(columns[place])
        row[column] = row.get(column, 0.0) + float(values[place])
    return row
