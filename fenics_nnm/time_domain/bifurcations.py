r"""Bifurcations of the exact motions of a branch, found from their Floquet multipliers.

Where a kind of instability begins or ends between two neighbouring points, a pair of multipliers
has left the unit circle or come back to it:

    through +1, with an extremum of the energy along the family      fold
    through +1, without                                              symmetry breaking
    through -1                                                       period doubling
    in a collision of two complex pairs (Krein)                      Neimark-Sacker

(in a conservative system the last is also called Hamiltonian Hopf bifurcation; the first two are
told apart by the tangent of the family). The place is found by bisection along the chord u_a, u_b
between the two motions: from each point of the chord the shortest Newton steps lead to a motion of
the family, which thus may turn back in energy. Between the last two motions a smooth function of
the multipliers is taken linear: with a = mu + 1/mu, which is real for a pair on the circle or on
the real axis, it is a - 2, a + 2, or (a_1 - a_2)^2 of the pair that collides.

A family that is nearly square to the chord may lead back beyond the first motion, over what was
found before it: that is kept once, and the change of stability is told as one without a place.

Pairs that leave while another one of their kind is outside already are not told, nor is what begins
and ends between two points.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from fenics_nnm.arrays import Array, Complex
from fenics_nnm.time_domain.family import Steps, family_tangent, periodic_motion
from fenics_nnm.time_domain.flow import Flow
from fenics_nnm.time_domain.period_map import PeriodMap, Target, period_map
from fenics_nnm.time_domain.shooting import ShotMotion, mean_gamma_of
from fenics_nnm.time_domain.stability import (
    COMPLEX,
    DOUBLING,
    REAL,
    Stability,
    stability_of,
)

FOLD = "fold"
SYMMETRY_BREAKING = "symmetry breaking"
PERIOD_DOUBLING = "period doubling"
NEIMARK_SACKER = "Neimark-Sacker"
KINDS = (FOLD, SYMMETRY_BREAKING, PERIOD_DOUBLING, NEIMARK_SACKER)

#: Motions that are nearer to each other, relative in the energy norm, bracket a bifurcation.
_TOLERANCE = 1e-3

#: Neighbours that are farther apart, where the chord is as short as this, or where no motion is
#: found between them, bracket none: they may be of two families.
_FARTHEST = 0.02
_SHORTEST = 2.0**-16

#: Points farther apart than this, relative in the energy norm, are no neighbours on a family.
_LONGEST = 0.5

#: Bifurcations of a kind whose energies and frequencies agree to this are one.
_SAME = 1e-4

#: Most bifurcations between two points, and most motions shot for a whole branch.
_MOST_BETWEEN = 3
_MOST_MOTIONS = 250

#: A motion with a smaller share of its energy in the velocity starts at rest.
_AT_REST = 1e-16


@dataclass(frozen=True, slots=True)
class Place:
    """Where a bifurcation is.

    Attributes:
        kind: One of `KINDS`.
        gamma_ratio: Modal energy coordinate over its value at grazing.
        energy: Total energy in J.
        frequency: Frequency in Hz.
    """

    kind: str
    gamma_ratio: float
    energy: float
    frequency: float


@dataclass(frozen=True, slots=True)
class Bifurcation(Place):
    """A bifurcation between two points of a branch.

    Attributes:
        multiplier: Where the multiplier leaves the unit circle.
        bracket: Energies in J of the two exact motions that it lies between, in the order of the
            branch; at a fold both are on one side of it.
        breaks_time_reversal: Whether the motions that branch off a symmetry breaking are not
            time-reversible any more; false for the other kinds, and unless it starts at rest.
        stable_before: Whether the branch is stable just before it.
        stable_after: Whether it is stable just after it.
    """

    multiplier: complex
    bracket: tuple[float, float]
    breaks_time_reversal: bool
    stable_before: bool
    stable_after: bool


@dataclass(frozen=True, slots=True)
class Witness:
    """An exact motion of a branch.

    Attributes:
        gamma_ratio: Modal energy coordinate of its point over the value at grazing.
        shot: The motion.
        stability: Its multipliers.
    """

    gamma_ratio: float
    shot: ShotMotion
    stability: Stability


@dataclass(frozen=True, slots=True)
class Bifurcations:
    """Bifurcations of a branch.

    Attributes:
        located: Those that were found, in the order of the branch.
        unlocated: Gamma ratios of neighbouring points between which a kind of instability begins
            or ends, and it was not found where: by a jump to another family, by a way back over
            what is located already, or at the bound on the number of motions.
    """

    located: tuple[Bifurcation, ...] = ()
    unlocated: tuple[tuple[float, float], ...] = ()


def bifurcations(
    flow: Flow, witnesses: Sequence[Witness | None], *, reversible: bool
) -> Bifurcations:
    """Bifurcations between neighbouring points of a branch.

    Args:
        flow: Flow of the model, in SI units.
        witnesses: The exact motion of each point, None where there is none.
        reversible: Whether the motions are time-reversible and start at rest.
    """
    budget = _Budget(_MOST_MOTIONS)
    located: list[Bifurcation] = []
    unlocated: list[tuple[float, float]] = []
    for first, second in pairwise(witnesses):
        if first and second and _kinds(first.stability) != _kinds(second.stability):
            chord = _Chord.between(flow, first, second, budget, reversible)
            found, complete = chord.bifurcations()
            new = [each for each in found if not any(_same(each, other) for other in located)]
            located += new
            if not complete or len(new) < len(found):
                unlocated.append((first.gamma_ratio, second.gamma_ratio))
    return Bifurcations(tuple(located), tuple(unlocated))


def _same(one: Bifurcation, other: Bifurcation) -> bool:
    near = np.isclose(
        [one.energy, one.frequency], [other.energy, other.frequency], rtol=_SAME, atol=0
    )
    return one.kind == other.kind and bool(near.all())


@dataclass(slots=True)
class _Budget:
    """Motions that may still be shot."""

    left: int


@dataclass(frozen=True, slots=True)
class _Motion:
    """A motion of the family.

    Attributes:
        place: Place along the chord, 0 to 1, that it was shot from.
        unknowns: Unknowns of the period map.
        stability: Multipliers.
        tangent: Unit tangent of the family.
        climb: Derivative of H / E along the tangent.
    """

    place: float
    unknowns: Array
    stability: Stability
    tangent: Array
    climb: float


@dataclass(frozen=True, slots=True)
class _Chord:
    """The way between two neighbouring motions of a branch."""

    flow: Flow
    equations: PeriodMap
    first: Witness
    first_gamma: float
    start: Array
    end: Array
    budget: _Budget
    steps: Steps = field(default_factory=Steps)

    @classmethod
    def between(
        cls, flow: Flow, first: Witness, second: Witness, budget: _Budget, reversible: bool
    ) -> _Chord:
        """The chord between two motions, in the units of the first."""
        targets = [
            Target(each.shot.q, each.shot.velocity, each.shot.period, first.shot.energy)
            for each in (first, second)
        ]
        start, end = (period_map(flow, each, reversible=reversible).start for each in targets)
        end = np.append(end[:-1], second.shot.period / first.shot.period)
        equations = period_map(flow, targets[0], reversible=reversible)
        gamma = mean_gamma_of(flow, targets[0].q, targets[0].velocity, targets[0].period)
        return cls(flow, equations, first, gamma, start, end, budget)

    def bifurcations(self) -> tuple[list[Bifurcation], bool]:
        """Bifurcations from one end to the other, and whether they are all there are."""
        found: list[Bifurcation] = []
        left, end = self._motion(0.0), self._motion(1.0)
        too_long = np.linalg.norm(self.end - self.start) > _LONGEST
        if too_long or left is None or end is None:
            return found, False
        for _ in range(_MOST_BETWEEN):
            before, left = self._bracket(left, end)
            if np.linalg.norm(left.unknowns - before.unknowns) > _FARTHEST:
                return found, False
            found += self._events(before, left)
            if _kinds(left.stability) == _kinds(end.stability):
                return found, True
        return found, False

    def _motion(self, place: float) -> _Motion | None:
        """The motion of the family nearest to a place of the chord, None if none is found."""
        self.budget.left -= 1
        guess = self.start + place * (self.end - self.start)
        found = periodic_motion(self.equations, guess, self.steps, keep_energy=False)
        if found.failure:
            return None
        known = stability_of(self.flow, *self.equations.state(found.unknowns))
        if known.failure:
            return None
        tangent = family_tangent(found.miss, self.end - self.start)
        climb = float(found.miss.jacobian[-1] @ tangent)
        return _Motion(place, found.unknowns, known, tangent, climb)

    def _bracket(self, left: _Motion, right: _Motion) -> tuple[_Motion, _Motion]:
        """Neighbouring motions of which the first is as unstable as `left`, the second not."""
        kinds = _kinds(left.stability)
        while (
            np.linalg.norm(right.unknowns - left.unknowns) > _TOLERANCE
            and right.place - left.place > _SHORTEST
            and self.budget.left > 0
        ):
            middle = self._motion((left.place + right.place) / 2)
            if middle is None:
                break
            if _kinds(middle.stability) == kinds:
                left = middle
            else:
                right = middle
        return left, right

    def _events(self, before: _Motion, after: _Motion) -> list[Bifurcation]:
        """What happens between two neighbouring motions."""
        changed = _kinds(before.stability) ^ _kinds(after.stability)
        outside = [sum(map(bool, each.stability.kinds)) for each in (before, after)]
        if outside[0] == outside[1] and COMPLEX in changed and len(changed) > 1:
            return []  # two pairs met on the real axis, outside the circle
        shares = {kind: _crossing(kind, before, after) for kind in sorted(changed)}
        in_order = sorted(shares, key=lambda kind: shares[kind])
        return [self._event(kind, shares[kind], before, after) for kind in in_order]

    def _event(self, kind: str, share: float, before: _Motion, after: _Motion) -> Bifurcation:
        """What happens at a share of the way between two neighbouring motions."""
        turns = before.climb * after.climb * (before.tangent @ after.tangent) < 0
        unknowns = before.unknowns + share * (after.unknowns - before.unknowns)
        q, velocity, period = self.equations.state(unknowns)
        unstable = before if kind in before.stability.kinds else after
        index = unstable.stability.kinds.index(kind)
        multiplier = complex(unstable.stability.multipliers[index])
        energies = [self._energy(each.unknowns) for each in (before, after)]
        name = {DOUBLING: PERIOD_DOUBLING, COMPLEX: NEIMARK_SACKER}.get(
            kind, FOLD if turns else SYMMETRY_BREAKING
        )
        return Bifurcation(
            kind=name,
            gamma_ratio=self._gamma_ratio(q, velocity, period),
            energy=self._energy(unknowns),
            frequency=1 / period,
            multiplier=multiplier / abs(multiplier),
            bracket=(energies[0], energies[1]),
            breaks_time_reversal=name == SYMMETRY_BREAKING
            and _at_rest(self.first.shot)
            and _is_odd(unstable.stability.directions[:, index]),
            stable_before=before.stability.stable,
            stable_after=after.stability.stable,
        )

    def _energy(self, unknowns: Array) -> float:
        q, velocity, _ = self.equations.state(unknowns)
        return self.flow.energy(q, velocity)

    def _gamma_ratio(self, q: Array, velocity: Array, period: float) -> float:
        """Its gamma over that of the first motion, times the ratio of that."""
        found = mean_gamma_of(self.flow, q, velocity, period)
        return self.first.gamma_ratio * found / self.first_gamma


def _kinds(found: Stability) -> frozenset[str]:
    return frozenset(found.kinds) - {""}


def _crossing(kind: str, before: _Motion, after: _Motion) -> float:
    """Share of the way between two motions at which the multipliers leave the circle, or return."""
    ends = [_test_function(kind, each.stability.multipliers) for each in (before, after)]
    return ends[0] / (ends[0] - ends[1]) if ends[0] * ends[1] < 0 else 0.5


def _test_function(kind: str, multipliers: Complex) -> float:
    """What changes sign where a pair of multipliers leaves the unit circle in this way."""
    a = multipliers + 1 / multipliers
    if kind != COMPLEX:
        distance = a - (2 if kind == REAL else -2)
        return float(distance[np.argmin(np.abs(distance))].real)
    pairs = _one_of_each_pair(a)
    gaps = np.subtract.outer(pairs, pairs)[np.triu_indices(len(pairs), 1)] ** 2
    return float(gaps[np.argmin(np.abs(gaps))].real) if gaps.size else float("nan")


def _one_of_each_pair(a: Complex) -> Complex:
    """Values of mu + 1/mu, each of which is there twice, once."""
    left, kept = list(a), []
    while left:
        kept.append(left.pop(0))
        left.pop(int(np.argmin(np.abs(np.array(left) - kept[-1]))))
    return np.array(kept)


def _at_rest(shot: ShotMotion) -> bool:
    return float(shot.velocity @ shot.velocity) <= _AT_REST * shot.energy


def _is_odd(direction: Complex) -> bool:
    """Whether a direction is one of velocities, so that time reversal changes its sign."""
    coordinates, velocities = np.split(direction, 2)
    return bool(np.linalg.norm(velocities) > np.linalg.norm(coordinates))
