"""fenics-nnm plot: pictures of a results folder."""

from __future__ import annotations

import argparse
from pathlib import Path

from fenics_nnm.commands.shared import DONE, Commands, add_verbose, console_of, show
from fenics_nnm.errors import StudyError

#: Formats of plots where none are named.
_FORMATS = "png,svg"


def add_to(commands: Commands) -> None:
    """Add the command."""
    plot = commands.add_parser("plot", help="draw the pictures of a results folder")
    plot.add_argument(
        "results", type=Path, metavar="DIR", help="results folder of a run or response"
    )
    plot.add_argument(
        "--output",
        type=Path,
        metavar="FOLDER",
        help="folder of the pictures (default: DIR/pictures)",
    )
    plot.add_argument(
        "--formats",
        default=_FORMATS,
        metavar="LIST",
        help="of png, svg, pdf (default: %(default)s)",
    )
    add_verbose(plot)
    plot.set_defaults(action=_plot)


def _plot(arguments: argparse.Namespace) -> int:
    from mpi4py import MPI

    from fenics_nnm.fem.parallel import on_root
    from fenics_nnm.output.gallery import FORMATS, MANIFEST, make_pictures
    from fenics_nnm.output.response_gallery import make_response_pictures
    from fenics_nnm.results.kinds import folder_of, is_response

    formats = tuple(dict.fromkeys(arguments.formats.split(",")))
    for name in formats:
        if name not in FORMATS:
            raise StudyError(
                f"--formats {arguments.formats}: {name!r} must be one of {', '.join(FORMATS)}"
            )
    comm, results = MPI.COMM_WORLD, folder_of(arguments.results)
    folder = arguments.output or results / "pictures"
    make = make_response_pictures if is_response(arguments.results) else make_pictures
    pictures = on_root(comm, make, results, folder, formats=formats)
    show(console_of(comm), f"{len(pictures)} pictures in {folder}; {MANIFEST} describes them")
    return DONE
