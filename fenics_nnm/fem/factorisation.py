"""LDL^T factorisations by MUMPS, with workspace enough on several ranks."""

from __future__ import annotations

from petsc4py import PETSc

from fenics_nnm.errors import ConvergenceError

#: MUMPS's ICNTL(14): workspace beyond its estimate in per cent. The estimate is good on one rank;
#: on several, messages come in an order that may need more than the usual 20 (INFOG(1) = -9).
_WORKSPACE = ("mat_mumps_icntl_14", 200)

#: PETSc's error of a library that it calls.
_LIBRARY = 76


def use_mumps(ksp: PETSc.KSP) -> None:
    """Solve by one Cholesky (LDL^T) factorisation of MUMPS; PETSc options of the user win."""
    ksp.setType(PETSc.KSP.Type.PREONLY)
    ksp.getPC().setType(PETSc.PC.Type.CHOLESKY)
    ksp.getPC().setFactorSolverType(PETSc.Mat.SolverType.MUMPS)
    ksp.setErrorIfNotConverged(True)
    options, (name, value) = PETSc.Options(ksp.getOptionsPrefix()), _WORKSPACE
    if ksp.comm.size > 1 and not options.hasName(name):
        options.setValue(name, value)


def factorise(ksp: PETSc.KSP) -> None:
    """Factorise the matrix of a solver.

    Raises:
        ConvergenceError: if there is no factorisation; it names MUMPS's error.
    """
    try:
        ksp.setUp()
    except PETSc.Error as error:
        raise ConvergenceError(reason(ksp, error)) from error


def reason(ksp: PETSc.KSP, error: PETSc.Error) -> str:
    """Why a factorisation failed, with MUMPS's error if it was MUMPS."""
    pc, factors = ksp.getPC(), (PETSc.PC.Type.CHOLESKY, PETSc.PC.Type.LU)
    direct = error.ierr == _LIBRARY and pc.getType() in factors
    if not direct or pc.getFactorSolverType() != PETSc.Mat.SolverType.MUMPS:
        return f"PETSc error {error.ierr}"
    factor = pc.getFactorMatrix()
    infog = [factor.getMumpsInfog(i) for i in (1, 2)]
    return f"MUMPS INFOG(1) = {infog[0]}, INFOG(2) = {infog[1]}"
