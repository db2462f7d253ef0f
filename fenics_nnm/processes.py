"""What processes that this one starts see of it."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping
from pathlib import Path

#: Beginnings of the names that mpirun and batch systems tell their processes by.
OF_MPIRUN = ("OMPI_", "PMIX_", "PMI_", "PRTE_", "MPI_", "I_MPI_", "HYDRA_", "MPIR_", "SLURM_")

_CHECKOUT = Path(__file__).resolve().parents[1]


def environment_of_child(**changed: str) -> Mapping[str, str]:
    """Variables for a process of its own: no rank of mpirun, the same modules, one thread.

    The folder that the command is called in is not on its path of modules.

    Args:
        changed: Further variables.
    """
    plain = {name: value for name, value in os.environ.items() if not name.startswith(OF_MPIRUN)}
    path = os.pathsep.join(filter(None, without_current_folder(sys.path)))
    return {**plain, "PYTHONPATH": path, "PYTHONSAFEPATH": "1", **changed}


def without_current_folder(path: list[str]) -> list[str]:
    """A path of modules without the folder that the command is called in.

    Modules of anybody may lie there, such as a `random.py` beside a study.
    """
    try:
        here = Path.cwd().resolve()
    except OSError:  # it was removed
        return [entry for entry in path if entry]
    return [
        entry
        for entry in path
        if entry and (Path(entry).resolve() != here or Path(entry).resolve() == _CHECKOUT)
    ]
