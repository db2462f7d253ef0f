"""A branch in Python: its points, its curve, and the folder of its results."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from operator import index
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.face.arguments import number
from fenics_nnm.face.loaded import Loaded, loaded
from fenics_nnm.face.point import Point
from fenics_nnm.face.saving import save
from fenics_nnm.face.words import in_words_of_study
from fenics_nnm.results.tables import COLUMNS

if TYPE_CHECKING:
    from matplotlib.axes import Axes


_ONE_VALUE = "nearest: must be given one value, as in nearest(energy_J=1.2)"


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Branch:
    """The points of a nonlinear mode, by position along the branch.

    Made by `Study.branch` or `load_branch`. `len(branch)`, `branch[0]` and `for point in branch`
    are those of its points.

    Attributes:
        folder: Folder of the results, as `fenics-nnm run` makes it.
        frequency_Hz: Frequency of each point in Hz.
        energy_J: Total energy of each point in J.
        gamma_ratio: Modal energy coordinate of each point over its value at first contact.
        status: Status of each point: "verified", "converged", "inside resonance" or "failed".
        linear_frequency_Hz: Frequency of the linear mode that the branch begins at, in Hz.
        summary: Contents of summary.json; empty for a run that was stopped.
    """

    folder: Path
    frequency_Hz: Array
    energy_J: Array
    gamma_ratio: Array
    status: Array
    linear_frequency_Hz: float
    summary: dict[str, Any]
    _loaded: Loaded

    def __repr__(self) -> str:
        return f"Branch({len(self)} points of mode {self._loaded.results.header.mode})"

    def __len__(self) -> int:
        return len(self._loaded.results.points)

    def __getitem__(self, place: int) -> Point:
        return Point(self._loaded, self._loaded.results.points[index(place)])

    def __iter__(self) -> Iterator[Point]:
        return (Point(self._loaded, each) for each in self._loaded.results.points)

    @property
    def table(self) -> dict[str, Array]:
        """Columns of backbone.csv by name, each with an entry for every point, in full digits."""
        return {name: _column(self._loaded, name) for name in COLUMNS}

    @property
    def complete(self) -> bool:
        """Whether all points that were asked for were found."""
        return bool(self.summary.get("complete", False))

    @property
    def reason(self) -> str:
        """Why the branch ended."""
        return str(self.summary.get("reason", "the run was stopped"))

    def nearest(self, **given: float) -> Point:
        """The point at which a column of `table` is nearest to a value.

        Look at what it has: no point need be near.

        Args:
            given: One column with its value, as in `nearest(displacement_m=2e-3)`; such are
                gamma_ratio, energy_J, frequency_Hz, displacement_m and von_mises_Pa.

        Raises:
            ValueError: if it is not one column with numbers, or the value is no number.
        """
        if len(given) != 1:
            raise ValueError(_ONE_VALUE)
        ((name, wanted),) = given.items()
        try:
            value = number(name, wanted)
        except ValueError as error:
            raise ValueError(f"{_ONE_VALUE}: {error}") from error
        column = _column(self._loaded, name) if name in COLUMNS else np.empty(0)
        if column.dtype.kind not in "fi" or not np.isfinite(column).any():
            raise ValueError(f"nearest: {name} is no column of the table that has numbers")
        return self[int(np.nanargmin(np.abs(column - value)))]

    @in_words_of_study
    def save(self, folder: str | Path) -> Path:
        """Copy the results to a folder, which `load_branch` and all commands can read.

        Results of an earlier run there are replaced.

        Args:
            folder: Folder, made if there is none.

        Raises:
            StudyError: if it holds files with names of results that no run has written.
            OutputError: if it cannot be written.
        """
        save(self.folder, Path(folder))
        return Path(folder)

    def plot(self, axes: Axes | None = None, *, over: str = "gamma ratio") -> Axes:
        """Draw the frequency of the branch, with the status and stability of its points.

        Args:
            axes: Where to draw; new ones of a new figure of pyplot if not given.
            over: "gamma ratio", "energy" or "amplitude".

        Returns:
            The axes.

        Raises:
            ValueError: if `over` is none of these.
        """
        from fenics_nnm.face.plots import plot_frequency

        return plot_frequency(self._loaded.results, axes, over)


@in_words_of_study
def load_branch(folder: str | Path) -> Branch:
    """Load the results of a run, of this face or of `fenics-nnm run`.

    Args:
        folder: Folder of the results, with branch.h5.

    Raises:
        OutputError: if there is no branch, or it cannot be read or has no points.
    """
    return branch_of(loaded(Path(folder)))


def branch_of(found: Loaded) -> Branch:
    """The branch of results that were read."""
    return Branch(
        folder=found.folder,
        frequency_Hz=_column(found, "frequency_Hz"),
        energy_J=_column(found, "energy_J"),
        gamma_ratio=_column(found, "gamma_ratio"),
        status=_column(found, "status"),
        linear_frequency_Hz=found.results.linear_frequency,
        summary=found.results.summary,
        _loaded=found,
    )


def _column(found: Loaded, name: str) -> Array:
    """A column of backbone.csv, shape (points,)."""
    return np.array([COLUMNS[name].of(point) for point in found.results.points])
