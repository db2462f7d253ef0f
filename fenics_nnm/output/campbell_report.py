"""campbell.csv, crossings.csv and campbell.png, campbell.svg: frequencies over speed."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.errors import OutputError
from fenics_nnm.output.pictures.campbell import campbell_plot
from fenics_nnm.output.pictures.style import save
from fenics_nnm.reduction.mode_lines import Crossing, crossings
from fenics_nnm.results.durable import write_whole
from fenics_nnm.structure.campbell import AtSpeed

#: Columns of campbell.csv; energy 0 is the linear mode. Other programs rely on the names.
COLUMNS = (
    "speed_rad_s",
    "rpm",
    "mode",
    "energy_J",
    "amplitude_m",
    "frequency_Hz",
    "smallest_gap_m",
    "status",
)

#: Columns of crossings.csv.
OF_CROSSINGS = (
    "engine_order",
    "mode",
    "energy_J",
    "amplitude_m",
    "speed_rad_s",
    "frequency_Hz",
)


def lines_of(points: Sequence[AtSpeed]) -> tuple[Array, Array]:
    """Speeds in rad/s and frequencies in Hz, shape (s, k), of speeds with a static state."""
    found = [point for point in points if not point.reason]
    speeds = np.array([point.speed for point in found])
    return speeds, np.array([point.frequencies for point in found])


def crossings_of(points: Sequence[AtSpeed], orders: Iterable[int]) -> list[Crossing]:
    """Where engine orders meet modes, by order, mode and speed."""
    speeds, frequencies = lines_of(points)
    if not len(speeds):
        return []
    return [each for order in orders for each in crossings(speeds, frequencies, order)]


def write_campbell(
    folder: Path,
    points: Sequence[AtSpeed],
    orders: Sequence[int],
    *,
    title: str,
    turns: bool = False,
) -> list[Crossing]:
    """Write a Campbell diagram to a folder, and give its crossings.

    Args:
        folder: Folder, made where it is not there.
        points: The body at each speed.
        orders: Engine orders.
        title: Title of the picture.
        turns: Whether the picture shows speeds in turns per minute.

    Raises:
        OutputError: if it cannot be written.
    """
    found = crossings_of(points, orders)
    lines = [row for point in points for row in _rows(point)]
    marks = [
        (each.order, each.mode + 1, 0, 0, f"{each.speed:.12g}", f"{each.frequency:.12g}")
        for each in found
    ]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        write_whole(folder / "campbell.csv", _table(COLUMNS, lines))
        write_whole(folder / "crossings.csv", _table(OF_CROSSINGS, marks))
        if len(lines_of(points)[0]):
            figure = campbell_plot(points, found, orders, title, turns=turns)
            save(figure, folder, "campbell", ("png", "svg"))
    except OSError as error:
        raise OutputError(f"{folder}: cannot be written: {error.strerror or error}") from error
    return found


def _rows(point: AtSpeed) -> list[tuple[object, ...]]:
    """Rows of a speed, one a mode; one without a mode where there is no static state."""
    at = (f"{point.speed:.12g}", f"{point.speed * 30 / np.pi:.12g}")
    if point.reason:
        return [(*at, "", "", "", "", "", f"failed: {point.reason}")]
    return [
        (*at, mode, 0, 0, f"{hertz:.12g}", f"{point.gap:.12g}", "linear")
        for mode, hertz in enumerate(point.frequencies, start=1)
    ]


def _table(columns: Sequence[str], rows: Iterable[Sequence[object]]) -> bytes:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(rows)
    return text.getvalue().encode()
