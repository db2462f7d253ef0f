"""The eigenproblem K phi = omega^2 M phi of a body, lowest frequencies first."""

from __future__ import annotations

from petsc4py import PETSc
from slepc4py import SLEPc

#: Relative residual of an eigenpair, and the largest number of restarts.
_TOLERANCE, _RESTARTS = 1e-10, 200


def eigenproblem(stiffness: PETSc.Mat, mass: PETSc.Mat, prefix: str) -> SLEPc.EPS:
    """Shift-invert Krylov-Schur about zero; the linear solver is the caller's to choose.

    PETSc options of the user win.

    Args:
        stiffness: K.
        mass: M.
        prefix: Prefix of its PETSc options.
    """
    eps = SLEPc.EPS().create(stiffness.comm)
    eps.setOptionsPrefix(prefix)
    eps.setOperators(stiffness, mass)
    eps.setProblemType(SLEPc.EPS.ProblemType.GHEP)
    eps.setWhichEigenpairs(SLEPc.EPS.Which.TARGET_MAGNITUDE)
    eps.setTarget(0.0)
    eps.getST().setType(SLEPc.ST.Type.SINVERT)
    eps.setTolerances(_TOLERANCE, _RESTARTS)
    eps.setFromOptions()
    return eps


def ask_for(eps: SLEPc.EPS, count: int) -> None:
    """Ask for so many eigenpairs; the basis is as large as the user says, or SLEPc's choice.

    In SLEPc 3.25 a size left to SLEPc would take the place of the user's; in 3.22 it did not.
    """
    options = PETSc.Options(eps.getOptionsPrefix())
    size, projected = (options.getInt(f"eps_{key}", PETSc.DETERMINE) for key in ("ncv", "mpd"))
    eps.setDimensions(count, size, projected)
