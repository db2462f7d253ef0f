"""fenics-nnm run: follow the nonlinear mode of a study."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

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
from fenics_nnm.interrupts import terminable

if TYPE_CHECKING:
    from rich.table import Table

    from fenics_nnm.backbone.branch import Encounter
    from fenics_nnm.backbone.extremes import Extremes
    from fenics_nnm.backbone.point import BranchPoint
    from fenics_nnm.run import RunResult
    from fenics_nnm.study import Study


#: Motions that need less damping than this are stable but for round-off.
_ROUND_OFF = 1e-9


#: Columns of a terminal that has room for displacement and stress.
_WIDE = 80


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
    console.print(result_table(result, study, console.width))
    for encounter in result.branch.encounters:
        show(console, _line(encounter))
    for line in (result.message, stability_line(result.branch.points)):
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


def _line(encounter: Encounter) -> str:
    """What became of an internal resonance, in a line."""
    entered, skipped = (
        f"{what} at gamma ratio {', '.join(f'{ratio:g}' for ratio in ratios)}" if ratios else ""
        for what, ratios in (("entered", encounter.entered), ("skipped", encounter.skipped))
    )
    places = "; ".join(text for text in (entered, skipped) if text)
    return f"internal resonance with {encounter.name} near {encounter.frequency:.6g} Hz: {places}"


def result_table(result: RunResult, study: Study, width: int = 0) -> Table:
    """A few points of the branch: those reported, or evenly spread ones.

    Where there is room for it the largest displacement and von Mises stress are among the columns.
    """
    from rich.table import Table

    from fenics_nnm.backbone.quantities import asked_points

    table = Table(title=study.title or None, box=None, padding=(0, 3, 0, 0))
    points = result.branch.points
    several = any(point.family > 1 for point in points)
    family = ("family",) if several else ()
    sizes = _sizes_of(points, width - 10 * several)
    for heading in ("gamma ratio", "frequency (Hz)", "ratio", *sizes, "status", *family):
        table.add_column(heading, justify="right", no_wrap=True)
    reported = asked_points(points, study.continuation.report_at)
    for point in reported or points[:: max(1, len(points) // 10)]:
        table.add_row(
            f"{point.gamma_ratio:g}",
            f"{point.motion.frequency:.4f}",
            f"{point.frequency_ratio:.5f}",
            *(f"{of(point.extremes):.4g}" for of in sizes.values()),
            point.status,
            *((str(point.family),) if several else ()),
        )
    return table


def _sizes_of(points: Sequence[BranchPoint], width: int) -> dict[str, Callable[[Extremes], float]]:
    """Columns of displacement and stress by their heading: those that are known and fit."""
    if width < _WIDE:
        return {}
    columns: dict[str, Callable[[Extremes], float]] = {
        "u (mm)": lambda own: 1e3 * own.displacement.value,
        "s (MPa)": lambda own: 1e-6 * own.von_mises.away.value,
    }
    return {
        heading: of
        for heading, of in columns.items()
        if any(of(point.extremes) == of(point.extremes) for point in points)
    }


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
