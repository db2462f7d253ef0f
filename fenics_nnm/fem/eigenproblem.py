"""The eigenproblem K phi = omega^2 M phi of a body, lowest frequencies first."""

from __future__ import annotations

from slepc4py import SLEPc

from fenics_nnm.fem.solid import Solid

#: Relative residual of an eigenpair, and the largest number of restarts.
_TOLERANCE, _RESTARTS = 1e-10, 200


def eigenproblem(solid: Solid, prefix: str) -> SLEPc.EPS:
    """Shift-invert Krylov-Schur about zero; the linear solver is the caller's to choose.

    PETSc options of the user win.

    Args:
        solid: Assembled body.
        prefix: Prefix of its PETSc options.
    """
    eps = SLEPc.EPS().create(solid.stiffness.comm)
    eps.setOptionsPrefix(prefix)
    eps.setOperators(solid.stiffness, solid.mass)
    eps.setProblemType(SLEPc.EPS.ProblemType.GHEP)
    eps.setWhichEigenpairs(SLEPc.EPS.Which.TARGET_MAGNITUDE)
    eps.setTarget(0.0)
    eps.getST().setType(SLEPc.ST.Type.SINVERT)
    eps.setTolerances(_TOLERANCE, _RESTARTS)
    eps.setFromOptions()
    return eps
