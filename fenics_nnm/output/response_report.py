"""response.csv and response.png: the motions of a driven structure."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Sequence
from pathlib import Path

from fenics_nnm.errors import OutputError
from fenics_nnm.output.pictures.response import response_plot
from fenics_nnm.output.pictures.style import DPI
from fenics_nnm.response.driven import ResponsePoint
from fenics_nnm.results.durable import replacing, write_whole

#: Columns of response.csv; other programs rely on the names.
COLUMNS = (
    "frequency_Hz",
    "monitor",
    "amplitude_m",
    "phase_deg",
    "smallest_gap_m",
    "status",
    "reason",
)


def write_response(
    folder: Path, monitors: Sequence[str], points: Sequence[ResponsePoint], *, title: str
) -> None:
    """Write the motions of a driven structure, and their picture, to a folder.

    Raises:
        OutputError: if they cannot be written.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for point in points:
        writer.writerows(_rows(monitors, point))
    try:
        folder.mkdir(parents=True, exist_ok=True)
        write_whole(folder / "response.csv", text.getvalue().encode())
        with replacing(folder / "response.png") as part:
            response_plot(monitors, points, title).savefig(part, format="png", dpi=DPI)
    except OSError as error:
        raise OutputError(f"{folder}: cannot be written: {error.strerror or error}") from error


def _rows(monitors: Sequence[str], point: ResponsePoint) -> Iterator[list[str]]:
    """Rows of a frequency, one for each point that is watched; empty where there is no number."""
    excited = len(monitors) - len(point.gap)
    gaps = [point.gap.min()] * excited + list(point.gap)
    for monitor, amplitude, phase, gap in zip(
        monitors, point.amplitude, point.phase, gaps, strict=True
    ):
        numbers = [f"{value:.12g}" if point.found else "" for value in (amplitude, phase, gap)]
        yield [f"{point.frequency:.12g}", monitor, *numbers, point.status, point.reason]
