"""response.csv, resonance.csv and response.png: the motions of a driven structure."""

from __future__ import annotations

import csv
import io
import itertools
from collections.abc import Iterator, Sequence
from pathlib import Path

from fenics_nnm.errors import OutputError
from fenics_nnm.output.pictures.response import response_plot
from fenics_nnm.output.pictures.style import DPI
from fenics_nnm.output.resonance_report import known, resonance_table
from fenics_nnm.response.levels import Response
from fenics_nnm.response.phase_resonance import DampedBackbone
from fenics_nnm.response.point import ResponsePoint
from fenics_nnm.results.durable import replacing, write_whole

#: Columns of response.csv; other programs rely on the names.
COLUMNS = (
    "level",
    "branch",
    "point",
    "frequency_Hz",
    "speed_rad_s",
    "monitor",
    "amplitude_m",
    "phase_deg",
    "max_m",
    "min_m",
    "contact_fraction",
    "smallest_gap_m",
    "largest_multiplier",
    "stability",
    "energy_balance",
    "event",
    "status",
    "reason",
)


def write_response(folder: Path, monitors: Sequence[str], found: Response, *, title: str) -> None:
    """Write the motions of a driven structure, and their picture, to a folder.

    A resonance.csv of before goes where there is no damped backbone, and a picture where no motion
    was found.

    Raises:
        OutputError: if they cannot be written.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for _, own in itertools.groupby(found.points, key=lambda point: (point.level, point.branch)):
        for number, point in enumerate(own, start=1):
            writer.writerows(_rows(monitors, point, number))
    try:
        folder.mkdir(parents=True, exist_ok=True)
        write_whole(folder / "response.csv", text.getvalue().encode())
        _write_backbone(folder / "resonance.csv", found.backbone)
        _draw(folder / "response.png", monitors, found, title)
    except OSError as error:
        raise OutputError(f"{folder}: cannot be written: {error.strerror or error}") from error


def _draw(file: Path, monitors: Sequence[str], found: Response, title: str) -> None:
    if not found.points:
        file.unlink(missing_ok=True)
        return
    with replacing(file) as part:
        response_plot(monitors, found, title).savefig(part, format="png", dpi=DPI)


def _write_backbone(file: Path, backbone: DampedBackbone) -> None:
    if backbone.points:
        write_whole(file, resonance_table(backbone).encode())
    else:
        file.unlink(missing_ok=True)


def _rows(monitors: Sequence[str], point: ResponsePoint, number: int) -> Iterator[list[str]]:
    """Rows of a motion, one for each place that is watched; empty where there is no number."""
    moved = point.displacements
    others = len(monitors) - len(point.gap)
    gaps = [point.gap.min()] * others + list(point.gap)
    for place, monitor in enumerate(monitors):
        numbers = (
            point.amplitude[place],
            point.phase[place],
            moved.highest[place],
            moved.lowest[place],
            moved.contact[place],
            gaps[place],
        )
        yield [
            f"{point.level:.12g}",
            str(point.branch),
            str(number),
            f"{point.frequency:.12g}",
            known(point.speed),
            monitor,
            *(known(value) if point.found else "" for value in numbers),
            known(point.judgement.largest_multiplier),
            point.judgement.stability,
            f"{point.imbalance:.2e}" if point.found else "",
            point.event,
            point.status,
            point.reason,
        ]
