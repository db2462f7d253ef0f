"""Matrices in the files of other programs: Matrix Market, NumPy, MATLAB."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from scipy import sparse
from scipy.io import loadmat, mmread, whosmat

from fenics_nnm.errors import ModelError
from fenics_nnm.files.bounds import (
    assert_fits,
    check_hdf5,
    check_matrix_market,
    check_npy,
    check_npz,
    check_shape,
)


def read_matrix(path: Path, name: str | None = None) -> Any:
    """Read a matrix, dense or sparse.

    Args:
        path: A .mtx (Matrix Market), .npy, .npz (NumPy, SciPy) or .mat (MATLAB) file.
        name: Name of the matrix in a .npz or .mat file that holds several.

    Raises:
        ModelError: if the file cannot be read, or has no such matrix.
    """
    readers: dict[str, Callable[[], Any]] = {
        ".mtx": lambda: _from_matrix_market(path),
        ".npy": lambda: _from_array(path),
        ".npz": lambda: _from_numpy(path, name),
        ".mat": lambda: _from_matlab(path, name),
    }
    if path.suffix not in readers:
        raise ModelError(f"{path}: must be a .mtx, .npy, .npz or .mat file")
    try:
        with path.open("rb"):  # the readers' messages about a missing file differ
            return _in_bounds(readers[path.suffix]())
    except (ModelError, MemoryError):
        raise
    except Exception as error:  # readers raise many kinds at a broken file
        reason = getattr(error, "strerror", None) or error
        raise ModelError(f"{path}: cannot be read as a matrix: {reason}") from error


def _in_bounds(matrix: Any) -> Any:
    """The matrix, whose indices all lie in its shape: native code does not look at them."""
    check_shape(tuple(matrix.shape))
    if sparse.issparse(matrix) and matrix.format in ("csr", "csc", "bsr"):
        matrix.check_format(full_check=True)
    elif sparse.issparse(matrix) and matrix.format == "coo":
        for axis, size in ((matrix.row, matrix.shape[0]), (matrix.col, matrix.shape[1])):
            if len(axis) and not 0 <= axis.min() <= axis.max() < size:
                raise ValueError(f"has an index outside of 0 to {size - 1}")
    return matrix


def _from_matrix_market(path: Path) -> Any:
    check_matrix_market(path)
    return mmread(path)


def _from_array(path: Path) -> Any:
    check_npy(path)
    return np.load(path, allow_pickle=False)


def _from_numpy(path: Path, name: str | None) -> Any:
    check_npz(path)
    with np.load(path, allow_pickle=False) as file:
        if {"format", "shape", "data"} <= set(file.files):
            if name is not None:
                raise ModelError(
                    f'{path}: holds one sparse matrix without a name: must hold "{name}", or name '
                    "a file for each matrix"
                )
            return sparse.load_npz(path)
        chosen = _chosen(path, name, file.files)
        try:
            return file[chosen]
        except ValueError as error:
            raise ModelError(
                f'{path}: "{chosen}" is not an array of numbers: save sparse matrices with '
                "scipy.sparse.save_npz, one in a file, or with scipy.io.savemat"
            ) from error


def _from_matlab(path: Path, name: str | None) -> Any:
    if h5py.is_hdf5(path):
        check_hdf5(path)
        with h5py.File(path) as file:
            return _from_hdf5(file[_chosen(path, name, list(file))])
    held = {name: shape for name, shape, _ in whosmat(path)}
    chosen = _chosen(path, name, list(held))
    check_shape(held[chosen])
    if {kind for name, _, kind in whosmat(path) if name == chosen} != {"sparse"}:
        assert_fits(8.0 * math.prod(held[chosen]), chosen)
    return loadmat(path, variable_names=[chosen])[chosen]


def _from_hdf5(item: h5py.Group | h5py.Dataset) -> Any:
    """A matrix of MATLAB's format 7.3: transposed if dense, compressed by columns if sparse."""
    if isinstance(item, h5py.Dataset):
        return item[()].T
    columns = item["jc"][()].astype(np.int64)
    shape = (int(item.attrs["MATLAB_sparse"]), len(columns) - 1)
    if "data" not in item:
        return sparse.csc_matrix(shape)
    return sparse.csc_matrix((item["data"][()], item["ir"][()].astype(np.int64), columns), shape)


def _chosen(path: Path, name: str | None, held: list[str]) -> str:
    held = [key for key in held if not key.startswith(("__", "#"))]
    if name is None and len(held) == 1:
        return held[0]
    if name not in held:
        wanted = f'no matrix "{name}"' if name else "several matrices: one must be named"
        raise ModelError(f"{path}: has {wanted}; it has {', '.join(sorted(held))}")
    return name
