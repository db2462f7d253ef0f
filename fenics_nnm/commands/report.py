"""fenics-nnm report: one HTML page about a results folder."""

from __future__ import annotations

import argparse
from pathlib import Path

from fenics_nnm.commands.shared import DONE, Commands, add_verbose, console_of, show
from fenics_nnm.errors import StudyError

#: Endings of a page: a file of another name may be a study or data, which a page would replace.
_SUFFIXES = (".html", ".htm")


def add_to(commands: Commands) -> None:
    """Add the command."""
    report = commands.add_parser("report", help="write an HTML page about a results folder")
    report.add_argument(
        "results", type=Path, metavar="DIR", help="results folder of a run or response"
    )
    report.add_argument(
        "--output", type=Path, metavar="FILE.html", help="the page (default: DIR/report.html)"
    )
    add_verbose(report)
    report.set_defaults(action=_report)


def _report(arguments: argparse.Namespace) -> int:
    from mpi4py import MPI

    from fenics_nnm.fem.parallel import on_root
    from fenics_nnm.output.html_report.report import write_report
    from fenics_nnm.output.html_report.response import write_response_report
    from fenics_nnm.results.kinds import folder_of, is_response

    comm, results = MPI.COMM_WORLD, folder_of(arguments.results)
    file = arguments.output or results / "report.html"
    if file.suffix.lower() not in _SUFFIXES:
        raise StudyError(f"--output {file}: must end in {' or '.join(_SUFFIXES)}")
    write = write_response_report if is_response(arguments.results) else write_report
    on_root(comm, write, results, file)
    show(console_of(comm), f"report in {file}")
    return DONE
