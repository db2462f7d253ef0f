"""All steady loads at once, by steps with the factors of the stiffness of the unloaded body."""

from __future__ import annotations

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.errors import ConvergenceError, OutOfMemoryError
from fenics_nnm.fem.anderson import Anderson
from fenics_nnm.fem.factored import Factors
from fenics_nnm.fem.factorisation import mumps_asked_for
from fenics_nnm.fem.inside_out import turned_inside_out
from fenics_nnm.fem.least_ratio import least_ratio
from fenics_nnm.fem.loaded_residual import LoadedResidual
from fenics_nnm.fem.ordered import Ordered
from fenics_nnm.fem.parallel import HeldTogether
from fenics_nnm.fem.solid import Solid
from fenics_nnm.fem.substructures import Substructures

#: Steps have converged when one is this part of the displacement, as what is left then is some ten
#: times less; as many at most, and so many without a smaller one, by round-off where the smallest
#: one is the last part of the displacement.
_ACCURACY, _MOST_STEPS, _PATIENCE, _ROUND_OFF = 3e-10, 40, 5, 1e-7

#: A step, or the displacement, that is more than this times the first step leads elsewhere.
_FARTHER = 3.0

#: A tangent stiffness below this part of that of the unloaded body is left to others; it is enough
#: to know that it is above the second one.
_SOFT, _FIRM = 0.01, 0.2

#: Prefix of PETSc options of the factorisation.
_PREFIX = "nnm_static_"


class LoadsAtOnce(HeldTogether):
    """Accelerated steps with one stiffness; a context manager that frees its factors.

    PETSc options take the prefix `nnm_static_`.

    Attributes:
        steps: Number of steps so far.
    """

    def __init__(self, solid: Solid, residual: LoadedResidual, memory: float | None) -> None:
        """Prepare for a body.

        Args:
            solid: The unloaded body.
            residual: Its residual, whose displacement moves.
            memory: Memory in bytes that a rank may take for factors; no limit if None.
        """
        comm = solid.tagged.mesh.comm
        super().__init__(comm)
        self._solid, self._residual, self._comm, self._memory = solid, residual, comm, memory
        self._factors: Factors | None = None
        self.steps = 0

    def release(self) -> None:
        """Free the factorisation."""
        if self._factors is not None:
            self._factors.release()

    def found(self) -> bool:
        """Whether steps lead to a state of all loads; its tangent is assembled.

        Raises:
            OutOfMemoryError: if there is too little memory for the factors.
        """
        self._residual.apply(1.0)
        try:
            if self._inverse.negative or not self._converged():
                return False
            if turned_inside_out(self._residual.displacement):
                return False
        except OutOfMemoryError:
            raise
        except ConvergenceError:
            return False
        self._residual.assemble()
        return True

    def firm(self) -> bool:
        """Whether the state that was found is stable, as the factors of the unloaded body show."""
        try:
            return least_ratio(self._residual.tangent, self._inverse.solve, _FIRM) > _SOFT
        except ConvergenceError:
            return False

    @property
    def _inverse(self) -> Factors:
        """The factors of the stiffness, made once.

        Raises:
            OutOfMemoryError: if there is too little memory.
            ConvergenceError: if there are none for another reason.
        """
        if self._factors is None and not mumps_asked_for(_PREFIX):
            self._factors = Substructures.of(self._solid, self._memory)
        if self._factors is None:
            self._factors = inverse = Ordered.of(self._solid, self._memory, _PREFIX)
            inverse.factorise(self._memory)
        return self._factors

    def _converged(self) -> bool:
        """Whether accelerated steps converge.

        Raises:
            ConvergenceError: if a step is not to be had.
        """
        residual, faster = self._residual, Anderson(self._comm)
        first, least, since = 0.0, np.inf, 0
        for _ in range(_MOST_STEPS):
            self.steps += 1
            before = residual.owned.copy()
            change = self._step() - before
            moved, whole = residual.norm(change), residual.norm(before)
            first = first or moved
            if not moved <= _FARTHER * first or whole > _FARTHER * first:
                return False
            least, since = (moved, 0) if moved < least else (least, since + 1)
            residual.move(faster.following(before, change))
            if moved <= _ACCURACY * whole or since == _PATIENCE:
                return least <= _ROUND_OFF * whole
        return False

    def _step(self) -> Array:
        """The next displacement u - K^-1 r(u) in m, without acceleration, shape (n_owned,)."""
        return self._inverse.solve(-self._residual.rest()[:, None])[:, 0]
