"""Of several motions at one position, the one that is on the branch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fenics_nnm.backbone.belonging import Belonging
from fenics_nnm.backbone.cascade_solution import CascadeSolution
from fenics_nnm.backbone.levels import Level
from fenics_nnm.backbone.resonance import STILL, Resonance, strongest_resonance
from fenics_nnm.nonlinear.solution import Solution


@dataclass(frozen=True, slots=True)
class Selection:
    """Compares motions of the finest level.

    Attributes:
        belonging: Thresholds.
        finest: The finest level.
        mode: Index of the followed mode.
    """

    belonging: Belonging
    finest: Level
    mode: int

    def share(self, solution: Solution) -> float:
        """Share of the kinetic energy of a finest motion in the first harmonic of its mode."""
        return self.finest.share(solution.q, self.mode)

    def doubtful(self, found: CascadeSolution, neighbour: CascadeSolution | None) -> bool:
        """Whether a motion is missing, or may be inside an internal resonance."""
        if found.finest is None:
            return True
        if neighbour is not None and found.has_lost_share(neighbour):
            return True
        if self._jumps(found, neighbour):
            return True
        strength = self._resonance(found.finest).strength
        return strength > self.belonging.suspect or found.slope_ratio < STILL

    def best(
        self, found: Sequence[CascadeSolution], neighbour: CascadeSolution | None = None
    ) -> CascadeSolution:
        """Of several motions the one that keeps most of its energy in the followed mode.

        Where closed points lift off this share falls along the branch, and the motions that stay
        behind in a resonance have the larger one. There it is the motion whose frequency is near
        that of the neighbour, and outside resonances if there is one.

        Args:
            found: Motions at one position. The strongest internal resonance among those that are
                left is named.
            neighbour: Motion at a position nearby.
        """
        best = max(found, key=lambda each: self._rank(each, neighbour))
        if best.finest is None or self._resonance(best.finest).entered:
            return best
        left = [self._resonance(each.finest) for each in found if each.finest is not None]
        left = [resonance for resonance in left if resonance.entered]
        left += [self._resonance(each.refused) for each in found if each.refused is not None]
        strongest = max(left, key=lambda resonance: resonance.share, default=None)
        return replace(best, skipped=str(strongest)) if strongest else best

    def _jumps(self, found: CascadeSolution, neighbour: CascadeSolution | None) -> bool:
        """Whether the frequency leaves that of the neighbour, where closed points lift off."""
        beyond = self.belonging.lifts_off and found.gamma_ratio > self.belonging.linear_until
        return beyond and found.frequency_change(neighbour) > self.belonging.frequency_jump

    def _rank(
        self, found: CascadeSolution, neighbour: CascadeSolution | None
    ) -> tuple[bool, bool, float]:
        """By which the better of two motions is known."""
        if found.finest is None or not self.belonging.lifts_off:
            return False, False, found.share
        outside = not self._resonance(found.finest).entered
        change = found.frequency_change(neighbour)
        if np.isnan(change):
            return False, outside, found.share
        return change < self.belonging.far, outside, 1 - change

    def _resonance(self, solution: Solution) -> Resonance:
        """The internal resonance that draws most energy from a finest motion."""
        model, series = self.finest.equations.model, self.finest.equations.series
        return strongest_resonance(model, series, solution.q, solution.omega, mode=self.mode)
