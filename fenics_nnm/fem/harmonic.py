"""Full order: the finite-element model at the frequencies of the harmonics."""

from __future__ import annotations

import numpy as np
from petsc4py import PETSc

from fenics_nnm.arrays import Array
from fenics_nnm.errors import ConvergenceError, OutOfMemoryError
from fenics_nnm.fem.block import product, solved
from fenics_nnm.fem.blocks import Blocks
from fenics_nnm.fem.factorisation import factorise, use_mumps
from fenics_nnm.fem.gathering import gathering
from fenics_nnm.fem.linear import LinearAnalysis
from fenics_nnm.fem.parallel import HeldTogether
from fenics_nnm.mechanics.fourier import Series
from fenics_nnm.mechanics.motion import Motion
from fenics_nnm.reduction.flexibility import ACCURACY, ResidualFlexibility

#: Where K - s M is singular in round-off, s is moved by this part of it.
_ASIDE = 1e-8


def inertial_blocks(analysis: LinearAnalysis, series: Series, motion: Motion) -> Blocks:
    """Harmonics in m of what inertia adds to the static residual shapes, (N + 1, nodes, dim).

    Args:
        analysis: Massless-boundary analysis.
        series: Series in time of the motion.
        motion: Motion in SI units.
    """
    with HarmonicSolver(analysis, harmonics=series.harmonics) as solver:
        omega, ell = 2 * np.pi * motion.frequency, series.analysis @ motion.force
        added = -solver.inertial_displacement(omega, series.order, ell)
    return gathering(analysis.solid).blocks(added.T)


class HarmonicSolver(HeldTogether):
    """Residual flexibility D of the harmonics about a frequency; a context manager.

    One matrix Z = K - s M and one symbolic factorisation serve all harmonics, one after the
    other. A harmonic is factorised again only where its parabola about an earlier s is not
    accurate any more. The J modes that stay explicit are projected out of right-hand sides and
    solutions, so s may come near one of their frequencies.

    PETSc options take the prefix `nnm_harmonic_`.

    Attributes:
        factorisations: Number of numeric factorisations so far.
    """

    def __init__(self, analysis: LinearAnalysis, *, harmonics: int) -> None:
        """Prepare for a massless-boundary analysis, whose modes stay explicit, and N harmonics."""
        solid = analysis.solid
        self._analysis = analysis
        self._comm = solid.tagged.mesh.comm
        super().__init__(self._comm)
        self._mass_shapes = product(solid.mass, analysis.reduction.shapes)
        self._forces = (
            analysis.interface.unit_forces(solid.owned) - self._mass_shapes @ analysis.model.Phi.T
        )
        self._mass_static = product(solid.mass, analysis.reduction.residual_shapes)
        self._allowed = ACCURACY * float(analysis.model.static_flexibility.max())
        truncation = analysis.reduction.truncation
        if truncation is None:
            raise TypeError("full order has no shapes besides modes and attachment solutions")
        self._known = truncation.residual_flexibility(harmonics)
        self._system = solid.system
        self._matrix = self._system.stiffness.copy()
        self._ksp = PETSc.KSP().create(solid.stiffness.comm)
        self._ksp.setOptionsPrefix("nnm_harmonic_")
        use_mumps(self._ksp)
        self.factorisations = 0

    def release(self) -> None:
        """Free the factorisation."""
        self._ksp.destroy()
        self._matrix.destroy()

    def __call__(self, omega: float) -> ResidualFlexibility:
        """D of all harmonics, accurate about omega in rad/s; called on all ranks alike.

        Raises:
            ConvergenceError: if a factorisation fails.
        """
        for n in np.flatnonzero(self._known.error(omega) > self._allowed):
            self._known = self._known.renewed(int(n), *self._parabola((n * omega) ** 2))
        return self._known

    def inertial_displacement(self, omega: float, order: Array, ell: Array) -> Array:
        """What inertia adds to the static residual shapes: (X_n - X_0) ell_n.

        Args:
            omega: Circular frequency in rad/s.
            order: Harmonic number n of each row, shape (r,).
            ell: Harmonics of the contact forces in N, shape (r, n_c).

        Returns:
            Displacements in m, shape (r, n_owned).
        """
        added = np.zeros((len(ell), len(self._mass_static)))
        for n in np.unique(order[order > 0]):
            rows = order == n
            s = self._factorise((n * omega) ** 2)
            inertia = s * (self._mass_static @ ell[rows].T)
            added[rows] = self._deflated(self._solved(inertia)).T
        return added

    def _parabola(self, s: float) -> tuple[float, Array, Array, Array]:
        """Centre, D, D' and D'' / 2 at s, or just beside it."""
        s = self._factorise(s)
        X = self._deflated(self._solved(self._forces))
        mass_X = product(self._analysis.solid.mass, X)
        second = self._solved(mass_X)
        value = s * self._gram(self._mass_static, X)
        return s, value, self._gram(X, mass_X), self._gram(mass_X, second)

    def _gram(self, left: Array, right: Array) -> Array:
        whole = self._comm.allreduce(left.T @ right)
        return np.asarray((whole + whole.T) / 2)

    def _factorise(self, s: float) -> float:
        """Factorise at s, or beside it where a frequency of the mesh makes it singular; returns s.

        D has no pole at the frequencies of the explicit modes, so that it is smooth there.
        """
        try:
            self._factorise_at(s)
        except OutOfMemoryError:
            raise
        except ConvergenceError:
            s *= 1 + _ASIDE
            self._ksp.getPC().reset()  # MUMPS goes on from no factorisation that failed
            self._factorise_at(s)
        return s

    def _factorise_at(self, s: float) -> None:
        system = self._system
        system.stiffness.copy(self._matrix, PETSc.Mat.Structure.SAME_NONZERO_PATTERN)
        self._matrix.axpy(-s, system.mass, PETSc.Mat.Structure.SUBSET_NONZERO_PATTERN)
        self._matrix.setOption(PETSc.Mat.Option.SYMMETRIC, True)
        self._ksp.setOperators(self._matrix)
        try:
            factorise(self._ksp)
        except ConvergenceError as error:
            raise type(error)(
                f"K - s M cannot be factorised at {np.sqrt(s) / 2 / np.pi:.6g} Hz: {error}"
            ) from error
        self.factorisations += 1

    def _solved(self, forces: Array) -> Array:
        """Displacements under columns of forces, at the s factorised last."""
        return self._system.whole(solved(self._ksp, self._system.forces(forces)))

    def _deflated(self, X: Array) -> Array:
        """Without the explicit modes, which round-off brings in near their frequencies."""
        part = self._comm.allreduce(self._mass_shapes.T @ X)
        return np.asarray(X - self._analysis.reduction.shapes @ part)
