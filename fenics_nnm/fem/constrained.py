"""From constraints to the system that is solved: dependent degrees of freedom, T and T^T K T."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from dolfinx import fem
from petsc4py import PETSc
from scipy.sparse import coo_array, csr_array

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.errors import MeshError
from fenics_nnm.fem.constraint_rows import SIX, constraint_equations
from fenics_nnm.fem.constraints import AXES, LinearConstraints, Reference
from fenics_nnm.fem.elimination import Elimination, Expression, eliminated
from fenics_nnm.fem.mesh import TaggedMesh
from fenics_nnm.fem.system import ConstrainedSystem, FreeSystem, System
from fenics_nnm.fem.unrolled import owned_rows

#: Most displacements that may carry the mass of a point together: each pair has an entry.
_MOST_CARRYING = 6000

_AXIS_NAMES = (
    *("motion along x", "motion along y", "motion along z"),
    *("rotation about x", "rotation about y", "rotation about z"),
)


@dataclass(frozen=True, slots=True)
class _Load:
    """What one reference point carries, in degrees of freedom of the mesh.

    Attributes:
        columns: Global degrees of freedom that move it, shape (n,).
        A: Motion along its axes per displacement there, shape (k, n).
        stiffness: Springs along these axes, shape (k, k).
        mass: Mass and inertia.
    """

    columns: Indices
    A: Array
    stiffness: Array
    mass: Array


@dataclass(frozen=True, slots=True)
class Constrained:
    """Constraints on a space, solved for dependent degrees of freedom; the same on all ranks.

    Attributes:
        space: Displacement space.
        constraints: What was asked for.
        found: Global degrees of freedom as expressions of independent ones.
    """

    space: fem.FunctionSpace
    constraints: LinearConstraints
    found: Elimination

    @property
    def held(self) -> Indices:
        """Local degrees of freedom, ghosts included, that do not move at all, unrolled."""
        still = np.array([c for c, row in self.found.dependent.items() if not row], dtype=np.int64)
        size = self.space.dofmap.index_map_bs
        local = self.space.dofmap.index_map.global_to_local(still // size)
        return np.sort((local * size + still % size)[local >= 0]).astype(np.int32)

    def system(self, stiffness: PETSc.Mat, mass: PETSc.Mat) -> tuple[PETSc.Mat, PETSc.Mat, System]:
        """K and M with what reference points carry, and the system to solve; all ranks call this.

        Args:
            stiffness: K of the mesh, assembled.
            mass: M of the mesh, whose pattern is a part of that of K.

        Raises:
            MeshError: if a point that carries something is not held by the nodes.
        """
        K, M = stiffness, mass
        for load in self._loads():
            K, M = (_with_load(m, load, S) for m, S in ((K, load.stiffness), (M, load.mass)))
        rows = {column: row for column, row in self.found.dependent.items() if row}
        if not rows:
            return K, M, FreeSystem(K, M)
        T = _transformation(rows, K)
        start, end = K.getOwnershipRange()
        dependent = np.array(sorted(rows), dtype=np.int64)
        own = dependent[(dependent >= start) & (dependent < end)]
        reduced = _plus(K.PtAP(T), own, own, np.ones(len(own)))
        inertia = _plus(M.PtAP(T), own, own, np.zeros(len(own)))  # so its pattern is a part of K's
        for matrix in (reduced, inertia):
            matrix.setOption(PETSc.Mat.Option.SYMMETRIC, True)
        keys = self.constraints.keys
        back = T.copy().transpose()
        return K, M, ConstrainedSystem(reduced, inertia, len(rows), keys, T, back, own - start)

    def _loads(self) -> Iterator[_Load]:
        """What each reference point carries, if anything."""
        inside = self.space.dofmap.index_map.size_global * self.space.dofmap.index_map_bs
        for place, reference in enumerate(self.constraints.references):
            stiffness, mass = np.array(reference.stiffness), np.array(reference.mass)
            carried = (np.abs(stiffness) + np.abs(mass)).any(axis=0)
            axes = [axis for axis in AXES[self.space.dofmap.index_map_bs] if carried[axis]]
            rows = [self._axis(reference, axis, inside + SIX * place + axis) for axis in axes]
            columns = np.unique(np.array([c for row in rows for c in row], dtype=np.int64))
            if len(columns) > _MOST_CARRYING:
                raise MeshError(
                    f"{reference.key} cannot be followed: its mass or springs follow the mean of "
                    f"{len(columns)} displacements: must be at most {_MOST_CARRYING}"
                )
            A = np.array([[row.get(int(c), 0.0) for c in columns] for row in rows])
            if len(columns):
                own = np.ix_(axes, axes)
                yield _Load(columns, A, stiffness[own], mass[own])

    def _axis(self, reference: Reference, axis: int, column: int) -> Expression:
        if column not in self.found.outside:
            raise MeshError(
                f"{reference.key} cannot be followed: it has mass or springs, and no node of the "
                f"body holds its {_AXIS_NAMES[axis]}"
            )
        return self.found.outside[column]


def constrained(
    space: fem.FunctionSpace, tagged: TaggedMesh, constraints: LinearConstraints, clamped: Indices
) -> Constrained:
    """Solve constraints for dependent degrees of freedom; all ranks call this.

    Args:
        space: Displacement space.
        tagged: Mesh.
        constraints: Constraints, whose nodes are numbers of the input mesh.
        clamped: Local degrees of freedom that do not move, unrolled.

    Raises:
        MeshError: if a constraint cannot be put on this mesh.
    """
    if not constraints.joining:
        return Constrained(space, constraints, Elimination())
    fixed = np.concatenate(tagged.mesh.comm.allgather(owned_rows(space, clamped)))
    found = eliminated(constraint_equations(space, tagged, constraints, fixed))
    return Constrained(space, constraints, found)


def _transformation(rows: Mapping[int, Expression], like: PETSc.Mat) -> PETSc.Mat:
    """T: the identity, with expressions in the rows of dependent degrees of freedom."""
    start, end = like.getOwnershipRange()
    own = {column: row for column, row in rows.items() if start <= column < end}
    kept = np.setdiff1d(np.arange(start, end), np.fromiter(own, dtype=np.int64, count=len(own)))
    entries = [(c, other, value) for c, row in own.items() for other, value in row.items()]
    row, column, value = np.array(entries).reshape(-1, 3).T
    return _matrix(
        np.concatenate([kept, row.astype(np.int64)]),
        np.concatenate([kept, column.astype(np.int64)]),
        np.concatenate([np.ones(len(kept)), value]),
        like,
    )


def _with_load(matrix: PETSc.Mat, load: _Load, S: Array) -> PETSc.Mat:
    """A matrix with A^T S A, whose zeros are a part of its pattern, too."""
    start, end = matrix.getOwnershipRange()
    mine = (load.columns >= start) & (load.columns < end)
    values = load.A[:, mine].T @ S @ load.A
    row = np.repeat(load.columns[mine], len(load.columns))
    column = np.tile(load.columns, int(mine.sum()))
    return _plus(matrix, row, column, values.ravel())


def _plus(matrix: PETSc.Mat, row: Indices, column: Indices, value: Array) -> PETSc.Mat:
    """A matrix with entries of owned rows added."""
    added = _matrix(row, column, value, matrix)
    matrix.axpy(1.0, added, PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN)
    added.destroy()
    return matrix


def _matrix(row: Indices, column: Indices, value: Array, like: PETSc.Mat) -> PETSc.Mat:
    """A matrix of owned rows with the layout of another one."""
    start, end = like.getOwnershipRange()
    entries = coo_array((value, (row - start, column)), shape=(end - start, like.getSize()[1]))
    rows = csr_array(entries)
    matrix = PETSc.Mat().createAIJ(
        like.getSizes(),
        csr=(rows.indptr.astype(np.int32), rows.indices.astype(np.int32), rows.data),
        comm=like.comm,
    )
    matrix.assemble()
    return matrix
