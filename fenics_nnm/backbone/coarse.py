"""The followed mode alone: a smooth branch, from which all finer levels start."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from fenics_nnm.backbone.level_solver import Guess
from fenics_nnm.backbone.levels import Level
from fenics_nnm.backbone.memory import remember
from fenics_nnm.mechanics.contact_law import Complementarity
from fenics_nnm.nonlinear.equations import harmonic_equations
from fenics_nnm.nonlinear.newton import Newton
from fenics_nnm.nonlinear.solution import Solution

#: gamma of a linear motion of unit amplitude about the state of rest: m^ = 1/2, so gamma = 1/4.
GRAZING_GAMMA = 0.25

#: Step in gamma ratio at the coarsest level, whose branch is smooth; relative above 1.
_STEP = 0.1

#: Where a motion is begun that forces besides contact make nonlinear at any energy.
_ALL_BUT_LINEAR = 1e-4

#: Motions that are kept.
_KEPT = 500

#: Parts of the reference displacement by which touching points are opened on the way to none.
_OPENED = (1.2, 1.0, 0.8, 0.6, 0.4, 0.2, 0.1, 0.05, 0.0)


@dataclass(frozen=True, slots=True)
class CoarseBranch:
    """Motions of the coarsest level, each reached in small steps from the nearest one known.

    Attributes:
        level: The coarsest level.
        mode: Index of the followed mode.
        newton: Newton's configuration.
        smallest_share: A motion with a smaller share of its kinetic energy in the first harmonic
            is not on the branch.
    """

    level: Level
    mode: int
    newton: Newton
    smallest_share: float
    _known: dict[float, Solution] = field(default_factory=dict)

    def at(self, gamma_ratio: float) -> Solution | None:
        """The motion at a gamma ratio, without the slopes of its forces; None if not reached."""
        if not self._known:
            linear = self.level.equations.rest.is_linear(self._column)
            begin = self._first_ratio
            first = self._linear_start(self.level, begin) if linear else self._touching_start()
            if not first.converged:
                return None
            self._known[begin if linear else 1.0] = first.thinned()
        at = min(self._known, key=lambda known: abs(known - gamma_ratio))
        while at != gamma_ratio:
            longest = min(_STEP * max(1.0, at), self._growth * at)
            step = np.clip(gamma_ratio - at, -longest, longest)
            following = gamma_ratio if abs(gamma_ratio - at) <= longest else float(at + step)
            solution = self._solved(self.level.scaled(self._known[at], following / at), following)
            if solution is None:
                return None
            remember(self._known, following, solution.thinned(), _KEPT)
            at = following
        return self._known[at]

    @property
    def _first_ratio(self) -> float:
        """Gamma ratio to begin at: where the motion is linear, or all but linear with forces."""
        return _ALL_BUT_LINEAR if self.level.equations.mechanics.forces else 0.5

    @property
    def _growth(self) -> float:
        """Largest relative step: without forces besides contact it is linear up to ratio 1."""
        return 1.0 if self.level.equations.mechanics.forces else np.inf

    @property
    def _column(self) -> int:
        return int(np.searchsorted(self.level.modes, self.mode))

    def _solved(self, guess: Guess, gamma_ratio: float) -> Solution | None:
        try:
            found = self.level.at_energy(gamma_ratio * GRAZING_GAMMA, guess, self.newton)
        except np.linalg.LinAlgError:
            return None
        followed = found.converged and self.level.share(found.q, self.mode) >= self.smallest_share
        return found if followed else None

    def _linear_start(self, level: Level, gamma_ratio: float) -> Solution:
        rest = level.equations.rest
        q = np.zeros(level.equations.shape)
        q[0] = rest.q
        q[1] = np.sqrt(gamma_ratio) * rest.shapes[:, self._column]
        force = np.tile(rest.force, (len(level.equations.series.phase), 1))
        guess = Guess(q, float(rest.omega[self._column]), force)
        return level.at_energy(gamma_ratio * GRAZING_GAMMA, guess, self.newton)

    def _touching_start(self) -> Solution:
        """The motion at gamma ratio 1 where points touch at rest.

        They are opened so far that they do not touch, and brought back step by step.
        """
        found = self._linear_start(_opened(self.level, 1.5), 1.0)
        for part in _OPENED:
            opened = _opened(self.level, part)
            found = opened.at_energy(GRAZING_GAMMA, Guess.of(found), self.newton)
        return found


def _opened(level: Level, part: float) -> Level:
    """A level whose touching points are opened by a part of the reference displacement."""
    equations = level.equations
    rest, model = equations.rest, equations.model
    gap = np.where(rest.touching, model.gap + part * rest.scale, model.gap)
    law = Complementarity(model.R, gap)
    opened = harmonic_equations(replace(model, gap=gap), equations.series, law)
    return replace(level, equations=opened)
