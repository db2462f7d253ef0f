"""How PETSc begins: with its variable PETSC_OPTIONS, and without files of options.

It would read `.petscrc` in the current folder, which may be somebody else's and can have code
loaded or files written.
"""

from __future__ import annotations

import petsc4py


def begin() -> None:
    """Begin PETSc; of no effect where it has begun. To be called on all ranks."""
    petsc4py.init(["fenics-nnm", "-skip_petscrc"])
