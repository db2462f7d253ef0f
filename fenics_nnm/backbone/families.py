"""Which points of a branch are of one family of motions, and where neighbours are not.

The slope s = d ln f / d ln gamma of a family is known at each of its points, so that two of them,
x = ln gamma apart by d, are expected to differ in ln f by what lies between s_1 d and s_2 d. If
they differ by something else, then they are of two families, or of two ways of one.

The *main branch* is what lets internal resonances aside: of all chains of points of which each
follows from the one before it, that which leads farthest, a point where the frequency rises by
little counting for less; points where it hardly rises, or stands still, are no links. A point
between two links is on the main branch if its frequency is within 2e-3 of the cubic through both
with their slopes. Motions without contact belong to it. All others are of other families, those
that follow from each other of one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.backbone.family_jumps import Jump, contacts
from fenics_nnm.backbone.point import MAIN_BRANCH, BranchPoint
from fenics_nnm.backbone.resonance import LAGS, STILL
from fenics_nnm.mechanics.fourier import Series

#: Frequencies that differ by more than this part are not the same.
SAME_FREQUENCY = 1e-3

#: A point follows from another one, or is on the main branch, to this part of its frequency, and to
#: a part of the expected change.
_FOLLOWS, _OF_CHANGE = 2e-3, 0.05

#: A point whose frequency rises by less than this part of that of the followed mode alone, and less
#: than half as much as is usual on the branch, is no link of the main branch.
_HARDLY = 0.25

#: Of points that are farther apart in ln gamma, and than some steps, nothing is said.
_FARTHEST, _STEPS = 0.5, 2.5

#: A wider way, in ln gamma, counts no more.
_WIDEST = 0.2

#: Where contact begins the frequency may rise with the square root of what is beyond: twice as far
#: as the slope at the end of the way says. So it may where another point begins to touch.
_KINK = 2.0


@dataclass(frozen=True, slots=True)
class Expected:
    """Between what a frequency is expected to change, as ln of its factor."""

    low: float
    high: float

    def miss(self, change: float) -> float:
        """How far a change is outside."""
        return max(self.low - change, change - self.high, 0.0)

    @property
    def tolerance(self) -> float:
        """How far outside a change may be."""
        return _FOLLOWS + _OF_CHANGE * max(abs(self.low), abs(self.high))

    def inner(self) -> Expected:
        """The middle half of it."""
        quarter = (self.high - self.low) / 4
        return Expected(self.low + quarter, self.high - quarter)

    def widened(self) -> Expected:
        """The same where contact may begin at a further point on the way."""
        return Expected(
            min(self.low * _KINK, self.low / _KINK), max(self.high * _KINK, self.high / _KINK)
        )


@dataclass(frozen=True, slots=True)
class Course:
    """What is known of the course of the frequency over the energy at the points of a branch.

    Attributes:
        x: ln of the gamma ratios, shape (p,).
        y: ln of the frequency ratios, shape (p,).
        slope: Slopes dy / dx; where they are not known the smaller one of those to both neighbours,
            0 if they have other signs.
        rise: Slopes over those of the followed mode alone, 1 where they are not known.
        mild: The slopes, none steeper than that of the followed mode alone, or than is usual if
            that is more.
        weight: What a point counts as a link of the main branch; 0 for no link.
        linear: Which motions are linear, without contact.
        farthest: Points that are farther apart in x do not tell whether they follow.
        connected: Whether each point was followed continuously from the one before it.
        joined: Numbers of the points that an exact family joins to the next one.
    """

    x: Array
    y: Array
    slope: Array
    rise: Array
    mild: Array
    weight: Array
    linear: Array
    farthest: float
    connected: bool
    joined: frozenset[int] = frozenset()

    @classmethod
    def of(
        cls, points: Sequence[BranchPoint], *, connected: bool, joined: frozenset[int] = frozenset()
    ) -> Course:
        """That of points in the order of the branch."""
        x = np.log([point.gamma_ratio for point in points])
        y = np.log([point.frequency_ratio for point in points])
        linear = np.array([point.is_linear for point in points], dtype=bool)
        own = np.array([point.notes.slope for point in points])
        slope = np.where(linear, 0.0, np.where(np.isnan(own), _smaller_secants(x, y), own))
        rise = np.array([point.rise for point in points])
        rise = np.where(np.isnan(rise) | linear, 1.0, rise)
        usual = float(np.median(rise[~linear])) if not linear.all() else 1.0
        counts = np.where(rise < _least(usual), 0.0, np.minimum(rise, 1.0))
        weight = np.where(linear, 0.0, counts * (_widths(x) + 1e-9))
        mild = slope / np.maximum(rise / max(usual, 1.0), 1.0)
        step = float(np.median(np.abs(np.diff(x)))) if len(x) > 1 else 0.0
        farthest = max(_FARTHEST, _STEPS * step)
        return cls(x, y, slope, rise, mild, weight, linear, farthest, connected, joined)

    def expected(self, i: int, j: int) -> Expected:
        """Between what ln f is expected to change from a point to a later one."""
        return self._expected(i, j, self.slope)

    def mildly(self, i: int, j: int) -> Expected:
        """The same with the mild slopes."""
        return self._expected(i, j, self.mild)

    def change(self, i: int, j: int) -> float:
        """Change of ln f from a point to another one."""
        return float(self.y[j] - self.y[i])

    def follows(self, i: int, j: int) -> bool:
        """Whether a later point is where the family of an earlier one is expected.

        Where the frequency of one of them hardly rises it is to be nearer to what the mean of both
        slopes says; so it is over points in between, and with mild slopes: where a resonance has
        been left they are steeper, for a little while.
        """
        if self._far(i, j) or (j == i + 1 and (self.connected or i in self.joined)):
            return j == i + 1
        expected = self.expected(i, j) if j == i + 1 else self.mildly(i, j)
        if j > i + 1 or min(self.rise[i], self.rise[j]) < LAGS:
            expected = expected.inner()
        return expected.miss(self.change(i, j)) <= expected.tolerance

    def jumps(self, i: int) -> bool:
        """Whether the next point is nowhere near where this one's family is expected."""
        if self._far(i, i + 1) or self.follows(i, i + 1):
            return False
        expected = self.mildly(i, i + 1)
        if self.linear[i] == self.linear[i + 1]:
            expected = expected.widened()
        return expected.miss(self.change(i, i + 1)) > SAME_FREQUENCY

    def between(self, i: int, j: int, k: int) -> float:
        """Ln f at point k on the cubic through two points with their slopes; nan outside."""
        width = self.x[j] - self.x[i]
        t = (self.x[k] - self.x[i]) / width if width else -1.0
        if not 0 <= t <= 1:
            return float("nan")
        values = (2 * t**3 - 3 * t**2 + 1) * self.y[i] + (3 * t**2 - 2 * t**3) * self.y[j]
        first, last = (t**3 - 2 * t**2 + t) * self.mild[i], (t**3 - t**2) * self.mild[j]
        return float(values + width * (first + last))

    def _expected(self, i: int, j: int, slope: Array) -> Expected:
        if self.linear[i] != self.linear[j]:
            end, sense = (j, 1) if self.linear[i] else (i, -1)
            return _from_grazing(sense * float(slope[end] * self.x[end]))
        ends = sorted(float(slope[k] * (self.x[j] - self.x[i])) for k in (i, j))
        return Expected(*ends)

    def _far(self, i: int, j: int) -> bool:
        return bool(abs(self.x[j] - self.x[i]) > self.farthest)


@dataclass(frozen=True, slots=True)
class Families:
    """Families of the points of a branch.

    Attributes:
        numbers: Number of the family of each point: `MAIN_BRANCH`, or 2, 3 ..
        by_course: The same by the course of the frequency alone.
        behind: Whether the frequency of each lags behind the main branch, or may do so: it is off
            that and nearer to the linear one than the nearest link says (so are all where there
            are no links), or on it and no link, or among its last links, rises by little, and
            nothing beyond tells.
        jumps: Neighbours whose frequencies do not follow from each other.
    """

    numbers: tuple[int, ...] = ()
    by_course: tuple[int, ...] = ()
    behind: tuple[bool, ...] = ()
    jumps: tuple[Jump, ...] = ()


def families(
    points: Sequence[BranchPoint],
    series: Series,
    *,
    connected: bool = False,
    joined: frozenset[int] = frozenset(),
) -> Families:
    """The families of points in the order of the branch.

    Points that an exact family joins to a neighbour are of its family, of the main branch first;
    whether a frequency lags behind that is said of them as before.

    Args:
        points: Points.
        series: Series that they are written in.
        connected: Whether each was followed continuously from the one before it, as by arc-length.
        joined: Numbers of the points that an exact family joins to the next one.
    """
    if not points:
        return Families()
    course = Course.of(points, connected=connected, joined=joined)
    links = _links(course)
    numbers = _numbers(course, links)
    told = set(links) - set(_last(course, links))
    behind = [
        k not in told and not course.linear[k]
        if number == MAIN_BRANCH
        else _behind(course, links, k)
        for k, number in enumerate(numbers)
    ]
    ways = (i for i in range(len(points) - 1) if course.jumps(i))
    found = [_jump(course, points[i], points[i + 1], i, series) for i in ways]
    return Families(tuple(_united(numbers, joined)), tuple(numbers), tuple(behind), tuple(found))


def _links(course: Course) -> list[int]:
    """The chain of points that is the main branch: the one of the largest weight.

    What a link passes over is taken off, in half.
    """
    weight = [float(each) for each in course.weight]
    passed = np.concatenate([[0.0], np.cumsum(course.weight)]) / 2
    able = [k for k, each in enumerate(weight) if each > 0]
    best, before = list(weight), [-1] * len(weight)
    for at, j in enumerate(able):
        for i in able[:at]:
            gained = best[i] + weight[j] - float(passed[j] - passed[i + 1])
            if gained > best[j] and course.follows(i, j):
                best[j], before[j] = gained, i
    chain = [max(able, key=lambda k: best[k])] if able else []
    while chain and before[chain[-1]] >= 0:
        chain.append(before[chain[-1]])
    return chain[::-1]


def _numbers(course: Course, links: list[int]) -> list[int]:
    """Number of the family of each point."""
    numbers: list[int] = []
    for k in range(len(course.x)):
        main = course.linear[k] or k in links or _on_main(course, links, k)
        numbers.append(MAIN_BRANCH if main else _other(course, numbers, k))
    return numbers


def _united(numbers: Sequence[int], joined: frozenset[int]) -> list[int]:
    """The numbers where points that are joined are of one family: that of the smallest number."""
    united = list(numbers)
    for i in sorted(joined) + sorted(joined, reverse=True):
        united[i] = united[i + 1] = min(united[i], united[i + 1])
    order = sorted({MAIN_BRANCH, *united})
    return [order.index(number) + MAIN_BRANCH for number in united]


def _on_main(course: Course, links: list[int], k: int) -> bool:
    """Whether a point that is no link has the frequency of the main branch at its energy."""
    after = int(np.searchsorted(links, k))
    if not 0 < after < len(links):
        return False
    expected = course.between(links[after - 1], links[after], k)
    return bool(abs(course.y[k] - expected) <= _FOLLOWS)


def _behind(course: Course, links: list[int], k: int) -> bool:
    """Whether the frequency is nearer to the linear one than the nearest link and its slope say."""
    if not links:
        return True
    nearest = min(links, key=lambda i: abs(i - k))
    expected = course.y[nearest] + course.slope[nearest] * (course.x[k] - course.x[nearest])
    return bool(abs(course.y[k]) < abs(expected))


def _last(course: Course, links: list[int]) -> list[int]:
    """The last links, as far back as all of them rise by little."""
    until = len(links)
    while until and course.rise[links[until - 1]] < LAGS:
        until -= 1
    return links[until:]


def _other(course: Course, numbers: Sequence[int], k: int) -> int:
    """The latest other family that a point follows from, or a new one."""
    for i in range(k - 1, -1, -1):
        if numbers[i] != MAIN_BRANCH and course.follows(i, k):
            return numbers[i]
    return max([MAIN_BRANCH, *numbers]) + 1


def _jump(course: Course, one: BranchPoint, other: BranchPoint, i: int, series: Series) -> Jump:
    """The jump from point i, which is `one`, to the next."""
    expected = course.mildly(i, i + 1)
    return Jump(
        gamma_ratios=(one.gamma_ratio, other.gamma_ratio),
        change=float(np.expm1(course.change(i, i + 1))),
        predicted=(float(np.expm1(expected.low)), float(np.expm1(expected.high))),
        contacts=(contacts(series, one.motion), contacts(series, other.motion)),
    )


def _from_grazing(change: float) -> Expected:
    """From the end of the linear motions, with the change that the slope beyond it says."""
    ends = sorted((0.0, _KINK * change))
    return Expected(*ends)


def _least(usual: float) -> float:
    """The rise that a link of the main branch has at least, by the median of all points."""
    return max(STILL, min(_HARDLY, usual / 2))


def _smaller_secants(x: Array, y: Array) -> Array:
    """The smaller one of the slopes to both neighbours, 0 where they have other signs."""
    if len(x) < 2:
        return np.zeros(len(x))
    step = np.diff(x)
    secant = np.divide(np.diff(y), step, out=np.zeros(len(step)), where=step != 0)
    left, right = np.r_[secant[:1], secant], np.r_[secant, secant[-1:]]
    smaller = np.where(np.abs(left) < np.abs(right), left, right)
    return np.where(left * right > 0, smaller, 0.0)


def _widths(x: Array) -> Array:
    """Half of the way from each point's neighbour before it to that after it, if they are near."""
    if len(x) < 2:
        return np.ones(len(x))
    step = np.minimum(np.abs(np.diff(x)), _WIDEST)
    return np.asarray((np.r_[step[:1], step] + np.r_[step, step[-1:]]) / 2)
