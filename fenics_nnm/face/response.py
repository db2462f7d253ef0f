"""The response of a driven structure in Python: its curves, peaks and damped backbone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.face.response_curve import ResponseCurve, curve_of
from fenics_nnm.face.tables import Table
from fenics_nnm.face.temporary import Folder
from fenics_nnm.face.words import in_words_of_study
from fenics_nnm.output.pictures.response import curves_of
from fenics_nnm.output.response_gallery import stored_response
from fenics_nnm.response.phase_resonance import Resonance
from fenics_nnm.results.response_file import StoredResponse

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Response:
    """Motions of a driven structure over frequency; made by `Study.response` or `load_response`.

    Attributes:
        folder: Folder of the results, as `fenics-nnm response` makes it.
        levels: Factors of the forces, in the order of the results, shape (L,).
        places: Names of the places that are watched: those of the forces, further ones, contact
            points.
        lines: What was said of the response: what is missing, and notes.
    """

    folder: Path
    levels: Array
    places: tuple[str, ...]
    lines: tuple[str, ...]
    _stored: StoredResponse
    _kept: Folder

    def __repr__(self) -> str:
        points = len(self._stored.found.points)
        return f"Response({points} points at {len(self.levels)} levels)"

    def curves(
        self, *, level: float | None = None, place: str | None = None
    ) -> tuple[ResponseCurve, ...]:
        """Curves of a place at a level, or at all levels.

        Args:
            level: One of `levels`; all if not given.
            place: One of `places`; the first if not given.

        Raises:
            ValueError: if there is no such level or place.
        """
        number = self._place(place)
        levels = [float(each) for each in self.levels]
        if level is not None and level not in levels:
            raise ValueError(f"level = {level!r}: must be one of {', '.join(map(repr, levels))}")
        points = self._stored.found.points
        return tuple(
            curve_of(own, self.places[number], number)
            for each in (levels if level is None else [level])
            for own in curves_of(points, each)
        )

    @property
    def peaks(self) -> Table:
        """Peaks of the curves: level, place, frequency_Hz, amplitude_m and phase_deg."""
        found = self._stored.found.peaks
        return {
            "level": np.array([peak.level for peak in found]),
            "place": np.array([self.places[peak.monitor] for peak in found], dtype=str),
            "frequency_Hz": np.array([peak.frequency for peak in found]),
            "amplitude_m": np.array([peak.amplitude for peak in found]),
            "phase_deg": np.array([peak.phase for peak in found]),
        }

    @property
    def resonances(self) -> Table:
        """The damped backbone: columns of resonance.csv with numbers; no rows if there is none."""
        found = self._stored.found.backbone.points
        return {name: np.array([of(each) for each in found]) for name, of in _RESONANCE.items()}

    def plot(self, axes: Axes | None = None, *, place: str | None = None) -> Axes:
        """Draw the amplitude of a place over frequency at all levels; unstable motions dashed.

        Args:
            axes: Where to draw; new ones of a new figure of pyplot if not given.
            place: One of `places`; the first if not given. The damped backbone is that of the
                first.

        Returns:
            The axes.

        Raises:
            ValueError: if there is no such place.
        """
        from fenics_nnm.face.plots import plot_response

        curves = self.curves(place=place)
        return plot_response(curves, {} if self._place(place) else self.resonances, axes)

    def _place(self, name: str | None) -> int:
        if name is None:
            return 0
        if name not in self.places:
            known = ", ".join(map(repr, self.places))
            raise ValueError(f"place = {name!r}: must be one of {known}")
        return self.places.index(name)


#: Columns of `Response.resonances`, by those of resonance.csv.
_RESONANCE: dict[str, Callable[[Resonance], float]] = {
    "level": lambda each: each.point.level,
    "branch": lambda each: each.point.branch,
    "frequency_Hz": lambda each: each.point.frequency,
    "speed_rad_s": lambda each: each.point.speed,
    "amplitude_m": lambda each: each.point.amplitude[0],
    "max_m": lambda each: each.point.displacements.highest[0],
    "contact_fraction": lambda each: each.point.displacements.contact[0],
    "resonance_force_N": lambda each: each.force,
    "damping_ratio": lambda each: each.damping_ratio,
}


@in_words_of_study
def load_response(folder: str | Path) -> Response:
    """Load the results of a response, of this face or of `fenics-nnm response`.

    Args:
        folder: Folder of the results, with response.h5.

    Raises:
        OutputError: if there is no response, or it cannot be read or has no points.
    """
    return response_of(Folder(Path(folder)))


def response_of(kept: Folder) -> Response:
    """The response in a folder.

    Raises:
        OutputError: if it cannot be read.
    """
    stored = stored_response(kept.path)
    found = stored.found
    return Response(
        folder=kept.path,
        levels=np.array(found.levels),
        places=stored.watched.names,
        lines=tuple(stored.lines),
        _stored=stored,
        _kept=kept,
    )
