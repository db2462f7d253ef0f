"""Pieces of a response that are not connected to its ends, from resonances on the damped backbone.

Where the damped backbone passes a level at a motion that the followed curves of this level have not
passed, there is another piece of the response. It is followed by its length from there, until it
comes back to where it began, or leaves the range of frequencies on both sides.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.fourier import FourierSeries
from fenics_nnm.nonlinear.conditions import FixedFrequency
from fenics_nnm.nonlinear.newton import Newton, solve
from fenics_nnm.nonlinear.unknowns import Unknowns
from fenics_nnm.response.curve import Follower
from fenics_nnm.response.levels import CurveEnd, Response
from fenics_nnm.response.peaks import curve_peaks
from fenics_nnm.response.point import ResponsePoint, Status
from fenics_nnm.response.structure import DrivenStructure

#: Number of the first branch that is not connected to the ends of the range.
FIRST_BRANCH = 3

#: Motions at one frequency that differ by less than this part of their size are the same.
_SAME = 1e-3

_NEAR = Newton(tolerance=1e-12, round_off=1e-10, iterations=25)


def with_isolas(
    structure: DrivenStructure,
    series: FourierSeries,
    frequencies: Array,
    found: Response,
    *,
    on_progress: Callable[[float], None] = lambda part: None,
) -> Response:
    """A response with the pieces that its damped backbone leads to.

    Args:
        structure: Driven structure at level 1.
        series: Series in time.
        frequencies: Wanted frequencies in Hz, ascending, shape (f,).
        found: Its response, with the damped backbone.
        on_progress: Called with the part that is done.
    """
    whole = Response((), backbone=found.backbone)
    for number, level in enumerate(found.levels):
        own = found.only((level,))
        wanted = [each.point for each in found.backbone.points if _may_lead_on(each.point, level)]
        if wanted and len(frequencies) > 1 and not structure.objection:
            follower = Follower.of(structure.at_level(level), series, frequencies)
            own = _Pieces(follower, level).added(own, wanted)
        whole = whole.followed_by(own)
        on_progress((number + 1) / len(found.levels))
    return whole


def _may_lead_on(point: ResponsePoint, level: float) -> bool:
    """Whether a motion in phase resonance is one of a level, with contact."""
    touches = bool(point.displacements.contact.max(initial=0.0) > 0)
    return point.level == level and touches and point.status is not Status.FAILED


@dataclass(frozen=True, slots=True)
class _Pieces:
    """What looks for pieces of the response at a level.

    Attributes:
        follower: What follows them.
        level: Factor of the forces.
    """

    follower: Follower
    level: float

    def added(self, own: Response, resonances: Sequence[ResponsePoint]) -> Response:
        """The response of the level with the pieces that its resonances lead to."""
        for resonance in resonances:
            if self._passes(own.points, resonance):
                continue
            branch = max(FIRST_BRANCH, 1 + max((p.branch for p in own.points), default=0))
            own = own.followed_by(self._piece(resonance, branch))
        return own

    def _passes(self, points: Sequence[ResponsePoint], resonance: ResponsePoint) -> bool:
        """Whether a curve goes through a motion between two of its points."""
        return any(self._meets(*pair, resonance) for pair in _around(points, resonance.omega))

    def _meets(self, first: ResponsePoint, second: ResponsePoint, resonance: ResponsePoint) -> bool:
        part = (resonance.omega - first.omega) / (second.omega - first.omega)
        guess = Unknowns.of(first.q + part * (second.q - first.q), resonance.omega)
        condition = FixedFrequency(resonance.omega)
        found = solve(self.follower.equations, condition, guess, options=_NEAR)
        apart = float(np.linalg.norm(found.q - resonance.q))
        return found.converged and apart < _SAME * float(np.linalg.norm(resonance.q))

    def _piece(self, resonance: ResponsePoint, branch: int) -> Response:
        """The piece through a motion."""
        at = Unknowns.of(resonance.q, resonance.omega)
        condition = FixedFrequency(resonance.omega)
        start = solve(self.follower.equations, condition, at, options=_NEAR)
        where = f"branch {branch} from {resonance.frequency:.6g} Hz"
        if start.failure:
            return Response((), (), (CurveEnd(f"{where}: {start.failure}", self.level),))
        found = self.follower.piece(start)
        points = [replace(each, level=self.level, branch=branch) for each in found.points]
        others = self.follower.structure.watched.before_contact
        reasons = (CurveEnd(f"{where}: {found.reason}", self.level),) if found.reason else ()
        return Response(tuple(points), tuple(curve_peaks(points, others)), reasons)


def _around(
    points: Sequence[ResponsePoint], omega: float
) -> Iterator[tuple[ResponsePoint, ResponsePoint]]:
    """Neighbours on a curve with a frequency between them."""
    for first, second in itertools.pairwise(points):
        together = first.branch == second.branch and first.found and second.found
        between = (first.omega - omega) * (second.omega - omega) <= 0
        if together and between and first.omega != second.omega:
            yield first, second
