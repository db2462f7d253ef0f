"""From a study to its branch or its response, in this process: as the commands."""

from __future__ import annotations

import logging
import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path

from mpi4py import MPI

from fenics_nnm.errors import ConvergenceError
from fenics_nnm.face.branch import Branch, branch_of
from fenics_nnm.face.loaded import loaded
from fenics_nnm.face.response import Response, response_of
from fenics_nnm.face.temporary import Folder
from fenics_nnm.fem.parallel import on_root
from fenics_nnm.results.folder import assert_replaceable
from fenics_nnm.run import run_study
from fenics_nnm.running.beginning import begin
from fenics_nnm.running.responding import ResponseJob, respond
from fenics_nnm.stages import Stages
from fenics_nnm.structure.analysis import Analyse
from fenics_nnm.study import Study

logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Asked:
    """What is to be followed.

    Attributes:
        study: Study.
        text: Text of its study file.
        path: The study file.
        analyse: Finds what is linear of it.
    """

    study: Study
    text: str
    path: Path
    analyse: Analyse


def followed(asked: Asked, folder: Path | None, *, resume: bool) -> Branch:
    """Follow the nonlinear mode; to be called on all ranks.

    Args:
        asked: What is to be followed.
        folder: Folder of the results; a temporary one if not given.
        resume: Whether to begin with the points of an earlier run there.

    Raises:
        NonlinearModeError: if it cannot be, or the results not be written.
    """
    begin()
    comm = MPI.COMM_WORLD
    if folder is not None:
        on_root(comm, assert_replaceable, folder, [asked.path])
        return _ended(asked, folder, resume=resume)
    made = on_root(comm, lambda: Path(tempfile.mkdtemp(prefix="fenics-nnm-")))
    try:
        return _ended(asked, made, resume=resume, temporary=True)
    except BaseException:
        if comm.rank == 0:
            shutil.rmtree(made, ignore_errors=True)
        raise


def responded(asked: Asked, folder: Path | None, *, resume: bool) -> Response:
    """Find the response that a study asks for; to be called on all ranks.

    Args:
        asked: The study.
        folder: Folder of the results; a temporary one if not given.
        resume: Whether to go on from the levels of an earlier response there.

    Raises:
        NonlinearModeError: if it cannot be driven, or the results not be written.
    """
    begin()
    comm = MPI.COMM_WORLD
    kept = Folder(folder or on_root(comm, lambda: Path(tempfile.mkdtemp(prefix="fenics-nnm-"))))
    if folder is None:
        kept.removed_at_last()
    job = ResponseJob(asked.study, asked.text, resume, comm, Stages())
    done = respond(job, kept.path)
    if comm.rank == 0:
        for line in done.missing:
            logger.warning("incomplete: %s", line)
    return response_of(kept)


def _ended(asked: Asked, folder: Path, *, resume: bool, temporary: bool = False) -> Branch:
    result = run_study(asked.study, asked.text, folder, resume=resume, analyse=asked.analyse)
    if not result.branch.points:
        raise ConvergenceError(result.branch.reason)
    if not result.branch.complete and MPI.COMM_WORLD.rank == 0:
        logger.warning("incomplete: %s", result.branch.reason)
    return branch_of(loaded(result.folder, temporary=temporary))
