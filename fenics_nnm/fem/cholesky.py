"""Cholesky factors of a matrix of one rank, by CHOLMOD: the two triangular systems one by one.

PETSc solves with both at once and gives no entry of them. The few lines of C between CHOLMOD and
NumPy (cholesky.c) are compiled where they are used first, with the compiler and into the folder in
which dolfinx keeps its compiled forms.
"""

from __future__ import annotations

import functools
import hashlib
import importlib.util
import logging
import os
import sys
import sysconfig
import tempfile
from pathlib import Path
from types import ModuleType
from typing import Any

import cffi
import numpy as np
from dolfinx import jit
from mpi4py import MPI

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.errors import ConvergenceError

logger = logging.getLogger(__name__)

_SOURCE = Path(__file__).with_suffix(".c")

_DECLARATIONS = """
typedef struct { ...; } nnm_factors;
nnm_factors *nnm_factorise(int n, int *starts, int *columns, double *values);
void nnm_order(nnm_factors *f, int *order);
int nnm_solve(nnm_factors *f, int transposed, int count, double *columns);
void nnm_last(nnm_factors *f, int count, double *lower);
void nnm_free(nnm_factors *f);
"""


class Cholesky:
    """L L^T of a symmetric positive definite matrix, in an order of its rows.

    Attributes:
        order: Row of the matrix that each row of L is, shape (n,).
    """

    order: Indices

    def __init__(self, kernel: ModuleType, starts: Indices, columns: Indices, values: Array):
        """Factorise a matrix; its rows are best in the order of nested dissection.

        Args:
            kernel: Of `kernel`.
            starts: Where each row begins in the arrays below, and their end, shape (n + 1,).
            columns: Columns of the entries, of which those before the diagonal are not read.
            values: Entries.

        Raises:
            ConvergenceError: if it is not positive definite, or memory is short.
        """
        self._lib, self._ffi = kernel.lib, kernel.ffi
        at = np.ascontiguousarray(starts, dtype=np.int32)
        beside = np.ascontiguousarray(columns, dtype=np.int32)
        entries = np.ascontiguousarray(values, dtype=float)
        found = self._lib.nnm_factorise(
            len(at) - 1,
            self._pointer("int", at),
            self._pointer("int", beside),
            self._pointer("double", entries),
        )
        if found == self._ffi.NULL:
            raise ConvergenceError("CHOLMOD has no factors of a part of the stiffness")
        self._factors = self._ffi.gc(found, self._lib.nnm_free)
        self.order = np.empty(len(at) - 1, dtype=np.int32)
        self._lib.nnm_order(found, self._pointer("int", self.order))

    def last(self, count: int) -> Array:
        """The last rows and columns of L, shape (count, count)."""
        lower = np.zeros((count, count), order="F")
        self._lib.nnm_last(self._factors, count, self._pointer("double", lower))
        return lower

    def forward(self, columns: Array) -> None:
        """L^-1 b, in place: columns of shape (n, k) that lie one after the other in memory."""
        self._solve(columns, 0)

    def backward(self, columns: Array) -> None:
        """L^-T b, as `forward`."""
        self._solve(columns, 1)

    def release(self) -> None:
        """Free the factors."""
        self._ffi.release(self._factors)

    def _solve(self, columns: Array, transposed: int) -> None:
        assert columns.flags.f_contiguous and len(columns) == len(self.order)
        pointer = self._pointer("double", columns)
        if not self._lib.nnm_solve(self._factors, transposed, columns.shape[1], pointer):
            raise ConvergenceError("linear equations cannot be solved: memory is short")

    def _pointer(self, kind: str, array: Array | Indices) -> Any:
        return self._ffi.cast(f"{kind} *", array.ctypes.data)


def kernel(comm: MPI.Intracomm) -> ModuleType | None:
    """The compiled lines of C on all ranks; None on all where one has no compiler or no CHOLMOD.

    One rank of each machine compiles them.
    """
    machine = comm.Split_type(MPI.COMM_TYPE_SHARED)
    found, reason = None, ""
    for turn in (machine.rank == 0, machine.rank > 0):
        if turn:
            try:
                found = _loaded(_compiled())
            except Exception as error:  # whatever ends a compiler
                reason = " ".join(str(error).split())
        machine.Barrier()
    machine.Free()
    if reason:
        logger.info("cholesky.c cannot be compiled, MUMPS factorises: %s", reason)
    return found if comm.allreduce(found is not None, op=MPI.LAND) else None


def _compiled() -> Path:
    """The compiled module, kept from one run to the next."""
    source = _SOURCE.read_text("utf-8")
    suffix = str(sysconfig.get_config_var("EXT_SUFFIX"))
    parts = (source, _DECLARATIONS, cffi.__version__, sys.version, suffix)
    name = f"nnm_cholesky_{hashlib.sha256(repr(parts).encode()).hexdigest()[:24]}"
    folder = Path(jit.get_options()["cache_dir"])
    kept = folder / f"{name}{suffix}"
    if not kept.exists():
        builder, prefix = cffi.FFI(), Path(sys.prefix)
        builder.cdef(_DECLARATIONS)
        builder.set_source(
            name,
            source,
            libraries=["cholmod"],
            include_dirs=[str(prefix / "include")],
            library_dirs=[str(prefix / "lib")],
            extra_compile_args=["-O2"],
        )
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=folder) as scratch:
            os.replace(builder.compile(tmpdir=scratch), kept)
    return kept


@functools.cache
def _loaded(path: Path) -> ModuleType:
    """The module of a file."""
    spec = importlib.util.spec_from_file_location(path.name.partition(".")[0], path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
