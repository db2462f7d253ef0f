"""Linear modes and attachment solutions from one factorisation of the stiffness."""

from __future__ import annotations

import logging
from types import TracebackType

import numpy as np
from petsc4py import PETSc

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.errors import ConvergenceError, ModelError
from fenics_nnm.fem.block import solved
from fenics_nnm.fem.eigenproblem import eigenproblem
from fenics_nnm.fem.factorisation import factorise, use_mumps
from fenics_nnm.fem.interface_modes import fixed_interface_modes
from fenics_nnm.fem.parallel import all_arrive
from fenics_nnm.fem.solid import Solid
from fenics_nnm.reduction.linear_modes import LinearModes, counting_shift

logger = logging.getLogger(__name__)

#: A squared frequency below this part of the highest one computed is a rigid-body mode.
_RIGID = 1e-9

#: Modes solved for beyond those asked for, so that the next frequency is known.
_SPARE = 4


class ModalSolver:
    """Factorises the stiffness once; a context manager that frees it.

    PETSc options of the eigensolver take the prefix `nnm_`, those of the inertia check
    `nnm_inertia_`.

    Attributes:
        free: Number of free degrees of freedom, of all ranks.
    """

    def __init__(self, solid: Solid) -> None:
        """Set up the eigenproblem K phi = omega^2 M phi of a body."""
        self._solid = solid
        clamped = int(np.count_nonzero(solid.clamped < solid.owned))
        self.free = solid.dofs - int(solid.mass.comm.tompi4py().allreduce(clamped))
        self._apart = solid.tagged.mesh.comm.Dup()
        self._eps = eigenproblem(solid, "nnm_")
        self._ksp = self._eps.getST().getKSP()
        self._ksp.setOperators(solid.stiffness)  # which shift-invert about zero keeps
        use_mumps(self._ksp)

    def __enter__(self) -> ModalSolver:
        """Enter the context."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Free the factorisation, if all ranks are there to do so."""
        if error is None or all_arrive(self._apart):
            self._eps.destroy()
            self._apart.Free()

    def modes(self, count: int) -> LinearModes:
        """The `count` lowest modes, with a check that none was missed.

        Raises:
            ModelError: if the body can move as a rigid body, or has too few degrees of freedom.
            ConvergenceError: if the eigensolver fails or a mode was missed.
        """
        if count > self.free:
            raise ModelError(f"reduction.modes = {count}: the mesh has only {self.free} free dofs")
        self._eps.setDimensions(min(count + _SPARE, self.free))
        self._factorise()
        try:
            self._eps.solve()
        except PETSc.Error as error:
            raise ConvergenceError(f"eigensolver: PETSc error {error.ierr}") from error
        found = self._eps.getConverged()
        if found < min(count + 1, self.free):
            raise ConvergenceError(f"eigensolver: {found} of {count} modes converged")
        squared = np.array([self._eps.getEigenvalue(i).real for i in range(found)])
        order = np.argsort(squared)
        self._check_rigid(squared[order])
        squared = squared[order]
        below = self._check_inertia(squared, count)
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
        self._factorise()
        return solved(self._ksp, forces)

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
            factorise(self._ksp)
        except ConvergenceError as error:
            raise ModelError(
                "the stiffness cannot be factorised: rigid-body modes (is the body clamped?), "
                f"or no memory ({error})"
            ) from error

    def _check_rigid(self, squared: Array) -> None:
        rigid = int(np.count_nonzero(squared <= _RIGID * np.abs(squared).max()))
        if rigid:
            raise ModelError(
                f"{rigid} rigid-body modes found: the body is not held; "
                "name facets that hold it in clamp.facets, or springs that are stiff enough"
            )

    def _check_inertia(self, squared: Array, count: int) -> float:
        """Count the eigenvalues below the first gap after `count` modes by Sylvester's law."""
        shift, inside = counting_shift(squared, count)
        if inside == 0:
            return 0.0
        negative = _negative_pivots(self._solid, shift)
        if negative != inside:
            raise ConvergenceError(
                f"eigensolver: {inside} modes below {np.sqrt(shift) / 2 / np.pi:.6g} Hz, but the "
                f"inertia of K - s^2 M counts {negative}: a mode was missed"
            )
        return float(np.sqrt(shift))

    def _shapes(self, order: Indices) -> Array:
        shapes = np.empty((self._solid.owned, len(order)))
        vector = self._solid.stiffness.createVecRight()
        product = vector.duplicate()
        for column, index in enumerate(order):
            self._eps.getEigenvector(int(index), vector)
            self._solid.mass.mult(vector, product)
            shapes[:, column] = vector.array / np.sqrt(vector.dot(product))
        vector.destroy()
        product.destroy()
        return shapes


def _negative_pivots(solid: Solid, shift: float) -> int:
    """Number of eigenvalues of (K, M) below `shift`, from a factorisation of K - shift M."""
    shifted = solid.stiffness.copy()
    shifted.axpy(-shift, solid.mass, PETSc.Mat.Structure.SAME_NONZERO_PATTERN)
    shifted.setOption(PETSc.Mat.Option.SYMMETRIC, True)
    ksp = PETSc.KSP().create(shifted.comm)
    ksp.setOptionsPrefix("nnm_inertia_")
    ksp.setOperators(shifted)
    use_mumps(ksp)
    factorise(ksp)
    negative = ksp.getPC().getFactorMatrix().getMumpsInfog(12)
    ksp.destroy()
    shifted.destroy()
    return int(negative)
