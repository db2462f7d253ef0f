r"""When contact opens and closes in a period, and points to integrate its forces at in between.

Contact forces that are taken at samples of a period change their harmonics in small jumps of the
slope wherever contact passes a sample, and do some work over a period. Between two events (a point
opens or closes) they are smooth: with the times of the events, and Gauss' rule between them, their
harmonics are exact to round-off, and so smooth functions of the motion, and they do no work.

For contact points without mass, with the set A of points in contact,

    lambda_A = R_AA^-1 (p_A - g_A),      y_c = p_c - g_c - R_cA lambda_A   (c open),

is a harmonic series in time for each set. A point closes where its y_c passes zero, and opens where
-lambda_c does. Contact that is shorter than a sample is found by the largest y between samples.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cache

import numpy as np

from fenics_nnm.arrays import Array, Indices, Mask
from fenics_nnm.mechanics.contact_law import Complementarity, ContactForces
from fenics_nnm.mechanics.fourier import FourierSeries
from fenics_nnm.mechanics.instants import Quadrature

#: Events closer together than this in phase are taken as one.
_TOGETHER = 1e-9

#: Events are located to this phase.
_PRECISE = 1e-13

#: Newton steps to an event; each falls back on halving.
_STEPS = 60

#: Gauss points for N harmonics over a phase L: this times N L, and some more.
_POINTS_A_HARMONIC, _MORE_POINTS = 0.6, 10


#: Contact is looked for at so many samples a harmonic at least.
_SAMPLES_A_HARMONIC = 8

#: Times of contact are looked for this often, with what was found before.
_ROUNDS = 4

#: So many rows of margins are kept for further motions.
_KEPT = 10_000


@dataclass(frozen=True, slots=True)
class Margins:
    """How far points are from a change of contact, by what moves them; kept from call to call.

    Attributes:
        R: Residual flexibility, shape (n_c, n_c).
    """

    R: Array
    _known: dict[tuple[bytes, int], Array] = field(
        default_factory=dict, init=False, repr=False, compare=False
    )

    def row(self, closed: Mask, point: int) -> Array:
        """Derivative of y of a point by p - g with a set in contact, shape (n_c,)."""
        key = (closed.tobytes(), point)
        if key not in self._known:
            if len(self._known) >= _KEPT:
                self._known.clear()
            self._known[key] = self._row(closed, point)
        return self._known[key]

    def _row(self, closed: Mask, point: int) -> Array:
        row = np.zeros(len(closed))
        if not closed[point]:
            row[point] = 1.0
        A = np.flatnonzero(closed)
        if len(A):
            side = self.R[point, A] if not closed[point] else (A == point).astype(float)
            row[A] -= np.linalg.solve(self.R[np.ix_(A, A)], side)
        return row


@dataclass(frozen=True, slots=True)
class FreeMotion:
    """Free displacement of contact points over a period, and what they meet.

    Attributes:
        series: Series in time.
        harmonics: Coefficients of the free displacement p, shape (c, n_c).
        law: Contact law, with R and gaps.
        margins: Distances from changes of contact under this law.
    """

    series: FourierSeries
    harmonics: Array
    law: Complementarity
    margins: Margins

    @classmethod
    def of(cls, series: FourierSeries, harmonics: Array, law: Complementarity) -> FreeMotion:
        """A motion under a law of which nothing is kept."""
        return cls(series, harmonics, law, Margins(law.R))

    def sets_at(self, phase: Array) -> Mask:
        """Points in contact at some phases, shape (s, n_c)."""
        return self.law(self.series.basis_at(phase) @ self.harmonics).force > 0

    def margin(self, closed: Mask, point: int) -> tuple[Array, float]:
        """Coefficients (c,) and offset of y of a point with a set in contact; see the module."""
        row = self.margins.row(closed, point)
        return self.harmonics @ row, float(-row @ self.law.gap)


@dataclass(frozen=True, slots=True)
class Grid:
    """Phases of a period in order, and the points in contact at each.

    Attributes:
        phase: Phases, ascending, shape (s,).
        closed: Points in contact, shape (s, n_c).
    """

    phase: Array
    closed: Mask

    def with_phases(self, phase: Array, closed: Mask) -> Grid:
        """The same with further phases."""
        whole = np.concatenate([self.phase, phase])
        order = np.argsort(whole, kind="stable")
        return Grid(whole[order], np.vstack([self.closed, closed])[order])

    @property
    def changes(self) -> Indices:
        """Phases after which the set is another one at the next, the last one before the first."""
        return np.flatnonzero((self.closed != np.roll(self.closed, -1, axis=0)).any(axis=1))

    @property
    def ends(self) -> Array:
        """The phase after each, that after the last one in the next period."""
        return np.append(self.phase[1:], self.phase[0] + 2 * np.pi)


def forces_in_time(motion: FreeMotion) -> ContactForces:
    """Contact forces of a motion at points of integration between the times of contact.

    Sets in contact that are others at these points than between the times that were found tell of
    times that are still missed: they are looked for again with what is known there.
    """
    law, series = motion.law, _densely_sampled(motion.series)
    motion = replace(motion, series=series)
    at_samples = law(series.synthesis @ motion.harmonics)
    grid = _with_short_contact(motion, at_samples, Grid(series.phase, at_samples.force > 0))
    for _ in range(_ROUNDS):
        instants, closed = _points_of(motion, grid)
        guess = ContactForces.alone(closed.astype(float))
        if not len(closed):
            return replace(guess, instants=instants)
        found = law(instants.synthesis(series) @ motion.harmonics, guess)
        missed = ((found.force > 0) != closed).any(axis=1)
        if not missed.any():
            break
        grid = grid.with_phases(instants.phase[missed] % (2 * np.pi), found.force[missed] > 0)
    return replace(found, instants=instants)


def _densely_sampled(series: FourierSeries) -> FourierSeries:
    """The series itself, or one of as many harmonics with enough samples to find contact."""
    few = series.samples < _SAMPLES_A_HARMONIC * series.harmonics
    return _dense(series.harmonics) if few else series


@cache
def _dense(harmonics: int) -> FourierSeries:
    return FourierSeries(harmonics, _SAMPLES_A_HARMONIC * harmonics)


def _points_of(motion: FreeMotion, grid: Grid) -> tuple[Quadrature, Mask]:
    """Points of integration, and the contact points that are closed there, shape (s, n_c)."""
    if not grid.closed.any():
        return Quadrature(np.empty(0), np.empty(0)), np.zeros((0, len(motion.law.gap)), dtype=bool)
    changes = _changes(motion, grid)
    if not changes:
        changes = [(0.0, grid.closed[0])]
    events = _together(np.array([phase for phase, _ in changes]))
    sets = np.array([closed for _, closed in changes])
    ends = np.append(events[1:], events[0] + 2 * np.pi)
    return _gauss(motion.series.harmonics, events, ends, sets)


def _together(events: Array) -> Array:
    """Events in order, with those that are one but for round-off at the phase of the first."""
    found = events.copy()
    for number in range(1, len(found)):
        if found[number] - found[number - 1] < _TOGETHER:
            found[number] = found[number - 1]
    return found


def _with_short_contact(motion: FreeMotion, forces: ContactForces, grid: Grid) -> Grid:
    """The grid with the tops of y above zero that lie between two samples without a change."""
    series, law = motion.series, motion.law
    free, rates = (
        series.synthesis @ motion.harmonics,
        series.synthesis @ series.turned(motion.harmonics),
    )
    force, force_rates = forces.force, forces.change(rates)
    y = np.where(grid.closed, -force, free - law.gap - force @ law.R)
    slope = np.where(grid.closed, -force_rates, rates - force_rates @ law.R)
    after, slope_after = np.roll(y, -1, axis=0), np.roll(slope, -1, axis=0)
    same = (grid.closed == np.roll(grid.closed, -1, axis=0)).all(axis=1)[:, None]
    step = 2 * np.pi / series.samples
    with np.errstate(divide="ignore", invalid="ignore"):
        top = (after - y - step * slope_after) / (slope - slope_after)
        highest = y + top * slope
    found = same & (slope > 0) & (slope_after < 0) & (highest > 0)
    phases = [
        _top(motion, grid.closed[k], point, grid.phase[k] + np.array([0.0, step]))
        for k, point in zip(*np.nonzero(found), strict=True)
    ]
    if not phases:
        return grid
    further = np.array(phases) % (2 * np.pi)
    return grid.with_phases(further, motion.sets_at(further))


def _top(motion: FreeMotion, closed: Mask, point: int, between: Array) -> float:
    """Phase of the largest y of a point between two phases."""
    coefficients, _ = motion.margin(closed, point)
    rate = -motion.series.turned(coefficients)
    return float(_rises(motion.series, rate[None], np.zeros(1), between[None])[0])


def _changes(motion: FreeMotion, grid: Grid) -> list[tuple[float, Mask]]:
    """Phases at which points open or close, in order, and the sets in contact from then on.

    Of several points that change between two phases of the grid the first one changes first; it
    moves the others, whose changes are looked for after it. Those that change at the same phase,
    as on a symmetric structure, change at once.
    """
    following = np.roll(grid.closed, -1, axis=0)
    gaps = [
        _Gap(float(grid.phase[k]), float(grid.ends[k]), grid.closed[k], following[k], [])
        for k in grid.changes
    ]
    while left := [gap for gap in gaps if gap.changing.size]:
        pairs = [(gap, int(point)) for gap in left for point in gap.changing]
        margins = [motion.margin(gap.closed, point) for gap, point in pairs]
        phases = _rises(
            motion.series,
            np.array([coefficients for coefficients, _ in margins]),
            np.array([offset for _, offset in margins]),
            np.array([(gap.at, gap.end) for gap, _ in pairs]),
        )
        for gap in left:
            own = [number for number, (each, _) in enumerate(pairs) if each is gap]
            first = float(phases[own].min())
            gap.change(first, [pairs[n][1] for n in own if phases[n] - first < _TOGETHER])
    return [change for gap in gaps for change in gap.found]


@dataclass(slots=True)
class _Gap:
    """The way from the set at one phase of the grid to that at the next.

    Attributes:
        at: Phase that is reached.
        end: Phase of the next one.
        closed: Points in contact where it is reached.
        after: Those at the end.
        found: Changes so far.
    """

    at: float
    end: float
    closed: Mask
    after: Mask
    found: list[tuple[float, Mask]]

    @property
    def changing(self) -> Indices:
        """Points that are still to change."""
        return np.flatnonzero(self.closed != self.after)

    def change(self, phase: float, points: list[int]) -> None:
        """Some points change at a phase."""
        self.at, self.closed = phase, self.closed.copy()
        self.closed[points] = self.after[points]
        self.found.append((phase, self.closed))


def _rises(series: FourierSeries, coefficients: Array, offset: Array, between: Array) -> Array:
    """Phases at which series plus offsets rise through zero; an end, where it lies beyond.

    Args:
        series: Series.
        coefficients: Coefficients of k series, shape (k, c).
        offset: Offsets, shape (k,).
        between: Phases to look between, shape (k, 2).
    """
    low, high = between.T.copy()
    first, last = (
        np.einsum("kc,kc->k", series.basis_at(end), coefficients) + offset for end in (low, high)
    )
    beyond = (first >= 0) | (last <= 0)
    ends = np.where(first >= 0, low, high)
    turned = series.turned(coefficients.T).T
    at = low - first * (high - low) / np.where(beyond, 1.0, last - first)
    at = np.where(beyond, ends, at)
    for _ in range(_STEPS):
        basis = series.basis_at(at)
        value = np.einsum("kc,kc->k", basis, coefficients) + offset
        slope = np.einsum("kc,kc->k", basis, turned)
        low, high = np.where(value < 0, at, low), np.where(value < 0, high, at)
        new = at - value / np.where(slope > 0, slope, np.inf)
        inside = (slope > 0) & (new >= low) & (new <= high)
        new = np.where(beyond, ends, np.where(inside, new, (low + high) / 2))
        if np.abs(new - at).max() < _PRECISE:
            break
        at = new
    return np.asarray(at)


@cache
def _rule(count: int) -> tuple[Array, Array]:
    """Points and weights of Gauss' rule on (-1, 1)."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return nodes, weights


def _gauss(harmonics: int, starts: Array, ends: Array, sets: Mask) -> tuple[Quadrature, Mask]:
    """Gauss' rule on each of some intervals with contact, with their sets."""
    phases, shares, closed = [], [], []
    for start, end, own in zip(starts, ends, sets, strict=True):
        if not own.any() or end <= start:
            continue
        count = int(np.ceil(_POINTS_A_HARMONIC * harmonics * (end - start))) + _MORE_POINTS
        nodes, weights = _rule(count)
        phases.append(start + (nodes + 1) / 2 * (end - start))
        shares.append(weights * (end - start) / (4 * np.pi))
        closed.append(np.broadcast_to(own, (count, sets.shape[1])))
    if not phases:
        return Quadrature(np.empty(0), np.empty(0)), np.zeros((0, sets.shape[1]), dtype=bool)
    return Quadrature(np.concatenate(phases), np.concatenate(shares)), np.vstack(closed)
