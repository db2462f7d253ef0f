"""The Campbell diagram beside a results folder."""

from __future__ import annotations

import csv
from pathlib import Path

from fenics_nnm.errors import OutputError
from fenics_nnm.output.html_report.elements import Column, Html, table
from fenics_nnm.output.html_report.figures import Gallery
from fenics_nnm.output.html_report.page import Section
from fenics_nnm.output.picture import Picture

#: Columns of the table, by those of crossings.csv.
_COLUMNS = {
    "engine_order": Column("engine order"),
    "mode": Column("mode"),
    "energy_J": Column("energy (J)"),
    "amplitude_m": Column("amplitude (m)"),
    "speed_rad_s": Column("speed (rad/s)"),
    "frequency_Hz": Column("frequency (Hz)"),
}


def campbell(results: Path) -> tuple[Section, ...]:
    """The diagram that `fenics-nnm campbell` wrote to NAME-campbell beside NAME, if it did.

    Raises:
        OutputError: if it cannot be read.
    """
    place = results.resolve()
    folder = place.with_name(f"{place.name}-campbell")
    if not (folder / "campbell.svg").exists():
        return ()
    caption = (
        f"As fenics-nnm campbell has left it in {folder.name}. Linear lines, nonlinear lines at "
        "their energies or largest displacements, engine orders (dashed) and where they meet "
        "lines; the smallest gap at rest beside them."
    )
    picture = Picture("campbell.svg", "Frequencies over speed", caption, "frequency")
    content = Gallery(folder, (picture,)).figures("frequency") + _crossings(folder)
    return (Section("campbell", "Campbell diagram", content),)


def _crossings(folder: Path) -> tuple[Html, ...]:
    path = folder / "crossings.csv"
    try:
        found = list(csv.DictReader(path.read_text("utf-8").splitlines()))
        rows = [tuple(f"{float(row[name]):.6g}" for name in _COLUMNS) for row in found]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise OutputError(f"{path}: cannot be read: {error}") from error
    columns = tuple(_COLUMNS.values())
    return (table(columns, rows, label="Engine orders meet lines"),) if rows else ()
