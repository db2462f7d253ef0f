"""Modes and attachment solutions of matrices, from one factorisation of the stiffness."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import ArpackError, LinearOperator, eigsh, splu

from fenics_nnm.arrays import Array
from fenics_nnm.errors import Code, ConvergenceError, ModelError
from fenics_nnm.reduction.gyroscopic import coriolis_frequencies
from fenics_nnm.reduction.linear_modes import LinearModes, counted, counting_shift
from fenics_nnm.reduction.matrices import Matrices
from fenics_nnm.reduction.operators import Operators

#: Up to this many unknowns with mass all modes are found by a dense method.
_DENSE = 600

#: Modes solved for beyond those asked for, so that the next frequency is known.
_SPARE = 4

#: A pivot, or the strain energy of a mode, below this part of its terms is round-off.
_ROUND_OFF = 1e-14

#: 1 / omega^2 below this part of the largest one is zero: a motion without mass.
_MASSLESS = 1e-14

#: Eigenvalues of the mass below minus this, scaled to a unit diagonal, are negative.
_NEGATIVE_MASS = 1e-10

#: Factors with at most so many entries are cheap to count pivots in: about 10 s.
_CHEAP = 30_000_000

Solve = Callable[[Array], Array]


class MatrixSolver:
    """Factorises the stiffness of a structure once."""

    def __init__(self, matrices: Matrices) -> None:
        """Factorise K.

        Raises:
            ModelError: if K is singular or not positive definite, or M has a negative eigenvalue.
        """
        self._matrices = matrices
        self._factor = _factor_of_stiffness(matrices.K)
        _check_mass(matrices.M)

    def modes(self, count: int) -> LinearModes:
        """The `count` lowest modes, with a check that none was missed where that is cheap.

        Raises:
            ModelError: if the structure can move as a rigid body, or has fewer modes.
            ConvergenceError: if the eigensolver fails or a mode was missed.
        """
        matrices = self._matrices
        if not 1 <= count <= matrices.massive:
            raise ModelError(
                f"modes = {count}: must be at least 1 and not above {matrices.massive}, the number "
                "of unknowns with mass",
                code=Code.MODES,
            )
        squared, shapes, complete = self._modes_of(self._factor.solve, count + _SPARE)
        _check_found(len(squared), count, "free")
        _check_rigid(matrices.K, shapes[:, :count])
        below = self._checked_below(squared, count, complete=complete)
        return LinearModes(np.sqrt(squared[:count]), shapes[:, :count], below)

    def attachments(self) -> Array:
        """Static displacements under unit contact forces, K^-1 B^T, shape (n, n_c).

        Raises:
            ModelError: if the contact rows depend on each other.
        """
        attachments = self._factor.solve(self._matrices.forces)
        S = self._matrices.contact_displacement(attachments)
        scale = np.sqrt(np.diag(S))
        if np.linalg.eigvalsh(S / np.outer(scale, scale))[0] < len(S) * np.finfo(float).eps:
            raise ModelError("contact rows B depend on each other: leave some of them out")
        return np.asarray(attachments)

    def operators(self) -> Operators:
        """Products with the matrices."""
        matrices = self._matrices
        return Operators(
            stiffness=lambda columns: np.asarray(matrices.K @ columns),
            mass=lambda columns: np.asarray(matrices.M @ columns),
            static=self._factor.solve,
            contact=matrices.contact_displacement,
            inner=lambda left, right: np.asarray(left.T @ right),
        )

    def coriolis(self, modes: LinearModes) -> Array:
        """Circular frequencies with Coriolis forces in rad/s, shape (J,); empty without any.

        Raises:
            ModelError: if their static displacements move no mass.
        """
        G = self._matrices.G
        if not G.nnz:
            return np.empty(0)
        return coriolis_frequencies(modes, lambda shapes: np.asarray(G @ shapes), self.operators())

    def held_modes(self, attachments: Array, count: int) -> Array:
        """The lowest modes with the contact points held, B u = 0, shape (n, count).

        With F = B^T and X = K^-1 F, the displacement under b that keeps F^T y = 0 is

            y = K^-1 b - X (F^T X)^-1 F^T K^-1 b,

        so the factorisation of K serves here too.

        Args:
            attachments: X, shape (n, n_c).
            count: Number of modes.

        Raises:
            ModelError: if there are fewer.
            ConvergenceError: if the eigensolver fails.
        """
        B = self._matrices.B
        stiffness = np.linalg.inv(self._matrices.contact_displacement(attachments))

        def held(right: Array) -> Array:
            moved = self._factor.solve(right)
            return np.asarray(moved - attachments @ (stiffness @ (B @ moved)))

        _, shapes, _ = self._modes_of(held, count)
        _check_found(shapes.shape[1], count, "held")
        return np.asarray(shapes[:, :count])

    def _modes_of(self, solve: Solve, count: int) -> tuple[Array, Array, bool]:
        """Squared frequencies, ascending, mass-normalised shapes, and whether these are all.

        Args:
            solve: Displacements under columns of forces.
            count: Number of modes; more or fewer are found if these are all.
        """
        M = self._matrices.M
        if self._matrices.massive <= max(_DENSE, 2 * count):
            return *_all_modes(solve, M), True
        inverse = LinearOperator(M.shape, matvec=solve, dtype=np.float64)
        start = np.random.default_rng(0).normal(size=self._matrices.size)
        try:
            squared, shapes = eigsh(self._matrices.K, count, M, sigma=0.0, OPinv=inverse, v0=start)
        except ArpackError as error:
            raise ConvergenceError(f"eigensolver: {count} modes not found: {error}") from error
        with np.errstate(divide="ignore"):
            return *_normalised(1 / squared, shapes, M), False

    def _checked_below(self, squared: Array, count: int, *, complete: bool) -> float:
        """Circular frequency below which the modes were counted in another way, or 0."""
        shift, inside = counting_shift(squared, count)
        if inside == 0 or complete:
            return float(np.sqrt(shift if inside else squared[-1]))
        if self._factor.nnz > _CHEAP:
            return 0.0
        negative = _negative_pivots(self._matrices.K - shift * self._matrices.M)
        if negative is None:
            return 0.0
        return counted(shift, inside, negative)


def _all_modes(solve: Solve, M: Any) -> tuple[Array, Array]:
    """All squared frequencies, ascending, and mass-normalised shapes, condensed to the masses.

    With M = C C^T and the flexibility G = K^-1 the pencil becomes C^T G C z = z / omega^2, and the
    shape of z is omega^2 G C z.
    """
    massive = np.flatnonzero(M.diagonal())
    scale = np.sqrt(M.diagonal()[massive])
    part = M[massive][:, massive].toarray() / np.outer(scale, scale)
    values, vectors = np.linalg.eigh(part)
    C = np.zeros((M.shape[0], len(massive)))
    C[massive] = scale[:, None] * vectors * np.sqrt(np.maximum(values, 0))
    moved = solve(C)
    inverse, combined = np.linalg.eigh(C.T @ moved)
    return _normalised(inverse, moved @ combined, M)


def _normalised(inverse: Array, shapes: Array, M: Any) -> tuple[Array, Array]:
    """Squared frequencies of the motions with mass, ascending, and shapes of unit modal mass."""
    order = np.argsort(-inverse)
    order = order[inverse[order] > _MASSLESS * np.abs(inverse).max()]
    shapes = shapes[:, order]
    return 1 / inverse[order], shapes / np.sqrt(np.einsum("ij,ij->j", shapes, M @ shapes))


def _factor_of_stiffness(K: Any) -> Any:
    try:
        factor = _symmetric_factor(K)
    except RuntimeError as error:
        raise ModelError(_not_held("is singular")) from error
    if factor.nnz <= _CHEAP:
        if not np.array_equal(factor.perm_r, factor.perm_c):
            raise ModelError("stiffness K is not positive definite")
        pivots = factor.U.diagonal()[factor.perm_c] / K.diagonal()
        if np.abs(pivots).min() < _ROUND_OFF:
            raise ModelError(_not_held("is singular"))
        if pivots.min() < 0:
            raise ModelError("stiffness K is not positive definite: a pivot is negative")
    return factor


def _symmetric_factor(matrix: Any) -> Any:
    """LU factors with pivots on the diagonal: those of L D L^T, as long as none of them is 0."""
    return splu(
        matrix,
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )


def _negative_pivots(matrix: Any) -> int | None:
    """Number of negative eigenvalues of a symmetric matrix; None if the factors do not tell."""
    try:
        factor = _symmetric_factor(matrix.tocsc())
    except RuntimeError:
        return None
    right = np.ones(matrix.shape[0])
    left = matrix @ factor.solve(right)
    if not np.array_equal(factor.perm_r, factor.perm_c) or np.abs(left - right).max() > 1e-6:
        return None
    return int(np.count_nonzero(factor.U.diagonal() < 0))


def _check_mass(M: Any) -> None:
    """Look for a negative eigenvalue; a Rayleigh quotient is never below the lowest one."""
    massive = np.flatnonzero(M.diagonal())
    scale = sparse.diags(1 / np.sqrt(M.diagonal()[massive]))
    scaled = scale @ M[massive][:, massive] @ scale
    if len(massive) <= _DENSE:
        lowest = float(np.linalg.eigvalsh(scaled.toarray())[0])
    else:
        start = np.random.default_rng(0).normal(size=len(massive))
        try:
            lowest = float(eigsh(scaled, 1, which="SA", v0=start, tol=1e-3, maxiter=100)[0][0])
        except ArpackError:  # not converged: there is no sign of one
            return
    if lowest < -_NEGATIVE_MASS:
        raise ModelError(
            "mass M has a negative eigenvalue: must be positive semidefinite, so that every "
            "motion has a kinetic energy"
        )


def _check_found(found: int, count: int, kind: str) -> None:
    if found < count:
        held = " with the contact points held" if kind == "held" else ""
        raise ModelError(
            f"modes = {count}: the matrices have only {max(found, 0)} modes{held}",
            code=Code.MODES,
        )


def _check_rigid(K: Any, shapes: Array) -> None:
    """Modes whose strain energy is nothing but round-off."""
    energy = np.einsum("ij,ij->j", shapes, K @ shapes)
    terms = np.einsum("ij,ij->j", np.abs(shapes), abs(K) @ np.abs(shapes))
    rigid = int(np.count_nonzero(energy < _ROUND_OFF * terms))
    if rigid:
        raise ModelError(_not_held(f"has {rigid} rigid-body modes"))


def _not_held(what: str) -> str:
    return (
        f"stiffness K {what}: the structure is not held; give the matrices without the clamped "
        "unknowns"
    )
