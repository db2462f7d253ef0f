"""fenics-nnm new: begin with a study that runs."""

from __future__ import annotations

import argparse
from pathlib import Path

from fenics_nnm.commands.shared import DONE, Commands, add_verbose, console_of, show
from fenics_nnm.errors import OutputError, StudyError
from fenics_nnm.templates import KINDS, ROTORS, write_template


def add_to(commands: Commands) -> None:
    """Add the command."""
    new = commands.add_parser("new", help="write a commented study that runs, to begin with")
    new.add_argument("kind", choices=KINDS, metavar="KIND", help=", ".join(KINDS))
    new.add_argument(
        "target",
        type=Path,
        nargs="?",
        default=Path(),
        metavar="FOLDER|STUDY.toml",
        help="where; never overwrites (default: this folder)",
    )
    new.add_argument(
        "--rotor", type=int, choices=ROTORS, help="blade: NASA rotor 37 (default) or 67"
    )
    add_verbose(new)
    new.set_defaults(action=_new)


def _new(arguments: argparse.Namespace) -> int:
    from mpi4py import MPI

    from fenics_nnm.fem.parallel import on_root

    if arguments.rotor is not None and arguments.kind != "blade":
        raise StudyError(f"--rotor {arguments.rotor}: belongs to blade, not to {arguments.kind}")
    rotor = arguments.rotor or ROTORS[0]
    comm = MPI.COMM_WORLD
    try:
        files = on_root(comm, write_template, arguments.kind, arguments.target, rotor=rotor)
    except OSError as error:
        named = error.filename or arguments.target
        raise OutputError(f"{named}: cannot be written: {error.strerror or error}") from error
    console = console_of(comm)
    for file in files:
        show(console, f"wrote {file}")
    show(console, f"next: fenics-nnm check {files[0]}")
    return DONE
