"""LDL^T factorisations by MUMPS, which get more workspace where its estimate was too small.

On one rank CHOLMOD is faster (benchmarks/README.md), but factorises positive definite matrices
alone, and knows no limit of its memory.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from petsc4py import PETSc

from fenics_nnm.errors import ConvergenceError, OutOfMemoryError

logger = logging.getLogger(__name__)

#: MUMPS's ICNTL(14): workspace beyond its estimate in per cent.
_WORKSPACE = 14

#: MUMPS's ICNTL(23): memory in 10^6 bytes that a rank may take.
_MEMORY = 23

#: Values of INFOG(1) that more workspace cures. MUMPS's estimate is good on one rank; on several,
#: messages come in an order that may need more than the usual 20 per cent.
_TOO_SMALL = (-8, -17, -20)

#: And one that it cures unless ICNTL(23) limits the memory: workspace is all that is left then.
_UNLIMITED = -9

#: Values of INFOG(1) that stand for too little memory: allocations that failed, a workspace that
#: is too small, and a limit that analysis has shown to be too low.
_TOO_LITTLE = (-5, -7, -8, -9, -11, -13, -19)

#: Bytes an entry of a dense factor and of what it is made of, and bytes that MUMPS takes besides.
_DENSE, _BESIDES = 16, 2**30

#: ICNTL(13) = 1: of several ranks one factorises the last block alone. MUMPS does not count the
#: negative pivots of a block that ScaLAPACK factorises.
ROOT_ALONE = ("mat_mumps_icntl_13", 1)

#: Entries of a factor of n rows over n^(4/3), more than meshes of any shape have.
_ENTRIES = 40

#: Options of CHOLMOD: it says nothing, and fails where a matrix is not positive definite.
_OF_CHOLMOD = (("mat_cholmod_factor", "supernodal"), ("mat_cholmod_print", 0))

#: The workspace is doubled at most so many times.
_DOUBLINGS = 5


def use_mumps(ksp: PETSc.KSP, settings: Sequence[tuple[str, int]] = ()) -> None:
    """Solve by one Cholesky (LDL^T) factorisation of MUMPS; PETSc options of the user win.

    Args:
        ksp: Solver.
        settings: Options of MUMPS and their values.
    """
    _use(ksp, PETSc.Mat.SolverType.MUMPS, settings)


def use_fastest(ksp: PETSc.KSP, memory: float | None, settings: Sequence[tuple[str, int]]) -> None:
    """Solve by one Cholesky factorisation of a matrix that is positive definite.

    On one rank it is CHOLMOD's if PETSc has it and it fits into memory for sure, else MUMPS's;
    options of the user win. Its matrix is that which the solver has already.

    Args:
        ksp: Solver with its matrix.
        memory: Memory in bytes that a rank may take for factors; no limit if None.
        settings: Options of MUMPS and their values.
    """
    if takes_cholmod(ksp.getOperators()[1], memory):
        _use(ksp, PETSc.Mat.SolverType.CHOLMOD, _OF_CHOLMOD)
    else:
        use_mumps(ksp, settings)


def takes_cholmod(matrix: PETSc.Mat, memory: float | None) -> bool:
    """Whether `use_fastest` takes CHOLMOD for a matrix and a limit of memory in bytes."""
    fits = cholmod_fits(matrix.getSize()[0], memory)
    known = any(map(PETSc.Sys.hasExternalPackage, ("cholmod", "suitesparse")))
    return matrix.comm.size == 1 and fits and known


def cholmod_fits(rows: int, memory: float | None) -> bool:
    """Whether factors of some rows of one rank fit into a memory in bytes for sure."""
    return memory is None or 8 * _ENTRIES * rows ** (4 / 3) <= memory


def mumps_asked_for(prefix: str) -> bool:
    """Whether the user's PETSc options of a prefix choose a solver, or are options of MUMPS."""
    given = PETSc.Options(prefix).getAll()
    ours = {ROOT_ALONE[0]}
    return any(
        name == "pc_factor_mat_solver_type" or (name.startswith("mat_mumps_") and name not in ours)
        for name in given
    )


def negative_pivots(ksp: PETSc.KSP) -> int:
    """Number of negative eigenvalues of a matrix that was factorised.

    MUMPS has counted them; others fail where there are some.
    """
    return int(ksp.getPC().getFactorMatrix().getMumpsInfog(12)) if _infog(ksp) else 0


def _use(ksp: PETSc.KSP, solver: str, settings: Sequence[tuple[str, int | str]]) -> None:
    ksp.setType(PETSc.KSP.Type.PREONLY)
    ksp.getPC().setType(PETSc.PC.Type.CHOLESKY)
    ksp.getPC().setFactorSolverType(solver)
    options = PETSc.Options(ksp.getOptionsPrefix())
    for name, value in settings:
        if not options.hasName(name):
            options.setValue(name, value)
    ksp.setFromOptions()


@contextmanager
def limited_memory(ksp: PETSc.KSP, memory: float | None) -> Iterator[None]:
    """Let each rank take some bytes at most for a factorisation inside; no limit if None.

    MUMPS knows after its analysis, a small part of the work, whether they are enough. It reserves
    all of them as address space, so they are no more than any matrix of this size can need.
    """
    options, name = PETSc.Options(ksp.getOptionsPrefix()), _option(_MEMORY)
    if memory is None or options.hasName(name):
        yield
        return
    rows = ksp.getOperators()[1].getSize()[0]
    options.setValue(name, max(1, int(min(memory, _DENSE * rows**2 + _BESIDES) / 1e6)))
    try:
        yield
    finally:
        options.delValue(name)


@contextmanager
def order_kept(ksp: PETSc.KSP, kept: bool) -> Iterator[None]:
    """Let CHOLMOD keep the order of the rows of its matrix in a factorisation inside.

    Without it CHOLMOD finds orders by itself and takes the best one.

    Args:
        ksp: Solver.
        kept: Whether the order is to be kept.
    """
    options, name = PETSc.Options(ksp.getOptionsPrefix()), "mat_cholmod_nmethods"
    pc = ksp.getPC()
    if not kept or options.hasName(name) or pc.getFactorSolverType() != "cholmod":
        yield
        return
    pc.setFactorOrdering("natural")
    options.setValue(name, 1)
    try:
        yield
    finally:
        options.delValue(name)


def factorise(ksp: PETSc.KSP) -> None:
    """Factorise the matrix of a solver, again with twice the workspace where that was too small.

    Raises:
        OutOfMemoryError: if there is too little memory.
        ConvergenceError: if there is no factorisation for another reason; it names MUMPS's error.
    """
    ksp.setErrorIfNotConverged(False)  # an error would leave no way to try again
    try:
        ksp.setUp()
        doublings = _DOUBLINGS
        while ksp.getPC().getFailedReason() and doublings and _lacks_workspace(ksp):
            _factorise_with_more(ksp)
            doublings -= 1
    except PETSc.Error as error:
        raise ConvergenceError(f"PETSc error {error.ierr}") from error
    if ksp.getPC().getFailedReason():
        raise _failure(ksp)
    ksp.setErrorIfNotConverged(True)


def _lacks_workspace(ksp: PETSc.KSP) -> bool:
    """Whether MUMPS had too little workspace, by its own estimate and not the user's."""
    options, infog = PETSc.Options(ksp.getOptionsPrefix()), _infog(ksp)
    if not infog or options.hasName(_option(_WORKSPACE)):
        return False
    limited = options.hasName(_option(_MEMORY))
    return infog[0] in _TOO_SMALL or (infog[0] == _UNLIMITED and not limited)


def _factorise_with_more(ksp: PETSc.KSP) -> None:
    pc = ksp.getPC()
    workspace = 100 + 2 * pc.getFactorMatrix().getMumpsIcntl(_WORKSPACE)
    logger.info("MUMPS lacks workspace: once more with ICNTL(%d) = %d", _WORKSPACE, workspace)
    operators = pc.getOperators()
    pc.reset()
    pc.setOperators(*operators)
    pc.setFactorSetUpSolverType()
    pc.getFactorMatrix().setMumpsIcntl(_WORKSPACE, workspace)
    pc.setUp()


def _failure(ksp: PETSc.KSP) -> ConvergenceError:
    """What a factorisation ended with; MUMPS's error if it was MUMPS."""
    infog = _infog(ksp)
    if not infog:
        reason = ksp.getPC().getFailedReason()
        return ConvergenceError(f"PETSc's preconditioner fails with reason {reason}")
    kind = OutOfMemoryError if infog[0] in _TOO_LITTLE else ConvergenceError
    return kind(f"MUMPS INFOG(1) = {infog[0]}, INFOG(2) = {infog[1]}")


def _infog(ksp: PETSc.KSP) -> list[int]:
    """INFOG(1) and INFOG(2), if it was MUMPS that factorised."""
    pc = ksp.getPC()
    direct = pc.getType() in (PETSc.PC.Type.CHOLESKY, PETSc.PC.Type.LU)
    if not direct or pc.getFactorSolverType() != PETSc.Mat.SolverType.MUMPS:
        return []
    return [int(pc.getFactorMatrix().getMumpsInfog(i)) for i in (1, 2)]


def _option(number: int) -> str:
    """PETSc's option of an entry of ICNTL."""
    return f"mat_mumps_icntl_{number}"
