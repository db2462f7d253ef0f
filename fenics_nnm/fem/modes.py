"""Linear modes and attachment solutions from one factorisation of the stiffness."""

from __future__ import annotations

from contextlib import suppress

import numpy as np
from petsc4py import PETSc

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.errors import Code, ConvergenceError, ModelError, OutOfMemoryError
from fenics_nnm.fem.block import solved
from fenics_nnm.fem.eigenproblem import ask_for, eigenproblem
from fenics_nnm.fem.factorisation import factorise, limited_memory, use_mumps
from fenics_nnm.fem.inertia import assert_held, counted_below
from fenics_nnm.fem.interface_modes import fixed_interface_modes
from fenics_nnm.fem.parallel import HeldTogether
from fenics_nnm.fem.parts import parts_that_move
from fenics_nnm.fem.solid import Solid
from fenics_nnm.reduction.linear_modes import LinearModes

#: Modes solved for beyond those asked for, so that the next frequency is known.
_SPARE = 4


class DirectModalSolver(HeldTogether):
    """Factorises the stiffness once; a context manager that frees it.

    PETSc options of the eigensolver take the prefix `nnm_`.

    Attributes:
        free: Number of free degrees of freedom, of all ranks.
    """

    def __init__(self, solid: Solid, memory: float | None = None) -> None:
        """Factorise the stiffness of a body.

        Args:
            solid: Assembled body.
            memory: Memory in bytes that a rank may take for factors; no limit if None.

        Raises:
            ModelError: if it cannot be factorised.
            OutOfMemoryError: if the memory is not enough.
        """
        self._solid, self._memory = solid, memory
        self.free = solid.free
        super().__init__(solid.tagged.mesh.comm)
        self._system = solid.system
        self._eps = eigenproblem(self._system.stiffness, self._system.mass, "nnm_")
        self._ksp = self._eps.getST().getKSP()
        self._ksp.setOperators(self._system.stiffness)  # which shift-invert about zero keeps
        use_mumps(self._ksp)
        self._factorise()

    def release(self) -> None:
        """Free the factorisation, or what an eigensolver that failed lets free."""
        with suppress(PETSc.Error):
            self._eps.destroy()

    def modes(self, count: int) -> LinearModes:
        """The `count` lowest modes, with a check that none was missed.

        Raises:
            ModelError: if the body can move as a rigid body, or has too few degrees of freedom.
            ConvergenceError: if the eigensolver fails or a mode was missed.
        """
        if count > self.free:
            raise ModelError(
                f"modes = {count}: the mesh has only {self.free} free dofs", code=Code.MODES
            )
        wanted = min(count + _SPARE, self.free)
        ask_for(self._eps, wanted)
        self._eps.setFromOptions()
        try:
            self._eps.solve()
        except PETSc.Error as error:
            raise ConvergenceError(
                f"eigensolver: PETSc error {error.ierr}: stiffness and mass may be too far apart "
                "to compute with: check lengths, units and material"
            ) from error
        found = self._eps.getConverged()
        if found < min(count + 1, self.free):
            raise ConvergenceError(f"eigensolver: {found} of {count} modes converged")
        squared = np.array([self._eps.getEigenvalue(i).real for i in range(found)])
        order = np.argsort(squared)
        squared = squared[order]
        assert_held(self._solid, squared)
        below = counted_below(self._solid, squared, count, self._memory)
        return LinearModes(
            omega=np.sqrt(squared[:count]), shapes=self._shapes(order[:count]), checked_below=below
        )

    def static(self, forces: Array) -> Array:
        """Static displacements under columns of forces, solved as one block.

        Args:
            forces: Forces in N at the owned degrees of freedom, shape (n_owned, k).

        Returns:
            Displacements in m, shape (n_owned, k).
        """
        return self._system.whole(solved(self._ksp, self._system.forces(forces)))

    def fixed_interface_modes(self, forces: Array, attachments: Array, count: int) -> Array:
        """The lowest modes with the contact interface held, from the same factorisation.

        Args:
            forces: Unit forces of the interface, shape (n_owned, i).
            attachments: Displacements under them, shape (n_owned, i).
            count: Number of modes.

        Returns:
            Mass-normalised shapes, shape (n_owned, count).

        Raises:
            ConvergenceError: if the eigensolver fails.
        """
        return fixed_interface_modes(self._solid, self._ksp, forces, attachments, count)

    def _factorise(self) -> None:
        try:
            with limited_memory(self._ksp, self._memory):
                factorise(self._ksp)
        except ConvergenceError as error:
            self._eps.destroy()
            if isinstance(error, OutOfMemoryError):
                raise
            raise ModelError(
                "the stiffness cannot be factorised: rigid-body modes (is the body clamped?): "
                f"{error}{parts_that_move(self._solid)}"
            ) from error

    def _shapes(self, order: Indices) -> Array:
        shapes = np.empty((self._solid.owned, len(order)))
        vector = self._system.stiffness.createVecRight()
        product = vector.duplicate()
        for column, index in enumerate(order):
            self._eps.getEigenvector(int(index), vector)
            self._system.mass.mult(vector, product)
            shapes[:, column] = vector.array / np.sqrt(vector.dot(product))
        vector.destroy()
        product.destroy()
        return self._system.whole(shapes)
