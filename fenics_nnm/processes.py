"""What processes that this one starts see of it."""

from __future__ import annotations

import os  # Python has loaded both at its start: nothing is looked for in the current folder
import sys

#: Beginnings of the names that mpirun and batch systems tell their processes by.
OF_MPIRUN = ("OMPI_", "PMIX_", "PMI_", "PRTE_", "MPI_", "I_MPI_", "HYDRA_", "MPIR_", "SLURM_")

_CHECKOUT = os.path.realpath(os.path.join(os.path.dirname(__file__), ".."))


def environment_of_child(**changed: str) -> dict[str, str]:
    """Variables for a process of its own: no rank of mpirun, and the same modules.

    The folder that the command is called in is not on its path of modules.

    Args:
        changed: Further variables.
    """
    plain = {name: value for name, value in os.environ.items() if not name.startswith(OF_MPIRUN)}
    path = os.pathsep.join(without_current_folder(sys.path))
    return {**plain, "PYTHONPATH": path, "PYTHONSAFEPATH": "1", **changed}


def without_current_folder(path: list[str]) -> list[str]:
    """A path of modules without the folder that the command is called in.

    Modules of anybody may lie there, such as a `random.py` beside a study.
    """
    try:
        here = os.path.realpath(os.getcwd())
    except OSError:  # it was removed
        here = ""
    foreign = here if here != _CHECKOUT else ""
    return [entry for entry in path if entry and os.path.realpath(entry) != foreign]
