"""What a process begins with, the command line or a user's own: caches, then PETSc."""

from __future__ import annotations

import os

from fenics_nnm.files.caches import use_writable_caches

#: To PETSc a closed pipe is a crash of the program; it is none.
_NO_HANDLER = "-no_signal_handler"


def begin() -> None:
    """Begin with the libraries; of no effect where they have begun. To be called on all ranks.

    Raises:
        OutputError: if there is no place for caches.
    """
    options = os.environ.get("PETSC_OPTIONS", "")
    if _NO_HANDLER not in options:
        os.environ["PETSC_OPTIONS"] = f"{options} {_NO_HANDLER}".strip()
    use_writable_caches()
    from fenics_nnm.fem import petsc_options

    petsc_options.begin()
