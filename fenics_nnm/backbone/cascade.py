"""One point of a branch: from the coarsest level to the finest at a given energy."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.backbone.coarse import GRAZING_GAMMA, CoarseBranch
from fenics_nnm.backbone.frequency_lift import FrequencyLift
from fenics_nnm.backbone.levels import Guess, Level
from fenics_nnm.backbone.memory import forget_oldest
from fenics_nnm.backbone.resonance import STILL, Resonance, strongest_resonance
from fenics_nnm.backbone.slope import frequency_slope
from fenics_nnm.errors import ModelError
from fenics_nnm.mechanics.rest import RestState
from fenics_nnm.nonlinear.newton import Newton
from fenics_nnm.nonlinear.solution import Solution, evaluated
from fenics_nnm.nonlinear.unknowns import Unknowns

#: Energies whose motions are kept for another try.
_TRIED = 8

#: A motion with less than this part of the contact of the followed mode alone avoids it.
_SMALLEST_CONTACT = 0.3

#: The same with points that are closed or touch at rest: the mode alone opens and closes others.
_SMALLEST_CONTACT_PRESSED = 0.05

#: A fall of that share from one point to the next by this much asks for a second look.
SHARE_DROP = 0.02

#: A motion with more than this part of the energy that marks a resonance is looked at twice.
_SUSPECT = 0.6

#: The slope of the coarsest level is that to an energy larger by this factor.
_BESIDE = 1.02

#: A branch with a smaller slope d ln omega / d ln gamma is level.
_LEVEL = 1e-10

#: A motion whose followed mode, in its first harmonic, has less than this share of m^ has left it.
_SMALLEST_SHARE = 0.5

#: The same with points that are closed or touch at rest: the shape changes as they open or close.
_SMALLEST_SHARE_PRESSED = 0.1

#: Where closed points lift off, a larger relative change of frequency asks for a second look.
_FREQUENCY_JUMP = 0.02

#: There a motion whose frequency is farther from that of its neighbour is hardly of its branch.
_FAR = 0.05


@dataclass(frozen=True, slots=True)
class Stack:
    """Solutions of all levels at one place of a branch, None where a level has none.

    Attributes:
        place: Place along the branch: gamma ratio, or frequency ratio.
        gamma_ratio: gamma over its value at grazing.
        solutions: One entry a level, coarse to fine.
        share: Share of the kinetic energy of the finest level in the first harmonic of the
            followed mode; 0 without a solution. Internal resonances draw on it.
        failure: Why the finest level has none; empty where it has one.
        skipped: Internal resonance that was left for this motion, or nothing.
        slope_ratio: d omega / d gamma of the finest motion over that of the followed mode alone.
        refused: A motion that the finest level ended with and that is not on the branch, or none.
    """

    place: float
    gamma_ratio: float
    solutions: tuple[Solution | None, ...]
    share: float = 0.0
    failure: str = ""
    skipped: str = ""
    slope_ratio: float = float("nan")
    refused: Solution | None = None

    @property
    def finest(self) -> Solution | None:
        """Solution at the truncation that the study asks for."""
        return self.solutions[-1]

    def thinned(self, *, levels: bool) -> Stack:
        """What a neighbour needs: no slopes of forces; all levels, or the finest alone."""
        below = self.solutions if levels else (*(None,) * (len(self.solutions) - 1), self.finest)
        solutions = tuple(found.thinned() if found else None for found in below)
        return replace(self, solutions=solutions, refused=None)


@dataclass(frozen=True, slots=True)
class _Attempt:
    """What a level gave: a solution, or why not, and the motion that was refused, if any."""

    solution: Solution | None = None
    failure: str = ""
    refused: Solution | None = None


@dataclass(slots=True)
class Lift:
    """Solves for points at given energies, level by level.

    Attributes:
        levels: Levels, coarse to fine.
        mode: Index of the followed mode.
        newton: Newton's configuration.
    """

    levels: tuple[Level, ...]
    mode: int
    newton: Newton
    _coarse: CoarseBranch = field(init=False)
    _alone: dict[float, Stack] = field(default_factory=dict)
    _beside: dict[float, Stack] = field(default_factory=dict)

    def __post_init__(self) -> None:
        least = self._smallest_share
        self._coarse = CoarseBranch(self.levels[0], self.mode, self.newton, least)

    def coarse(self, gamma_ratio: float) -> Solution | None:
        """Motion of the coarsest level, the followed mode alone, or None."""
        return self._coarse.at(gamma_ratio)

    def at(self, gamma_ratio: float, neighbour: Stack | None) -> Stack:
        """Solve at `gamma_ratio`, with the help of a neighbouring point where that is better.

        Lifting at this energy alone finds the branch afresh; where it fails, or ends in an
        internal resonance, motions of nearby frequencies and the levels of the neighbour guide
        it. Of several motions the one that keeps most of its energy in the followed mode is taken.
        An energy that is tried again, from another neighbour, keeps what does not depend on it.
        """
        if self._rest.homogeneous and gamma_ratio != 1:
            return self._grown(self.at(1.0, None), gamma_ratio)
        if gamma_ratio not in self._alone:
            self._alone[gamma_ratio] = self._lifted(gamma_ratio, None)
            forget_oldest(self._alone, _TRIED)
        alone = self._alone[gamma_ratio]
        if not self._doubtful(alone, neighbour):
            return alone
        if gamma_ratio not in self._beside:
            self._beside[gamma_ratio] = self._through_frequency(alone)
            forget_oldest(self._beside, _TRIED)
        found = [alone, self._beside[gamma_ratio]]
        if neighbour is not None:
            found.append(self._lifted(gamma_ratio, neighbour))
        return self.best(found, neighbour)

    @property
    def _rest(self) -> RestState:
        return self.levels[-1].equations.rest

    @property
    def _smallest_share(self) -> float:
        return _SMALLEST_SHARE_PRESSED if self._rest.pressed else _SMALLEST_SHARE

    @property
    def _linear_until(self) -> float:
        """Gamma ratio where the motion of the followed mode ceases to be linear."""
        return 1.0 if self._rest.is_linear(self.mode) else 0.0

    def _grown(self, stack: Stack, gamma_ratio: float) -> Stack:
        """The same motions at another energy, where all gaps are zero: any size will do."""
        factor = float(np.sqrt(gamma_ratio / stack.gamma_ratio))
        solutions = tuple(
            evaluated(level.equations, Unknowns.of(factor * found.q, found.omega))
            if found
            else None
            for level, found in zip(self.levels, stack.solutions, strict=True)
        )
        return replace(stack, place=gamma_ratio, gamma_ratio=gamma_ratio, solutions=solutions)

    def assert_without_multipliers(self, what: str) -> None:
        """Refuse what multipliers, which are found at fixed energy, cannot do.

        Raises:
            ModelError: if contact points carry mass.
        """
        if any(level.multipliers is not None for level in self.levels):
            raise ModelError(
                f"{what} needs contact points without mass: "
                'reduction.method = "massless", or "none" with complementarity'
            )

    def best(self, found: Sequence[Stack], neighbour: Stack | None = None) -> Stack:
        """Of several motions the one that keeps most of its energy in the followed mode.

        Where closed points lift off this share falls along the branch, and the motions that stay
        behind in a resonance have the larger one. There it is the motion whose frequency is near
        that of the neighbour, and outside resonances if there is one.

        Args:
            found: Motions at one place. The strongest internal resonance among those that are
                left is named.
            neighbour: Motion at a place nearby.
        """
        best = max(found, key=lambda stack: self._rank(stack, neighbour))
        if best.finest is None or self._resonance(best.finest).entered:
            return best
        left = [self._resonance(stack.finest) for stack in found if stack.finest is not None]
        left = [resonance for resonance in left if resonance.entered]
        left += [self._resonance(stack.refused) for stack in found if stack.refused is not None]
        strongest = max(left, key=lambda resonance: resonance.share, default=None)
        return replace(best, skipped=str(strongest)) if strongest else best

    def _rank(self, stack: Stack, neighbour: Stack | None) -> tuple[bool, bool, float]:
        """By which the better of two motions is known."""
        if stack.finest is None or not self._rest.closed.any():
            return False, False, stack.share
        outside = not self._resonance(stack.finest).entered
        if neighbour is None or neighbour.finest is None:
            return False, outside, stack.share
        change = abs(stack.finest.omega / neighbour.finest.omega - 1)
        return change < _FAR, outside, 1 - change

    @property
    def downwards(self) -> bool:
        """Whether the branch is better followed from high energies down.

        Where closed points lift off, harmonics of the motion meet modes at once if these have
        frequencies near multiples of the first; far above, the forces at rest hardly matter.
        """
        return bool(self._rest.closed.any())

    def restored(self, place: float, finest: Solution) -> Stack:
        """A stack of which the finest motion alone is known."""
        below = (None,) * (len(self.levels) - 1)
        ratio = finest.energies.gamma / GRAZING_GAMMA
        return Stack(place, ratio, (*below, finest), self.share(finest))

    def _doubtful(self, stack: Stack, neighbour: Stack | None) -> bool:
        """Whether a motion is missing, or may be inside an internal resonance."""
        if stack.finest is None:
            return True
        if neighbour is not None and stack.share < neighbour.share - SHARE_DROP:
            return True
        if self.downwards and neighbour is not None and neighbour.finest is not None:
            change = abs(stack.finest.omega / neighbour.finest.omega - 1)
            if change > _FREQUENCY_JUMP and stack.gamma_ratio > self._linear_until:
                return True
        return self._resonance(stack.finest).strength > _SUSPECT or stack.slope_ratio < STILL

    def slope_ratio(self, finest: Solution) -> float:
        """Slope d omega / d gamma of a finest motion over that of the mode alone, or nan."""
        rest, ratio = self._rest, finest.energies.gamma / GRAZING_GAMMA
        one_way = rest.closed.all() or not rest.pressed  # else it falls and rises
        alone = self.coarse(ratio) if ratio > 1 and one_way else None
        if alone is None:
            return float("nan")
        coarsest = self.levels[0].equations
        slope = frequency_slope(coarsest, alone.completed(coarsest))
        if not abs(slope) > _LEVEL:
            return float("nan")
        return frequency_slope(self.levels[-1].equations, finest) / slope

    def _resonance(self, finest: Solution) -> Resonance:
        """The internal resonance that draws most energy from a finest motion."""
        model, series = self.levels[-1].equations.model, self.levels[-1].equations.series
        return strongest_resonance(model, series, finest.q, finest.omega, mode=self.mode)

    def _through_frequency(self, alone: Stack) -> Stack:
        """The same levels with a finest motion found through motions of nearby frequencies."""
        reduced = self.reduced
        ratio, coarse = alone.gamma_ratio, alone.solutions[0]
        beside = self.coarse(ratio * _BESIDE)
        level = ratio <= self._linear_until or self._rest.homogeneous
        if level or coarse is None or beside is None:
            return alone
        slope = (beside.omega - coarse.omega) / ((_BESIDE - 1) * ratio * GRAZING_GAMMA)
        search = FrequencyLift(reduced, self.newton)
        near = search.near(ratio * GRAZING_GAMMA, coarse, slope)
        at = len(reduced) - 1
        for index in range(at, len(self.levels)):
            if near is None:
                return alone
            guess = Guess(self._moved(at, index, near.q), near.omega, near.forces.force)
            near, at = self._solve(index, ratio, guess).solution, index
        if near is None:
            return alone
        return Stack(
            place=ratio,
            gamma_ratio=ratio,
            solutions=(*alone.solutions[:-1], near),
            share=self.share(near),
            slope_ratio=self.slope_ratio(near),
        )

    def _lifted(self, gamma_ratio: float, neighbour: Stack | None) -> Stack:
        alone = self.coarse(gamma_ratio)
        if alone is not None and len(self.levels) == 1:
            alone = alone.completed(self.levels[0].equations)
        solutions: list[Solution | None] = [alone]
        attempt = _Attempt(alone, "" if alone else "the single-mode problem has no solution")
        for index in range(1, len(self.levels)):
            attempt = self._level(index, gamma_ratio, solutions, neighbour)
            solutions.append(attempt.solution)
        finest = attempt.solution
        return Stack(
            place=gamma_ratio,
            gamma_ratio=gamma_ratio,
            solutions=tuple(solutions),
            share=self.share(finest) if finest else 0.0,
            slope_ratio=self.slope_ratio(finest) if finest else float("nan"),
            failure=attempt.failure,
            refused=attempt.refused,
        )

    @property
    def reduced(self) -> list[Level]:
        """The levels with complementarity, coarse to fine."""
        return [level for level in self.levels if level.complementary]

    def share(self, finest: Solution) -> float:
        """Share of the kinetic energy of a finest motion in the first harmonic of its mode."""
        return self.levels[-1].share(finest.q, self.mode)

    def _level(
        self,
        index: int,
        gamma_ratio: float,
        below: list[Solution | None],
        neighbour: Stack | None,
    ) -> _Attempt:
        attempt = _Attempt(failure="no level below has a solution")
        for guess in self._guesses(index, below, gamma_ratio, neighbour):
            attempt = self._solve(index, gamma_ratio, guess)
            if attempt.solution is not None:
                break
        return attempt

    def _guesses(
        self, index: int, below: list[Solution | None], gamma_ratio: float, neighbour: Stack | None
    ) -> Iterator[Guess]:
        """Guesses for a level: beside the neighbour's solution, then from the level below."""
        lower = next((i for i in reversed(range(index)) if below[i] is not None), None)
        here = below[lower] if lower is not None else None
        beside = neighbour.solutions[index] if neighbour else None
        if neighbour is not None and beside is not None:
            there = neighbour.solutions[lower] if lower is not None else None
            if lower is not None and here is not None and there is not None:
                change = self._moved(lower, index, here.q - there.q)
                force = beside.forces.force + here.forces.force - there.forces.force
                omega = beside.omega + here.omega - there.omega
                yield Guess(beside.q + change, omega, np.maximum(force, 0.0))
            yield self.levels[index].scaled(beside, gamma_ratio / neighbour.gamma_ratio)
        if lower is not None and here is not None:
            yield Guess(self._moved(lower, index, here.q), here.omega, here.forces.force)

    def _moved(self, source: int, target: int, q: Array) -> Array:
        return self.levels[target].restricted(self.levels[source].extended(q))

    def _solve(self, index: int, gamma_ratio: float, guess: Guess) -> _Attempt:
        level = self.levels[index]
        try:
            solution = level.solve(gamma_ratio * GRAZING_GAMMA, guess, self.newton)
        except np.linalg.LinAlgError as error:
            return _Attempt(failure=f"the contact flexibility is singular to round-off ({error})")
        if solution.failure:
            return _Attempt(failure=solution.failure)
        reason = self._not_on_branch(level, gamma_ratio, solution)
        return _Attempt(failure=reason, refused=solution) if reason else _Attempt(solution)

    def _not_on_branch(self, level: Level, gamma_ratio: float, solution: Solution) -> str:
        """Why a converged motion is not on the branch of the followed mode; empty if it is."""
        touching = self._contact_share(level, gamma_ratio, solution)
        if touching < (_SMALLEST_CONTACT_PRESSED if self._rest.pressed else _SMALLEST_CONTACT):
            return (
                f"converged to a motion with {touching:.2g} of the contact that the followed mode "
                "alone has at this energy: an internal resonance lets it avoid the obstacle"
            )
        share = level.share(solution.q, self.mode)
        if share < self._smallest_share:
            return (
                f"converged to a motion that carries only {share:.0%} of its kinetic energy in the "
                "first harmonic of the followed mode: another family (internal resonance)"
            )
        return ""

    def _contact_share(self, level: Level, gamma_ratio: float, solution: Solution) -> float:
        """Change of contact over that of the coarsest level; 1 where that has none."""
        if level is self.levels[0] or gamma_ratio <= self._linear_until * (1 + 1e-9):
            return 1.0
        alone = self.coarse(gamma_ratio)
        reference = alone.energies.contact if alone else 0.0
        found = solution.energies
        if not reference:
            return float(found.contact > 1e3 * self.newton.tolerance * found.stiffness)
        return found.contact / reference
