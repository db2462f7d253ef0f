"""Motions of a family between two neighbours of a branch, and where their instability changes.

The motions are shot from a cubic through the two nearest known ones with their tangents, or, where
that leads nowhere or far from the cubic, from the chord between the neighbours: from there the
shortest Newton steps lead to a motion of the family, which thus may turn back in energy.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.time_domain.crossing import crossing
from fenics_nnm.time_domain.family import Found, Steps, family_tangent, periodic_motion
from fenics_nnm.time_domain.integrator import Integrator
from fenics_nnm.time_domain.period_map import Miss, PeriodMap, Target, period_map
from fenics_nnm.time_domain.shooting import ShotMotion
from fenics_nnm.time_domain.stability import Stability, stability_of

#: Motions that are nearer to each other, relative in the energy norm, bracket a bifurcation.
TOLERANCE = 1e-3

#: Between motions that are nearer than this the multipliers are as good as linear.
_STRAIGHT = 0.01

#: There a motion is looked for this part of the tolerance beyond the place where one is expected.
_BEYOND = 0.45

#: A motion between two others that leaves more of the way than this is followed by one half-way;
#: after so many of these on end the two are of different families.
_SLOW = 0.7
_MOST_SLOW = 4

#: The cubic is no guide to a family that is farther from it than this part of the way.
_FAITHFUL = 0.2

#: How well motions between two others are shot, relative in the energy norm: multipliers leave the
#: circle with the root of the distance to a bifurcation, and so show that to the square of it.
_STEPS = Steps(tolerance=1e-10)


@dataclass(slots=True)
class Budget:
    """Motions that may still be shot."""

    left: int


@dataclass(frozen=True, slots=True)
class FamilyMotion:
    """A motion of the family.

    Attributes:
        place: Place along the chord, 0 to 1, that it was shot for.
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

    def distance(self, other: FamilyMotion) -> float:
        """Distance of the unknowns, relative in the energy norm."""
        return float(np.linalg.norm(other.unknowns - self.unknowns))

    @property
    def instabilities(self) -> frozenset[str]:
        """Kinds of its instability."""
        return self.stability.instabilities


@dataclass(frozen=True, slots=True)
class Chord:
    """The way between two neighbouring motions of a branch, in the units of the first.

    Attributes:
        flow: Integrator of the model, in SI units.
        equations: Of a periodic motion, the energy of the first one's.
        first: The motion at its start.
        last: That at its end.
        reversible: Whether motions are time-reversible and start at rest.
        budget: Motions that may still be shot; shared with other chords.
    """

    flow: Integrator
    equations: PeriodMap
    first: FamilyMotion
    last: FamilyMotion
    reversible: bool
    budget: Budget

    @classmethod
    def between(
        cls,
        flow: Integrator,
        motions: tuple[ShotMotion, ShotMotion],
        stabilities: tuple[Stability, Stability],
        budget: Budget,
        *,
        reversible: bool,
    ) -> Chord:
        """The chord between two exact motions with known stability."""
        start, end = (
            Target(each.q, each.velocity, each.period, motions[0].energy) for each in motions
        )
        equations = period_map(flow, start, reversible=reversible)
        first = equations.start
        last = period_map(flow, end, reversible=reversible).start
        last[-1] = end.period / start.period
        ends = [
            _family_motion(place, unknowns, equations.miss(unknowns), known, last - first)
            for place, unknowns, known in zip((0.0, 1.0), (first, last), stabilities, strict=True)
        ]
        return cls(flow, equations, ends[0], ends[1], reversible, budget)

    @property
    def length(self) -> float:
        """Distance of the two motions, relative in the energy norm."""
        return self.first.distance(self.last)

    def bracket(self, left: FamilyMotion, right: FamilyMotion) -> tuple[FamilyMotion, FamilyMotion]:
        """Neighbouring motions of which the first is as unstable as `left`, the second not.

        They are farther apart than `TOLERANCE` where none was found between them, or only such of
        another family.
        The next motion is shot half-way, or, where the way is short, a little beyond the place
        where the multipliers are expected to leave the circle.
        """
        kinds, length, slow = left.instabilities, left.distance(right), 0
        while length > TOLERANCE and slow < _MOST_SLOW and self.budget.left > 0:
            halve = slow or length > _STRAIGHT
            share = 0.5 if halve else _expected(left, right, _BEYOND * TOLERANCE / length)
            middle = self._motion(left, right, share)
            if middle is None:
                break
            if middle.instabilities == kinds:
                left = middle
            else:
                right = middle
            before, length = length, left.distance(right)
            slow = slow + 1 if length > _SLOW * before else 0
        return left, right

    def _motion(self, left: FamilyMotion, right: FamilyMotion, share: float) -> FamilyMotion | None:
        """A motion of the family between two others, None if none is found."""
        self.budget.left -= 1
        place = left.place + share * (right.place - left.place)
        guess = _hermite(left, right, share)
        near = replace(_STEPS, stray=_FAITHFUL * left.distance(right))
        found = periodic_motion(self.equations, guess, near, keep_energy=False)
        if found.failure:
            guess = self.first.unknowns + place * (self.last.unknowns - self.first.unknowns)
            found = periodic_motion(self.equations, guess, _STEPS, keep_energy=False)
        return None if found.failure else self._known(place, found)

    def _known(self, place: float, found: Found) -> FamilyMotion | None:
        state = self.equations.state(found.unknowns)
        known = stability_of(self.flow, *state, reversible=self.reversible)
        if known.failure:
            return None
        along = self.last.unknowns - self.first.unknowns
        return _family_motion(place, found.unknowns, found.miss, known, along)


def _family_motion(
    place: float, unknowns: Array, miss: Miss, known: Stability, along: Array
) -> FamilyMotion:
    tangent = family_tangent(miss, along)
    return FamilyMotion(place, unknowns, known, tangent, float(miss.jacobian[-1] @ tangent))


def _expected(left: FamilyMotion, right: FamilyMotion, beyond: float) -> float:
    """Share of the way just beyond where the first kind is expected to change."""
    changed = left.instabilities ^ right.instabilities
    share = min(crossing(kind, left.stability, right.stability) for kind in changed)
    return share + beyond if share < 0.5 else share - beyond


def _hermite(left: FamilyMotion, right: FamilyMotion, share: float) -> Array:
    """The cubic through two motions with their tangents, at a share of the way."""
    length, rest = left.distance(right), 1 - share
    return (
        rest**2 * (1 + 2 * share) * left.unknowns
        + share**2 * (1 + 2 * rest) * right.unknowns
        + share * rest * length * (rest * left.tangent - share * right.tangent)
    )
