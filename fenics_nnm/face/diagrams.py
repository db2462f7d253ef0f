"""Campbell diagrams and sweeps in Python: the tables that the commands have written."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fenics_nnm.face.tables import Table, read_table
from fenics_nnm.face.words import in_words_of_study

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from fenics_nnm.face.branch import Branch
    from fenics_nnm.face.response import Response

#: Columns that the tables of a Campbell diagram have at least.
_OF_LINES = ("speed_rad_s", "rpm", "mode", "energy_J", "frequency_Hz", "status")
_OF_CROSSINGS = ("engine_order", "mode", "speed_rad_s", "frequency_Hz")


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Campbell:
    """A Campbell diagram, as `fenics-nnm campbell` has written it.

    Attributes:
        folder: Its folder.
        table: Columns of campbell.csv, a row for each speed and mode; energy_J is 0 in linear ones.
        crossings: Columns of crossings.csv: where engine orders meet the lines.
    """

    folder: Path
    table: Table
    crossings: Table

    def __repr__(self) -> str:
        speeds = len(np.unique(self.table["speed_rad_s"]))
        return f"Campbell({speeds} speeds, {len(self.crossings['mode'])} crossings)"

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw frequencies over speed: linear lines, points of nonlinear modes, crossings.

        Args:
            axes: Where to draw; new ones of a new figure of pyplot if not given.

        Returns:
            The axes.
        """
        from fenics_nnm.face.plots import plot_campbell

        return plot_campbell(self.table, self.crossings, axes)


@in_words_of_study
def load_campbell(folder: str | Path) -> Campbell:
    """Load the tables that `fenics-nnm campbell` has written.

    Raises:
        OutputError: if they are not there, or cannot be read.
    """
    place = Path(folder)
    table = read_table(place / "campbell.csv", _OF_LINES)
    return Campbell(place, table, read_table(place / "crossings.csv", _OF_CROSSINGS))


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Sweep:
    """The studies of a sweep, as `fenics-nnm sweep` has run them.

    Attributes:
        folder: Its folder.
        table: Columns of sweep.csv, a row for each study.
    """

    folder: Path
    table: Table

    def __repr__(self) -> str:
        return f"Sweep({len(self)} studies)"

    def __len__(self) -> int:
        return len(self.table["folder"])

    def branch(self, row: int) -> Branch:
        """The branch of the study of a row.

        Raises:
            OutputError: if there is none, or it cannot be read.
        """
        from fenics_nnm.face.branch import load_branch

        return load_branch(self._at(row))

    def response(self, row: int) -> Response:
        """The response of the study of a row.

        Raises:
            OutputError: if there is none, or it cannot be read.
        """
        from fenics_nnm.face.response import load_response

        return load_response(self._at(row))

    def _at(self, row: int) -> Path:
        return self.folder / str(self.table["folder"][row])


@in_words_of_study
def load_sweep(folder: str | Path) -> Sweep:
    """Load the table that `fenics-nnm sweep` has written.

    Raises:
        OutputError: if it is not there, or cannot be read.
    """
    return Sweep(Path(folder), read_table(Path(folder) / "sweep.csv", ("folder", "status")))
