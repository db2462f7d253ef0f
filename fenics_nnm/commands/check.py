"""fenics-nnm check: show what a study means."""

from __future__ import annotations

import argparse
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from fenics_nnm.commands.shared import (
    DONE,
    Commands,
    add_settings,
    add_study,
    asked_study,
    console_of,
    show,
    stages_of,
)
from fenics_nnm.errors import MeshError, ModelError, NonlinearModeError, OutputError, StudyError

if TYPE_CHECKING:
    from fenics_nnm.structure.structure import Outline

#: Endings of the file of a picture.
SUFFIXES = (".png", ".svg", ".pdf")


def add_to(commands: Commands) -> None:
    """Add the command."""
    check = commands.add_parser(
        "check",
        help="show what a study means, up to its linear modes; writes nothing but --picture",
    )
    check.add_argument(
        "--picture",
        type=Path,
        metavar="FILE.png",
        help="draw the mesh with its groups and contact points",
    )
    add_settings(check)
    add_study(check)
    check.set_defaults(action=_check)


def _check(arguments: argparse.Namespace) -> int:
    from mpi4py import MPI

    from fenics_nnm.running.checking import checked
    from fenics_nnm.running.trust import log_warnings
    from fenics_nnm.structure.analysis import structure_of

    (study, _), picture = asked_study(arguments), arguments.picture
    outline = structure_of(study).outline
    _refuse_picture(outline, picture)
    console = console_of(MPI.COMM_WORLD)
    try:
        with stages_of(console, arguments) as stages:
            found = checked(study, MPI.COMM_WORLD, stages)
    except (MeshError, ModelError) as error:
        _draw_groups(outline, picture, error)
        raise
    show(console, found.text)
    if MPI.COMM_WORLD.rank == 0:
        log_warnings(found.warnings)
    body = found.chosen.linear.body
    if picture and outline and body:
        from fenics_nnm.output.pictures.groups import draw_groups

        tagged, interface = body.solid.tagged, body.interface
        draw_groups(picture, tagged, outline.roles, interface, outline.casings)
        show(console, f"picture          {picture}")
    return DONE


def _refuse_picture(outline: Outline | None, picture: Path | None) -> None:
    """Refuse a picture that cannot be, before anything is computed."""
    if picture is None:
        return
    if outline is None:
        raise StudyError(f"--picture {picture}: matrices have no mesh to draw")
    if picture.suffix not in SUFFIXES:
        raise StudyError(f"--picture {picture}: must end in {' or '.join(SUFFIXES)}")
    if not picture.absolute().parent.is_dir():
        raise OutputError(f"--picture {picture}: cannot be written: there is no such folder")


def _draw_groups(outline: Outline | None, picture: Path | None, error: Exception) -> None:
    """Show the groups of a mesh that cannot be used as asked, if it can be read at all."""
    from mpi4py import MPI

    if picture is None or outline is None or MPI.COMM_WORLD.size > 1:
        return
    from fenics_nnm.output.pictures.groups import draw_groups

    with suppress(NonlinearModeError):
        draw_groups(picture, outline.mesh(MPI.COMM_WORLD), outline.roles)
        error.add_note(f"{picture} shows its groups")
