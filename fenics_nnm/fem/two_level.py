"""Preconditioner of the stiffness: smoothing, and the linear elements of the same mesh.

Two levels by polynomial degree: quadratic displacements are smoothed by Chebyshev iteration with
the diagonal (Adams, Brezina, Hu, Tuminaro, J. Comput. Phys. 188 (2003) 593), and corrected by the
factorised stiffness of the linear ones, which are a part of them; a sixth to an eighth of the
degrees of freedom in three dimensions.
"""

from __future__ import annotations

import numpy as np
from dolfinx import fem
from dolfinx.fem.petsc import interpolation_matrix
from petsc4py import PETSc

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.fem.block import product, solved
from fenics_nnm.fem.eigenproblem import ask_for, eigenproblem
from fenics_nnm.fem.factorisation import factorise, use_mumps
from fenics_nnm.fem.solid import Solid
from fenics_nnm.fem.vertices import at_vertices

#: Degree of the Chebyshev polynomial before and after the coarse correction.
_DEGREE = 2

#: The smoother damps the upper part of the spectrum of D^-1 K, from this part of its end; the end
#: is estimated from below, and taken larger by a tenth.
_FROM, _BEYOND = 0.1, 1.1

#: Columns and steps of the power iteration for that end.
_COLUMNS, _STEPS = 4, 15


class TwoLevel:
    """Symmetric positive definite T, near K^-1; blocks of columns at once.

    PETSc options of the coarse level take the prefix `nnm_coarse_`.
    """

    def __init__(self, solid: Solid) -> None:
        """Prepare for a body of quadratic elements, and factorise the linear ones."""
        self._stiffness, self._comm = solid.stiffness, solid.tagged.mesh.comm
        self._free = np.ones((solid.owned, 1))
        self._free[solid.clamped[solid.clamped < solid.owned]] = 0.0
        self._prolongation, held = _prolongation(solid)
        self._restriction = self._prolongation.copy().transpose()
        K, M = (matrix.PtAP(self._prolongation) for matrix in (solid.stiffness, solid.mass))
        for matrix, diagonal in ((K, 1.0), (M, 0.0)):
            matrix.zeroRowsColumns(held, diag=diagonal)
            matrix.setOption(PETSc.Mat.Option.SYMMETRIC, True)
        self._coarse = K, M
        self.coarse_free = K.size[0] - self._comm.allreduce(len(held))
        self._eps = eigenproblem(K, M, "nnm_coarse_")
        self._ksp = self._eps.getST().getKSP()
        self._ksp.setOperators(K)  # which shift-invert about zero keeps
        use_mumps(self._ksp)
        factorise(self._ksp)
        self._inverse_diagonal = 1 / solid.stiffness.getDiagonal().array[:, None]
        self._end = _BEYOND * self._largest()

    def destroy(self) -> None:
        """Free the coarse level."""
        self._eps.destroy()
        for matrix in (*self._coarse, self._prolongation, self._restriction):
            matrix.destroy()

    def __call__(self, residual: Array) -> Array:
        """T times columns of shape (n_owned, k)."""
        x = self._smoothed(residual)
        residual = residual - product(self._stiffness, x)
        correction = self._corrected(residual)
        x += correction
        residual -= product(self._stiffness, correction)
        return x + self._smoothed(residual)

    def modes(self, count: int) -> Array:
        """The lowest modes of the linear elements, prolongated, shape (n_owned, <= count)."""
        wanted = min(count, self.coarse_free)
        ask_for(self._eps, wanted)
        self._eps.solve()
        coarse, fine = self._coarse[0].createVecRight(), self._prolongation.createVecLeft()
        found = min(self._eps.getConverged(), count)
        modes = np.empty((len(self._free), found), order="F")
        for column in range(found):
            self._eps.getEigenvector(column, coarse)
            self._prolongation.mult(coarse, fine)
            modes[:, column] = fine.array_r
        return modes

    def random(self, count: int) -> Array:
        """Random displacements that keep the clamp, shape (n_owned, count)."""
        rng = np.random.default_rng(self._comm.rank)
        return np.asarray(rng.standard_normal((len(self._free), count)) * self._free)

    def _corrected(self, residual: Array) -> Array:
        coarse = solved(self._ksp, product(self._restriction, residual))
        return product(self._prolongation, coarse)

    def _smoothed(self, residual: Array) -> Array:
        """Chebyshev iteration from zero."""
        low, high = _FROM * self._end, self._end
        middle, half = (high + low) / 2, (high - low) / 2
        rho = half / middle
        step = residual * self._inverse_diagonal / middle
        x = step.copy(order="F")
        for _ in range(_DEGREE - 1):
            residual = residual - product(self._stiffness, step)
            following = 1 / (2 * middle / half - rho)
            step = following * (rho * step + (2 / half) * (residual * self._inverse_diagonal))
            x += step
            rho = following
        return x

    def _largest(self) -> float:
        """Largest eigenvalue of D^-1 K by power iteration and Rayleigh-Ritz, from below."""
        root = np.sqrt(self._inverse_diagonal)
        x = self.random(_COLUMNS)
        for _ in range(_STEPS):
            x = self._orthonormal(x)
            x = root * product(self._stiffness, root * x)
        x = self._orthonormal(x)
        ritz = self._comm.allreduce(x.T @ (root * product(self._stiffness, root * x)))
        return float(np.linalg.eigvalsh(ritz)[-1])

    def _orthonormal(self, x: Array) -> Array:
        factor = np.linalg.cholesky(self._comm.allreduce(x.T @ x))
        return np.asarray(np.linalg.solve(factor, x.T).T)


def _prolongation(solid: Solid) -> tuple[PETSc.Mat, Indices]:
    """Linear to quadratic displacements, and global numbers of clamped linear ones."""
    mesh, dim = solid.tagged.mesh, solid.tagged.dim
    linear = fem.functionspace(mesh, ("Lagrange", 1, (dim,)))
    matrix = interpolation_matrix(linear, solid.space)
    matrix.assemble()
    fine, coarse = (at_vertices(mesh, space.dofmap.list) for space in (solid.space, linear))
    held = np.isin(fine[:, None] * dim + np.arange(dim), solid.clamped)
    own = np.sort((coarse[:, None] * dim + np.arange(dim))[held])
    own = own[own < linear.dofmap.index_map.size_local * dim]
    start = linear.dofmap.index_map.local_range[0]
    rows = (start * dim + own).astype(np.int32)
    left, right = matrix.createVecLeft(), matrix.createVecRight()
    left.set(1.0)
    left.array[solid.clamped[solid.clamped < solid.owned]] = 0.0
    right.set(1.0)
    right.array[rows - start * dim] = 0.0
    matrix.diagonalScale(left, right)
    return matrix, rows
