r"""The lowest modes of a body by block Lanczos iteration with the factors of its stiffness.

A = K^-1 M is symmetric in the inner product of M, and its largest eigenvalues theta = 1/omega^2 are
those of the lowest modes. From an M-orthonormal basis V that grows by A times its last block,
T = V^T M A V has the Ritz pairs (theta, V s); the residual of one, in the norm of M, is that of
the part W s_last of A V_last that V has not (G. H. Golub, R. Underwood, The block Lanczos method,
in: Mathematical Software III, 1977; R. G. Grimes, J. G. Lewis, H. D. Simon, SIAM J. Matrix Anal.
Appl. 15 (1994) 228). Each block is orthogonalised against all of V, which costs as much as the
solutions and needs no test of what was lost. A basis that is full is made smaller by a thick
restart (K. Wu, H. Simon, SIAM J. Matrix Anal. Appl. 22 (2000) 602).

A block of right-hand sides costs a fraction of as many single ones, and finds modes of equal
frequency, as many as it has columns.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from fenics_nnm.arrays import Array, Indices, Mask
from fenics_nnm.errors import ConvergenceError

logger = logging.getLogger(__name__)

#: Columns of a block; measured, see benchmarks/README.md.
BLOCK = 8

#: Largest residual of a mode over theta; the error of its frequency is of the order of the square.
_TOLERANCE = 1e-10

#: The same of the modes beyond those asked for, of which the frequency alone is wanted.
_SPARE_TOLERANCE = 1e-3

#: A basis has room for twice the modes wanted and this many blocks.
_ROOM = 10

#: Of a new block, directions shorter than this part of it before it was orthogonalised are
#: round-off.
_ROUND_OFF = 1e-14

#: A block is orthogonal where the last pass took no more than this part of its columns away; and
#: the largest number of passes.
_LITTLE, _PASSES = 0.1, 4

#: Squared length of combinations of columns of unit length, that are orthonormal to round-off over
#: this only.
_ILL = 1e-4

#: Squared length, of columns of unit length, of combinations that depend on the others.
_DEPENDENT = 1e-13

#: Values below this part of the largest one are lost in its round-off, as beside rigid-body modes.
_NOISE = 1e-7

#: Largest number of blocks that are solved for.
_BLOCKS = 2000


class Inverse(Protocol):
    """What the iteration needs of a body; blocks of columns at the owned degrees of freedom."""

    def solve(self, forces: Array) -> Array:
        """K^-1 f, columns of shape (n_owned, k)."""

    def mass(self, columns: Array) -> Array:
        """M u, columns of shape (n_owned, k)."""

    def inner(self, left: Array, right: Array) -> Array:
        """a^T b over all ranks."""

    def random(self, count: int) -> Array:
        """Random columns, other ones at each call, shape (n_owned, count)."""


@dataclass(slots=True)
class _Basis:
    """M-orthonormal columns V with M V, and T of those that A was applied to.

    Attributes:
        V: Columns, those beyond `size` to be filled, shape (n_owned, capacity).
        MV: M V.
        T: V^T M A V, shape (capacity, capacity).
        size: Number of columns.
        last: Where the last block begins, which A was not applied to yet.
    """

    V: Array
    MV: Array
    T: Array
    size: int = 0
    last: int = 0

    @classmethod
    def of(cls, rows: int, capacity: int) -> _Basis:
        """An empty one."""
        V, MV = (np.empty((rows, capacity), order="F") for _ in range(2))
        return cls(V, MV, np.zeros((capacity, capacity)))

    @property
    def block(self) -> Array:
        """M times the last block."""
        return self.MV[:, self.last : self.size]

    def append(self, W: Array, MW: Array, found: Array) -> None:
        """A further block, of combinations of columns and of M times these that are orthonormal."""
        own = slice(self.size, self.size + found.shape[1])
        for columns, of in ((self.V, W), (self.MV, MW)):
            np.matmul(found.T, of.T, out=columns[:, own].T)
        self.last, self.size = own.start, own.stop

    @classmethod
    def begun(cls, shapes: Array, mass_shapes: Array, theta: Array, capacity: int) -> _Basis:
        """One of Ritz vectors alone, M times these, and their theta."""
        basis = cls.of(len(shapes), capacity)
        basis.append(shapes, mass_shapes, np.eye(len(theta)))
        basis.T[range(len(theta)), range(len(theta))] = theta
        basis.last = basis.size
        return basis

    def keep(self, theta: Array, S: Array) -> None:
        """The Ritz vectors V S in place of all columns."""
        count = S.shape[1]
        for columns in (self.V, self.MV):
            columns[:, :count] = _times(columns[:, : self.size], S)
        self.T[:] = 0.0
        self.T[range(count), range(count)] = theta
        self.size = self.last = count


@dataclass(frozen=True, slots=True)
class _Directions:
    """Combinations of the columns of a block.

    Attributes:
        found: M-orthonormal ones, the longest last, shape (b, k).
        again: Whether some are so short that they have to be orthogonalised once more.
        left: Those that are all but dependent on the others, to be looked at without them.
        before: Squared lengths of what these were taken from, shape (b - k,).
    """

    found: Array
    again: bool
    left: Array
    before: Array


@dataclass(frozen=True, slots=True)
class _Rest:
    """The part W of A V_last that V has not.

    Attributes:
        W: Columns, shape (n_owned, b).
        MW: M W.
        gram: W^T M W, shape (b, b).
        before: Squared lengths of the columns before, shape (b,).
    """

    W: Array
    MW: Array
    gram: Array
    before: Array

    def directions(self) -> _Directions:
        """Directions that are no round-off of what was before."""
        squared = np.diagonal(self.gram)
        real = squared > _ROUND_OFF**2 * self.before
        scale = np.where(real, 1 / np.sqrt(np.where(real, squared, 1.0)), 0.0)
        length, axes = np.linalg.eigh(self.gram * np.outer(scale, scale))
        long, left = length > _DEPENDENT, (length <= _DEPENDENT)
        found = scale[:, None] * axes[:, long] / np.sqrt(length[long])
        left[: np.count_nonzero(~real)] = False
        before = np.full(np.count_nonzero(left), (self.before * scale**2).max(initial=1.0))
        again = bool((length[long] <= _ILL).any())
        return _Directions(found, again, scale[:, None] * axes[:, left], before)


class BlockLanczos:
    """Ritz pairs of A = K^-1 M, of the largest |theta|.

    Attributes:
        theta: Ritz values, |theta| descending, in s^2, shape (k,).
        residual: Their residuals over |theta|, shape (k,).
    """

    theta: Array
    residual: Array

    def __init__(self, inverse: Inverse, rows: int, free: int, count: int, spare: int) -> None:
        """Prepare for a body.

        Args:
            inverse: Products with K^-1 and M.
            rows: Owned degrees of freedom of this rank, n_owned.
            free: Free degrees of freedom of all ranks: no more columns are independent.
            count: Number of modes wanted, at most `free`.
            spare: Number of further modes, of which the frequencies alone are wanted.
        """
        self._inverse, self._free = inverse, free
        self._count, self._wanted = count, min(count + spare, free)
        self._capacity = min(2 * self._wanted + _ROOM * BLOCK, free)
        self._basis = _Basis.of(rows, self._capacity)
        self._add_random(BLOCK)

    def run(self) -> None:
        """Iterate until the modes wanted have converged, or nothing is left but round-off.

        The latter where the stiffness is singular: all displacements are rigid-body modes then,
        and fewer Ritz values are found than were wanted.

        Raises:
            ConvergenceError: if they do not.
        """
        for _ in range(_BLOCKS):
            rest = self._applied()
            if self._basis.size >= self._free or self._converged():
                return
            before = self._basis.size
            self._extend(rest)
            if self._basis.size == before:
                return
        raise ConvergenceError(
            f"eigensolver: {int(self._good()[: self._count].sum())} of {self._count} modes "
            f"converged in {_BLOCKS} blocks of {BLOCK}"
        )

    def search_again(self, shapes: Array) -> None:
        """Go on from the shapes of `settled`, and from random displacements beside them.

        For modes of one frequency that are more than the columns of a block.

        Args:
            shapes: The first mass-normalised shapes, of which those that have converged are taken.
        """
        kept = np.flatnonzero(self._good()[: shapes.shape[1]])
        found = np.asfortranarray(shapes[:, kept])
        mass = self._inverse.mass(found)
        self._basis = _Basis.begun(found, mass, self.theta[kept], self._capacity)
        self._add_random(BLOCK)
        self.run()

    def shapes(self, count: int) -> Array:
        """The first mass-normalised shapes, shape (n_owned, count)."""
        return _times(self._basis.V[:, : self._basis.size], self._S[:, :count])

    def settled(self, count: int) -> Array:
        """The same, for which the basis, most of the memory, is given up until `search_again`."""
        shapes = self.shapes(count)
        self._basis = _Basis.of(len(shapes), 0)
        return shapes

    def _applied(self) -> _Rest:
        """Apply A to the last block: T, its Ritz pairs, and what goes beyond the basis."""
        basis = self._basis
        W = self._inverse.solve(basis.block)
        rest, C = self._orthogonal(W)
        own = slice(basis.last, basis.size)
        basis.T[: basis.size, own] = C
        basis.T[own, : basis.size] = C.T
        T = basis.T[: basis.size, : basis.size]
        theta, S = np.linalg.eigh((T + T.T) / 2)
        order = np.argsort(-np.abs(theta), kind="stable")
        self.theta, self._S = theta[order], S[:, order]
        squared = np.einsum("ik,ij,jk->k", self._S[own], rest.gram, self._S[own], optimize=True)
        size = np.abs(self.theta)
        scale = np.maximum(np.maximum(size, _NOISE * size[0]), np.finfo(float).tiny)
        self.residual = np.sqrt(np.maximum(squared, 0.0)) / scale
        return rest

    def _orthogonal(self, W: Array) -> tuple[_Rest, Array]:
        """W, changed in place, without its part V C in the basis, and C.

        Raises:
            ConvergenceError: if numbers are not finite.
        """
        recent = slice(max(0, self._basis.last - BLOCK), self._basis.size)
        C = self._without(W, recent)  # the largest part, so that the next one takes little away
        for _ in range(_PASSES):
            more = self._without(W, slice(0, self._basis.size))
            C += more
            MW = self._inverse.mass(W)
            gram = self._inverse.inner(W, MW)
            if not (np.isfinite(C).all() and np.isfinite(gram).all()):
                raise ConvergenceError(
                    "eigensolver: numbers that are not finite: stiffness and mass may be too far "
                    "apart to compute with: check lengths, units and material"
                )
            if ((more**2).sum(axis=0) <= _LITTLE**2 * np.diagonal(gram)).all():
                break
        return _Rest(W, MW, gram, np.diagonal(gram) + (C**2).sum(axis=0)), C

    def _without(self, W: Array, columns: slice) -> Array:
        """Take from W, in place, its part in columns of the basis: V C, C of shape (size, b)."""
        C = np.zeros((self._basis.size, W.shape[1]))
        C[columns] = self._inverse.inner(self._basis.MV[:, columns], W)
        W -= _times(self._basis.V[:, columns], C[columns])
        return C

    def _extend(self, rest: _Rest) -> None:
        """A further block, with random columns for those that are round-off."""
        basis = self._basis
        if basis.size + BLOCK > basis.V.shape[1] < self._free:
            kept = (basis.V.shape[1] + self._wanted) // 2 - BLOCK
            self._restart(np.arange(min(kept, basis.size)))
        added = self._append(rest, basis.V.shape[1] - basis.size)
        if added < BLOCK:
            self._add_random(BLOCK - added)

    def _append(self, rest: _Rest, most: int) -> int:
        """A further block of the longest directions, and how many they are."""
        first = self._basis.size
        while most > 0:
            directions = rest.directions()
            found = directions.found[:, -most:]
            own = rest
            if directions.again:
                own, _ = self._orthogonal(_times(rest.W, found))
                found = own.directions().found
            self._basis.append(own.W, own.MW, found)
            most -= found.shape[1]
            if not directions.left.shape[1]:
                break
            rest, _ = self._orthogonal(_times(rest.W, directions.left))
            rest = replace(rest, before=directions.before)
        self._basis.last = first
        return self._basis.size - first

    def _restart(self, kept: Indices) -> None:
        self._basis.keep(self.theta[kept], self._S[:, kept])

    def _add_random(self, count: int) -> None:
        """Random columns as a part of the last block, as many as are independent."""
        basis = self._basis
        last, count = basis.last, min(count, self._free - basis.size)
        if count == 0:
            return
        W = self._inverse.solve(self._inverse.mass(self._inverse.random(count)))
        for _ in range(2):  # the first time makes lengths alike
            rest, _ = self._orthogonal(W)
            W = _times(rest.W, rest.directions().found)
        rest, _ = self._orthogonal(W)
        self._append(rest, count)
        basis.last = last

    def _good(self) -> Mask:
        return np.asarray(self.residual <= _TOLERANCE)

    def _converged(self) -> bool:
        spare = self.residual[self._count : self._wanted]
        enough = len(self.theta) >= min(self._wanted + BLOCK, self._free)
        found = enough and bool((spare <= _SPARE_TOLERANCE).all())
        return found and bool(self._good()[: self._count].all())


def _times(columns: Array, coefficients: Array) -> Array:
    """Combinations of columns that lie one after the other in memory, and so do the results."""
    return np.asarray((coefficients.T @ columns.T).T)
