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
from collections.abc import Callable, Iterator
from contextlib import contextmanager
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
int nnm_fits(void);
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
            ConvergenceError: if it is not positive definite, memory is short, or it has more
                entries than CHOLMOD counts.
        """
        if starts[-1] > np.iinfo(np.int32).max:
            raise ConvergenceError(f"{starts[-1]} entries are more than CHOLMOD counts")
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
        """L^-1 b, in place: columns of shape (n, k) that lie one after the other in memory.

        Raises:
            MemoryError: if there is too little.
        """
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
            # of this rank alone: the others wait for it, so that nobody is to go on from it
            raise MemoryError("solutions of linear equations")

    def _pointer(self, kind: str, array: Array | Indices) -> Any:
        return self._ffi.cast(f"{kind} *", array.ctypes.data)


def kernel(comm: MPI.Intracomm) -> ModuleType | None:
    """The compiled lines of C on all ranks; None on all where one has no compiler or no CHOLMOD.

    One rank of each machine compiles them; the others load what it has compiled.
    """
    machine = comm.Split_type(MPI.COMM_TYPE_SHARED)
    found, reason = None, ""
    if machine.rank == 0:
        found, reason = _tried(_kept_or_compiled)
    if machine.bcast(found is not None, root=0) and machine.rank > 0:
        found, reason = _tried(_loaded)
    machine.Free()
    if reason:
        logger.info("cholesky.c cannot be compiled, MUMPS factorises: %s", reason)
    return found if comm.allreduce(found is not None, op=MPI.LAND) else None


def _tried(load: Callable[[Path], ModuleType]) -> tuple[ModuleType | None, str]:
    """The module, or why there is none."""
    try:
        return load(_place()), ""
    except Exception as error:  # whatever ends a compiler
        return None, " ".join(str(error).split())


@functools.cache
def _kept_or_compiled(place: Path) -> ModuleType:
    """The module of an earlier run; compiled anew where there is none, or CHOLMOD has changed."""
    if place.exists():
        try:
            return _loaded(place)
        except ImportError as error:
            logger.info("cholesky.c is compiled again: %s", error)
    return _compiled(place)


def _place() -> Path:
    """Where the compiled module is kept from one run to the next."""
    suffix = str(sysconfig.get_config_var("EXT_SUFFIX"))
    parts = (_SOURCE.read_text("utf-8"), _DECLARATIONS, cffi.__version__, sys.version, suffix)
    digest = hashlib.sha256(repr(parts).encode()).hexdigest()[:24]
    return Path(jit.get_options()["cache_dir"]) / f"nnm_cholesky_{digest}{suffix}"


def _compiled(place: Path) -> ModuleType:
    """The module, compiled and kept.

    Raises:
        ImportError: as `_loaded`.
        OSError: if its folder cannot be written to.
        cffi.VerificationError: if there is no compiler, or no CHOLMOD; with the compiler's words.
    """
    builder, prefix = cffi.FFI(), Path(sys.prefix)
    builder.cdef(_DECLARATIONS)
    builder.set_source(
        _name(place),
        _SOURCE.read_text("utf-8"),
        libraries=["cholmod"],
        include_dirs=[str(prefix / "include")],
        library_dirs=[str(prefix / "lib")],
        extra_compile_args=["-O2"],
    )
    place.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=place.parent) as scratch:
        try:
            with _errors_kept(Path(scratch) / "errors") as errors:
                made = builder.compile(tmpdir=scratch)
        except cffi.VerificationError as error:
            words = errors.read_text("utf-8", "replace").splitlines()
            lines = [line for line in words if "error" in line] or words
            raise cffi.VerificationError(" ".join([*lines[:1], str(error)])) from error
        module = _loaded(Path(made))  # from here, as Python knows that of `place` already
        os.replace(made, place)  # at once, as other processes may load it, or compile it, too
    return module


@contextmanager
def _errors_kept(path: Path) -> Iterator[Path]:
    """Have what is written to the standard error inside, by compilers too, in a file."""
    sys.stderr.flush()
    before = os.dup(2)
    try:
        with path.open("wb") as file:
            os.dup2(file.fileno(), 2)
        yield path
    finally:
        sys.stderr.flush()
        os.dup2(before, 2)
        os.close(before)


@functools.cache
def _loaded(place: Path) -> ModuleType:
    """The module of a file.

    Raises:
        ImportError: if it does not go with the CHOLMOD that there is.
    """
    spec = importlib.util.spec_from_file_location(_name(place), place)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    if not module.lib.nnm_fits():
        raise ImportError("another version of CHOLMOD")
    return module


def _name(place: Path) -> str:
    """Name of the module of a file."""
    return place.name.partition(".")[0]
