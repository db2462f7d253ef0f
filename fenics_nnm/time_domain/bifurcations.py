r"""Bifurcations of the exact motions of a branch, found from their Floquet multipliers.

Where a kind of instability begins or ends between two neighbouring points, a pair of multipliers
has left the unit circle or come back to it:

    through +1, with an extremum of the energy along the family      fold
    through +1, without                                              symmetry breaking
    through -1                                                       period doubling
    in a collision of two complex pairs (Krein)                      Neimark-Sacker

(in a conservative system the last is also called Hamiltonian Hopf bifurcation; the first two are
distinguished by the tangent of the family). The place is bracketed by motions that are shot between
the two, see `time_domain.chord`; between the last two a smooth function of the multipliers, which
changes sign there, is taken linear, see `time_domain.crossing`.

A family that is nearly square to the chord may lead back beyond the first motion, over what was
found before it: that is kept once, and the change of stability is reported as one without
a place.

Pairs that leave while another one of their kind is outside already are not reported, nor is what
begins and ends between two points.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from fenics_nnm.arrays import Array, Complex
from fenics_nnm.time_domain.chord import TOLERANCE, Budget, Chord, FamilyMotion
from fenics_nnm.time_domain.crossing import crossing
from fenics_nnm.time_domain.integrator import Integrator
from fenics_nnm.time_domain.shooting import ShotMotion, mean_gamma, mean_gamma_of
from fenics_nnm.time_domain.stability import COMPLEX, DOUBLING, Stability

FOLD = "fold"
SYMMETRY_BREAKING = "symmetry breaking"
PERIOD_DOUBLING = "period doubling"
NEIMARK_SACKER = "Neimark-Sacker"
KINDS = (FOLD, SYMMETRY_BREAKING, PERIOD_DOUBLING, NEIMARK_SACKER)

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
class BifurcationPoint:
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
class Bifurcation(BifurcationPoint):
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
    flow: Integrator, witnesses: Sequence[Witness | None], *, reversible: bool
) -> Bifurcations:
    """Bifurcations between neighbouring points of a branch.

    Args:
        flow: Integrator of the model, in SI units.
        witnesses: The exact motion of each point, None where there is none.
        reversible: Whether the motions are time-reversible and start at rest.
    """
    budget = Budget(_MOST_MOTIONS)
    located: list[Bifurcation] = []
    unlocated: list[tuple[float, float]] = []
    for first, second in pairwise(witnesses):
        if first and second and first.stability.instabilities != second.stability.instabilities:
            pair = (first.shot, second.shot), (first.stability, second.stability)
            chord = Chord.between(flow, *pair, budget, reversible=reversible)
            found, complete = _Search(chord, first).located()
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


@dataclass(frozen=True, slots=True)
class _Search:
    """Bifurcations between two neighbouring motions of a branch."""

    chord: Chord
    first: Witness

    def located(self) -> tuple[list[Bifurcation], bool]:
        """Those from one end to the other, and whether they are all there are."""
        found: list[Bifurcation] = []
        left, end = self.chord.first, self.chord.last
        if self.chord.length > _LONGEST:
            return found, False
        for _ in range(_MOST_BETWEEN):
            before, left = self.chord.bracket(left, end)
            if before.distance(left) > TOLERANCE:
                return found, False
            found += self._events(before, left)
            if left.instabilities == end.instabilities:
                return found, True
        return found, False

    def _events(self, before: FamilyMotion, after: FamilyMotion) -> list[Bifurcation]:
        """What happens between two neighbouring motions."""
        changed = before.instabilities ^ after.instabilities
        outside = [sum(map(bool, each.stability.kinds)) for each in (before, after)]
        if outside[0] == outside[1] and COMPLEX in changed and len(changed) > 1:
            return []  # two pairs met on the real axis, outside the circle
        shares = {
            kind: crossing(kind, before.stability, after.stability) for kind in sorted(changed)
        }
        in_order = sorted(shares, key=lambda kind: shares[kind])
        return [self._event(kind, shares[kind], before, after) for kind in in_order]

    def _event(
        self, kind: str, share: float, before: FamilyMotion, after: FamilyMotion
    ) -> Bifurcation:
        """What happens at a share of the way between two neighbouring motions."""
        turns = before.climb * after.climb * (before.tangent @ after.tangent) < 0
        unknowns = before.unknowns + share * (after.unknowns - before.unknowns)
        q, velocity, period = self.chord.equations.state(unknowns)
        unstable = before if kind in before.instabilities else after
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
        q, velocity, _ = self.chord.equations.state(unknowns)
        return self.chord.flow.energy(q, velocity)

    def _gamma_ratio(self, q: Array, velocity: Array, period: float) -> float:
        """Its gamma over that of the first motion, times the ratio of that."""
        flow = self.chord.flow
        periods = 0.5 if self.chord.reversible and not flow.cheap else 1.0
        gamma = mean_gamma_of(flow, q, velocity, period, periods=periods)
        first = mean_gamma(flow, self.first.shot, periods=periods)
        return self.first.gamma_ratio * gamma / first


def _at_rest(shot: ShotMotion) -> bool:
    return float(shot.velocity @ shot.velocity) <= _AT_REST * shot.energy


def _is_odd(direction: Complex) -> bool:
    """Whether a direction is one of velocities, so that time reversal changes its sign."""
    coordinates, velocities = np.split(direction, 2)
    return bool(np.linalg.norm(velocities) > np.linalg.norm(coordinates))
