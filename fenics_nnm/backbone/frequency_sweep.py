"""One point of a branch at a given frequency, from the coarsest level to the finest.

At fixed frequency the narrow tongues of internal resonances are crossed, not climbed. The motion at
rest, and linear motions, have to be refused instead: at a linear frequency they solve the
equations too.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from fenics_nnm.backbone.cascade import Lift, Stack
from fenics_nnm.backbone.coarse import GRAZING_GAMMA
from fenics_nnm.backbone.frequency_lift import FrequencyLift
from fenics_nnm.backbone.levels import Guess, Level
from fenics_nnm.nonlinear.conditions import FixedFrequency
from fenics_nnm.nonlinear.solution import Solution

#: The single-mode motion of a frequency is sought up to this gamma ratio, by steps of this factor.
_LARGEST_RATIO = 1e4
_FACTOR = 1.1

#: Steps of the search between two of these energies.
_HALVINGS = 60


@dataclass(frozen=True, slots=True)
class FrequencySweep:
    """Solves for points at given frequencies, as ratios to that of the linear mode.

    Attributes:
        lift: Levels, and their motions of given energy.

    Raises:
        ModelError: if contact points carry mass: multipliers are found at fixed energy.
    """

    lift: Lift

    def __post_init__(self) -> None:
        self.lift.assert_without_multipliers("continuation in frequency")

    def at(self, place: float, neighbour: Stack | None) -> Stack:
        """Solve at frequency ratio `place`; of several motions as `Lift.at` chooses."""
        coarse = self._coarse(place)
        if coarse is None:
            return self._missing(place, "the followed mode alone has no motion of this frequency")
        gamma = coarse.energies.gamma
        search = FrequencyLift(self.lift.reduced, self.lift.newton)
        found = [self._stack(place, coarse, search.lifted(place, gamma, coarse))]
        if neighbour is not None and neighbour.finest is not None:
            warm = search.warm(place, gamma, neighbour.finest)
            found.append(self._stack(place, coarse, warm))
        return self.lift.best(found)

    def at_energy(self, gamma_ratio: float, neighbour: Stack) -> Stack:
        """Solve at a gamma ratio; the place is that of the frequency found."""
        stack = self.lift.at(gamma_ratio, neighbour)
        return replace(stack, place=stack.finest.omega) if stack.finest else stack

    def restored(self, place: float, finest: Solution) -> Stack:
        """A stack of which the finest motion alone is known."""
        return self.lift.restored(place, finest)

    def _coarse(self, omega: float) -> Solution | None:
        """The single-mode motion of a frequency, between energies on either side of it."""
        low, high, side = 1.0, _FACTOR, 1.0 if omega > 1 else -1.0
        while (beyond := self.lift.coarse(high)) is not None and side * (beyond.omega - omega) < 0:
            low, high = high, _FACTOR * high
            if high > _LARGEST_RATIO:
                return None
        if beyond is None:
            return None
        for _ in range(_HALVINGS):
            middle = (low + high) / 2
            between = self.lift.coarse(middle)
            if between is None:
                return None
            if abs(between.omega - omega) < 1e-6 * omega:
                return between
            low, high = (middle, high) if side * (between.omega - omega) < 0 else (low, middle)
        return between

    def _stack(self, place: float, coarse: Solution, reduced: Solution | None) -> Stack:
        """All levels from a motion of the finest reduced one."""
        finest = reduced
        if reduced is not None:
            for level in self.lift.levels[len(self.lift.reduced) :]:
                finest = self._on_full_order(level, place, reduced)
        if finest is None:
            return self._missing(place, "no motion of this frequency with contact was found")
        below = (coarse, *(None,) * (len(self.lift.levels) - 2), finest)
        ratio = finest.energies.gamma / GRAZING_GAMMA
        return Stack(
            place=place,
            gamma_ratio=ratio,
            solutions=below[-len(self.lift.levels) :],
            share=self.lift.share(finest),
            slope_ratio=self.lift.slope_ratio(finest),
        )

    def _on_full_order(self, level: Level, omega: float, below: Solution) -> Solution | None:
        guess = Guess(below.q, omega, below.forces.force)
        found = level.constrained(FixedFrequency(omega), guess, self.lift.newton)
        return found if found.converged and found.energies.contact else None

    def _missing(self, place: float, why: str) -> Stack:
        failure = f"{why}; wanted {place:.6g} times the linear one"
        return Stack(place, float("nan"), (None,) * len(self.lift.levels), failure=failure)
