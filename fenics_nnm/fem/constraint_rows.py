"""Constraints as linear equations between global degrees of freedom.

A node at d from the reference point of a rigid body has the displacement u = r + theta x d. The
mean motion of nodes with weights w_i is that rigid motion which is nearest to theirs,

    sum_i w_i |u_i - r - theta x d_i|^2 -> min,

whose reaction spreads forces and moments at the point over the nodes (RBE3).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from dolfinx import fem
from scipy.sparse import coo_array, csr_array

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.errors import MeshError
from fenics_nnm.fem.constrained_nodes import (
    NodeBlocks,
    assert_no_others,
    blocks_at_nodes,
    blocks_of_coupling,
)
from fenics_nnm.fem.constraints import AXES, Coupling, Equation, LinearConstraints
from fenics_nnm.fem.elimination import Equations
from fenics_nnm.fem.mesh import TaggedMesh
from fenics_nnm.fem.unrolled import unrolled

#: Coordinates of a point outside of the mesh.
SIX = 6

#: Least eigenvalue of the normal equations of a mean motion, over the largest.
_SINGULAR = 1e-10


@dataclass(frozen=True, slots=True)
class _Rows:
    """Some equations: entries by row and column, and the column that each row prefers."""

    row: Indices
    column: Indices
    value: Array
    preferred: Indices


def constraint_equations(
    space: fem.FunctionSpace, tagged: TaggedMesh, constraints: LinearConstraints, clamped: Indices
) -> Equations:
    """All equations, without displacements that are clamped; all ranks call this.

    Columns are the global degrees of freedom, then six of each reference point.

    Args:
        space: Displacement space.
        tagged: Mesh.
        constraints: Constraints, whose nodes are numbers of the input mesh.
        clamped: Global degrees of freedom that do not move.

    Raises:
        MeshError: if a constraint cannot be put on this mesh.
    """
    maker = _Maker(space, tagged, constraints)
    parts = list(maker.parts())
    starts = np.cumsum([0, *(len(part.preferred) for part in parts)])
    row = np.concatenate([part.row + start for part, start in zip(parts, starts, strict=False)])
    column, value, preferred = (
        np.concatenate([getattr(part, name) for part in parts])
        for name in ("column", "value", "preferred")
    )
    kept = ~np.isin(column, clamped)
    shape = (int(starts[-1]), maker.inside + SIX * len(constraints.references))
    matrix = coo_array((value[kept], (row[kept], column[kept])), shape=shape)
    return Equations(csr_array(matrix), maker.inside, preferred)


class _Maker:
    """Equations of each constraint on one mesh."""

    def __init__(
        self, space: fem.FunctionSpace, tagged: TaggedMesh, constraints: LinearConstraints
    ) -> None:
        self._space, self._tagged, self._constraints = space, tagged, constraints
        self._dim = tagged.dim
        self.inside = int(space.dofmap.index_map.size_global) * self._dim
        self._points = np.array([each.point for each in constraints.references]).reshape(-1, 3)
        single = [
            np.array(each.nodes, dtype=np.int64)
            for each in constraints.couplings
            if each.kind == "mean"
        ]
        numbers_of_equations = np.array(
            [n for e in constraints.equations for n, _, _ in e.terms], dtype=np.int64
        )
        single.append(numbers_of_equations)
        single.append(np.array([each.node for each in constraints.references], dtype=np.int64))
        numbers = np.unique(np.concatenate(single))
        self._numbers = numbers[numbers >= 0]
        if len(self._numbers):
            self._at_nodes = blocks_at_nodes(space, tagged, self._numbers)
        if constraints.equations:
            equated = numbers_of_equations[numbers_of_equations >= 0]
            known = self._nodes(equated).blocks
            assert_no_others(space, tagged, equated, known, constraints.equations[0].key)

    def parts(self) -> Iterator[_Rows]:
        """Equations of each constraint in turn."""
        for place, reference in enumerate(self._constraints.references):
            axes = [axis for axis in AXES[self._dim] if axis in reference.held]
            yield _of_terms([[(self._outside(place, axis), 1.0)] for axis in axes])
            if reference.node >= 0:
                yield _of_terms(
                    [
                        [
                            (self._outside(place, axis), 1.0),
                            (self._column(reference.node, axis), -1),
                        ]
                        for axis in range(self._dim)
                    ]
                )
        for coupling in self._constraints.couplings:
            yield self._mean(coupling) if coupling.kind == "mean" else self._rigid(coupling)
            yield self._followers(coupling)
        yield _of_terms([self._terms(each) for each in self._constraints.equations])

    def _outside(self, reference: int, axis: int) -> int:
        return self.inside + SIX * reference + axis

    def _nodes(self, nodes: Indices) -> NodeBlocks:
        row = np.searchsorted(self._numbers, nodes)
        return NodeBlocks(self._at_nodes.blocks[row], self._at_nodes.points[row])

    def _column(self, node: int, axis: int) -> int:
        return int(self._nodes(np.array([node])).blocks[0]) * self._dim + axis

    def _rigid(self, coupling: Coupling) -> _Rows:
        """u_i - r - theta x d_i = 0 along the axes of the coupling."""
        found = blocks_of_coupling(self._space, self._tagged, coupling)
        if not len(found.blocks) and not coupling.followers:
            raise MeshError(f"{coupling.key}: there are no nodes of the body")
        G = _rigid_motion(found.points - self._points[coupling.reference])
        axes = np.array([axis for axis in range(self._dim) if axis in coupling.axes])
        own = (found.blocks[:, None] * self._dim + axes).ravel()
        G = G[:, axes].reshape(-1, SIX)
        row, axis = np.nonzero(G)
        keep = np.isin(axis, AXES[self._dim])
        row, axis = row[keep], axis[keep]
        return _Rows(
            np.concatenate([np.arange(len(own)), row]),
            np.concatenate([own, self._outside(coupling.reference, 0) + axis]),
            np.concatenate([np.ones(len(own)), -G[row, axis]]),
            own,
        )

    def _followers(self, coupling: Coupling) -> _Rows:
        """The same for points outside of the mesh that follow, whose rotations do, too."""
        terms = []
        for follower in coupling.followers:
            d = self._points[follower] - self._points[coupling.reference]
            G = np.vstack([_rigid_motion(d[None])[0], np.eye(3, SIX, 3)])
            for axis in sorted({*coupling.axes} & {*AXES[self._dim]}):
                row = [(self._outside(follower, axis), 1.0)]
                row += [
                    (self._outside(coupling.reference, other), -G[axis, other])
                    for other in AXES[self._dim]
                    if G[axis, other]
                ]
                terms.append(row)
        return _of_terms(terms)

    def _mean(self, coupling: Coupling) -> _Rows:
        """Q - (sum G_i^T W_i G_i)^-1 sum G_i^T W_i u_i = 0 for the motion q of the point."""
        found = self._nodes(np.array(coupling.nodes, dtype=np.int64))
        own = np.array(AXES[self._dim])
        G = _rigid_motion(found.points - self._points[coupling.reference])[:, : self._dim, own]
        W = np.array(coupling.weights)[:, : self._dim]
        normal = np.einsum("iap,ia,iaq->pq", G, W, G)
        size = np.sqrt(np.maximum(np.diag(normal), np.finfo(float).tiny))
        strengths = np.linalg.eigvalsh(normal / np.outer(size, size))
        if not strengths[0] > _SINGULAR * strengths[-1]:
            raise MeshError(
                f"{coupling.key}: its nodes do not determine the rotation of the point: must not "
                "lie on a line"
            )
        right = np.einsum("iap,ia->pia", G, W).reshape(len(own), -1)
        motion = np.linalg.solve(normal, right)
        columns = unrolled(found.blocks, self._dim)
        return _of_terms(
            [
                [
                    (self._outside(coupling.reference, int(axis)), 1.0),
                    *((int(columns[i]), -float(values[i])) for i in np.flatnonzero(values)),
                ]
                for axis, values in zip(own, motion, strict=True)
                if axis in coupling.axes
            ]
        )

    def _terms(self, equation: Equation) -> list[tuple[int, float]]:
        """Columns and coefficients of an equation."""
        beyond = [axis for _, axis, _ in equation.terms if axis not in AXES[self._dim]]
        turning = [axis for node, axis, _ in equation.terms if node >= 0 and axis >= self._dim]
        if beyond or turning:
            axis = (beyond or turning)[0] + 1
            raise MeshError(
                f"{equation.key} cannot be followed: a node of the mesh has no direction {axis}"
            )
        return [
            (self._column(n, axis) if n >= 0 else self._outside(-1 - n, axis), value)
            for n, axis, value in equation.terms
        ]


def _of_terms(terms: list[list[tuple[int, float]]]) -> _Rows:
    """Rows of columns and values; the first column is preferred."""
    flat = [(i, column, value) for i, row in enumerate(terms) for column, value in row]
    rows, columns, values = (list(each) for each in zip(*flat, strict=True)) if flat else ([],) * 3
    return _Rows(
        np.array(rows, dtype=np.int64),
        np.array(columns, dtype=np.int64),
        np.array(values, dtype=float),
        np.array([row[0][0] for row in terms], dtype=np.int64),
    )


def _rigid_motion(d: Array) -> Array:
    """Displacements under the six motions of a rigid body at places d (n, 3): shape (n, 3, 6)."""
    G = np.zeros((len(d), 3, SIX))
    G[:, range(3), range(3)] = 1.0
    x, y, z = d.T
    G[:, 0, 4], G[:, 0, 5] = z, -y
    G[:, 1, 3], G[:, 1, 5] = -z, x
    G[:, 2, 3], G[:, 2, 4] = y, -x
    return G
