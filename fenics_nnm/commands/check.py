"""fenics-nnm check: show what a study means."""

from __future__ import annotations

import argparse

from fenics_nnm.commands.shared import DONE, Commands, add_study, console_of, show, stages_of
from fenics_nnm.study import read_study


def add_to(commands: Commands) -> None:
    """Add the command."""
    check = commands.add_parser("check", help="show what a study means, up to its linear modes")
    add_study(check)
    check.set_defaults(action=_check)


def _check(arguments: argparse.Namespace) -> int:
    from mpi4py import MPI

    from fenics_nnm.output.description import describe
    from fenics_nnm.resolution.auto import provisional

    study = read_study(arguments.study)
    console = console_of(MPI.COMM_WORLD)
    with stages_of(console, arguments) as stages:
        shown = provisional(study, MPI.COMM_WORLD, stages)
        text = describe(shown.study, shown.analysis)
    if study.automatic:
        text += (
            f'\n\n{", ".join(study.automatic)} = "auto": a run finds what a tolerance of '
            f"{study.tolerance:g} needs; this is with {shown.study.resolution}"
        )
    show(console, text)
    return DONE
