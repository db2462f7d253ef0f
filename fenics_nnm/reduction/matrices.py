"""Reduced models from the matrices of another code."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from scipy import sparse
from scipy.io import loadmat, mmread
from scipy.sparse.linalg import eigsh, splu

from fenics_nnm.arrays import Array
from fenics_nnm.errors import ModelError
from fenics_nnm.reduction.massless import massless_model
from fenics_nnm.reduction.model import ReducedModel, towards_obstacle

#: Relative asymmetry of a matrix that is taken as round-off.
_ASYMMETRY = 1e-8


def massless_from_matrices(
    K: Any, M: Any, B: Any, gap: Array | list[float], *, modes: int
) -> ReducedModel:
    """Massless-boundary model of a structure given by its matrices.

    Args:
        K: Stiffness in N/m, symmetric positive definite, shape (n, n), dense or sparse.
        M: Mass in kg, symmetric positive semidefinite, shape (n, n), dense or sparse.
        B: Rows that give the displacement of each contact point towards its obstacle, (n_c, n).
        gap: Gaps in m, shape (n_c,).
        modes: Number of free modes J, below n.

    Raises:
        ModelError: if shapes disagree, a matrix is not symmetric, K is singular, or the points
            and modes leave no residual flexibility.
    """
    K, M, B = (sparse.csc_matrix(matrix, dtype=float) for matrix in (K, M, B))
    _check(K, M, B, modes)
    try:
        factor = splu(K)
        squared, shapes = eigsh(K, k=modes, M=M, sigma=0.0)
    except RuntimeError as error:
        raise ModelError(f"K is singular: the structure is not held ({error})") from error
    order = np.argsort(squared)
    squared, shapes = squared[order], shapes[:, order]
    if squared[0] <= 1e-10 * squared[-1]:
        raise ModelError("K has rigid-body modes: the structure is not held")
    attachments = factor.solve(B.T.toarray())
    Phi = B @ shapes
    Phi = Phi * towards_obstacle(Phi)
    return massless_model(np.sqrt(squared), Phi, B @ attachments, np.asarray(gap, float))


def read_matrix(path: Path, name: str | None = None) -> Any:
    """Read a matrix from a Matrix Market, NumPy or MATLAB file.

    Args:
        path: A .mtx, .npy, .npz or .mat file.
        name: Name of the matrix in a .npz or .mat file that holds several.

    Raises:
        ModelError: if the file cannot be read, or has no such matrix.
    """
    try:
        if path.suffix == ".mtx":
            return mmread(path)
        if path.suffix == ".npy":
            return np.load(path)
        if path.suffix in (".npz", ".mat"):
            return _named(path, name)
    except (OSError, ValueError, NotImplementedError) as error:
        raise ModelError(f"{path}: cannot be read as a matrix: {error}") from error
    raise ModelError(f"{path}: must be a .mtx, .npy, .npz or .mat file")


def _named(path: Path, name: str | None) -> Any:
    if path.suffix == ".mat":
        held = {key: value for key, value in loadmat(path).items() if not key.startswith("__")}
    else:
        with np.load(path) as file:
            if "format" in file and "indices" in file:
                return sparse.load_npz(path)
            held = {key: file[key] for key in file.files}
    if name is None and len(held) == 1:
        return next(iter(held.values()))
    if name not in held:
        raise ModelError(f'{path}: has no matrix "{name}"; it has {", ".join(sorted(held))}')
    return held[name]


def _check(K: Any, M: Any, B: Any, modes: int) -> None:
    size = K.shape[0]
    for name, matrix in (("K", K), ("M", M)):
        if matrix.shape != (size, size):
            raise ModelError(f"{name} has shape {matrix.shape}: must be {(size, size)}")
        if not np.all(np.isfinite(matrix.data)):
            raise ModelError(f"{name} has entries that are not finite")
        if abs(matrix - matrix.T).max() > _ASYMMETRY * abs(matrix).max():
            raise ModelError(f"{name} is not symmetric")
    if B.shape[1] != size:
        raise ModelError(f"contact rows have {B.shape[1]} columns: must be {size} as K has")
    if not 1 <= modes < size:
        raise ModelError(f"modes = {modes}: must be at least 1 and below {size}")
