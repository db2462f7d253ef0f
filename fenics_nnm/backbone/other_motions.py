"""Other motions of the energy of a point: out of its resonance, and along a neighbour's family.

At one energy many motions coexist beside the wanted one: those of the tongues of internal
resonances, each of which holds one mode and harmonic. Where one of them was found

* a motion beside it is sought from the same coefficients without one of those that hold most
  energy besides the followed mode;
* the family of a neighbouring point is followed by its length to the energy. That leads through
  folds, and along tongues, where the frequency stands still and a step in energy fails.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fenics_nnm.backbone.cascade import Cascade, refusal
from fenics_nnm.backbone.coarse import GRAZING_GAMMA
from fenics_nnm.backbone.frequency_cascade import PATIENCE
from fenics_nnm.backbone.level_solver import Guess
from fenics_nnm.backbone.levels import Level
from fenics_nnm.backbone.point import FAILED, VERIFIED, BranchPoint
from fenics_nnm.backbone.point_maker import PointMaker
from fenics_nnm.continuation.heading import Uphill
from fenics_nnm.continuation.trace import NoRules, trace
from fenics_nnm.continuation.trace_options import ArcLength, Bound, Range
from fenics_nnm.errors import ModelError
from fenics_nnm.nonlinear.conditions import GAMMA
from fenics_nnm.nonlinear.solution import Solution
from fenics_nnm.nonlinear.unknowns import Unknowns

#: So many coefficients are left out of a motion, one after the other.
_PARTS = 3

#: Steps along a neighbour's family. Where shorter ones are needed hundreds of them are.
_STEPS = ArcLength(step=0.05, smallest_step=0.005, largest_step=0.2, points=12)

#: Motions whose frequencies differ by less than this part are the same.
_SAME = 1e-7


@dataclass(frozen=True, slots=True)
class OtherMotions:
    """Finds other motions of the energy of a point.

    Attributes:
        cascade: Levels; the motions are those of the finest.
        maker: Makes points of solutions.
    """

    cascade: Cascade
    maker: PointMaker

    @property
    def able(self) -> bool:
        """Whether there are such motions, and they can be sought without the levels."""
        finest = self.cascade.levels[-1]
        return finest.solver.reduced and not finest.equations.rest.homogeneous

    def of(self, points: Sequence[BranchPoint], i: int) -> Iterator[BranchPoint]:
        """Motions of the energy of a point that may be on its branch, each once.

        Args:
            points: Points of a branch with their verdicts.
            i: Number of the point.
        """
        ratio, known = points[i].gamma_ratio, [points[i].frequency_ratio]
        for guess in self._guesses(points, i):
            found = self._solved(ratio, guess)
            if found is None or any(abs(found.omega / each - 1) < _SAME for each in known):
                continue
            known.append(found.omega)
            slope = self.cascade.slope_ratio(found)
            yield self.maker.point(points[i].position, ratio, found, slope_ratio=slope)

    def _guesses(self, points: Sequence[BranchPoint], i: int) -> Iterator[Guess]:
        """Where the iterations start."""
        level, mode = self.cascade.levels[-1], self.cascade.mode
        yield from _reduced(level, mode, self.maker.solution(points[i]))
        for neighbour in _leading(points, i):
            if neighbour.gamma_ratio > self.cascade.belonging.linear_until:
                yield from self._followed(neighbour, points[i].gamma_ratio)

    def _solved(self, ratio: float, guess: Guess) -> Solution | None:
        """The motion that a guess leads to, if that may be on the branch."""
        finest, newton = self.cascade.levels[-1], self.cascade.newton
        patient = replace(newton, patience=PATIENCE)
        try:
            found = finest.at_energy(ratio * GRAZING_GAMMA, guess, patient)
        except np.linalg.LinAlgError:
            return None
        number = len(self.cascade.levels) - 1
        if found.failure or refusal(self.cascade, number, ratio, found):
            return None
        return found

    def _followed(self, neighbour: BranchPoint, ratio: float) -> Iterator[Guess]:
        """The motion at which the family of a neighbour comes to an energy, if it does."""
        finest, newton = self.cascade.levels[-1], self.cascade.newton
        start = self.maker.solution(neighbour).completed(finest.equations)
        low, high = sorted((start.energies.gamma, ratio * GRAZING_GAMMA))
        try:
            path = trace(
                finest.problem(newton),
                start,
                Uphill(GAMMA, falls=ratio < neighbour.gamma_ratio),
                options=replace(_STEPS, newton=newton),
                bounds=(Bound(GAMMA, Range(low, high)),),
                events=(),
                rules=NoRules(),
            )
            yield from (Guess.of(point.solution) for point in path if point.target)
        except (ModelError, np.linalg.LinAlgError):
            return


def _leading(points: Sequence[BranchPoint], i: int) -> Iterator[BranchPoint]:
    """Neighbours whose families may lead to another motion: above first.

    Those that are verified do, and all others to a point that is no motion. To one that is not
    confirmed also those of other families; to one that is these end in resonances as well.
    """
    here = points[i]
    for k in (i + 1, i - 1):
        if not 0 <= k < len(points) or points[k].status == FAILED:
            continue
        elsewhere = points[k].family != here.family and not here.confirmed
        if points[k].status == VERIFIED or here.status == FAILED or elsewhere:
            yield points[k]


def _reduced(level: Level, mode: int, known: Solution) -> Iterator[Guess]:
    """A motion without one of its largest coefficients, brought back to its energy."""
    series, rest = level.equations.series, level.equations.rest
    by_mode = known.q @ rest.shapes
    kinetic = (series.mean_square * series.order**2)[:, None] * by_mode**2
    kinetic[series.order == 1, mode] = 0.0
    for part in np.argsort(kinetic, axis=None)[::-1][:_PARTS]:
        row, column = np.unravel_index(part, kinetic.shape)
        q = known.q.copy()
        q[row] -= by_mode[row, column] * rest.shapes[:, column]
        left = level.equations.energy.gamma(Unknowns.of(q, known.omega))
        factor = float(np.sqrt(known.energies.gamma / left))
        yield Guess(rest.scaled(q, factor), known.omega, known.forces.force)
