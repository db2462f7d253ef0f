"""Linear modes and attachment solutions without a factorisation of the stiffness."""

from __future__ import annotations

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.errors import Code, ModelError
from fenics_nnm.fem.conjugate_gradients import static_displacements
from fenics_nnm.fem.inertia import assert_held, counted_below
from fenics_nnm.fem.lobpcg import lowest_modes
from fenics_nnm.fem.parallel import HeldTogether
from fenics_nnm.fem.pencil import Pencil
from fenics_nnm.fem.solid import Solid
from fenics_nnm.fem.two_level import TwoLevel
from fenics_nnm.reduction.linear_modes import LinearModes

#: Error of a mode in the norm of its strain energy; that of its frequency is near the square.
_MODES = 1e-7

#: Error of a static displacement in that norm.
_STATIC = 1e-10

#: Vectors beyond the modes asked for: a fifth as many, but so many at least; the last ones begin
#: at random, so that a mode that the linear elements do not show is found too.
_SPARE, _RANDOM = 8, 4


class IterativeModalSolver(HeldTogether):
    """Modes by LOBPCG and attachments by conjugate gradients; a context manager.

    Both are preconditioned by two levels, linear and quadratic elements of the same mesh.
    """

    def __init__(self, solid: Solid, memory: float | None = None) -> None:
        """Prepare for a body.

        Args:
            solid: Assembled body.
            memory: Memory in bytes that a rank may take to count modes; no limit if None.

        Raises:
            ModelError: if its elements are not quadratic, or it has constraints.
        """
        if solid.body.degree < 2:
            raise ModelError(
                f"degree = {solid.body.degree}: the iterative solver needs quadratic elements: "
                "must be 2, or the direct solver",
                code=Code.DEGREE,
            )
        if solid.system.keys:
            raise ModelError(
                f"{solid.system.keys[0]}: constraints cannot be followed by the iterative solver: "
                "must be the direct solver",
                code=Code.CONSTRAINED,
            )
        super().__init__(solid.tagged.mesh.comm)
        self._solid, self._memory = solid, memory
        self.free = solid.free
        self._pencil, self._preconditioner = Pencil(solid), TwoLevel(solid)

    @property
    def negative(self) -> int:
        """Number of negative eigenvalues of the stiffness: none, as iterations need."""
        return 0

    def release(self) -> None:
        """Free the preconditioner."""
        self._preconditioner.destroy()

    def modes(self, count: int) -> LinearModes:
        """The `count` lowest modes; whether one was missed is found out where memory allows.

        Raises:
            ModelError: if the body can move as a rigid body, or is too small.
            ConvergenceError: if the iteration fails or a mode was missed.
        """
        block = count + max(_SPARE, count // 5)
        if 3 * block > self.free:
            raise ModelError(
                f"modes = {count}: the iterative solver needs {3 * block} free dofs, "
                f"the mesh has {self.free}: must be fewer, or the direct solver",
                code=Code.MODES_OF_ITERATION,
            )
        squared, shapes = lowest_modes(
            self._pencil, self._preconditioner, self._start(block), count + 1, tolerance=_MODES
        )
        assert_held(self._solid, squared)
        below = counted_below(self._solid, squared, count, self._memory)
        return LinearModes(
            omega=np.sqrt(squared[:count]), shapes=shapes[:, :count], checked_below=below
        )

    def static(self, forces: Array) -> Array:
        """Static displacements in m under columns of forces in N, shape (n_owned, k).

        Raises:
            ConvergenceError: if the iteration fails.
        """
        return static_displacements(self._pencil, self._preconditioner, forces, tolerance=_STATIC)

    def fixed_interface_modes(self, forces: Array, attachments: Array, count: int) -> Array:
        """Refused: modes with the interface held need factors.

        Raises:
            ModelError: always.
        """
        raise ModelError(
            "the iterative solver finds no modes with the contact points held: must be "
            "the direct solver",
            code=Code.HELD_MODES,
        )

    def _start(self, block: int) -> Array:
        """First vectors of unit mass, shape (n_owned, block)."""
        modes = self._preconditioner.modes(block - _RANDOM)
        random = self._preconditioner.random(block - modes.shape[1])
        whole = np.asfortranarray(np.hstack([modes, random]))
        return np.asarray(whole / np.sqrt(self._pencil.products(whole, self._pencil.mass(whole))))
