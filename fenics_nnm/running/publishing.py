"""Third step of a run: fields, tables and summary, and all results moved to their place."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

from fenics_nnm.backbone.follow import Branch
from fenics_nnm.backbone.quantities import asked_points
from fenics_nnm.fem.conducting import led
from fenics_nnm.fem.harmonic import inertial_blocks
from fenics_nnm.fem.linear import LinearAnalysis
from fenics_nnm.fem.parallel import on_root
from fenics_nnm.fields.files import Shown, write_motions
from fenics_nnm.fields.linear import write_linear_modes
from fenics_nnm.fields.named import of_branch
from fenics_nnm.fields.state import write_state
from fenics_nnm.interrupts import uninterrupted
from fenics_nnm.output.pictures.backbone import LinearMode, Places, plot_backbone
from fenics_nnm.results import branch_file
from fenics_nnm.results.resume import remove_taken_over
from fenics_nnm.results.staging import move_results
from fenics_nnm.results.stored_branch import read_stored_branch
from fenics_nnm.results.tables import write_backbone, write_summary
from fenics_nnm.running.preparing import Ready
from fenics_nnm.running.run_summary import run_summary


def publish(ready: Ready, branch: Branch) -> tuple[Path, dict[str, Any]]:
    """Write all that is made of a branch, and put it in the place of older results.

    Returns:
        Folder of the results, which may have been moved since the run began, and contents of
        summary.json.

    Raises:
        OSError: if something cannot be written.
    """
    job, body = ready.job, ready.chosen.linear.body
    with job.stages.stage("output"):
        if body:  # without a mesh there is nothing to see in ParaView
            _write_fields(ready, body, branch)
        summary = run_summary(
            ready.chosen,
            branch,
            job.stages.timings,
            inputs=ready.inputs,
            warnings=ready.warnings,
        )
        on_root(job.comm, _write_tables, ready, branch, summary)
    with uninterrupted():
        return on_root(job.comm, _move, ready, branch), summary


def _move(ready: Ready, branch: Branch) -> Path:
    folder = ready.staging.results
    move_results(ready.staging.path, folder)
    remove_taken_over(ready.earlier.stopped, ready.job.text, branch)
    return folder


def _write_fields(ready: Ready, body: LinearAnalysis, branch: Branch) -> None:
    """Write ParaView files of the linear modes and of the motions asked for."""
    comm, study = body.solid.tagged.mesh.comm, ready.chosen.study
    file = on_root(comm, lambda: ready.staging.branch)
    folder = file.with_name("fields")
    on_root(comm, folder.mkdir)
    write_linear_modes(folder / "linear_modes.vtu", body)
    if body.solid.state is not None:
        on_root(comm, write_state, folder / "static_state.vtu", file)
    output = study.output
    wanted = asked_points(branch.points, study.continuation.report_at)
    if study.full_order:
        series = ready.chosen.prepared.balance.series
        inertia = {p.position: inertial_blocks(body, series, p.motion) for p in wanted}
        led(comm, inertia, lambda blocks: branch_file.add_inertia(file, blocks))
    write_motions(
        folder,
        partial(read_stored_branch, file),
        of_branch(wanted),
        shown=Shown(output.fields, output.frames, output.format, ready.bases),
        comm=comm,
        on_progress=ready.job.stages.report,
    )


def _write_tables(ready: Ready, branch: Branch, summary: dict[str, Any]) -> None:
    """Write table, picture and summary."""
    folder: Path = ready.staging.path
    prepared = ready.chosen.prepared
    write_backbone(folder / "backbone.csv", branch.points)
    plot_backbone(
        folder / "backbone.png",
        branch.points,
        title=prepared.study.title,
        linear=LinearMode(
            float(prepared.linear_frequencies[prepared.mode]),
            prepared.linear.model.at_rest().at_one(prepared.mode),
        ),
        places=Places(
            bifurcations=branch.bifurcations.located,
            jumps=[jump.gamma_ratios for jump in branch.jumps],
            failures=summary["failures"],
        ),
    )
    write_summary(folder / "summary.json", summary)
