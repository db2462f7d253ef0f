"""fenics-nnm export: files for ParaView of any points of a finished run or response."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from fenics_nnm.commands.amounts import EXAMPLES, add_amounts, amounts_of
from fenics_nnm.commands.shared import (
    DONE,
    INCOMPLETE,
    Commands,
    add_verbose,
    console_of,
    show,
    stages_of,
)
from fenics_nnm.errors import StudyError
from fenics_nnm.field_names import (
    DEFAULT_FIELDS,
    FIELDS,
    FORMATS,
    LEAST_FRAMES,
    MOST_FRAMES,
    FieldName,
)

if TYPE_CHECKING:
    from fenics_nnm.backbone.point import BranchPoint
    from fenics_nnm.backbone.quantities import Sought
    from fenics_nnm.response.point import ResponsePoint
    from fenics_nnm.results.stored_branch import StoredBranch

Found = TypeVar("Found")

#: Fields that have to be asked for.
_LEFT_OUT = [name for name in FIELDS if name not in DEFAULT_FIELDS]

#: A point whose gamma ratio differs by more, relative to the one asked for, is another motion.
_TOLERANCE = 0.05


def add_to(commands: Commands) -> None:
    """Add the command."""
    export = commands.add_parser("export", help="write ParaView files of points of a finished run")
    export.add_argument(
        "branch",
        type=Path,
        metavar="branch.h5",
        help="file of a run, or response.h5 of a response, or its results folder",
    )
    export.add_argument(
        "--gamma", type=float, nargs="+", metavar="RATIO", help="gamma ratios, of a run"
    )
    add_amounts(export, ", of a run")
    export.add_argument(
        "--at", type=float, nargs="+", metavar="HZ", help="frequencies, of a response"
    )
    export.add_argument(
        "--level", type=float, metavar="X", help="level of a response (default: all)"
    )
    export.add_argument(
        "--fields",
        default=",".join(DEFAULT_FIELDS),
        metavar="LIST",
        help=f"{', '.join(FIELDS)} (default: all but {', '.join(_LEFT_OUT)})",
    )
    export.add_argument(
        "--frames",
        type=int,
        default=LEAST_FRAMES,
        metavar="N",
        help="frames of a period (default: %(default)s)",
    )
    export.add_argument(
        "--format",
        choices=FORMATS,
        default=FORMATS[0],
        help="a .vtu file for each frame, or one .vtkhdf file a motion (default: %(default)s)",
    )
    export.add_argument(
        "--output", type=Path, metavar="DIR", help="new folder (default: export beside the file)"
    )
    add_verbose(export)
    export.set_defaults(action=_export)


def _export(arguments: argparse.Namespace) -> int:
    from fenics_nnm.results.kinds import is_response
    from fenics_nnm.results.response_file import NAME

    if arguments.frames < LEAST_FRAMES:
        raise StudyError(f"--frames {arguments.frames}: must be at least {LEAST_FRAMES}")
    if arguments.frames > MOST_FRAMES:
        raise StudyError(f"--frames {arguments.frames}: must be {MOST_FRAMES} at most")
    if is_response(arguments.branch):
        return _export_response(arguments)
    for option in ("at", "level"):
        if getattr(arguments, option) is not None:
            file = arguments.branch / NAME
            hint = f"; the response of this folder is in {file}" if file.exists() else ""
            raise StudyError(
                f"--{option}: is for a response: of a run name --gamma, --{', --'.join(EXAMPLES)}"
                f"{hint}"
            )
    return _export_branch(arguments)


def _export_branch(arguments: argparse.Namespace) -> int:
    from fenics_nnm.fields.export import export, export_points

    sought = list(amounts_of(arguments).values())
    if not sought:
        ratios = _numbers("gamma", arguments.gamma)
        found = _written(arguments, "branch.h5", export, ratios, _line)
        have = [point.gamma_ratio for point in found]
        return _told("--gamma {:g}: no such point, the nearest has gamma ratio {:g}", ratios, have)
    if arguments.gamma is not None:
        raise StudyError(f"--gamma: does not go with --{sought[0].quantity}: name one of both")
    return _ended(_written_of(arguments, export_points, sought))


def _written_of(
    arguments: argparse.Namespace, write: Callable[..., list[BranchPoint]], sought: Sequence[Sought]
) -> list[str]:
    """Write the points nearest to values; lines about those that are not there."""
    from mpi4py import MPI

    from fenics_nnm.fields.nearest import nearest_to

    lines: list[str] = []
    far: list[str] = []

    def choose(branch: StoredBranch) -> list[BranchPoint]:
        listed = [each for value in sought for each in nearest_to(branch.points, value)]
        for each in listed:
            (lines if abs(each.off) <= _TOLERANCE else far).append(str(each))
        chosen = {each.point.position for each in listed}
        return [point for point in branch.points if point.position in chosen]

    _written(arguments, "branch.h5", write, choose, _line)
    lines, far = MPI.COMM_WORLD.bcast((lines, far))
    for line in lines:
        show(console_of(MPI.COMM_WORLD), line)
    return far


def _export_response(arguments: argparse.Namespace) -> int:
    from fenics_nnm.fields.export import AtFrequencies, export_response
    from fenics_nnm.results.response_file import NAME

    for option in ("gamma", *EXAMPLES):
        if getattr(arguments, option):
            raise StudyError(
                f"--{option}: is for a run: of a response name frequencies in Hz by --at"
            )
    wanted = AtFrequencies(_numbers("at", arguments.at), arguments.level)
    found = _written(arguments, NAME, export_response, wanted, _line_of_response)
    have = [point.frequency for point in found]
    return _told("--at {:g}: no such motion, the nearest has {:g} Hz", wanted.frequencies, have)


def _written(
    arguments: argparse.Namespace,
    name: str,
    write: Callable[..., list[Found]],
    wanted: Any,
    line: Callable[[Found], str],
) -> list[Found]:
    """Write what is wanted of a file of results, of this name in its folder, and list it."""
    from mpi4py import MPI

    from fenics_nnm.fields.files import Shown

    shown = Shown(_fields(arguments.fields), arguments.frames, arguments.format)
    given, comm = arguments.branch, MPI.COMM_WORLD
    file = given / name if given.is_dir() else given
    folder = arguments.output or file.with_name("export")
    console = console_of(comm)
    with stages_of(console, arguments) as stages, stages.stage("output"):
        found = write(
            file,
            folder,
            wanted,
            shown=shown,
            comm=comm,
            on_progress=stages.report,
        )
    for point in found:
        show(console, line(point))
    show(console, f"files in {folder}")
    return found


def _told(words: str, wanted: Sequence[float], found: Sequence[float]) -> int:
    """Say where the nearest is not what was asked for, and which are so far that they are others.

    Args:
        words: Line about what is missing, with places for what was asked for and the nearest.
        wanted: What was asked for.
        found: What the points that were written have.
    """
    from mpi4py import MPI

    pairs = [(asked, min(found, key=lambda have: abs(have - asked))) for asked in wanted]
    far = [(asked, near) for asked, near in pairs if abs(near - asked) > _TOLERANCE * abs(asked)]
    for asked, near in pairs:
        if (asked, near) not in far and f"{asked:g}" != f"{near:g}":
            line = f"asked for {asked:g}, which is not computed: the nearest computed is {near:g}"
            show(console_of(MPI.COMM_WORLD), line)
    return _ended([words.format(*pair) for pair in far])


def _ended(missing: Sequence[str]) -> int:
    """Say what is not there as it was asked for."""
    from mpi4py import MPI

    console = console_of(MPI.COMM_WORLD)
    for line in missing:
        show(console, line)
    return INCOMPLETE if missing else DONE


def _numbers(option: str, given: Sequence[float] | None) -> Sequence[float]:
    """Numbers of an option.

    Raises:
        StudyError: if there are none, or one is not a finite, positive number.
    """
    if not given:
        raise StudyError(f"--{option}: is missing: which points are wanted")
    for value in given:
        if not math.isfinite(value) or (option == "at" and value <= 0):
            right = "positive" if option == "at" else "a number"
            raise StudyError(f"--{option} {value}: must be {right}")
    return given


def _fields(names: str) -> tuple[FieldName, ...]:
    wanted = names.split(",")
    for name in wanted:
        if name not in FIELDS:
            raise StudyError(f"--fields {names}: {name!r} must be one of {', '.join(FIELDS)}")
    return tuple(name for name in FIELDS if name in wanted)


def _line_of_response(point: ResponsePoint) -> str:
    return f"level {point.level:g}, {point.frequency:.6g} Hz: {point.status}"


def _line(point: BranchPoint) -> str:
    return f"gamma ratio {point.gamma_ratio:g}: {point.motion.frequency:.6g} Hz, {point.status}"
