r"""Factors of the stiffness of a body on several ranks: each rank's part, and what they share.

The nodes that several ranks have cells at are the interface s of the parts; the others of a rank r
are its inner ones, and no matrix entry couples inner ones of two ranks. Each rank factorises its
inner rows and, after them, its rows of the interface,

    [K_rr K_rs]   [L_rr     ] [L_rr^T L_sr^T]
    [K_sr K_ss] = [L_sr L_ss] [       L_ss^T],   L_ss L_ss^T = K_ss - K_sr K_rr^-1 K_rs,

so that the stiffness condensed to the interface is S = K_ss + sum_r (L_ss L_ss^T - K_ss)_r, a dense
matrix that every rank factorises (J. S. Przemieniecki, Matrix structural analysis of substructures,
AIAA J. 1 (1963) 138-147). A solution is one forward step of each rank, S^-1 on the interface, and
one backward step: as much work on each rank as its part has, and one sum over ranks.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from types import ModuleType

import numpy as np
from dolfinx import fem
from mpi4py import MPI
from petsc4py import PETSc
from scipy.linalg import cho_factor, cho_solve
from scipy.sparse import csr_matrix

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.errors import ConvergenceError
from fenics_nnm.fem.block import groups, product
from fenics_nnm.fem.cholesky import Cholesky, kernel
from fenics_nnm.fem.dissection import nodes_dissected, worth_dissecting
from fenics_nnm.fem.factorisation import cholmod_fits
from fenics_nnm.fem.solid import Solid
from fenics_nnm.fem.unrolled import unrolled

logger = logging.getLogger(__name__)

#: Largest number of degrees of freedom of the interface: S has its square of entries.
_MOST_SHARED = 6000

#: Most arrays of the size of S that there are at once.
_ARRAYS = 8

#: Residual of a solution over its force, both of a random displacement; above it MUMPS is used.
_RESIDUAL = 1e-9

#: Columns that are solved for at once.
_AT_ONCE = 64


@dataclass(frozen=True, slots=True)
class Part:
    """Rows of a rank.

    Attributes:
        inner: Owned degrees of freedom that no other rank has, in an order of few entries of
            factors, local, shape (i,).
        face: Degrees of freedom of the interface that this rank has, local, shape (f,).
        numbers: Rows of the matrix of `inner` and `face`, shape (i + f,).
        places: Where those of `face` are on the whole interface, shape (f,).
        shared: The whole interface, numbers of rows of the matrix, ascending, shape (s,).
    """

    inner: Indices
    face: Indices
    numbers: Indices
    places: Indices
    shared: Indices

    @classmethod
    def of(cls, space: fem.FunctionSpace, comm: MPI.Intracomm) -> Part:
        """The rows of a space of displacements; to be called on all ranks."""
        nodes, size = space.dofmap.index_map, space.dofmap.index_map_bs
        shared = np.unique(np.concatenate(comm.allgather(np.asarray(nodes.ghosts))))
        order = nodes_dissected(space)
        numbers = np.asarray(nodes.local_to_global(order.astype(np.int32)), dtype=np.int64)
        elsewhere = np.isin(numbers, shared)
        inner, face, own = order[~elsewhere], order[elsewhere], numbers[elsewhere]
        return cls(
            unrolled(inner, size),
            unrolled(face, size),
            unrolled(np.concatenate([numbers[~elsewhere], own]), size),
            unrolled(np.searchsorted(shared, own), size),
            unrolled(shared, size),
        )


class Substructures:
    """K^-1 of a body on several ranks, as `factored.Factors`.

    Attributes:
        negative: Number of negative eigenvalues of the stiffness: it has none.
    """

    negative = 0

    def __init__(self, solid: Solid, part: Part, code: ModuleType) -> None:
        """Factorise the stiffness; to be called on all ranks.

        Args:
            solid: Body, without constraints.
            part: Rows of this rank.
            code: Of `cholesky.kernel`.

        Raises:
            ConvergenceError: on all ranks, if the stiffness is not positive definite, memory is
                short or solutions are not accurate.
        """
        comm = solid.tagged.mesh.comm
        self._comm, self._shared, inner = comm, len(part.shared), len(part.inner)
        held = _of_interface(solid, part)
        end = held[np.ix_(part.places, part.places)]
        self._factors = self._factorised(code, solid, part, end)
        face = self._factors.order[inner:] - inner
        self._L = self._factors.last(len(face))
        self._places = part.places[face]
        self._owned = np.flatnonzero(part.face[face] < solid.owned)
        self._inner = part.inner[self._factors.order[:inner]]
        self._outer = part.face[face][self._owned]
        change = self._L @ self._L.T
        change -= end[np.ix_(face, face)]
        self._condensed = self._condensation(change, held)
        self._assert_solves(solid.stiffness)

    @classmethod
    def of(cls, solid: Solid, memory: float | None) -> Substructures | None:
        """Factors of a body on several ranks; None where others are faster, or there are none.

        Args:
            solid: Body, without constraints.
            memory: Memory in bytes that a rank may take for factors; no limit if None.
        """
        comm = solid.tagged.mesh.comm
        fits = cholmod_fits(solid.owned, memory) and worth_dissecting(solid.space)
        if comm.size == 1 or not comm.allreduce(fits, op=MPI.LAND):
            return None
        part = Part.of(solid.space, comm)
        code = kernel(comm) if _shared_fits(len(part.shared), memory) else None
        if code is None:
            return None
        try:
            return cls(solid, part, code)
        except ConvergenceError as error:
            logger.info("MUMPS factorises: %s", error)
            return None

    def solve(self, columns: Array) -> Array:
        """Solutions for right-hand sides of shape (n_owned, k)."""
        found = np.empty(columns.shape, order="F")
        for group in groups(columns.shape[1], _AT_ONCE):
            self._solve(columns[:, group], found[:, group])
        return found

    def solve_in_order(self, columns: Array) -> Array:
        """As `solve`: rows stay in the order of the matrix."""
        return self.solve(columns)

    def in_order(self, columns: Array) -> Array:
        """The columns as they are."""
        return columns

    def matrix_in_order(self, matrix: PETSc.Mat) -> PETSc.Mat:
        """The matrix as it is."""
        return matrix

    def restored(self, columns: Array) -> Array:
        """The columns as they are."""
        return columns

    def release(self) -> None:
        """Free the factors."""
        self._factors.release()

    def _factorised(self, code: ModuleType, solid: Solid, part: Part, end: Array) -> Cholesky:
        """Factors of this rank's rows, the interface last.

        Raises:
            ConvergenceError: on all ranks, if one has none.
        """
        inner = len(part.inner)
        with _on_all(self._comm):
            factors = Cholesky(code, *_with_end(_inner_rows(solid, part), end))
            if (factors.order[inner:] < inner).any():
                raise ConvergenceError("CHOLMOD does not keep the interface last")
        return factors

    def _condensation(self, change: Array, held: Array) -> tuple[Array, bool]:
        """Factors of the stiffness S that is condensed to the interface.

        Args:
            change: What the inner rows of this rank add to it, shape (f, f).
            held: Stiffness of the interface with all inner rows held, shape (s, s).

        Raises:
            ConvergenceError: on all ranks, if it is not positive definite.
        """
        S = np.zeros((self._shared, self._shared))
        S[np.ix_(self._places, self._places)] = change
        self._comm.Allreduce(MPI.IN_PLACE, S)
        S += held
        with _on_all(self._comm):
            try:
                # in its own memory, as columns lie one after the other there
                factors: tuple[Array, bool] = cho_factor(S.T, lower=True, overwrite_a=True)
            except np.linalg.LinAlgError as error:
                raise ConvergenceError("the stiffness is not positive definite") from error
        return factors

    def _solve(self, columns: Array, found: Array) -> None:
        inner, face = len(self._inner), len(self._places)
        own = np.zeros((inner + face, columns.shape[1]), order="F")
        for column in range(columns.shape[1]):
            np.take(columns[:, column], self._inner, out=own[:inner, column], mode="clip")
        self._factors.forward(own)
        shared = np.zeros((self._shared, columns.shape[1]))
        shared[self._places] = self._L @ own[inner:]
        shared[self._places[self._owned]] += columns[self._outer]
        self._comm.Allreduce(MPI.IN_PLACE, shared)
        shared = cho_solve(self._condensed, shared, overwrite_b=True, check_finite=False)
        own[inner:] = self._L.T @ shared[self._places]
        self._factors.backward(own)
        for column in range(columns.shape[1]):
            found[self._inner, column] = own[:inner, column]
        found[self._outer] = shared[self._places[self._owned]]

    def _assert_solves(self, stiffness: PETSc.Mat) -> None:
        """Solve once for a force that is known to have a solution.

        Raises:
            ConvergenceError: on all ranks, if the residual is more than round-off.
        """
        rows = stiffness.getLocalSize()[0]
        moved = np.random.default_rng(self._comm.rank).standard_normal((rows, 1))
        force = product(stiffness, moved)
        left = product(stiffness, self.solve(force)) - force
        squared = [(left**2).sum(), (force**2).sum()]
        error, size = np.sqrt(self._comm.allreduce(np.array(squared)))
        if not error <= _RESIDUAL * size:
            self.release()
            raise ConvergenceError(f"residual {error / size:.1e} of solutions by substructures")


@contextmanager
def _on_all(comm: MPI.Intracomm) -> Iterator[None]:
    """Have an error of one rank on all of them: ConvergenceError.

    Raises:
        ConvergenceError: if one rank has it, or MemoryError.
    """
    failed = ""
    try:
        yield
    except (ConvergenceError, MemoryError) as error:
        failed = str(error) or "memory is short"
    words = comm.allgather(failed)
    if any(words):
        raise ConvergenceError(next(filter(None, words)))


def _shared_fits(shared: int, memory: float | None) -> bool:
    """Whether dense matrices of an interface fit into a memory in bytes; no limit if None."""
    return shared <= _MOST_SHARED and (memory is None or 8 * _ARRAYS * shared**2 <= memory)


def _inner_rows(solid: Solid, part: Part) -> csr_matrix:
    """Stiffness at the inner rows of a rank: of itself, and of the interface after it.

    Raises:
        ConvergenceError: if it has entries at other columns.
    """
    place = np.full(solid.stiffness.getSize()[0], -1, dtype=np.int32)
    place[part.numbers] = np.arange(len(part.numbers))
    starts, columns, values = solid.stiffness.getValuesCSR()
    shape = (len(starts) - 1, len(place))
    found = csr_matrix((values, columns, starts), shape=shape)[part.inner]
    columns = place[found.indices]
    if (columns < 0).any():
        raise ConvergenceError("the stiffness couples inner displacements of two ranks")
    return csr_matrix(
        (found.data, columns, found.indptr), shape=(len(part.inner), len(part.numbers))
    )


def _of_interface(solid: Solid, part: Part) -> Array:
    """Stiffness of the whole interface with all inner displacements held, shape (s, s)."""
    rows = PETSc.IS().createGeneral(part.shared.astype(PETSc.IntType), comm=PETSc.COMM_SELF)
    (matrix,) = solid.stiffness.createSubMatrices([rows], [rows])
    starts, columns, values = matrix.getValuesCSR()
    size = matrix.getSize()
    matrix.destroy()
    return np.asarray(csr_matrix((values, columns, starts), shape=size).toarray())


def _with_end(inner: csr_matrix, end: Array) -> tuple[Indices, Indices, Array]:
    """Rows of a symmetric matrix, those after the inner ones from their diagonal block on.

    The latter has all entries, also those that are zero: so it stays last in the order of the
    factors, which are dense there.

    Returns:
        Starts of rows, columns and values, as of `Cholesky`.
    """
    count, whole = inner.shape
    face = whole - count
    starts = np.concatenate([inner.indptr, int(inner.indptr[-1]) + face * np.arange(1, face + 1)])
    own = np.arange(count, whole, dtype=inner.indices.dtype)
    columns = np.concatenate([inner.indices, np.tile(own, face)])
    return starts, columns, np.concatenate([inner.data, end.ravel()])
