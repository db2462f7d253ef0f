"""Anderson's acceleration of an iteration x + g(x), with vectors spread over the ranks.

D. G. Anderson, J. ACM 12 (1965) 547-560; H. F. Walker, P. Ni, SIAM J. Numer. Anal. 49 (2011)
1715-1735. With all earlier steps kept it does for g what GMRES does where g is linear.
"""

from __future__ import annotations

import numpy as np
from mpi4py import MPI

from fenics_nnm.arrays import Array

#: Earlier changes of g are forgotten when no more than this part of a new one is not along them:
#: what they say is no longer so where g is not linear.
_DEPENDENT = 0.003

#: Rows that there is room for at first; those that stay empty take no memory.
_ROOM = 32


class Anderson:
    """The next x from all x and g(x) so far, with the least g that their changes can make."""

    def __init__(self, comm: MPI.Comm) -> None:
        """Begin with no step; `comm` has all parts of the vectors."""
        self._comm = comm
        self._last: tuple[Array, Array] | None = None
        self._count = 0
        self._rows = np.empty((2, 0, 0))  # changes of x, and of g: these are orthonormal

    def following(self, x: Array, g: Array) -> Array:
        """The next x, each of shape (n_owned,); to be called on all ranks."""
        if self._last is not None:
            self._learn(x - self._last[0], g - self._last[1])
        self._last = x, g
        moved, changed = self._along(g)
        return x + g - moved - changed

    def _learn(self, moved: Array, changed: Array) -> None:
        """Keep a change of x and that of g that it made, made orthogonal to those before."""
        size, latest = self._norm(changed), (moved, changed)
        for _ in range(2):  # twice is enough
            along = self._along(changed)
            moved, changed = moved - along[0], changed - along[1]
        left = self._norm(changed)
        if left <= _DEPENDENT * size:
            (moved, changed), left = latest, size
            self._count = 0
        if left:
            self._keep(moved / left, changed / left)

    def _along(self, g: Array) -> tuple[Array, Array]:
        """The part of g along earlier changes of g, as a change of x and of g."""
        if not self._count:
            return np.zeros(len(g)), np.zeros(len(g))
        moved, changed = self._rows[:, : self._count]
        parts = np.asarray(self._comm.allreduce(changed @ g))
        return parts @ moved, parts @ changed

    def _keep(self, moved: Array, changed: Array) -> None:
        if self._count >= self._rows.shape[1]:
            rows = np.empty((2, max(_ROOM, 2 * self._count), len(moved)))
            if self._count:
                rows[:, : self._count] = self._rows[:, : self._count]
            self._rows = rows
        self._rows[:, self._count] = moved, changed
        self._count += 1

    def _norm(self, one: Array) -> float:
        return float(np.sqrt(self._comm.allreduce(float(one @ one))))
