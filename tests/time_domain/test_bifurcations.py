"""Bifurcations of exact motions against closed forms and differences of the period map."""

import csv
import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from test_followed_branches import Command, StudyFile, structure, study
from test_stability import MODEL, by_differences

from fenics_nnm.arrays import Array
from fenics_nnm.backbone.branch import Branch
from fenics_nnm.backbone.follow import EnergyContinuation, follow
from fenics_nnm.backbone.levels import HarmonicBalance
from fenics_nnm.backbone.point_numbers import stability_kind
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.output.pictures.backbone import LinearMode, Places, plot_backbone
from fenics_nnm.time_domain import chord
from fenics_nnm.time_domain.bifurcations import (
    Bifurcation,
    Witness,
    bifurcations,
)
from fenics_nnm.time_domain.crossing import crossing
from fenics_nnm.time_domain.family import Steps, family_tangent, periodic_motion
from fenics_nnm.time_domain.flow import Flow
from fenics_nnm.time_domain.period_map import Target, period_map
from fenics_nnm.time_domain.shooting import OrbitGuess, Shooting, ShotMotion, shoot
from fenics_nnm.time_domain.stability import (
    COMPLEX,
    DOUBLING,
    REAL,
    Stability,
    _kind,
    stability,
)

BALANCE = HarmonicBalance(10, 256)


@cache
def three_modes(*, general: bool = False) -> Branch:
    balance = HarmonicBalance(10, 256, general=general)
    return follow(MODEL, EnergyContinuation(1.5, 2.3, 0.1), balance, mode=0, shooting=True)


def motion(energy: float) -> ShotMotion:
    """The exact motion of an energy, from the nearest point."""
    point = min(three_modes().points, key=lambda point: abs(point.motion.energy - energy))
    flow, steps = Flow(MODEL), Shooting(Steps(walk=60, walk_step=0.01))
    nearest = shoot(flow, OrbitGuess.of(BALANCE.series, point.motion), options=steps)
    target = Target(nearest.q, nearest.velocity, nearest.period, energy)
    equations = period_map(flow, target, reversible=True)
    found = periodic_motion(equations, equations.start, Steps(), keep_energy=True)
    assert not found.failure
    q, velocity, period = equations.state(found.unknowns)
    assert flow.energy(q, velocity) == pytest.approx(energy, rel=1e-11)
    return ShotMotion(q, velocity, period, energy, 0, 0, 0, 0, 0, 0, 0, 0)


def multipliers(energy: float) -> Array:
    """By differences of the period map, without the two that are 1."""
    found = np.linalg.eigvals(by_differences(motion(energy)))
    return np.delete(found, np.argsort(np.abs(found - 1))[:2])


def test_kinds_in_the_order_of_the_branch() -> None:
    found = three_modes().bifurcations
    assert not found.unlocated
    assert [(b.kind, b.stable_before, b.stable_after) for b in found.located] == [
        ("Neimark-Sacker", True, False),
        ("Neimark-Sacker", False, True),
        ("period doubling", True, False),
    ]
    for each in found.located:
        assert min(each.bracket) < each.energy < max(each.bracket)
        assert abs(each.bracket[1] / each.bracket[0] - 1) < 3e-3
        assert abs(each.multiplier) == pytest.approx(1, abs=1e-12)
    places = [b.gamma_ratio for b in found.located]
    assert places == sorted(places)
    assert 1.6 < places[0] < 1.7


@pytest.mark.parametrize("number", [0, 1, 2])
def test_multipliers_leave_the_circle_there(number: int) -> None:
    """Differences of the flow on both sides of the place."""
    place = three_modes().bifurcations.located[number]
    below, above = multipliers(0.998 * place.energy), multipliers(1.002 * place.energy)
    stable, unstable = (below, above) if place.stable_before else (above, below)
    assert np.abs(stable).max() < 1 + 1e-6
    assert np.abs(unstable).max() > 1.005
    assert np.abs(unstable - place.multiplier).min() < 0.1
    assert motion(place.energy).period * place.frequency == pytest.approx(1, rel=1e-6)


def test_period_doubling_is_where_the_differences_say() -> None:
    """mu + 1/mu is smooth: its value -2 between two energies 0.4 % apart."""
    place = three_modes().bifurcations.located[2]
    energies = place.energy * np.array([0.998, 1.002])
    distances = []
    for energy in energies:
        a = multipliers(energy)
        a = a + 1 / a
        distances.append(a[np.argmin(np.abs(a + 2))].real + 2)
    exact = np.interp(0, distances[::-1], energies[::-1])
    assert place.energy == pytest.approx(exact, rel=5e-5)


def test_way_back_over_a_bifurcation_does_not_count_it_twice() -> None:
    place = three_modes().bifurcations.located[0]
    there, back = (motion(factor * place.energy) for factor in (0.995, 1.005))
    flow = Flow(MODEL)
    stable, unstable = (Witness(r, m, stability(flow, m)) for r, m in ((1.6, there), (1.7, back)))
    (forth,) = bifurcations(flow, [stable, unstable], reversible=True).located
    again = bifurcations(flow, [stable, unstable, stable], reversible=True)
    assert again.located == (forth,)
    assert again.unlocated == ((1.7, 1.6),)
    assert forth.energy == pytest.approx(place.energy, rel=1e-4)


def test_a_cubic_that_leads_astray_is_left_for_the_chord(monkeypatch: pytest.MonkeyPatch) -> None:
    """Guesses beside the family, and as far before the first neighbour as the second is beyond."""
    points, rng = three_modes().points, np.random.default_rng(1)

    def astray(left: chord.FamilyMotion, right: chord.FamilyMotion, share: float) -> Array:
        off = rng.normal(size=left.unknowns.size)
        off -= left.tangent * (left.tangent @ off)
        off *= 0.3 * left.distance(right) / np.linalg.norm(off)
        return 2 * left.unknowns - right.unknowns + off

    monkeypatch.setattr(chord, "_hermite", astray)
    flow = Flow(MODEL)
    motions = [shoot(flow, OrbitGuess.of(BALANCE.series, point.motion)) for point in points]
    witnesses = [
        Witness(point.gamma_ratio, each, stability(flow, each, reversible=True))
        for point, each in zip(points, motions, strict=True)
    ]
    told = bifurcations(flow, witnesses, reversible=True)
    assert not told.unlocated
    for each, same in zip(told.located, three_modes().bifurcations.located, strict=True):
        assert each.kind == same.kind
        assert each.energy == pytest.approx(same.energy, rel=1e-4)


def test_general_motions_bifurcate_at_the_same_energies() -> None:
    general = three_modes(general=True).bifurcations.located
    for each, same in zip(general, three_modes().bifurcations.located, strict=True):
        assert each.kind == same.kind
        assert each.energy == pytest.approx(same.energy, rel=1e-4)


def hill(energy: float, antisymmetric: float, R: float) -> tuple[float, Array]:
    """Trace over a period and matrix over half of one of the antisymmetric mode, closed form.

    Two points touch at once while the symmetric mode, a bilinear oscillator, moves; meanwhile the
    antisymmetric mode has the stiffness omega_2^2 + 2 / R, and else omega_2^2.
    """
    K = 2 / R
    free = 2 * np.arccos(-np.sqrt(1 / (2 * energy)))
    touching = 2 / np.sqrt(K + 1) * np.arccos(1 / np.sqrt(2 * energy * (K + 1) - K))

    def turn(omega: float, time: float) -> Array:
        c, s = np.cos(omega * time), np.sin(omega * time)
        return np.array([[c, s / omega], [-omega * s, c]])

    first = turn(np.sqrt(antisymmetric**2 + K), touching / 2)
    half = turn(antisymmetric, free / 2) @ first
    return float(np.trace(first @ turn(antisymmetric, free) @ first)), half


def symmetric(antisymmetric: float, R: float, start: float, stop: float) -> tuple[Bifurcation, ...]:
    model = ReducedModel(
        [1.0, antisymmetric], [[1.0, 1.0], [1.0, -1.0]], np.diag([R, R]), [1.0, 1.0]
    )
    branch = follow(model, EnergyContinuation(start, stop, 0.15), BALANCE, mode=0, shooting=True)
    assert not branch.bifurcations.unlocated
    return branch.bifurcations.located


@pytest.mark.parametrize(
    ("antisymmetric", "R", "start", "stop", "kind", "trace"),
    [
        (3.3, 0.5, 2.0, 2.9, "symmetry breaking", 2),
        (2.1, 0.1, 1.4, 2.0, "symmetry breaking", 2),
        (2.6, 0.5, 1.55, 1.85, "period doubling", -2),
    ],
)
def test_loss_of_a_spatial_symmetry_in_closed_form(
    antisymmetric: float, R: float, start: float, stop: float, kind: str, trace: float
) -> None:
    """The edges of a tongue of Hill's equation; its periodic solution is even, or odd, there."""
    found = symmetric(antisymmetric, R, start, stop)
    assert [b.kind for b in found] == [kind] * 2
    assert [b.stable_before for b in found] == [True, False]
    for each in found:
        exact, half = hill(each.energy, antisymmetric, R)
        assert exact == pytest.approx(trace, abs=2e-5)
        assert each.multiplier == np.sign(trace)
        if trace > 0:  # the even solution is at rest after half a period, the odd one in place
            odd = abs(half[0, 1]) < abs(half[1, 0]) / 10
            assert min(abs(half[0, 1]), abs(half[1, 0])) < 5e-3
            assert each.breaks_time_reversal == odd
    if trace > 0:
        assert {b.breaks_time_reversal for b in found} == {True, False}


def along_family(flow: Flow, start: ShotMotion, *, steps: int, length: float) -> list[ShotMotion]:
    """Exact motions down in energy along a family, through its folds."""
    target = Target(start.q, start.velocity, start.period, start.energy)
    equations = period_map(flow, target, reversible=True)
    at = periodic_motion(equations, equations.start, Steps(), keep_energy=False)
    tangent, motions = -at.miss.jacobian[-1], []
    for _ in range(steps):
        tangent = family_tangent(at.miss, tangent)
        guess = at.unknowns + length * tangent
        at = periodic_motion(equations, guess, Steps(), keep_energy=False)
        assert not at.failure
        q, velocity, period = equations.state(at.unknowns)
        energy = flow.energy(q, velocity)
        motions.append(ShotMotion(q, velocity, period, energy, 0, 0, 0, 0, 0, 0, 0, 0))
    return motions


def test_fold_of_a_family() -> None:
    """A family that turns back in energy has two motions above the fold and none below."""
    model = ReducedModel([1.0, 3.4], [[1.0, 1.0]], [[0.1]], [1.0])
    flow, balance = Flow(model), HarmonicBalance(12, 144)
    points = follow(model, EnergyContinuation(3.0, 3.6, 0.3), balance, mode=0).points
    start = shoot(flow, OrbitGuess.of(balance.series, points[0].motion))
    motions = along_family(flow, start, steps=10, length=0.04)
    energies = np.array([each.energy for each in motions])
    lowest = int(np.argmin(energies))
    assert 0 < lowest < 9
    witnesses = [Witness(1.0, each, stability(flow, each)) for each in motions]
    (fold,) = bifurcations(flow, witnesses, reversible=True).located
    assert (fold.kind, fold.stable_before, fold.stable_after) == ("fold", True, False)
    assert fold.multiplier == 1
    assert fold.energy < energies.min()
    near = np.abs(np.arange(10) - lowest) <= 1
    parabola = np.polyfit(np.arange(10)[near], energies[near], 2)
    bottom = np.polyval(parabola, -parabola[1] / (2 * parabola[0]))
    assert fold.energy == pytest.approx(bottom, rel=1e-4)
    ends = []
    for each in (motions[lowest - 1], motions[lowest + 1]):
        for factor, exists in ((1.0005, True), (0.999, False)):
            target = Target(each.q, each.velocity, each.period, factor * fold.energy)
            equations = period_map(flow, target, reversible=True)
            found = periodic_motion(equations, equations.start, Steps(), keep_energy=True)
            assert bool(found.failure) is not exists
            if exists:
                ends.append(equations.state(found.unknowns)[2])
    assert abs(ends[1] / ends[0] - 1) > 1e-3


def test_place_of_a_crossing_between_two_motions() -> None:
    """Multipliers of oscillators whose sums a = mu + 1/mu go linearly from one motion to the other.

    At a share t: one pair through +1 or -1; two that meet, where (a_1 - a_2)^2 is linear.
    """

    def motion(*sums: complex) -> Stability:
        a = np.array(sums, dtype=complex)
        larger = (a + np.sqrt((a - 2) * (a + 2))) / 2
        larger = np.where(np.abs(larger) < 1, 1 / larger, larger)
        values = np.concatenate([larger, 1 / larger])
        kinds = tuple(_kind(each, 1e-9) for each in values)
        return Stability(values, 0, 0, 0, 0, np.eye(len(values), dtype=complex), kinds)

    bystander, t = 0.9, 0.3
    for kind, edge in ((REAL, 2), (DOUBLING, -2)):
        on, off = (edge - np.sign(edge) * 0.2 * share for share in (t, t - 1))
        there = motion(on, bystander), motion(off, bystander)
        assert crossing(kind, *there) == pytest.approx(t, rel=1e-9)
        assert crossing(kind, *reversed(there)) == pytest.approx(1 - t, rel=1e-9)
    half = np.sqrt(complex(0.01 * t)), np.sqrt(complex(0.01 * (t - 1)))
    there = tuple(motion(0.3 + each, 0.3 - each, bystander, bystander - 1e-3) for each in half)
    assert crossing(COMPLEX, *there) == pytest.approx(t, rel=1e-9)
    assert crossing(COMPLEX, *reversed(there)) == pytest.approx(1 - t, rel=1e-9)


def test_nothing_is_told_without_exact_motions() -> None:
    first = three_modes().bifurcations.located
    assert first
    without = follow(MODEL, EnergyContinuation(1.5, 2.3, 0.4), BALANCE, mode=0)
    assert not without.bifurcations.located
    assert not bifurcations(Flow(MODEL), [None, None], reversible=True).located


def test_points_of_two_families_have_no_bifurcation_between_them() -> None:
    flow, energies = Flow(MODEL), EnergyContinuation(0.9, 1.3, 0.2)
    other = follow(MODEL, energies, BALANCE, mode=1).points[-1]
    ends = [three_modes().points[0].motion, other.motion]
    motions = [shoot(flow, OrbitGuess.of(BALANCE.series, each)) for each in ends]
    first, second = (stability(flow, each) for each in motions)
    assert first.stable
    assert second.kind == DOUBLING
    witnesses = [Witness(1.5, motions[0], first), Witness(1.3, motions[1], second)]
    told = bifurcations(flow, witnesses, reversible=True)
    assert told.located == ()
    assert told.unlocated == ((1.5, 1.3),)


def test_summary_and_picture(tmp_path: Path) -> None:
    branch = three_modes()
    for name, shown in (("with", branch.bifurcations.located), ("without", ())):
        plot_backbone(
            tmp_path / f"{name}.png",
            branch.points,
            title="three modes",
            linear=LinearMode(1 / (2 * np.pi)),
            places=Places(bifurcations=shown),
        )
    assert (tmp_path / "with.png").read_bytes() != (tmp_path / "without.png").read_bytes()
    assert {stability_kind(point) for point in branch.points} == {"stable", COMPLEX, DOUBLING}


def test_run_lists_bifurcations(study_file: StudyFile, command: Command, tmp_path: Path) -> None:
    structure(tmp_path, [1.0, 2.6], np.array([[1.0, 1.0], [1.0, -1.0]]), 0.5)
    energies = {"from": 1.55, "to": 1.85, "step": 0.15}
    path = study_file(study(2, 10, 256, energies=energies))
    assert command("run", path, "--output", "out").code == 0
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert [each["kind"] for each in summary["bifurcations"]] == ["period doubling"] * 2
    assert summary["bifurcations_not_located"] == []
    first = summary["bifurcations"][0]
    assert hill(first["energy_J"], 2.6, 0.5)[0] == pytest.approx(-2, abs=2e-5)
    assert first["multiplier"] == [-1.0, 0.0]
    assert first["bracket_J"][0] < first["energy_J"] < first["bracket_J"][1]
    with (tmp_path / "out" / "backbone.csv").open() as file:
        told = [row["stability"] for row in csv.DictReader(file)]
    assert told == ["stable", DOUBLING, "stable"]
