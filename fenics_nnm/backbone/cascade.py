"""One point of a branch: from the coarsest level to the finest at a given energy."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from fenics_nnm.backbone.attempts import Attempt, FailedAttempts
from fenics_nnm.backbone.belonging import Belonging
from fenics_nnm.backbone.cascade_solution import CascadeSolution
from fenics_nnm.backbone.coarse import GRAZING_GAMMA, CoarseBranch
from fenics_nnm.backbone.frequency_cascade import PATIENCE, FrequencyCascade
from fenics_nnm.backbone.guesses import guesses
from fenics_nnm.backbone.level_solver import Guess, needs_massless
from fenics_nnm.backbone.levels import Level
from fenics_nnm.backbone.memory import remember
from fenics_nnm.backbone.selection import Selection
from fenics_nnm.backbone.slope import slope_ratio
from fenics_nnm.nonlinear.newton import Newton
from fenics_nnm.nonlinear.solution import Solution, evaluated
from fenics_nnm.nonlinear.unknowns import Unknowns

#: Energies whose motions are kept for another try.
_TRIED = 8

#: Energies at which is kept whether their levels lead to the finest without a neighbour.
_STUCK = 200

#: A level below the finest that has found nothing at so many energies on end hardly ever does.
_HOPELESS = 3

#: The slope of the coarsest level is that to an energy larger by this factor.
_BESIDE = 1.02


@dataclass(slots=True)
class Cascade:
    """Solves for points at given energies, level by level.

    Attributes:
        levels: Levels, coarse to fine.
        mode: Index of the followed mode.
        newton: Newton's configuration.
        belonging: By what a motion is known to be on the branch.
        selection: Compares motions of the finest level.
    """

    levels: tuple[Level, ...]
    mode: int
    newton: Newton
    belonging: Belonging = field(init=False)
    selection: Selection = field(init=False)
    _coarse: CoarseBranch = field(init=False)
    _alone: dict[float, CascadeSolution] = field(default_factory=dict)
    _beside: dict[float, CascadeSolution] = field(default_factory=dict)
    _stuck: dict[float, bool] = field(default_factory=dict)
    _misses: dict[int, int] = field(default_factory=dict)
    _failed: FailedAttempts = field(default_factory=FailedAttempts)

    def __post_init__(self) -> None:
        coarsest, finest = self.levels[0], self.levels[-1]
        self.belonging = Belonging.about(finest.equations.rest, self.mode)
        self.selection = Selection(self.belonging, finest, self.mode)
        least = self.belonging.smallest_share
        self._coarse = CoarseBranch(coarsest, self.mode, self.newton, least)

    @property
    def reduced(self) -> tuple[Level, ...]:
        """The levels with complementarity on a reduced model, coarse to fine."""
        return tuple(level for level in self.levels if level.solver.reduced)

    def assert_any_condition(self, what: str) -> None:
        """Refuse what multipliers, which are found at fixed energy, cannot do.

        Raises:
            ModelError: if contact points carry mass.
        """
        if any(level.solver.fixes_energy_only for level in self.levels):
            raise needs_massless(what)

    def coarse(self, gamma_ratio: float) -> Solution | None:
        """Motion of the coarsest level, the followed mode alone, or None."""
        return self._coarse.at(gamma_ratio)

    def at(self, position: float, neighbour: CascadeSolution | None) -> CascadeSolution:
        """Solve at a gamma ratio, with the help of a neighbouring point where that is better.

        Starting from the coarsest level at this energy alone finds the branch afresh; where it
        fails, the levels of the neighbour guide it, and where that is not enough, or it ends in an
        internal resonance, motions of nearby frequencies, too. Of several motions the one that
        keeps most of its energy in the followed mode is taken. An energy that is tried again, from
        another neighbour, keeps what does not depend on it.
        """
        if _homogeneous(self.levels) and position != 1:
            return _grown(self.levels, self.at(1.0, None), position)
        led = self._led(position, neighbour)
        if led is not None and not self.selection.doubtful(led, neighbour):
            remember(self._stuck, position, True, _STUCK)
            return led
        alone = self._alone.get(position)
        if alone is None:
            alone = self._level_by_level(position, None)
            remember(self._alone, position, alone.light(), _TRIED)
            remember(self._stuck, position, alone.finest is None, _STUCK)
        if not self.selection.doubtful(alone, neighbour):
            return alone
        found = [alone]
        if led is not None and led.finest is not None:
            found.append(led)
        elif neighbour is not None:
            found.append(self._guided(alone, neighbour))
        if alone.finest is None and not self.selection.doubtful(found[-1], neighbour):
            return self.selection.best(found, neighbour)
        if position not in self._beside:
            remember(self._beside, position, self._through_frequency(alone).light(), _TRIED)
        found.insert(1, self._beside[position])
        return self.selection.best(found, neighbour)

    def restored(self, position: float, finest: Solution) -> CascadeSolution:
        """Solutions of which the finest alone is known."""
        below = (None,) * (len(self.levels) - 1)
        ratio = finest.energies.gamma / GRAZING_GAMMA
        share = self.selection.share(finest)
        return CascadeSolution(position, ratio, (*below, finest), share)

    def slope_ratio(self, finest: Solution) -> float:
        """Slope d omega / d gamma of a finest motion over that of the mode alone, or nan."""
        return slope_ratio(self._coarse, self.levels[-1], finest)

    def _led(self, position: float, neighbour: CascadeSolution | None) -> CascadeSolution | None:
        """What a neighbour leads to, if the levels alone do not come to that one; else None.

        They will fail here, too, and levels without a motion there have none here. A finest level
        of full order needs the levels below it.
        """
        known = neighbour is not None and self._stuck.get(neighbour.position)
        if neighbour is None or not known or len(self.reduced) < len(self.levels):
            return None
        if neighbour.solutions[0] is None or neighbour.gamma_ratio <= self.belonging.linear_until:
            return None
        return self._level_by_level(position, neighbour, passing=neighbour)

    def _guided(self, alone: CascadeSolution, neighbour: CascadeSolution) -> CascadeSolution:
        """The levels again, guided by those of a neighbour.

        A linear motion beside one with contact has nothing to say of the levels in between.
        """
        ratio = alone.gamma_ratio
        if neighbour.gamma_ratio <= self.belonging.linear_until < ratio:
            below = alone.solutions[:-1]
            return self._completed(ratio, below, self._on_level(below, ratio, neighbour))
        return self._level_by_level(ratio, neighbour)

    def _level_by_level(
        self,
        gamma_ratio: float,
        neighbour: CascadeSolution | None,
        *,
        passing: CascadeSolution | None = None,
    ) -> CascadeSolution:
        """Solutions of all levels.

        Args:
            gamma_ratio: The energy.
            neighbour: Guides the levels, if given.
            passing: Levels that it lacks are passed over.
        """
        alone = self.coarse(gamma_ratio)
        if len(self.levels) == 1:
            return self._completed(gamma_ratio, (), _alone(self.levels[0], alone))
        below: list[Solution | None] = [alone]
        for _ in self.levels[1:-1]:
            lacks = passing is not None and passing.solutions[len(below)] is None
            if lacks or _leads_straight(self.levels[0], alone):
                below.append(None)
                continue
            found = self._on_level(below, gamma_ratio, neighbour).solution
            below.append(found.light() if found else None)
        return self._completed(gamma_ratio, below, self._on_level(below, gamma_ratio, neighbour))

    def _on_level(
        self,
        below: Sequence[Solution | None],
        gamma_ratio: float,
        neighbour: CascadeSolution | None,
    ) -> Attempt:
        """The next level above some, from one guess after the other."""
        number = len(below)
        attempt = Attempt(failure="no level below has a solution")
        for guess in guesses(self.levels, below, gamma_ratio, neighbour):
            make = partial(self._attempt, number, gamma_ratio, guess)
            attempt = self._failed.once(number, gamma_ratio, guess, make)
            if attempt.solution is not None:
                break
        self._misses[number] = 0 if attempt.solution else self._misses.get(number, 0) + 1
        return attempt

    def _completed(
        self, gamma_ratio: float, below: Sequence[Solution | None], attempt: Attempt
    ) -> CascadeSolution:
        """Solutions of all levels at an energy."""
        finest = attempt.solution
        return CascadeSolution(
            position=gamma_ratio,
            gamma_ratio=gamma_ratio,
            solutions=(*below, finest),
            share=self.selection.share(finest) if finest else 0.0,
            slope_ratio=self.slope_ratio(finest) if finest else float("nan"),
            failure=attempt.failure,
            refused=attempt.refused,
        )

    def _through_frequency(self, alone: CascadeSolution) -> CascadeSolution:
        """The same levels with a finest motion found through motions of nearby frequencies."""
        found = self._near_in_frequency(alone.gamma_ratio, alone.solutions[0])
        if found is None:
            return alone
        return CascadeSolution(
            position=alone.gamma_ratio,
            gamma_ratio=alone.gamma_ratio,
            solutions=(*alone.solutions[:-1], found),
            share=self.selection.share(found),
            slope_ratio=self.slope_ratio(found),
        )

    def _near_in_frequency(self, ratio: float, coarse: Solution | None) -> Solution | None:
        """Motion of the finest level from one of nearly this energy at a fixed frequency."""
        beside, reduced = self.coarse(ratio * _BESIDE), self.reduced
        one_frequency = ratio <= self.belonging.linear_until or _homogeneous(self.levels)
        if one_frequency or not reduced or coarse is None or beside is None:
            return None
        slope = (beside.omega - coarse.omega) / ((_BESIDE - 1) * ratio * GRAZING_GAMMA)
        search = FrequencyCascade(reduced, self.newton)
        found = search.near(ratio * GRAZING_GAMMA, coarse, slope)
        below = reduced[-1]
        for number in range(len(reduced) - 1, len(self.levels)):
            if found is None:
                return None
            level = self.levels[number]
            guess = replace(Guess.of(found), q=level.adopted(below, found.q))
            found, below = self._attempt(number, ratio, guess).solution, level
        return found

    def _attempt(self, number: int, gamma_ratio: float, guess: Guess) -> Attempt:
        level = self.levels[number]
        below_finest = number < len(self.levels) - 1
        hopeless = below_finest and self._misses.get(number, 0) >= _HOPELESS
        newton = replace(self.newton, patience=PATIENCE) if hopeless else self.newton
        try:
            solution = level.at_energy(gamma_ratio * GRAZING_GAMMA, guess, newton)
        except np.linalg.LinAlgError as error:
            return Attempt(failure=f"the contact flexibility is singular to round-off ({error})")
        if solution.failure:
            return Attempt(failure=solution.failure)
        reason = refusal(self, number, gamma_ratio, solution)
        return Attempt(failure=reason, refused=solution) if reason else Attempt(solution)


def refusal(cascade: Cascade, number: int, gamma_ratio: float, solution: Solution) -> str:
    """Why a converged motion of a level is not on the branch of the followed mode, or nothing.

    Args:
        cascade: Levels.
        number: Number of the level.
        gamma_ratio: Energy of the motion.
        solution: The motion.
    """
    level, contact = cascade.levels[number], 1.0
    if number > 0 and gamma_ratio > cascade.belonging.linear_until * (1 + 1e-9):
        alone, tolerance = cascade.coarse(gamma_ratio), cascade.newton.tolerance
        contact = _contact_share(level, solution, alone, tolerance)
    return cascade.belonging.refusal(contact, level.share(solution.q, cascade.mode))


def _homogeneous(levels: Sequence[Level]) -> bool:
    """Whether all gaps are zero, so that motions of any size are alike."""
    return levels[-1].equations.rest.homogeneous


def _alone(level: Level, alone: Solution | None) -> Attempt:
    """What is found where the coarsest level is the finest one, too."""
    if alone is None:
        return Attempt(failure="the single-mode problem has no solution")
    return Attempt(alone.completed(level.equations))


def _contact_share(
    level: Level, solution: Solution, alone: Solution | None, tolerance: float
) -> float:
    """Change of contact over that of the coarsest level; 1 where that has none."""
    reference = alone.energies.contact if alone else 0.0
    found = solution.energies
    if not reference and level.equations.mechanics.forces:
        return 1.0  # the mode alone does not touch at this energy yet
    if not reference:
        return float(found.contact > 1e3 * tolerance * found.stiffness)
    return found.contact / reference


def _leads_straight(coarsest: Level, alone: Solution | None) -> bool:
    """Whether the finest level can start at the coarsest: it bends smoothly without contact."""
    bends = len(coarsest.equations.model.kinematics.masters) > 0
    return bends and alone is not None and not alone.forces.force.any()


def _grown(levels: Sequence[Level], known: CascadeSolution, gamma_ratio: float) -> CascadeSolution:
    """The same motions at another energy, where all gaps are zero: any size will do."""
    factor = float(np.sqrt(gamma_ratio / known.gamma_ratio))
    solutions = tuple(
        evaluated(level.equations, Unknowns.of(factor * found.q, found.omega)) if found else None
        for level, found in zip(levels, known.solutions, strict=True)
    )
    return replace(known, position=gamma_ratio, gamma_ratio=gamma_ratio, solutions=solutions)
