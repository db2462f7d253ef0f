"""LDL^T factorisations by MUMPS, with workspace enough on several ranks."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from petsc4py import PETSc

from fenics_nnm.errors import ConvergenceError, OutOfMemoryError

#: MUMPS's ICNTL(14): workspace beyond its estimate in per cent. The estimate is good on one rank;
#: on several, messages come in an order that may need more than the usual 20 (INFOG(1) = -9).
_WORKSPACE = ("mat_mumps_icntl_14", 200)

#: MUMPS's ICNTL(23): memory in 10^6 bytes that a rank may take.
_MEMORY = "mat_mumps_icntl_23"

#: Values of INFOG(1) that stand for too little memory: allocations that failed, a workspace that
#: is too small, and a limit that analysis has shown to be too low.
_TOO_LITTLE = (-5, -7, -8, -9, -11, -13, -19)

#: PETSc's error of a library that it calls.
_LIBRARY = 76


def use_mumps(ksp: PETSc.KSP, settings: Sequence[tuple[str, int]] = ()) -> None:
    """Solve by one Cholesky (LDL^T) factorisation of MUMPS; PETSc options of the user win.

    Args:
        ksp: Solver.
        settings: Options of MUMPS and their values.
    """
    ksp.setType(PETSc.KSP.Type.PREONLY)
    ksp.getPC().setType(PETSc.PC.Type.CHOLESKY)
    ksp.getPC().setFactorSolverType(PETSc.Mat.SolverType.MUMPS)
    ksp.setErrorIfNotConverged(True)
    options = PETSc.Options(ksp.getOptionsPrefix())
    for name, value in (*([_WORKSPACE] if ksp.comm.size > 1 else []), *settings):
        if not options.hasName(name):
            options.setValue(name, value)


@contextmanager
def limited_memory(ksp: PETSc.KSP, memory: float | None) -> Iterator[None]:
    """Let each rank take some bytes at most for a factorisation inside; no limit if None.

    MUMPS knows after its analysis, a small part of the work, whether they are enough.
    """
    options = PETSc.Options(ksp.getOptionsPrefix())
    if memory is None or options.hasName(_MEMORY):
        yield
        return
    options.setValue(_MEMORY, max(1, int(memory / 1e6)))
    try:
        yield
    finally:
        options.delValue(_MEMORY)


def factorise(ksp: PETSc.KSP) -> None:
    """Factorise the matrix of a solver.

    Raises:
        OutOfMemoryError: if there is too little memory.
        ConvergenceError: if there is no factorisation for another reason; it names MUMPS's error.
    """
    try:
        ksp.setUp()
    except PETSc.Error as error:
        raise failure(ksp, error) from error


def failure(ksp: PETSc.KSP, error: PETSc.Error) -> ConvergenceError:
    """What a factorisation ended with."""
    short = any(code in _TOO_LITTLE for code in _infog(ksp, error)[:1])
    return (OutOfMemoryError if short else ConvergenceError)(reason(ksp, error))


def reason(ksp: PETSc.KSP, error: PETSc.Error) -> str:
    """Why a factorisation failed, with MUMPS's error if it was MUMPS."""
    infog = _infog(ksp, error)
    if not infog:
        return f"PETSc error {error.ierr}"
    return f"MUMPS INFOG(1) = {infog[0]}, INFOG(2) = {infog[1]}"


def _infog(ksp: PETSc.KSP, error: PETSc.Error) -> list[int]:
    """INFOG(1) and INFOG(2) of MUMPS, if it was MUMPS that failed."""
    pc, factors = ksp.getPC(), (PETSc.PC.Type.CHOLESKY, PETSc.PC.Type.LU)
    direct = error.ierr == _LIBRARY and pc.getType() in factors
    if not direct or pc.getFactorSolverType() != PETSc.Mat.SolverType.MUMPS:
        return []
    factor = pc.getFactorMatrix()
    return [int(factor.getMumpsInfog(i)) for i in (1, 2)]
