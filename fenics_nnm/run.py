"""A whole run: from a study file to a folder of results."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mpi4py import MPI

from fenics_nnm.backbone.follow import Branch
from fenics_nnm.fem.parallel import on_root
from fenics_nnm.results.folder import assert_replaceable
from fenics_nnm.running.auto_report import message_of, warn_of
from fenics_nnm.running.claiming import claimed
from fenics_nnm.running.families_report import warn_of_families
from fenics_nnm.running.following import follow
from fenics_nnm.running.preparing import Job, prepare
from fenics_nnm.running.publishing import publish
from fenics_nnm.running.trust import warn_of_points, warn_of_strength
from fenics_nnm.stages import Stages
from fenics_nnm.structure.analysis import Analyse
from fenics_nnm.study import Study
from fenics_nnm.study.inputs import input_files


@dataclass(frozen=True, slots=True)
class RunResult:
    """What a run gave.

    Attributes:
        folder: Where the results are.
        branch: The branch, with the reason of its end.
        summary: Contents of summary.json.
        message: The numbers found for "auto" in a line; empty where all were given.
    """

    folder: Path
    branch: Branch
    summary: dict[str, Any]
    message: str = ""


def run_study(
    study: Study,
    text: str,
    folder: Path,
    *,
    resume: bool = False,
    comm: MPI.Comm = MPI.COMM_WORLD,
    stages: Stages | None = None,
    analyse: Analyse | None = None,
) -> RunResult:
    """Run a study and write its results.

    Results are made in a folder of their own and moved to `folder` when the branch has ended, so
    that a run that fails leaves older results alone. Where there are no older ones, the points
    of an interrupted run are moved there too. What a killed run left is reported and left alone.

    Args:
        study: Study.
        text: Text of the study file, kept in branch.h5.
        folder: Folder of the results, made if need be.
        resume: Begin with the points of a stopped, or finished, run of this study in `folder`.
        comm: Communicator of the mesh.
        stages: Timings and progress.
        analyse: Finds what is linear of the study, in place of `linear_analysis`.

    Raises:
        NonlinearModeError: if the study cannot be run, or the results not be written.
    """
    job = Job(study, text, resume, comm, stages or Stages(), analyse)
    on_root(comm, assert_replaceable, folder, _read_files(study))
    with claimed(folder, comm) as staging:
        ready, branch = follow(prepare(job, staging))
        place, summary = publish(ready, branch)
    if comm.rank == 0:
        warn_of_points(branch)
        warn_of_families(branch)
        warn_of_strength(branch)
        warn_of(ready.chosen, branch)
    return RunResult(place, branch, summary, message_of(ready.chosen, branch))


def _read_files(study: Study) -> list[Path]:
    """Files that a study names, besides results that it starts from."""
    named = input_files(study).items()
    return [path for key, path in named if not key.startswith("continuation.")]
