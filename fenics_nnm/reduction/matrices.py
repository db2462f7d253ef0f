"""A structure given by the matrices of another code."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import sparse

from fenics_nnm.arrays import Array
from fenics_nnm.errors import Code, ModelError

#: Relative asymmetry of a matrix that is taken as round-off.
_ASYMMETRY = 1e-8

#: Contact rows whose directions agree to this are the same.
_SAME_ROW = 1e-12


@dataclass(frozen=True, slots=True)
class Matrices:
    """Stiffness, mass and contact rows of a structure that is held, in SI units.

    Dense arrays and sparse matrices are taken alike and kept in sparse form.

    Attributes:
        K: Stiffness in N/m, symmetric positive definite, shape (n, n).
        M: Mass in kg, symmetric positive semidefinite, shape (n, n).
        B: Rows that give the displacement of each contact point towards its obstacle,
            shape (n_c, n).
        gap: Gaps in m, shape (n_c,); one number stands for all rows.
        G: Coriolis forces per unit rate in kg/s, but for their sign: M u'' + G u' + K u = 0; skew,
            shape (n, n). None, given, stands for zero.

    Raises:
        ModelError: if shapes disagree, values are not finite real numbers, K or M is not
            symmetric or has a diagonal that cannot be, G is not skew, two contact rows are
            multiples of each other, or a gap is not finite.
    """

    K: Any
    M: Any
    B: Any
    gap: Any
    G: Any = None

    def __post_init__(self) -> None:
        if self.G is None:
            object.__setattr__(self, "G", sparse.csc_matrix(self.K.shape))
        for field, name, form in (
            ("K", "stiffness K", sparse.csc_matrix),
            ("M", "mass M", sparse.csc_matrix),
            ("B", "contact rows B", sparse.csr_matrix),
            ("G", "gyroscopic G", sparse.csc_matrix),
        ):
            object.__setattr__(self, field, _checked(getattr(self, field), name, form))
        _check_square(self.K, "stiffness K", self.K.shape[0])
        _check_square(self.M, "mass M", self.size)
        _check_skew(self.G, self.size)
        _check_diagonals(self.K, self.M)
        _check_rows(self.B, self.size)
        object.__setattr__(self, "gap", _gaps(self.gap, self.points))

    @property
    def size(self) -> int:
        """Number of unknowns n."""
        return int(self.K.shape[0])

    @property
    def points(self) -> int:
        """Number of contact points n_c."""
        return int(self.B.shape[0])

    @property
    def massive(self) -> int:
        """Number of unknowns with mass: no more modes than that have a frequency."""
        return int(np.count_nonzero(self.M.diagonal()))

    @property
    def massive_points(self) -> int:
        """Number of contact points that move an unknown with mass."""
        massive = self.M.diagonal() > 0
        return int(np.count_nonzero(abs(self.B) @ massive))

    @property
    def forces(self) -> Array:
        """B^T, a unit force at each contact point, shape (n, n_c)."""
        return np.asarray(self.B.T.toarray())

    def contact_displacement(self, columns: Array) -> Array:
        """B u of displacements, shape (n, k), as (n_c, k)."""
        return np.asarray(self.B @ columns)


def _checked(matrix: Any, name: str, form: Any) -> Any:
    """A sparse matrix of finite real numbers."""
    if not sparse.issparse(matrix):
        matrix = np.asarray(matrix)
    if matrix.dtype.kind not in "biuf":
        raise ModelError(f"{name} has entries of type {matrix.dtype}: must be real numbers")
    if matrix.ndim > 2 or 0 in matrix.shape:
        raise ModelError(f"{name} has shape {matrix.shape}: must be a matrix with entries")
    matrix = form(matrix, dtype=np.float64, copy=True)
    matrix.sum_duplicates()
    matrix.eliminate_zeros()
    if not np.all(np.isfinite(matrix.data)):
        raise ModelError(f"{name} has entries that are not finite")
    return matrix


def _check_square(matrix: Any, name: str, size: int) -> None:
    if matrix.shape != (size, size):
        raise ModelError(f"{name} has shape {matrix.shape}: must be {(size, size)}")
    difference = abs(matrix - matrix.T).max()
    if difference > _ASYMMETRY * abs(matrix).max():
        raise ModelError(
            f"{name} is not symmetric: entries differ from their mirror images by up to "
            f"{difference:.3g}; a file of one triangle must be completed"
        )


def _check_skew(G: Any, size: int) -> None:
    if G.shape != (size, size):
        raise ModelError(f"gyroscopic G has shape {G.shape}: must be {(size, size)}")
    difference = abs(G + G.T).max()
    if difference > _ASYMMETRY * abs(G).max():
        raise ModelError(
            f"gyroscopic G is not skew: entries differ from minus their mirror images by up to "
            f"{difference:.3g}: must be G^T = -G; damping belongs to [damping]"
        )


def _check_diagonals(K: Any, M: Any) -> None:
    """What positive matrices need, and what is cheap to see."""
    diagonal = K.diagonal()
    if diagonal.min() <= 0:
        row = int(np.argmin(diagonal)) + 1
        raise ModelError(
            f"stiffness K has {diagonal.min():g} on the diagonal of row {row}: must be positive; "
            "leave clamped and unused unknowns out"
        )
    diagonal = M.diagonal()
    filled = np.diff(M.indptr) > 0
    wrong = np.flatnonzero((diagonal < 0) | (filled & (diagonal == 0)))
    if len(wrong):
        raise ModelError(
            f"mass M has {diagonal[wrong[0]]:g} on the diagonal of row {wrong[0] + 1}: must be "
            "positive, or the whole row zero for an unknown without mass"
        )
    if not filled.any():
        raise ModelError("mass M is zero: must have mass somewhere")


def _check_rows(B: Any, size: int) -> None:
    if B.shape[1] != size:
        raise ModelError(f"contact rows B have {B.shape[1]} columns: must be {size} as K has")
    length = np.sqrt(np.asarray(B.multiply(B).sum(axis=1)).ravel())
    if length.min() == 0:
        raise ModelError(f"contact row {int(np.argmin(length)) + 1} is zero: must move with u")
    unit = sparse.diags(1 / length) @ B
    cosines = abs((unit @ unit.T).toarray()) - np.eye(len(length))
    first, second = np.unravel_index(int(np.argmax(cosines)), cosines.shape)
    if cosines[first, second] > 1 - _SAME_ROW:
        raise ModelError(
            f"contact rows {first + 1} and {second + 1} are multiples of each other: each must be "
            "a contact point of its own"
        )


def _gaps(gap: Any, points: int) -> Array:
    gaps = np.array(gap, dtype=np.float64)
    if gaps.ndim == 0:
        gaps = np.full(points, float(gaps))
    if gaps.shape != (points,):
        raise ModelError(
            f"gap has {gaps.size} values: must be one number, or one for each of the {points} "
            "contact rows",
            code=Code.GAP,
        )
    if not np.all(np.isfinite(gaps)):
        wrong = gaps[~np.isfinite(gaps)][0]
        raise ModelError(f"gap = {wrong:g}: must be a length in m", code=Code.GAP)
    gaps.setflags(write=False)
    return gaps
