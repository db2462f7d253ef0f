"""simulation.csv, simulation.png and state.npz: a driven structure in time."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from fenics_nnm.errors import OutputError
from fenics_nnm.output.pictures.simulation import simulation_plot
from fenics_nnm.output.pictures.style import DPI
from fenics_nnm.response.simulation import Period
from fenics_nnm.results.durable import replacing, write_whole
from fenics_nnm.structure.simulated import STATE_FILE, Leg, Simulated

#: Columns of simulation.csv; other programs rely on the names.
COLUMNS = (
    "way",
    "period",
    "time_s",
    "frequency_Hz",
    "monitor",
    "max_m",
    "min_m",
    "poincare_m",
    "poincare_m_s",
    "contact_fraction",
    "energy_J",
)


def write_simulation(folder: Path, names: Sequence[str], found: Simulated, *, title: str) -> None:
    """Write a simulation, its picture and its last state to a folder.

    Raises:
        OutputError: if they cannot be written.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for leg in found.legs:
        for number, period in enumerate(leg.found.periods, start=1):
            writer.writerows(_rows(leg, number, period, names))
    try:
        folder.mkdir(parents=True, exist_ok=True)
        write_whole(folder / "simulation.csv", text.getvalue().encode())
        write_whole(folder / STATE_FILE, _state(found))
        with replacing(folder / "simulation.png") as part:
            simulation_plot(names, found, title).savefig(part, format="png", dpi=DPI)
    except OSError as error:
        raise OutputError(f"{folder}: cannot be written: {error.strerror or error}") from error


def _rows(leg: Leg, number: int, period: Period, names: Sequence[str]) -> Iterator[list[str]]:
    """Rows of a period, one for each place that is watched."""
    for place, name in enumerate(names):
        numbers = (
            period.largest[place],
            period.least[place],
            period.section[place],
            period.section_speed[place],
            period.contact_fraction,
            period.energy,
        )
        shown = [f"{value:.12g}" for value in numbers]
        begun = f"{period.time:.12g}", f"{period.frequency:.12g}"
        yield [leg.name, str(number), *begun, name, *shown]


def _state(found: Simulated) -> bytes:
    """The last state, with the natural frequencies that tell its structure."""
    last, file = found.legs[-1].found, io.BytesIO()
    np.savez(file, q=last.q, velocity=last.velocity, omega=found.omega)
    return file.getvalue()
