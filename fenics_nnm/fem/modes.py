"""Linear modes and attachment solutions from one factorisation of the stiffness."""

from __future__ import annotations

from contextlib import suppress

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.errors import (
    Code,
    ConvergenceError,
    MissedModesError,
    ModelError,
    OutOfMemoryError,
)
from fenics_nnm.fem.block import product
from fenics_nnm.fem.block_lanczos import BlockLanczos
from fenics_nnm.fem.factored import Factored, Factors
from fenics_nnm.fem.factorisation import ROOT_ALONE, mumps_asked_for
from fenics_nnm.fem.inertia import assert_held, counted_below
from fenics_nnm.fem.interface_modes import fixed_interface_modes
from fenics_nnm.fem.ordered import Ordered, pays
from fenics_nnm.fem.parallel import HeldTogether
from fenics_nnm.fem.parts import parts_that_move
from fenics_nnm.fem.solid import Solid
from fenics_nnm.fem.substructures import Substructures
from fenics_nnm.reduction.linear_modes import LinearModes

#: Modes solved for beyond those asked for, so that the next frequency is known.
_SPARE = 4

#: Rigid-body modes of one part: so many more Ritz values show how low they are beside others.
_RIGID = 6

#: Strain energy over that of each displacement alone, of motions that strain a body.
_STRAINED = 1e-12

#: Prefix of PETSc options of the factorisation.
_PREFIX = "nnm_st_"

#: How often modes that the count finds missing are looked for.
_SEARCHES = 5


class DirectModalSolver(HeldTogether):
    """Factorises the stiffness once; a context manager that frees it.

    PETSc options of the factorisation take the prefix `nnm_st_`.

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
        self._inverse: Factors = self._by_cholmod() or self._by_mumps()

    @property
    def negative(self) -> int:
        """Number of negative eigenvalues of the stiffness of a body under loads; on all ranks."""
        return self._inverse.negative

    def release(self) -> None:
        """Free the factorisation."""
        self._inverse.release()

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
        inverse = self.factored()
        lanczos = BlockLanczos(inverse, inverse.rows, self.free, count, _SPARE)
        lanczos.run()
        squared, shapes = self._found(lanczos, count)
        for _ in range(_SEARCHES):
            with suppress(MissedModesError):
                return self._counted(squared, shapes, count)
            lanczos.search_again(shapes)
            squared, shapes = self._found(lanczos, count)
        return self._counted(squared, shapes, count)

    def static(self, forces: Array) -> Array:
        """Static displacements under columns of forces, solved as one block.

        Args:
            forces: Forces in N at the owned degrees of freedom, shape (n_owned, k).

        Returns:
            Displacements in m, shape (n_owned, k).
        """
        return self._system.whole(self._inverse.solve(self._system.forces(forces)))

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
        return fixed_interface_modes(self.factored(), self.free, forces, attachments, count)

    def factored(self) -> Factored:
        """K^-1 and M."""
        return Factored.of(self._inverse, self._system, self._solid.tagged.mesh.comm)

    def _by_cholmod(self) -> Factors | None:
        """Factors in the order of nested dissection; none where others suit better, or are needed.

        CHOLMOD fails where the stiffness is not positive definite: MUMPS then counts how often.
        """
        if self._system.keys or mumps_asked_for(_PREFIX):
            return None
        if not pays(self._solid, self._memory):
            return Substructures.of(self._solid, self._memory)
        inverse = Ordered.of(self._solid, self._memory, _PREFIX)
        try:
            inverse.factorise(self._memory)
        except ConvergenceError:
            inverse.release()
            return None
        return inverse

    def _by_mumps(self) -> Ordered:
        """Factors by MUMPS.

        Raises:
            ModelError: if the stiffness cannot be factorised.
            OutOfMemoryError: if the memory is not enough.
        """
        settings = () if self._solid.state is None else (ROOT_ALONE,)
        inverse = Ordered.by_mumps(self._system.stiffness, _PREFIX, settings)
        try:
            inverse.factorise(self._memory)
        except ConvergenceError as error:
            inverse.release()
            if isinstance(error, OutOfMemoryError):
                raise
            raise ModelError(
                "the stiffness cannot be factorised: rigid-body modes (is the body clamped?): "
                f"{error}{parts_that_move(self._solid)}"
            ) from error
        return inverse

    def _found(self, lanczos: BlockLanczos, count: int) -> tuple[Array, Array]:
        """Squared frequencies and shapes of the modes wanted and of those beyond, by theta.

        The count needs the memory of the basis, which is given up for the shapes.

        Raises:
            ModelError: if the body can move as a rigid body.
        """
        squared = _squared(lanczos.theta[: count + _SPARE + _RIGID])
        if len(squared) < min(count + _SPARE, self.free):
            squared = self._with_lost(squared, self._inverse.restored(lanczos.shapes(len(squared))))
        assert_held(self._solid, squared)
        squared = squared[: count + _SPARE]
        return squared, lanczos.settled(len(squared))

    def _counted(self, squared: Array, shapes: Array, count: int) -> LinearModes:
        """Modes that were counted, of squared frequencies and their shapes.

        Raises:
            MissedModesError: if one was missed.
        """
        order = np.argsort(squared)
        squared = squared[order]
        below = counted_below(self._solid, squared, count, self._memory)
        shapes = self._inverse.restored(shapes[:, order[:count]])
        return LinearModes(np.sqrt(squared[:count]), self._system.whole(shapes), below)

    def _with_lost(self, squared: Array, shapes: Array) -> Array:
        """Squared frequencies of rigid-body modes with one of those lost in their round-off.

        Raises:
            ConvergenceError: if they strain the body, so that others are lost in heavy masses.
        """
        system, inner = self._system, self.factored().inner
        forces = product(system.stiffness, shapes)
        diagonal = system.stiffness.getDiagonal().array_r[:, None]
        strain = np.diagonal(inner(shapes, forces)) / np.diagonal(inner(shapes, diagonal * shapes))
        if np.abs(strain).max() > _STRAINED:
            raise ConvergenceError(
                "eigensolver: higher modes are lost in the round-off of the lowest ones: stiffness "
                "and mass may be too far apart to compute with: check lengths, units and material"
            )
        return np.append(squared, np.inf)


def _squared(theta: Array) -> Array:
    """Squared circular frequencies 1 / theta in rad^2/s^2, infinite at zero."""
    return np.divide(1.0, theta, out=np.full(len(theta), np.inf), where=theta != 0)
