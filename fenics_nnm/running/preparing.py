"""First step of a run: what is linear, the numbers for "auto", and points of earlier runs."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import partial

from mpi4py import MPI

from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.fem.parallel import on_root
from fenics_nnm.fields.kept_bases import KeptBases
from fenics_nnm.resolution.auto import Choice, choice
from fenics_nnm.results.branch_file import BranchHeader
from fenics_nnm.results.kept_mesh import KeptMesh, kept_mesh
from fenics_nnm.results.resume import (
    StoredRun,
    assert_nobody_runs,
    assert_written_in,
    known_points,
    stored_run,
)
from fenics_nnm.results.staging import Staging, Stopped, stopped_runs
from fenics_nnm.results.start import beginning
from fenics_nnm.running.headers import header_of
from fenics_nnm.running.trust import log_warnings
from fenics_nnm.stages import Stages
from fenics_nnm.structure.analysis import Analyse, linear_analysis
from fenics_nnm.structure.damped_choice import damped_run
from fenics_nnm.structure.mesh_notes import report_notes
from fenics_nnm.structure.motions import assert_still_gaps, assert_without_coriolis
from fenics_nnm.structure.prepared import Prepared
from fenics_nnm.study import Study
from fenics_nnm.study.inputs import input_digests, input_files

logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Job:
    """What is asked for; the same on all ranks.

    Attributes:
        study: Study.
        text: Text of the study file, kept in branch.h5.
        resume: Whether to begin with the points of a stopped, or finished, run.
        comm: Communicator of the mesh.
        stages: Timings and progress.
        analyse: Finds what is linear of the study, in place of `linear_analysis`.
    """

    study: Study
    text: str
    resume: bool
    comm: MPI.Comm
    stages: Stages
    analyse: Analyse | None = None


@dataclass(frozen=True, slots=True)
class Earlier:
    """Earlier runs that a run goes on from; none where it begins anew.

    Attributes:
        stopped: What stopped runs left.
        stored: The run that points are taken over from.
        mesh: Its mesh, which is taken over, too; none of matrices, or if its file has changed.
    """

    stopped: tuple[Stopped, ...] = ()
    stored: StoredRun | None = None
    mesh: KeptMesh | None = None

    def points(self, prepared: Prepared) -> tuple[BranchPoint, ...]:
        """Stored points that are wanted again.

        Raises:
            StudyError: if they are of another model.
        """
        if self.stored is None:
            return ()
        assert_written_in(self.stored, prepared.series)
        return known_points(self.stored, prepared.model_in_contact, prepared.wanted)


@dataclass(frozen=True, slots=True)
class Ready:
    """All that a branch is followed with, on all ranks.

    Attributes:
        job: What is asked for.
        staging: Folder of the results until they are published.
        earlier: Earlier runs.
        inputs: Digests of the files that the study names, by key.
        chosen: The study with all its numbers, and what is linear of it.
        warnings: What looks like a wrong unit or direction in the study, a line each.
        bases: Stresses of shapes, kept on rank 0 from the measuring of points for their files.
    """

    job: Job
    staging: Staging
    earlier: Earlier
    inputs: Mapping[str, str]
    chosen: Choice
    warnings: tuple[str, ...] = ()
    bases: KeptBases = field(default_factory=KeptBases)

    @property
    def header(self) -> BranchHeader:
        """What branch.h5 says of all points."""
        prepared = self.chosen.prepared
        return header_of(
            prepared.study,
            prepared.model_in_contact,
            prepared.series,
            text=self.job.text,
            inputs=self.inputs,
        )

    def with_finer(self, chosen: Choice) -> Ready:
        """The same with finer numbers: a branch begins anew with them."""
        chosen = replace(chosen, prepared=_damped(chosen.prepared))
        return replace(self, chosen=chosen, earlier=replace(self.earlier, stored=None))


def prepare(job: Job, staging: Staging) -> Ready:
    """Find what is linear of a study, its numbers, and where its branch begins.

    Raises:
        NonlinearModeError: if the study cannot be run.
    """
    assert_without_coriolis(job.study)
    assert_still_gaps(job.study)
    inputs = on_root(job.comm, input_digests, job.study)
    earlier = on_root(job.comm, _earlier_runs, job, staging, inputs)
    shared, job = job.analyse is not None, _on_mesh_of(earlier, job)
    found = earlier.stored.header.resolution if earlier.stored else None
    chosen = choice(job.study, job.comm, job.stages, found=found, analyse=job.analyse)
    if not shared:
        report_notes(chosen.linear.notes(), job.comm)
    _tell_first_contact(chosen, job.comm)
    warnings = chosen.prepared.warnings()
    if job.comm.rank == 0:
        log_warnings(warnings)
    begun = _with_damping(_from_start(job, chosen), job.comm)
    ignored = begun.prepared.damping.ignored and begun.prepared.damping.warning
    warnings = (*warnings, ignored) if ignored else warnings
    return Ready(job, staging, earlier, inputs, begun, warnings)


def _damped(prepared: Prepared) -> Prepared:
    """The same with what its damping does; to be called on all ranks."""
    return prepared.with_damping(damped_run(prepared.study, prepared.linear))


def _with_damping(chosen: Choice, comm: MPI.Comm) -> Choice:
    """The choice with what the damping of its study does; says where motions stay undamped."""
    found = replace(chosen, prepared=_damped(chosen.prepared))
    if comm.rank == 0 and (warning := found.prepared.damping.warning):
        logger.warning(warning)
    return found


def _tell_first_contact(chosen: Choice, comm: MPI.Comm) -> None:
    """Say where contact begins, and warn where that depends on the choice of contact points."""
    first = chosen.linear.first_contact(chosen.prepared.mode)
    if comm.rank == 0:
        logger.info("gamma ratio 1 at %.6g J; %s", first.energy, first)
        if first.warning:
            logger.warning(first.warning)


def _from_start(job: Job, chosen: Choice) -> Choice:
    """The choice with the motion of an earlier run that its branch begins at, if it has one."""
    start, prepared = job.study.continuation.beginning, chosen.prepared
    if start is None:
        return chosen
    begin = on_root(
        job.comm, beginning, start, job.study.mode, prepared.linear.model, prepared.balance
    )
    return replace(chosen, prepared=prepared.beginning_at(begin))


def _on_mesh_of(earlier: Earlier, job: Job) -> Job:
    """The job with the mesh of an earlier run in place of its file."""
    if earlier.mesh is None:
        return job
    return replace(job, analyse=partial(job.analyse or linear_analysis, stored=earlier.mesh))


def _earlier_runs(job: Job, staging: Staging, inputs: Mapping[str, str]) -> Earlier:
    stopped = stopped_runs(staging.results)
    if not job.resume:
        _report(stopped)
        return Earlier()
    assert_nobody_runs(staging.results, but=staging.path)
    stored = stored_run(staging.results, stopped, job.text)
    if stored is None:
        logger.warning("%s: no points to resume from: starting anew", staging.results)
        return Earlier(stopped)
    mesh = kept_mesh(stored.path, stored.header, inputs, input_files(job.study))
    if mesh:
        logger.info("the mesh is taken from %s", mesh.path)
    return Earlier(stopped, stored, mesh)


def _report(stopped: tuple[Stopped, ...]) -> None:
    """Say where the points of stopped runs are."""
    for run in stopped:
        what = f"{run.points} points" if run.points else "a file that cannot be read"
        end = "that was stopped or killed" if run.gone else "on another machine, perhaps going on"
        advice = "; --resume goes on from there" if run.gone and run.points else ""
        logger.warning("%s: has %s of a run %s; left as it is%s", run.path, what, end, advice)
