"""One point of a branch at a given frequency, from the coarsest level to the finest.

At fixed frequency the narrow tongues of internal resonances are crossed, not climbed. The motion at
rest, and linear motions, have to be refused instead: at a linear frequency they solve the
equations too.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from fenics_nnm.backbone.cascade import Cascade
from fenics_nnm.backbone.cascade_solution import CascadeSolution
from fenics_nnm.backbone.coarse import GRAZING_GAMMA
from fenics_nnm.backbone.frequency_cascade import FrequencyCascade
from fenics_nnm.backbone.level_solver import Guess
from fenics_nnm.backbone.levels import Level
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
        cascade: Levels, and their motions of given energy.

    Raises:
        ModelError: if contact points carry mass: multipliers are found at fixed energy.
    """

    cascade: Cascade

    def __post_init__(self) -> None:
        self.cascade.assert_any_condition("continuation in frequency")

    def at(self, position: float, neighbour: CascadeSolution | None) -> CascadeSolution:
        """Solve at frequency ratio `position`; of several motions as `Cascade.at` chooses."""
        coarse = self._coarse(position)
        beside = neighbour.finest if neighbour is not None else None
        if coarse is None:
            return self._beyond_coarse(position, beside)
        gamma = coarse.energies.gamma
        afresh = self._search.from_coarse(position, gamma, coarse)
        found = [self._of_all_levels(position, coarse, afresh)]
        if beside is not None:
            warm = self._search.warm(position, gamma, beside) or self._near(position, beside)
            found.append(self._of_all_levels(position, coarse, warm))
        return self.cascade.selection.best(found)

    @property
    def _search(self) -> FrequencyCascade:
        return FrequencyCascade(self.cascade.reduced, self.cascade.newton)

    def _near(self, position: float, beside: Solution) -> Solution | None:
        """From a neighbour, with an energy near that of its own.

        That of the followed mode alone may be far off, as lower modes are taken as static there.
        """
        return self._search.warm(position, beside.energies.gamma, beside)

    def _beyond_coarse(self, position: float, beside: Solution | None) -> CascadeSolution:
        """Where the followed mode alone does not come to, and with all others perhaps does."""
        if beside is not None and (warm := self._near(position, beside)) is not None:
            return self._of_all_levels(position, None, warm)
        return self._missing(position, "the followed mode alone has no motion of this frequency")

    def at_energy(self, gamma_ratio: float, neighbour: CascadeSolution) -> CascadeSolution:
        """Solve at a gamma ratio; the position is that of the frequency found."""
        found = self.cascade.at(gamma_ratio, neighbour)
        return replace(found, position=found.finest.omega) if found.finest else found

    def restored(self, position: float, finest: Solution) -> CascadeSolution:
        """Solutions of which the finest alone is known."""
        return self.cascade.restored(position, finest)

    def _coarse(self, omega: float) -> Solution | None:
        """The single-mode motion of a frequency, between energies on either side of it."""
        side = 1.0 if omega > 1 else -1.0
        ends = self._energies_about(omega, side)
        if ends is None:
            return None
        low, high = ends
        for _ in range(_HALVINGS):
            middle = (low + high) / 2
            between = self.cascade.coarse(middle)
            if between is None:
                return None
            if abs(between.omega - omega) < 1e-6 * omega:
                return between
            low, high = (middle, high) if side * (between.omega - omega) < 0 else (low, middle)
        return between

    def _energies_about(self, omega: float, side: float) -> tuple[float, float] | None:
        """Gamma ratios between which the single-mode motion passes a frequency, if it does."""
        low, high = 1.0, _FACTOR
        while high <= _LARGEST_RATIO:
            beyond = self.cascade.coarse(high)
            if beyond is None:
                return None
            if side * (beyond.omega - omega) >= 0:
                return low, high
            low, high = high, _FACTOR * high
        return None

    def _of_all_levels(
        self, position: float, coarse: Solution | None, reduced: Solution | None
    ) -> CascadeSolution:
        """All levels from a motion of the finest reduced one."""
        finest = reduced
        if reduced is not None:
            for level in self.cascade.levels[len(self.cascade.reduced) :]:
                finest = self._on_full_order(level, position, reduced)
        if finest is None:
            return self._missing(position, "no motion of this frequency with contact was found")
        below = (coarse, *(None,) * (len(self.cascade.levels) - 2), finest)
        ratio = finest.energies.gamma / GRAZING_GAMMA
        return CascadeSolution(
            position=position,
            gamma_ratio=ratio,
            solutions=below[-len(self.cascade.levels) :],
            share=self.cascade.selection.share(finest),
            slope_ratio=self.cascade.slope_ratio(finest),
        )

    def _on_full_order(self, level: Level, omega: float, below: Solution) -> Solution | None:
        guess = replace(Guess.of(below), omega=omega)
        found = level.at_condition(FixedFrequency(omega), guess, self.cascade.newton)
        return found if found.converged and found.energies.contact else None

    def _missing(self, position: float, why: str) -> CascadeSolution:
        failure = f"{why}; wanted {position:.6g} times the linear one"
        nothing = (None,) * len(self.cascade.levels)
        return CascadeSolution(position, float("nan"), nothing, failure=failure)
