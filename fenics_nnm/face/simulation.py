"""A simulation in Python: a driven structure in time."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from fenics_nnm.face.tables import Table, read_table

#: Columns that its table has at least.
_COLUMNS = ("way", "period", "time_s", "frequency_Hz", "monitor", "max_m", "poincare_m")


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Simulation:
    """A driven structure in time; made by `Study.simulate`.

    Attributes:
        folder: Its folder, as `fenics-nnm simulate` makes it.
        table: Columns of simulation.csv, a row for each period and monitored place.
        settled: Where a motion at constant frequency has come to, in words; empty in a sweep.
        failure: Why it was given up; empty if it was not.
    """

    folder: Path
    table: Table
    settled: str
    failure: str

    def __repr__(self) -> str:
        return f"Simulation({len(set(self.table['time_s']))} periods)"


def simulation_of(folder: Path, settled: str, failure: str) -> Simulation:
    """The simulation in a folder.

    Raises:
        OutputError: if its table cannot be read.
    """
    return Simulation(folder, read_table(folder / "simulation.csv", _COLUMNS), settled, failure)
