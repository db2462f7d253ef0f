"""campbell.csv, crossings.csv and campbell.png, campbell.svg: frequencies over speed."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from fenics_nnm.errors import OutputError
from fenics_nnm.output.campbell_crossings import Met, crossings_of
from fenics_nnm.output.pictures.campbell import campbell_plot
from fenics_nnm.output.pictures.style import save
from fenics_nnm.results.durable import write_whole
from fenics_nnm.structure.campbell import AtSpeed
from fenics_nnm.structure.motions_at_speed import MotionAtSpeed, Quantity

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


def write_campbell(
    folder: Path,
    points: Sequence[AtSpeed],
    orders: Sequence[int],
    *,
    title: str,
    turns: bool = False,
    lobes: Sequence[int] = (),
) -> list[Met]:
    """Write a Campbell diagram to a folder, and give its crossings.

    Args:
        folder: Folder, made where it is not there.
        points: The body at each speed.
        orders: Engine orders.
        title: Title of the picture.
        turns: Whether the picture shows speeds in turns per minute.
        lobes: Orders that are those of lobes that pass.

    Raises:
        OutputError: if it cannot be written.
    """
    found = crossings_of(points, orders)
    lines = [row for point in points for row in _rows(point)]
    marks = [_mark(each) for each in found]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        write_whole(folder / "campbell.csv", _table(COLUMNS, lines))
        write_whole(folder / "crossings.csv", _table(OF_CROSSINGS, marks))
        if any(not point.reason for point in points):
            figure = campbell_plot(points, found, orders, title, turns=turns, lobes=lobes)
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
        *(
            (*at, mode, 0, 0, f"{hertz:.12g}", f"{point.gap:.12g}", "linear")
            for mode, hertz in enumerate(point.frequencies, start=1)
        ),
        *((*at, point.mode, *_of_motion(motion, point.gap)) for motion in point.motions),
    ]


def _of_motion(motion: MotionAtSpeed, gap: float) -> tuple[str, str, str, str, str]:
    """Energy, amplitude, frequency, gap and status of a motion; of a failed one what was asked."""
    if motion.failed:
        value = f"{motion.target.value:.12g}"
        asked = (value, "") if motion.target.quantity is Quantity.ENERGY else ("", value)
        return (*asked, "", f"{gap:.12g}", f"failed: {motion.reason}")
    numbers = (motion.energy, motion.amplitude, motion.frequency, gap)
    energy, amplitude, hertz, smallest = (f"{number:.12g}" for number in numbers)
    return energy, amplitude, hertz, smallest, motion.status


def _mark(met: Met) -> tuple[object, ...]:
    numbers = (met.energy, met.amplitude, met.speed, met.frequency)
    return (met.order, met.mode, *(f"{number:.12g}" for number in numbers))


def _table(columns: Sequence[str], rows: Iterable[Sequence[object]]) -> bytes:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(rows)
    return text.getvalue().encode()
