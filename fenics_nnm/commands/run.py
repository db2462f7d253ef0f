"""fenics-nnm run: follow the nonlinear mode of a study."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from fenics_nnm.commands.run_table import line_of_marks, result_table, shown_points
from fenics_nnm.commands.shared import (
    DONE,
    INCOMPLETE,
    Commands,
    add_settings,
    add_study,
    asked_study,
    complain,
    console_of,
    show,
    stages_of,
)
from fenics_nnm.importing import importing
from fenics_nnm.interrupts import terminable

if TYPE_CHECKING:
    from fenics_nnm.backbone.branch import Encounter
    from fenics_nnm.backbone.point import BranchPoint


#: Motions that need less damping than this are stable but for round-off.
_ROUND_OFF = 1e-9


def add_to(commands: Commands) -> None:
    """Add the command."""
    run = commands.add_parser("run", help="follow the nonlinear mode of a study")
    run.add_argument(
        "--output",
        type=Path,
        metavar="DIR",
        help="folder of the results (default: output.folder of the study, or results/STUDY)",
    )
    run.add_argument(
        "--resume",
        action="store_true",
        help="go on from the points of a stopped, or finished, run of the same study",
    )
    add_settings(run)
    add_study(run)
    run.set_defaults(action=_run)


def _run(arguments: argparse.Namespace) -> int:
    with importing():
        from mpi4py import MPI

        from fenics_nnm.commands.place import place_line
        from fenics_nnm.fem.parallel import on_root
        from fenics_nnm.results.folder import assert_replaceable, older_results
        from fenics_nnm.run import run_study

    study, text = asked_study(arguments)
    console = console_of(MPI.COMM_WORLD)
    folder = arguments.output or study.output.folder or Path("results") / arguments.study.stem
    assert_replaceable(folder, [arguments.study])
    older = "" if arguments.resume else on_root(MPI.COMM_WORLD, older_results, folder)
    with terminable(), stages_of(console, arguments) as stages:
        result = run_study(study, text, folder, resume=arguments.resume, stages=stages)
    points = result.branch.points
    console.print(result_table(result, study, console.width))
    for line in (_left_out(points, study.continuation.report_at), line_of_marks(points)):
        if line:
            show(console, line)
    for encounter in result.branch.encounters:
        show(console, _line(encounter))
    for line in (result.message, stability_line(points)):
        if line:
            show(console, line)
    for line in result.summary["advice"]:
        show(console, f"next: {line}")
    show(console, f"{result.branch.reason}; {place_line(result.folder)}")
    if older:
        show(console, f"they replace {older}")
    if not result.branch.complete:
        if MPI.COMM_WORLD.rank == 0:
            complain(f"incomplete: {result.branch.reason}")
        return INCOMPLETE
    return DONE


def _left_out(points: Sequence[BranchPoint], ratios: Sequence[float]) -> str:
    """How many points the table has; empty where it has all of them."""
    shown = len(shown_points(points, ratios))
    return "" if shown == len(points) else f"{shown} of {len(points)} points; backbone.csv has all"


def _line(encounter: Encounter) -> str:
    """What became of an internal resonance, in a line."""
    entered, skipped = (
        f"{what} at gamma ratio {', '.join(f'{ratio:g}' for ratio in ratios)}" if ratios else ""
        for what, ratios in (("entered", encounter.entered), ("skipped", encounter.skipped))
    )
    places = "; ".join(text for text in (entered, skipped) if text)
    return f"internal resonance with {encounter.name} near {encounter.frequency:.6g} Hz: {places}"


def stability_line(points: Sequence[BranchPoint]) -> str:
    """How many motions are unstable, and what damping holds them; empty if none is."""
    from fenics_nnm.backbone.point_numbers import damping_needed, is_damped

    needed = [each for each in map(damping_needed, points) if each > _ROUND_OFF]
    if not needed:
        return ""
    if any(map(is_damped, points)):
        return (
            f"{len(needed)} of {len(points)} motions are unstable with the damping of the study; "
            f"{100 * max(needed):.2g} % of critical damping more would hold all of them"
        )
    return (
        f"{len(needed)} of {len(points)} motions are unstable without damping; "
        f"{100 * max(needed):.2g} % of critical damping (ln |mu| / 2 pi) holds all of them"
    )
