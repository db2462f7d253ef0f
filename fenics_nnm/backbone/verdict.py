"""What may be believed of each point of a branch.

The independent witness is integration in time of the reduced model. It verifies a point, unless
the reduction is expected to put its frequency off by more than 1e-3, in one of three ways:

* below grazing, or lift-off, the motion is the linear mode, in closed form;
* the motion starts with its energy within 1 % and comes back within 5 % after a period, and the
  exact motion of the same energy that shooting finds is near it (10 %) and has its frequency
  (1e-3);
* where no such motion is found, it starts with its energy within 2e-3 and comes back within 2 %
  after ten periods.

The last is a bound, if a safe one only as far as errors do not cancel: a relative error d of the
frequency shifts the phase by 20 pi d in ten periods, which moves the state by as much of its
amplitude or more; so d <= 0.02 / 20 pi = 3e-4. The energy of the state that is followed is within
2e-3 of that of the point, for d ln omega / d ln E < 0.3 another 6e-4. Of 87 motions of random
models that came back within 2 %, the worst was 1.2e-4 from the exact frequency.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.backbone.certificate import (
    NO_CERTIFICATE,
    Certificate,
    certified,
    of_linear_mode,
)
from fenics_nnm.backbone.exact_joins import Joins, exact_joins
from fenics_nnm.backbone.families import Families, families
from fenics_nnm.backbone.family_jumps import Jump
from fenics_nnm.backbone.periodicity import NOT_FOLLOWED, PERIODS, InTime, followed
from fenics_nnm.backbone.point import (
    CONVERGED,
    FAILED,
    MAIN_BRANCH,
    RESONANT,
    VERIFIED,
    BranchPoint,
    Orbit,
    Verdict,
)
from fenics_nnm.backbone.resonance import (
    STILL,
    UNNAMED,
    largest_share,
    left_behind,
    strongest_resonance,
)
from fenics_nnm.backbone.wanted import Followed
from fenics_nnm.mechanics.fourier import Series
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.time_domain.bifurcations import Bifurcations, bifurcations
from fenics_nnm.time_domain.integrator import Integrator

#: A motion that misses its start by more than this part of its amplitude is no motion.
_LARGEST_RETURN_ERROR = 1 / 3

#: So is one whose exact motion of the same energy has another frequency by more than this part.
_LARGEST_SHOT_CHANGE = 0.01

#: Nor does one solve its equations whose virial identity, or complementarity, is off by more.
_LARGEST_EQUATION_ERROR = 1e-6

#: Verified: return error after a period, error of the energy of the initial state, and what the
#: exact motion, and the motion without reduction if that is known, may differ by from the point.
VERIFIED_RETURN_ERROR = 0.05
_VERIFIED_START_ENERGY = 0.01
VERIFIED_CHANGE = 1e-3
_VERIFIED_DISTANCE = 0.1
_VERIFIED_SHOT_RETURN_ERROR = 1e-10

#: Verified without an exact motion: return error after ten periods, and the same of the energy.
_VERIFIED_RETURN_ERROR_10 = 0.02
_VERIFIED_START_ENERGY_ALONE = 2e-3

#: Nor is the frequency of a point to be trusted of which a larger error is expected: of its series,
#: and of the reduction, whose sign is known and told.
LARGEST_SERIES_ERROR, LARGEST_REDUCTION_ERROR = 0.01, 0.02

#: That of the series is an order of magnitude where its step leaves more of the defect than this
#: part, and is then to be so many times larger.
_UNSURE, _ORDER = 0.5, 10

#: Why points of models without an integration in time are not verified.
WITH_MASS = "contact points carry mass: there is no motion in time to compare with"


@dataclass(frozen=True, slots=True)
class Judgement:
    """What integration in time says of a branch.

    Attributes:
        points: Points with their verdicts.
        bifurcations: Bifurcations of its exact motions.
        jumps: Neighbours whose frequencies do not follow from each other.
    """

    points: tuple[BranchPoint, ...]
    bifurcations: Bifurcations
    jumps: tuple[Jump, ...] = ()


@dataclass(frozen=True, slots=True)
class Evidence:
    """What integration in time, and shooting, say of a point."""

    followed: InTime
    certificate: Certificate


@dataclass(frozen=True, slots=True)
class Judged:
    """A branch with its verdicts, and what they rest on.

    Attributes:
        found: The branch, without verdicts.
        evidence: What is known of each of its points.
        points: Its points with their verdicts.
        jumps: Neighbours whose frequencies do not follow from each other.
    """

    found: Followed
    evidence: tuple[Evidence, ...]
    points: tuple[BranchPoint, ...]
    jumps: tuple[Jump, ...]


@dataclass(slots=True)
class Judge:
    """Judges branches of a model.

    Beyond grazing, points of a model whose contact points carry mass are "converged" at best: their
    motion after an impact depends on an impact law that harmonic balance does not have.

    Attributes:
        model: Reduced model in SI units.
        series: Series that the points are written in.
        flow: What follows its motions in time; None where contact points carry mass.
        mode: Index of the followed mode.
        harmonic: Harmonic that it is written in.
        shooting: Whether to shoot for the true motion near each point.
    """

    model: ReducedModel
    series: Series
    flow: Integrator | None
    mode: int
    harmonic: int
    shooting: bool
    _joins: Joins | None = field(init=False)

    def __post_init__(self) -> None:
        reversible = not self.series.free_phase
        self._joins = Joins(self.flow, reversible) if self.flow is not None else None

    @property
    def costs_little(self) -> bool:
        """Whether motions can be followed in time at little cost."""
        return self.flow is not None and self.flow.cheap

    def judged(self, found: Followed) -> Judged:
        """A branch with its verdicts."""
        return self._with(found, tuple(self._evidence(found.points)))

    def exchanged(self, known: Judged, i: int, point: BranchPoint) -> Judged:
        """A branch of which one point is another motion, judged anew with what is known."""
        before, after = slice(i), slice(i + 1, None)
        points = (*known.found.points[before], point, *known.found.points[after])
        own = self._evidence([point])
        evidence = (*known.evidence[before], *own, *known.evidence[after])
        return self._with(replace(known.found, points=points), evidence)

    def judgement(self, known: Judged) -> Judgement:
        """What is said of a branch, with its bifurcations."""
        if self.flow is None or not self.shooting:
            return Judgement(known.points, Bifurcations(), known.jumps)
        witnesses = [each.certificate.witness for each in known.evidence]
        along = bifurcations(self.flow, witnesses, reversible=not self.series.free_phase)
        return Judgement(known.points, along, known.jumps)

    def _evidence(self, points: Sequence[BranchPoint]) -> list[Evidence]:
        return _evidence_of(self.flow, self.series, points, shooting=self.shooting)

    def _with(self, found: Followed, evidence: tuple[Evidence, ...]) -> Judged:
        of = _families(self._joins, self.series, found, evidence)
        others = np.delete(self.model.at_rest().omega, self.mode)
        behind = [
            late or (course != MAIN_BRANCH and point.rise < STILL)
            for point, course, late in zip(found.points, of.by_course, of.behind, strict=True)
        ]
        verdicts = tuple(
            _judged(
                point,
                _place(self._resonance(point, course), point, family, behind=late),
                each,
                others,
                massless=self.model.massless,
            )
            for point, family, course, late, each in zip(
                found.points, of.numbers, of.by_course, behind, evidence, strict=True
            )
        )
        return Judged(found, evidence, verdicts, of.jumps)

    def _resonance(self, point: BranchPoint, family: int) -> str:
        return internal_resonance(self.model, self.series, point, family, self.mode, self.harmonic)


def doubted(points: tuple[BranchPoint, ...], doubt: str) -> tuple[BranchPoint, ...]:
    """The points, none of them verified where a doubt stands against all."""
    if not doubt:
        return points
    return tuple(_doubted(point, doubt) for point in points)


def _doubted(point: BranchPoint, doubt: str) -> BranchPoint:
    if point.verdict is None or point.verdict.status != VERIFIED:
        return point
    verdict = replace(point.verdict, status=CONVERGED, reason=doubt, confirmed=False)
    return replace(point, verdict=verdict)


@dataclass(frozen=True, slots=True)
class _Place:
    """Where a point is: number of its family, and mode and harmonic of an internal resonance.

    It is inside the resonance if it lags behind the main branch, or if its slope does not tell.
    """

    family: int
    resonance: str
    inside: bool


def _families(
    joins: Joins | None, series: Series, found: Followed, evidence: Sequence[Evidence]
) -> Families:
    """Families by the course of the frequency, and by exact motions where that parts neighbours."""
    points = found.points
    of = families(points, series, connected=found.connected)
    if joins is None:
        return of
    witnesses = [each.certificate.witness for each in evidence]
    joined: frozenset[int] = frozenset()
    while more := exact_joins(joins, points, witnesses, of):
        joined |= more
        of = families(points, series, connected=found.connected, joined=joined)
    return of


def _place(resonance: str, point: BranchPoint, family: int, *, behind: bool) -> _Place:
    """Where a point is; without a slope energy in a resonance is enough to be inside."""
    inside = bool(np.isnan(point.rise)) or behind
    return _Place(family, resonance, inside=bool(resonance) and inside)


def internal_resonance(
    model: ReducedModel,
    series: Series,
    point: BranchPoint,
    family: int,
    mode: int,
    harmonic: int = 1,
) -> str:
    """The mode and harmonic that draw energy from the motion in resonance, or nothing."""
    if point.is_linear:
        return ""
    q, omega = point.motion.q, 2 * np.pi * point.motion.frequency
    found = strongest_resonance(model, series, q, omega, mode=mode, harmonic=harmonic)
    if found.entered:
        return str(found)
    by_mode, slope = q @ model.at_rest().shapes, point.rise
    held = left_behind(series, by_mode, slope, mode=mode, harmonic=harmonic)
    if family == MAIN_BRANCH or not held:
        return ""
    return found.named(largest_share(series, by_mode, mode, harmonic))


def _evidence_of(
    flow: Integrator | None, series: Series, points: Sequence[BranchPoint], *, shooting: bool
) -> list[Evidence]:
    """What integration in time, and shooting, say of points."""
    if flow is None:
        return [Evidence(NOT_FOLLOWED, NO_CERTIFICATE) for _ in points]
    rough = flow.rough
    return [_evidence(flow, rough, series, point, shooting=shooting) for point in points]


def _evidence(
    flow: Integrator, rough: Integrator, series: Series, point: BranchPoint, *, shooting: bool
) -> Evidence:
    """What they say of a point; ten periods where nothing else tells, or they cost little.

    Shooting begins with the period that was followed, so that this is an exact one.
    """
    once = shooting and not flow.cheap
    first, periods = (flow, 1) if once else (rough, PERIODS)
    found = followed(first, series, point.motion, periods=periods)
    certificate = NO_CERTIFICATE
    if shooting and found.returned is not None:
        certificate = certified(flow, series, point, found.returned)
    if once and certificate.orbit is None:
        found = followed(rough, series, point.motion)
    return Evidence(found, certificate)


def _judged(
    point: BranchPoint, place: _Place, evidence: Evidence, others: Array, *, massless: bool
) -> BranchPoint:
    """A point with its verdict.

    `others` are the circular frequencies of the linear modes besides the followed one.
    """
    orbit, stability = evidence.certificate.orbit, evidence.certificate.stability
    if point.is_linear:
        orbit, stability = of_linear_mode(point.motion.frequency, others)
    returned = evidence.followed.returned
    known = replace(point, returned=returned, orbit=orbit, stability=stability)
    return replace(known, verdict=_verdict(known, place, evidence, massless=massless))


def _verdict(point: BranchPoint, place: _Place, evidence: Evidence, *, massless: bool) -> Verdict:
    """The status of a point, and the reason for any but the best."""
    doubt = "" if point.is_linear else _doubt(point, evidence) if massless else WITH_MASS
    failure = _failure(point, evidence.followed)
    if not failure and not place.inside:  # of those inside a resonance no frequency is trusted
        failure = _too_far_off(point, confirmed=not doubt)
    if failure:
        return Verdict(FAILED, failure, place.resonance, family=place.family)
    status, reason = CONVERGED if doubt else VERIFIED, doubt
    if place.inside:
        draw = "draw" if place.resonance == UNNAMED else "draws"
        status, reason = RESONANT, f"{place.resonance} {draw} energy from the motion"
        reason += f"; not confirmed in time: {doubt}" if doubt else ", which is confirmed in time"
    elif doubt and place.family != MAIN_BRANCH:
        reason = f"{doubt}; a motion of family {place.family}, off the main branch"
    return Verdict(status, reason, place.resonance, confirmed=not doubt, family=place.family)


def _failure(point: BranchPoint, followed: InTime) -> str:
    """What shows that the point is no motion of the model, or nothing."""
    balance, returned = point.balance, point.returned
    if balance.virial_error > _LARGEST_EQUATION_ERROR:
        return f"the virial identity is off by {balance.virial_error:.1e}"
    if balance.complementarity > _LARGEST_EQUATION_ERROR:
        return f"force times gap is {balance.complementarity:.1e} and not zero at a sample"
    if followed.failure and returned is None:
        return f"integration in time gave up: {followed.failure}"
    if returned and returned.after_one > _LARGEST_RETURN_ERROR:
        return f"after one period the motion misses its start by {returned.after_one:.0%}"
    if point.orbit and abs(change := _change(point, point.orbit)) > _LARGEST_SHOT_CHANGE:
        return f"the exact motion of its energy is {change:+.1%} away in frequency"
    return ""


def _too_far_off(point: BranchPoint, *, confirmed: bool) -> str:
    """Whether the errors that are expected are larger than those of any point may be, or nothing.

    Those of the series are estimates, which integration in time may confirm or contradict.
    """
    reduction, series = point.expected.reduction, point.expected.series
    left_out = abs(reduction.frequency) if reduction else 0.0
    if left_out > LARGEST_REDUCTION_ERROR:
        return f"the reduction is expected to put its frequency off by {left_out:.1%}"
    if series is None or confirmed or point.orbit:
        return ""
    discrete = abs(series.harmonics) + abs(series.samples)
    largest = LARGEST_SERIES_ERROR * (_ORDER if series.remainder > _UNSURE else 1)
    if discrete > largest:
        return f"its harmonics and samples are expected to put its frequency off by {discrete:.1%}"
    return ""


def contradicted(point: BranchPoint) -> bool:
    """Whether a point failed for another reason than the error that is expected of it."""
    if point.status != FAILED or point.returned is None:
        return point.status == FAILED
    found = _failure(point, InTime(point.returned, float("nan")))
    return bool(found) or not _too_far_off(point, confirmed=False)


def _doubt(point: BranchPoint, evidence: Evidence) -> str:
    """Why integration in time does not confirm the point, or nothing."""
    reduction = point.expected.reduction
    if reduction and abs(reduction.frequency) > VERIFIED_CHANGE:
        return f"the reduction is expected to put its frequency off by {reduction.frequency:+.2%}"
    if point.orbit:
        return _doubt_beside_exact_motion(point, point.orbit, evidence.followed)
    missed = _doubt_without_exact_motion(evidence.followed)
    why = evidence.certificate.failure
    return f"{missed}; {why}" if missed and why else missed


def _doubt_beside_exact_motion(point: BranchPoint, orbit: Orbit, followed: InTime) -> str:
    returned, change = followed.returned, _change(point, orbit)
    if abs(followed.start_energy) > _VERIFIED_START_ENERGY:
        return _energy_off(followed)
    if returned and returned.after_one > VERIFIED_RETURN_ERROR:
        return f"after one period the motion misses its start by {returned.after_one:.1%}"
    if abs(change) > VERIFIED_CHANGE:
        return f"the exact motion of its energy is {change:+.2%} away in frequency"
    if orbit.distance > _VERIFIED_DISTANCE:
        return f"the exact motion of its energy is {orbit.distance:.0%} of the amplitude away"
    if orbit.return_error > _VERIFIED_SHOT_RETURN_ERROR:
        return f"the shot motion misses its start by {orbit.return_error:.1e}"
    return ""


def _doubt_without_exact_motion(followed: InTime) -> str:
    returned = followed.returned
    if followed.failure:
        return f"integration in time gave up: {followed.failure}"
    if returned and not returned.after_ten <= _VERIFIED_RETURN_ERROR_10:
        return f"after ten periods the motion misses its start by {returned.after_ten:.1%}"
    if abs(followed.start_energy) > _VERIFIED_START_ENERGY_ALONE:
        return _energy_off(followed)
    return ""


def _energy_off(followed: InTime) -> str:
    return f"the energy of its initial state is {followed.start_energy:+.2%} off"


def _change(point: BranchPoint, orbit: Orbit) -> float:
    """Frequency of the exact motion over that of the point, less 1."""
    return orbit.frequency / point.motion.frequency - 1
