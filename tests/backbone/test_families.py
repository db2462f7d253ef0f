"""Families of motions against closed forms: none is taken for another, and no jump is silent."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from fenics_nnm.arrays import Array
from fenics_nnm.backbone.coexistence import coexistences, reaches
from fenics_nnm.backbone.families import Families, families
from fenics_nnm.backbone.follow import ArcContinuation, EnergyContinuation, follow
from fenics_nnm.backbone.levels import HarmonicBalance
from fenics_nnm.backbone.point import (
    FREQUENCY_RATIO,
    GAMMA_RATIO,
    MAIN_BRANCH,
    RESONANT,
    VERIFIED,
    Balance,
    BranchPoint,
    ContinuationNotes,
    ExpectedErrors,
    Verdict,
)
from fenics_nnm.continuation.trace_options import ArcLength
from fenics_nnm.mechanics.fourier import CosineSeries
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.mechanics.motion import Motion

SERIES = CosineSeries(3, 12)

#: Contact at the samples of half a period, once and twice a period.
ONCE, TWICE = np.eye(7)[:1].T, np.eye(7)[0][:, None] + np.eye(7)[6][:, None]

Law = Callable[[float], float]


def point(x: float, law: Law, *, force: Array = ONCE, ratio: float = 1.0) -> BranchPoint:
    """A point with the frequency and the slope of a closed form."""
    step = 1e-6
    slope = (np.log(law(x * (1 + step))) - np.log(law(x * (1 - step)))) / (2 * step)
    zero = np.zeros((4, 1))
    motion = Motion(zero, force, zero, law(x), 1.0, x, 0.1)
    return BranchPoint(
        position=x,
        at={GAMMA_RATIO: x, FREQUENCY_RATIO: law(x)},
        motion=motion,
        balance=Balance(0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        expected=ExpectedErrors(None, None),
        notes=ContinuationNotes(1, ratio, slope=slope),
    )


def found(points: list[BranchPoint]) -> Families:
    return families(points, SERIES)


def pressed(energy: float) -> float:
    """Pressed rod: period 3 - 1 / sqrt(1 + 2 E), that at rest is 2."""
    return 2 / (3 - 1 / np.sqrt(1 + 2 * energy))


def pressed_with_two_bounces(energy: float) -> float:
    """Amplitude a = 1 / (10 - 4 T), and E + 1/2 = 2 a^2."""
    return 2 / ((10 - 1 / np.sqrt(energy / 2 + 0.25)) / 4)


def bilinear(stiffness: float) -> Law:
    """An oscillator, m = k = 1, that meets a spring at 1, over its energy by that of grazing."""

    def frequency(ratio: float) -> float:
        if ratio <= 1:
            return 1.0
        free = 2 * np.arccos(-np.sqrt(1 / ratio))
        both = 1 + stiffness
        held = 2 / np.sqrt(both) * np.arccos(1 / np.sqrt(ratio * both - stiffness))
        return float(2 * np.pi / (free + held))

    return frequency


def test_motions_with_two_bounces_are_another_family_of_the_pressed_rod() -> None:
    """They are 9.5 to 12 % above their neighbours, at three energies on the way."""
    energies = np.arange(0.5, 2.4, 0.1)
    other = [5, 11, 15]
    points = [
        point(float(energy), pressed_with_two_bounces, force=TWICE)
        if index in other
        else point(float(energy), pressed)
        for index, energy in enumerate(energies)
    ]
    told = found(points)
    assert [i for i, number in enumerate(told.numbers) if number != MAIN_BRANCH] == other
    assert len(told.jumps) == 6
    for jump, start in zip(told.jumps, (4, 5, 10, 11, 14, 15), strict=True):
        one, next_one = points[start : start + 2]
        assert jump.gamma_ratios == (one.gamma_ratio, next_one.gamma_ratio)
        change = next_one.motion.frequency / one.motion.frequency - 1
        assert jump.change == pytest.approx(change, rel=1e-9) and abs(change) > 0.08
        assert max(abs(each) for each in jump.predicted) < 0.02
        assert sorted(jump.contacts) == [1, 2]
    assert "contacts a period: 1 and 2" in str(told.jumps[0])


@pytest.mark.parametrize("stiffness", [1.0, 10.0, 99.0])
@pytest.mark.parametrize("step", [0.1, 0.3])
def test_no_jump_on_one_family(stiffness: float, step: float) -> None:
    """Also where contact begins with a kink, or with the square root of the energy beyond it."""
    ratios = [*np.arange(0.7, 1.0, step), *np.arange(1.05, 4.0, step)]
    told = found([point(float(ratio), bilinear(stiffness)) for ratio in ratios])
    assert set(told.numbers) == {MAIN_BRANCH} and told.jumps == ()


def test_contact_of_the_rod_does_not_begin_at_its_linear_mode() -> None:
    """The square waves of period T = 3 + 1 / sqrt(2 E) are 2.6 % above the sine that grazes."""

    def law(ratio: float) -> float:
        energy = ratio * np.pi**2 / 16
        return float(4 / (3 + 1 / np.sqrt(2 * energy))) if ratio > 1 else 1.0

    told = found([point(ratio, law) for ratio in (0.8, 0.9, 0.99, 1.1, 1.2, 1.3, 1.4)])
    assert set(told.numbers) == {MAIN_BRANCH}
    (jump,) = told.jumps
    assert jump.gamma_ratios == (0.99, 1.1) and jump.change == pytest.approx(law(1.1) - 1)


def test_a_frequency_that_lags_is_off_the_main_branch() -> None:
    """A tongue that is entered slowly and left with a jump; the branch goes on where it was."""
    law = bilinear(10.0)
    entering = {2.0: 0.5, 2.1: 0.3, 2.2: 0.15, 2.3: 0.05}
    points, at = [], law(1.9)
    for ratio in np.arange(1.1, 3.0, 0.1).round(1).tolist():
        rises = entering.get(ratio, 1.0)
        each = point(ratio, law, ratio=rises)
        if rises < 1:
            at *= (law(ratio) / law(ratio - 0.1)) ** rises
            motion = replace(each.motion, frequency=at)
            notes = replace(each.notes, slope=each.notes.slope * rises)
            each = replace(each, motion=motion, notes=notes, at={**each.at, FREQUENCY_RATIO: at})
        points.append(each)
    told = found(points)
    off = [p.gamma_ratio for p, n in zip(points, told.numbers, strict=True) if n != MAIN_BRANCH]
    assert set(off) >= {2.1, 2.2, 2.3} and set(off) <= set(entering)
    assert all(told.behind[points.index(p)] for p in points if p.gamma_ratio in off)
    (jump,) = told.jumps
    assert jump.gamma_ratios == (2.3, 2.4)


def test_families_at_one_energy_are_told_with_their_range() -> None:
    points = [
        *(point(e, pressed) for e in (1.0, 1.1, 1.2, 1.3)),
        *(point(e, pressed_with_two_bounces) for e in (1.15, 1.25)),
    ]
    numbers = [1, 1, 1, 1, 2, 2]
    confirmed = [
        replace(each, verdict=Verdict(VERIFIED, confirmed=True, family=number))
        for each, number in zip(points, numbers, strict=True)
    ]
    told = coexistences(confirmed)
    assert [each.energy for each in told] == [1.15, 1.2, 1.25]
    for each in told:
        assert each.families == (1, 2)
        exact = (pressed(each.energy), pressed_with_two_bounces(each.energy))
        assert each.frequencies == pytest.approx(exact, rel=1e-3)
    back = [1.0, 1.1, 1.15, 1.05]  # one family that turns back, its frequency rising all the way
    family = [point(energy, lambda x, k=k: 1.0 + 0.01 * k) for k, energy in enumerate(back)]
    turned = [replace(each, verdict=Verdict(VERIFIED, confirmed=True, family=1)) for each in family]
    first, second = coexistences(turned)
    assert (first.energy, second.energy) == (1.05, 1.1)
    part = np.log(1.05 / 1.0) / np.log(1.1 / 1.0)
    assert first.frequencies == pytest.approx((1 + 0.01 * part, 1.03))
    main, other = reaches(confirmed)
    assert (main.points, main.confirmed, main.gamma_ratio) == (4, 4, (1.0, 1.3))
    assert other.frequency == pytest.approx(
        (pressed_with_two_bounces(1.25), pressed_with_two_bounces(1.15))
    )
    assert not coexistences(points)


def rod(modes: int, dispersion: float) -> ReducedModel:
    """L = c = EA = 1, fixed at one end, with the gap 1 at the other.

    Frequencies are by `dispersion` (j + 1/2)^2 too high, as those of finite elements are.
    """
    number = np.arange(modes) + 0.5
    omega = number * np.pi * (1 + dispersion * number**2)
    Phi = np.sqrt(2) * (-1.0) ** np.arange(modes)
    return ReducedModel(omega, Phi[None, :], [[1 - np.sum(Phi**2 / omega**2)]], [1.0])


def test_mouth_of_a_tongue_is_inside_the_resonance() -> None:
    """By its length the rod goes into the tongue of mode 2, below all its motions in contact."""
    wanted = ArcContinuation(0.98, 1.11, arc=ArcLength(step=0.05, points=8))
    branch = follow(rod(4, 1e-5), wanted, HarmonicBalance(6, 48), mode=0, shooting=True)
    beyond = [each for each in branch.points if each.gamma_ratio > 1 + 1e-9]
    assert beyond and branch.jumps == ()
    for each in beyond:
        exact = 4 / (3 + 1 / np.sqrt(2 * each.motion.energy))
        assert each.frequency_ratio < 0.98 * exact
        assert (each.status, each.confirmed) == (RESONANT, True)
        assert each.family != MAIN_BRANCH
        assert each.resonance == "mode 2 in harmonic 3"
    unknown = replace(beyond[0], at={GAMMA_RATIO: 1.05, FREQUENCY_RATIO: 1.0})
    assert unknown.rise == 0 and beyond[0].rise == beyond[0].notes.slope_ratio


def beam(modes: int, stiffness: float) -> ReducedModel:
    """Cantilever, EI = L = 1 and unit mass, with a stop of so many times 3 EI / L^3 at its tip."""

    def characteristic(x: float) -> float:
        return float(np.cos(x) + 1 / np.cosh(x))

    guesses = (np.arange(modes) + 0.5) * np.pi
    roots = np.array([brentq(characteristic, x - 0.6, x + 0.6) for x in guesses])
    Phi = 2 * (-1.0) ** np.arange(modes)
    R = 1 / 3 - np.sum(Phi**2 / roots**4) + 1 / (3 * stiffness)
    return ReducedModel(roots**2, Phi[None, :], [[R]], [1.0])


def test_energy_in_a_mode_is_no_resonance_on_the_main_branch() -> None:
    """A beam at a stiff stop: mode 2 has more than 2.5 % of the energy, and no frequency lags."""
    ratios = (1.5, 1.6, 1.7, 1.8, 3.6, 3.7, 3.8)
    energies = EnergyContinuation(1.2, 3.8, 10.0, report_at=(1.2, 1.3, 1.4, *ratios))
    branch = follow(beam(6, 10.0), energies, HarmonicBalance(16, 192), mode=0, shooting=True)
    at = {each.gamma_ratio: each for each in branch.points}
    for ratio in (3.6, 3.7, 3.8):
        assert (at[ratio].status, at[ratio].family) == (VERIFIED, MAIN_BRANCH)
        assert at[ratio].resonance == "mode 2 in harmonic 5"  # a note
    for ratio in (1.3, 1.4):  # here it lags, and is left with a jump
        assert at[ratio].status == RESONANT and at[ratio].family != MAIN_BRANCH
        assert at[ratio].confirmed
    (jump,) = branch.jumps
    assert jump.gamma_ratios == (1.4, 1.5) and jump.change > 0.03 > jump.predicted[1] * 2


def test_points_that_an_exact_family_joins_are_of_one_family() -> None:
    """Of a beam at a very stiff stop the family of 3.6 goes on to 3.8, its frequency falling."""
    energies = EnergyContinuation(3.5, 3.8, 0.1)
    branch = follow(beam(6, 99.0), energies, HarmonicBalance(40, 384), mode=0, shooting=True)
    assert families(branch.points, CosineSeries(40, 384)).numbers == (1, 1, 2, 2)
    assert {each.family for each in branch.points} == {MAIN_BRANCH} and not branch.jumps
    falling = branch.points[2:]
    assert all(each.notes.slope < 0 and each.status == RESONANT for each in falling)
    said = "other modes draw energy from the motion; not confirmed in time: after one period "
    assert all(each.reason.startswith(said) for each in falling)
