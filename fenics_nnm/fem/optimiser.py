"""gmsh's optimiser of curved elements, in a process of its own that may crash or not end."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable
from pathlib import Path

import gmsh
import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.fem.confinement import die_with_parent

#: Seconds that the optimiser may take.
_SECONDS = 60.0

#: Seconds between two looks at the process.
_PAUSE = 0.02


def optimise(folder: Path, seconds: float = _SECONDS) -> str:
    """Move the nodes of the current gmsh model to where its optimiser moves them.

    Args:
        folder: Private folder, for the nodes that the process hands back.
        seconds: Seconds that it may take.

    Returns:
        Why nothing was moved; empty if the optimiser came to its end.
    """
    tags, before, _ = gmsh.model.mesh.getNodes()
    moved = folder / "optimised.npy"
    problem = _in_fork(lambda: _write_optimised(moved), seconds)
    if problem:
        return problem
    after = np.load(moved)
    for tag, old, new in zip(tags, before.reshape(-1, 3), after, strict=True):
        if (old != new).any():
            gmsh.model.mesh.setNode(int(tag), new, [])
    return ""


def _write_optimised(path: Path) -> None:
    """Optimise, and write the coordinates of the nodes in gmsh's order, shape (nodes, 3)."""
    gmsh.model.mesh.optimize("HighOrder")
    coordinates: Array = gmsh.model.mesh.getNodes()[1].reshape(-1, 3)
    np.save(path, coordinates)


def _in_fork(work: Callable[[], None], seconds: float) -> str:
    """Do `work` in a copy of this process; why it did not end, empty if it did."""
    child = os.fork()
    if not child:
        _do_and_exit(work)
    end = time.monotonic() + seconds
    while True:
        ended, status = os.waitpid(child, os.WNOHANG)
        if ended:
            return _reason(os.waitstatus_to_exitcode(status))
        if time.monotonic() > end:
            os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)
            return f"took more than {seconds:g} s"
        time.sleep(_PAUSE)


def _do_and_exit(work: Callable[[], None]) -> None:
    """Do `work` and end this process, past all that the process it is a copy of would do."""
    code = 1
    try:
        die_with_parent()
        work()
        code = 0
    finally:
        os._exit(code)


def _reason(code: int) -> str:
    if code < 0:
        return f"crashed ({signal.Signals(-code).name})"
    return "failed" if code else ""
