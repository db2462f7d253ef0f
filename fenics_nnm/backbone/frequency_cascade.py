"""A second way on to the main branch: level by level at a fixed frequency.

Internal resonances are narrow in frequency and wide in energy, because in them energy flows into
another mode while n omega stays near omega_j. So a motion of given energy may be hidden by
one, where motions of nearby frequencies are not. Levels are solved at a frequency first; then the
frequency is moved until the energy is right.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.backbone.levels import Level
from fenics_nnm.nonlinear.conditions import FixedFrequency
from fenics_nnm.nonlinear.newton import Newton, solve
from fenics_nnm.nonlinear.solution import Solution
from fenics_nnm.nonlinear.unknowns import Unknowns

#: Largest number of frequencies tried for one energy.
_TRIES = 8

#: From this near, relative, an energy is reached by Newton's iteration.
_NEAR = 0.02

#: Largest relative change of the frequency from one try to the next.
_LARGEST_CHANGE = 0.005

#: Where no motion is found at a frequency, the next ones tried lie this part of it away.
_ASIDE = 6e-4

#: Steps of Newton's iteration on the way to a finest motion, unless one is near: of those that take
#: more hardly any comes to a motion, and the next level or frequency may do so at once.
PATIENCE = 12

#: After so many frequencies on end without a finest motion none is found at the next ones: of 39
#: searches of random studies that came to a motion none had more than two of them on the way.
_BARREN = 3

#: A motion whose gamma is off the wanted one by more than this factor belongs to a resonance.
_FARTHEST = 3.0

#: Newton at a fixed frequency is given up where a full step leaves a residual above this. Of the
#: iterations of random studies none came back from above 62; the others wander among motions of
#: hundreds of times the energy, where many contact points open and close.
_WILDEST_LEAP = 100.0


@dataclass(frozen=True, slots=True)
class FrequencyCascade:
    """Finds a motion on the finest of some levels, near an energy, through fixed frequencies.

    Attributes:
        levels: Levels with complementarity, coarse to fine.
        newton: Newton's configuration.
    """

    levels: Sequence[Level]
    newton: Newton

    def near(self, gamma: float, coarse: Solution, slope: float) -> Solution | None:
        """A motion of the finest level whose gamma is within 2 % of the wanted one, or None.

        Args:
            gamma: Wanted gamma.
            coarse: Motion of the coarsest level at this gamma.
            slope: d omega / d gamma of the coarsest level there.
        """
        omega, found, barren = coarse.omega, None, 0
        for number in range(_TRIES):
            found = self.warm(omega, gamma, found)
            if found is None:
                found = self.from_coarse(omega, gamma, coarse)
            barren = 0 if found else barren + 1
            if barren == _BARREN:
                return None
            if found is None:
                side = -1 if number % 2 else 1
                omega *= 1 + side * (number + 1) * _ASIDE
                continue
            missing = gamma - found.energies.gamma
            if abs(missing) < _NEAR * gamma:
                return found
            change = np.clip(slope * missing / omega, -_LARGEST_CHANGE, _LARGEST_CHANGE)
            omega = float(omega * (1 + change))
        return None

    def warm(self, omega: float, gamma: float, nearby: Solution | None) -> Solution | None:
        """From a motion of the finest level at a nearby frequency."""
        if nearby is None:
            return None
        return self._solved(self.levels[-1], omega, gamma, nearby.q)

    def from_coarse(self, omega: float, gamma: float, coarse: Solution) -> Solution | None:
        """From the coarsest level; levels without a solution are passed over."""
        whole, found = self.levels[0].extended(coarse.q), None
        for level in self.levels[1:]:
            found = self._solved(level, omega, gamma, level.restricted(whole))
            if found is not None:
                whole = level.extended(found.q)
        return found

    def _solved(self, level: Level, omega: float, gamma: float, q: Array) -> Solution | None:
        try:
            guess = Unknowns.of(q, omega)
            options = replace(self.newton, wildest_leap=_WILDEST_LEAP, patience=PATIENCE)
            found = solve(level.equations, FixedFrequency(omega), guess, options=options)
        except np.linalg.LinAlgError:
            return None
        if not found.converged or not found.energies.contact:
            return None
        near = 1 / _FARTHEST < found.energies.gamma / gamma < _FARTHEST
        return found if near else None
