"""LDL^T factorisations by MUMPS, which get more workspace where its estimate was too small."""

from __future__ import annotations

import logging

from petsc4py import PETSc

from fenics_nnm.errors import ConvergenceError

logger = logging.getLogger(__name__)

#: MUMPS's ICNTL(14): workspace beyond its estimate in per cent.
_WORKSPACE = 14

#: Values of MUMPS's INFOG(1) that more workspace cures. Its estimate is good on one rank; on
#: several, messages come in an order that may need more than the usual 20 per cent.
_TOO_SMALL = (-8, -9, -17, -20)

#: The workspace is doubled at most so many times.
_DOUBLINGS = 5


def use_mumps(ksp: PETSc.KSP) -> None:
    """Solve by one Cholesky (LDL^T) factorisation of MUMPS; PETSc options of the user win."""
    ksp.setType(PETSc.KSP.Type.PREONLY)
    ksp.getPC().setType(PETSc.PC.Type.CHOLESKY)
    ksp.getPC().setFactorSolverType(PETSc.Mat.SolverType.MUMPS)
    ksp.setFromOptions()


def factorise(ksp: PETSc.KSP) -> None:
    """Factorise the matrix of a solver, again with twice the workspace where that was too small.

    Raises:
        ConvergenceError: if there is no factorisation; it names MUMPS's error.
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
        raise ConvergenceError(_reason(ksp))
    ksp.setErrorIfNotConverged(True)


def _lacks_workspace(ksp: PETSc.KSP) -> bool:
    """Whether MUMPS had too little workspace, by its own estimate and not by the user's."""
    given = PETSc.Options(ksp.getOptionsPrefix()).hasName(f"mat_mumps_icntl_{_WORKSPACE}")
    factor = ksp.getPC().getFactorMatrix()
    return _by_mumps(ksp) and not given and factor.getMumpsInfog(1) in _TOO_SMALL


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


def _reason(ksp: PETSc.KSP) -> str:
    """Why a factorisation failed, with MUMPS's error if it was MUMPS."""
    if not _by_mumps(ksp):
        return f"PETSc's preconditioner fails with reason {ksp.getPC().getFailedReason()}"
    infog = [ksp.getPC().getFactorMatrix().getMumpsInfog(i) for i in (1, 2)]
    return f"MUMPS INFOG(1) = {infog[0]}, INFOG(2) = {infog[1]}"


def _by_mumps(ksp: PETSc.KSP) -> bool:
    pc = ksp.getPC()
    direct = pc.getType() in (PETSc.PC.Type.CHOLESKY, PETSc.PC.Type.LU)
    return bool(direct and pc.getFactorSolverType() == PETSc.Mat.SolverType.MUMPS)
