"""Matrices in the files of other programs: Matrix Market, NumPy, MATLAB."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from scipy import sparse
from scipy.io import loadmat, mmread, whosmat

from fenics_nnm.errors import ModelError


def read_matrix(path: Path, name: str | None = None) -> Any:
    """Read a matrix, dense or sparse.

    Args:
        path: A .mtx (Matrix Market), .npy, .npz (NumPy, SciPy) or .mat (MATLAB) file.
        name: Name of the matrix in a .npz or .mat file that holds several.

    Raises:
        ModelError: if the file cannot be read, or has no such matrix.
    """
    readers: dict[str, Callable[[], Any]] = {
        ".mtx": lambda: mmread(path),
        ".npy": lambda: np.load(path),
        ".npz": lambda: _from_numpy(path, name),
        ".mat": lambda: _from_matlab(path, name),
    }
    if path.suffix not in readers:
        raise ModelError(f"{path}: must be a .mtx, .npy, .npz or .mat file")
    try:
        with path.open("rb"):  # the readers' messages about a missing file differ
            return readers[path.suffix]()
    except (ModelError, MemoryError):
        raise
    except Exception as error:  # readers raise many kinds at a broken file
        reason = getattr(error, "strerror", None) or error
        raise ModelError(f"{path}: cannot be read as a matrix: {reason}") from error


def _from_numpy(path: Path, name: str | None) -> Any:
    with np.load(path) as file:
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
        with h5py.File(path) as file:
            return _from_hdf5(file[_chosen(path, name, list(file))])
    chosen = _chosen(path, name, [held for held, _, _ in whosmat(path)])
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
