"""A whole run: from a study file to a folder of results."""

from __future__ import annotations

import logging
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from fenics_nnm.backbone.follow import Branch
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.backbone.verdict import CONVERGED, FAILED, RESONANT, STATUSES
from fenics_nnm.errors import OutputError
from fenics_nnm.fem.blocks import Data, led
from fenics_nnm.fem.harmonic import HarmonicSolver
from fenics_nnm.fem.linear import LinearAnalysis
from fenics_nnm.fem.parallel import conducted, on_root
from fenics_nnm.interrupts import uninterrupted
from fenics_nnm.nonlinear.full_order_solver import FlexibilitySource
from fenics_nnm.output.pictures.backbone import plot_backbone
from fenics_nnm.output.report import Analysis, report_of
from fenics_nnm.resolution.auto import Choice, choice, improved
from fenics_nnm.results import branch_file, journal
from fenics_nnm.results.auto_report import told, warn_of
from fenics_nnm.results.journal import Journal
from fenics_nnm.results.place import assert_replaceable
from fenics_nnm.results.resume import (
    StoredRun,
    assert_nobody_runs,
    known_points,
    remove_taken_over,
    stored_run,
)
from fenics_nnm.results.run_summary import run_summary, versions
from fenics_nnm.results.staging import Staging, Stopped, claim, publish, rescue, stopped_runs
from fenics_nnm.results.tables import write_backbone, write_summary
from fenics_nnm.stages import Stages
from fenics_nnm.structure.analysis import (
    Analyse,
    linear_frequencies,
    model_in_contact,
    nonlinear_mode,
    wanted_motions,
)
from fenics_nnm.study import Study
from fenics_nnm.study.inputs import input_digests, input_files

logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class RunResult:
    """What a run gave.

    Attributes:
        folder: Where the results are.
        branch: The branch, with the reason of its end.
        summary: Contents of summary.json.
        told: The numbers found for "auto" in a line; empty where all were given.
    """

    folder: Path
    branch: Branch
    summary: dict[str, Any]
    told: str = ""


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
    of an interrupted run are moved there too. What a killed run left is told and left alone.

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
    stages = stages or Stages()
    read_from = [
        path for key, path in input_files(study).items() if not key.startswith("continuation.")
    ]
    on_root(comm, lambda: assert_replaceable(folder, read_from))
    staging = on_root(comm, lambda: claim(folder))
    try:
        stopped = on_root(comm, lambda: stopped_runs(folder))
        stored = on_root(comm, lambda: _to_resume(staging, stopped, text)) if resume else None
        if comm.rank == 0 and not resume:
            _tell(stopped)
        inputs = on_root(comm, lambda: input_digests(study))
        found = stored.header.resolution if stored else None
        chosen = choice(study, comm, stages, found=found, analyse=analyse)
        recorder = _Recorder(chosen, text, inputs, staging, stored, comm, stages)
        recorder, branch = _followed(recorder, analyse)
        with stages.stage("output"):
            analysis = recorder.chosen.analysis
            report_of(analysis).write_fields(staging.branch, recorder.study, branch, stages)
            summary = recorder.write_tables(analysis, branch)
        with uninterrupted():
            on_root(comm, lambda: publish(staging.path, folder))
            if resume:
                on_root(comm, lambda: remove_taken_over(stopped, text, branch))
    except BaseException as error:
        if comm.rank == 0:
            with uninterrupted():
                _note(error, rescue(staging))
        if isinstance(error, OSError) and not isinstance(error, OutputError):
            raise _unwritable(error, folder) from error
        raise
    finally:
        if comm.rank == 0:
            staging.release()
    if comm.rank == 0:
        _warn(branch)
        warn_of(recorder.chosen, branch)
    return RunResult(folder, branch, summary, told(recorder.chosen, branch))


def _followed(recorder: _Recorder, analyse: Analyse | None) -> tuple[_Recorder, Branch]:
    """Follow the branch, again from its beginning while "auto" asks for finer numbers."""
    while True:
        chosen = recorder.chosen
        branch = recorder.follow(chosen.analysis)
        finer = improved(chosen, branch.points, recorder.comm, recorder.stages, analyse=analyse)
        if finer is None:
            return recorder, branch
        recorder = replace(recorder, chosen=finer, stored=None)


def _to_resume(staging: Staging, stopped: tuple[Stopped, ...], text: str) -> StoredRun | None:
    assert_nobody_runs(staging.results, but=staging.path)
    stored = stored_run(staging.results, stopped, text)
    if stored is None:
        logger.warning("%s: no points to resume from: starting anew", staging.results)
    return stored


def _tell(stopped: tuple[Stopped, ...]) -> None:
    """Say where the points of stopped runs are."""
    for run in stopped:
        what = f"{run.points} points" if run.points else "a file that cannot be read"
        end = "that was stopped or killed" if run.gone else "on another machine, perhaps going on"
        advice = "; --resume goes on from there" if run.gone and run.points else ""
        logger.warning("%s: has %s of a run %s; left as it is%s", run.path, what, end, advice)


@dataclass(frozen=True, slots=True)
class _Recorder:
    chosen: Choice
    text: str
    inputs: dict[str, str]
    staging: Staging
    stored: StoredRun | None
    comm: MPI.Comm
    stages: Stages

    @property
    def study(self) -> Study:
        return self.chosen.study

    def follow(self, analysis: Analysis) -> Branch:
        """Follow the branch; each point is on disk before the next one is begun."""
        with self.stages.stage("output"):
            data = report_of(analysis).data()
            known = led(self.comm, data, lambda data: self._begin(analysis, data))
        if known:
            logger.info("%d points taken over", len(known))

        def solve(flexibility: FlexibilitySource | None = None) -> Branch:
            points = journal.opened(self.staging.branch)
            branch = nonlinear_mode(
                self.study,
                analysis,
                flexibility=flexibility,
                known=known,
                on_point=lambda point: _store(points, point),
                stages=self.stages,
            )
            with uninterrupted():
                branch_file.finish(self.staging.branch, branch)
            return branch

        # one rank decides about the steps, so that round-off cannot part the ranks
        if not (self.study.full_order and isinstance(analysis, LinearAnalysis)):
            return on_root(self.comm, solve)
        with HarmonicSolver(analysis, harmonics=self.study.resolution.harmonics) as flexibility:
            return conducted(self.comm, solve, flexibility)

    def write_tables(self, analysis: Analysis, branch: Branch) -> dict[str, Any]:
        """Write table, picture and summary; the summary is returned."""
        summary = run_summary(
            self.chosen, analysis, branch, self.stages.timings, inputs=self.inputs
        )
        on_root(self.comm, lambda: self._write_tables(analysis, branch, summary))
        return summary

    def _begin(self, analysis: Analysis, data: Data) -> tuple[BranchPoint, ...]:
        """Make branch.h5, with the points of an earlier run that are wanted again."""
        model, numbers = model_in_contact(self.study, analysis), self.study.resolution
        header = branch_file.BranchHeader(
            study=self.text,
            versions=versions(),
            mode=self.study.mode.number,
            harmonics=numbers.harmonics,
            samples=numbers.samples,
            modes=numbers.modes,
            series=self.study.mode.series,
            model=model,
        )
        stored = self.stored
        known = known_points(stored, model, wanted_motions(self.study)) if stored else ()
        branch_file.create(self.staging.branch, header, data, known)
        return known

    def _write_tables(self, analysis: Analysis, branch: Branch, summary: dict[str, Any]) -> None:
        folder = self.staging.path
        write_backbone(folder / "backbone.csv", branch.points)
        plot_backbone(
            folder / "backbone.png",
            branch.points,
            title=self.study.title,
            linear_frequency=float(linear_frequencies(analysis)[self.study.mode.number - 1]),
            failures=summary["failures"],
            bifurcations=branch.bifurcations.located,
            at_one=analysis.model.at_rest().at_one(self.study.mode.number - 1),
        )
        write_summary(folder / "summary.json", summary)


def _store(points: Journal, point: BranchPoint) -> None:
    with uninterrupted():
        branch_file.append(points, point)
    logger.info(
        "gamma ratio %.6g: %.6f Hz, %.6g J, %d Newton steps",
        point.gamma_ratio,
        point.frequency,
        point.energy,
        point.iterations,
    )


def _warn(branch: Branch) -> None:
    """Say which points are not to be trusted as they are."""
    total = len(branch.points)
    by_status = {status: [p for p in branch.points if p.status == status] for status in STATUSES}
    if failed := by_status[FAILED]:
        logger.warning(
            "%d of %d points failed the check in time: %s; raise mode.harmonics and mode.samples",
            len(failed),
            total,
            _first_reason(failed),
        )
    if resonant := by_status[RESONANT]:
        logger.warning(
            "%d of %d points are inside an internal resonance (%s): their frequency is off "
            "that of the main branch",
            len(resonant),
            total,
            "; ".join(sorted({point.resonance for point in resonant})),
        )
    if converged := by_status[CONVERGED]:
        unchecked = any(np.isnan(point.return_error) for point in converged)
        logger.log(
            logging.WARNING if unchecked else logging.INFO,
            "%d of %d points solve their equations, but are not verified in time: %s",
            len(converged),
            total,
            _first_reason(converged),
        )


def _first_reason(points: list[BranchPoint]) -> str:
    """Why the worst of some points is not verified, or what is said of all of them."""
    if len({point.reason for point in points}) == 1:
        return points[0].reason
    worst = max(points, key=lambda point: np.nan_to_num(point.return_error, nan=np.inf))
    return f"at gamma ratio {worst.gamma_ratio:g} {worst.reason}"


def _note(error: BaseException, text: str) -> None:
    if text:
        error.add_note(text)


def _unwritable(error: OSError, folder: Path) -> OutputError:
    """The error of the operating system as one of ours."""
    wrapped = OutputError(
        f"{error.filename or folder}: cannot be written: {error.strerror or error}"
    )
    wrapped.__notes__ = getattr(error, "__notes__", [])
    return wrapped
