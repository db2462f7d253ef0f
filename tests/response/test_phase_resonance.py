"""The damped backbone: closed forms, and the peaks of responses through contact on it."""

import csv
import dataclasses
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from conftest import Ended
from scipy.optimize import brentq

from fenics_nnm.continuation.trace_options import ArcLength
from fenics_nnm.mechanics.force import CubicSprings
from fenics_nnm.mechanics.fourier import FourierSeries
from fenics_nnm.mechanics.linear_part import RatedPart
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.response.curve import curve
from fenics_nnm.response.judge import Unjudged
from fenics_nnm.response.phase_resonance import Resonance, damped_backbone
from fenics_nnm.response.structure import Drive, DrivenStructure

StudyFile = Callable[..., Path]
Command = Callable[..., Ended]


def oscillator(gap: float = 1.0) -> DrivenStructure:
    """x'' + 0.02 x' + x + 4 (x - gap)_+ = 0.05 cos(omega t)."""
    model = ReducedModel(np.ones(1), np.ones((1, 1)), np.array([[0.25]]), np.array([gap]))
    linear = RatedPart(model.omega, np.array([[0.02]]))
    return DrivenStructure.of(model, linear, Drive.simple(np.ones((1, 1)), np.array([0.05 + 0j])))


def two_modes(gap: float = 1.0) -> DrivenStructure:
    """A force at a place that both modes move; the stop is at another one."""
    omega = np.array([1.0, 2.7])
    model = ReducedModel(omega, np.array([[1.0, -0.7]]), np.array([[0.25]]), np.array([gap]))
    drive = Drive.simple(np.array([[1.0, 0.8]]), np.array([0.05j]))
    return DrivenStructure.of(model, RatedPart(omega, np.diag([0.02, 0.03]) * omega), drive)


def hertz(*omega: float) -> np.ndarray:
    return np.array(omega) / (2 * np.pi)


def at_level(points: tuple[Resonance, ...], level: float) -> Resonance:
    (found,) = (each for each in points if each.point.level == level)
    return found


def test_oscillator_with_a_stop_resonates_at_the_peak_of_the_exact_response() -> None:
    """That of tests/reference/b_bilinear_forced_frf.csv: 1.779182 at 1.199978."""
    found = damped_backbone(oscillator(), FourierSeries(16, 48), hertz(0.9, 1.5), (0.3, 1.0))
    assert not found.reasons and not found.refuted
    peak = at_level(found.points, 1.0)
    assert peak.point.omega == pytest.approx(1.199978, rel=1e-4)
    assert peak.point.displacements.highest[0] == pytest.approx(1.779182, rel=2e-5)
    assert peak.force == pytest.approx(0.05, rel=1e-12)
    assert peak.damping_ratio == pytest.approx(0.01 / peak.point.omega, rel=1e-9)
    touching = [each.point for each in found.points if each.point.displacements.contact[0] > 0]
    assert len(touching) > 5 and {point.status for point in touching} == {"verified"}
    assert {point.judgement.stability for point in touching} == {"stable"}
    assert max(abs(point.phase[0] - 90) for point in touching) < 1e-8
    assert max(point.imbalance for point in touching) < 1e-10


def test_oscillator_without_contact_is_the_closed_form() -> None:
    found = damped_backbone(oscillator(), FourierSeries(4, 32), hertz(0.9, 1.5), (0.3, 0.41))
    low, touch = found.points[:2]
    assert at_level(found.points, 0.41).point.omega > 1.001
    near = damped_backbone(oscillator(), FourierSeries(4, 32), hertz(0.9, 1.5), (0.401, 0.41))
    assert at_level(near.points, 0.401).point.displacements.contact[0] > 0
    assert low.point.omega == pytest.approx(1.0, rel=1e-12)
    assert low.point.amplitude[0] == pytest.approx(0.3 * 0.05 / 0.02, rel=1e-12)
    assert low.damping_ratio == pytest.approx(0.01, rel=1e-12) and low.point.status == "exact"
    assert touch.point.event == "first contact" and touch.point.level == pytest.approx(0.4)


def test_peaks_of_two_modes_lie_on_the_backbone() -> None:
    structure, series, levels = two_modes(), FourierSeries(5, 40), (0.9,)
    frequencies = hertz(0.98, 1.2)
    found = damped_backbone(structure, series, frequencies, levels, judge=Unjudged())
    assert not found.reasons
    known = np.array([(each.point.amplitude[0], each.point.level) for each in found.points])
    for level in levels:
        driven = structure.at_level(level)
        points = curve(driven, series, frequencies, judge=Unjudged()).points
        (peak,) = (point for point in points if point.event == "peak of the amplitude")
        near = at_level(found.points, level).point
        assert peak.displacements.contact[0] > 0.1
        assert near.frequency == pytest.approx(peak.frequency, rel=1e-3)
        assert near.amplitude[0] == pytest.approx(peak.amplitude[0], rel=1e-3)
        assert float(np.interp(peak.amplitude[0], *known.T)) == pytest.approx(level, rel=1e-3)


def test_level_that_the_curve_passes_three_times_has_three_resonances() -> None:
    """An internal resonance with the second mode: the level turns back, and back again."""
    omega = np.array([1.0, 2.98, 4.17])
    model = ReducedModel(omega, np.array([[0.65, -2.31, -0.19]]), np.array([[0.126]]), np.ones(1))
    linear = RatedPart(omega, np.diag([0.0132, 0.0727, 0.0718]))
    drive = Drive.simple(np.array([[1.0, 0.86, 1.51]]), np.array([0.0284 + 0j]))
    structure = DrivenStructure.of(model, linear, drive)
    series, frequencies = FourierSeries(4, 48), hertz(0.93, 1.25)
    found = damped_backbone(structure, series, frequencies, (1.0,), judge=Unjudged())
    points = [each.point for each in found.points]
    levels = np.array([point.level for point in points])
    first, second, third = np.flatnonzero(levels == 1.0)
    top, bottom = (n for n, point in enumerate(points) if point.event == "fold in level")
    assert first < top < second < bottom < third
    assert levels[top] == levels[first : second + 1].max() > 1.001
    assert levels[bottom] == levels[second : third + 1].min() < 0.999
    assert all(point.phase[0] == pytest.approx(90, abs=1e-8) for point in points)
    assert max(point.imbalance for point in points) < 1e-10


def test_curve_leads_away_from_first_contact_where_the_energy_falls() -> None:
    """Chain of five masses: from 1 % more than at first contact the energy falls to either side."""
    squares, shapes = np.linalg.eigh(
        1e4 * (2 * np.eye(5) - np.eye(5, k=1) - np.eye(5, k=-1)) - 1e4 * np.diag([0, 0, 0, 0, 1.0])
    )
    omega, end, lacking = (
        np.sqrt(squares[:2]),
        shapes[-1:, :2],
        shapes[-1, 2:] ** 2 @ (1 / squares[2:]),
    )
    model = ReducedModel(omega, end, np.array([[lacking]]), np.array([1e-3]))
    drive = Drive.simple(shapes[:1, :2], np.array([2.0 + 0j]))
    structure = DrivenStructure.of(model, RatedPart(omega, np.diag(0.04 * omega)), drive)
    series, range_ = FourierSeries(6, 64), np.array([3.5, 6.5])
    found = damped_backbone(structure, series, range_, (0.1, 0.3), judge=Unjudged())
    assert not found.reasons
    assert at_level(found.points, 0.1).point.displacements.contact[0] == 0
    touching = at_level(found.points, 0.3).point
    assert touching.displacements.contact[0] > 0.07 and touching.frequency > 5


def test_linear_resonances_are_where_the_force_lags_by_90_degrees() -> None:
    structure = two_modes(gap=100.0)
    found = damped_backbone(structure, FourierSeries(2, 16), hertz(0.5, 4.0), (1.0,))

    def receptance(w: float) -> complex:
        return sum(
            shape**2 / (omega**2 - w**2 + 1j * w * rate)
            for omega, shape, rate in ((1.0, 1.0, 0.02), (2.7, 0.8, 0.081))
        )

    def real(w: float) -> float:
        return complex(receptance(w)).real

    exact = [brentq(real, low, high, xtol=1e-14) for low, high in ((0.9, 1.1), (2.5, 2.9))]
    assert [each.point.omega for each in found.points] == pytest.approx(exact, rel=1e-12)
    assert [each.point.branch for each in found.points] == [1, 2]
    for each, w in zip(found.points, exact, strict=True):
        assert each.point.amplitude[0] == pytest.approx(0.05 * abs(receptance(w)), rel=1e-10)


def test_cubic_spring_has_the_backbone_of_duffing() -> None:
    """With one harmonic: omega^2 = 1 + 3/4 k a^2 and F = c omega a."""
    hard = CubicSprings(np.ones((1, 1)), np.array([0.4]))
    structure = dataclasses.replace(oscillator(gap=100.0), forces=(hard,))
    found = damped_backbone(structure, FourierSeries(1, 16), hertz(0.9, 3.0), (0.5, 1.0))
    assert not found.reasons and at_level(found.points, 0.5) and at_level(found.points, 1.0)
    for each in found.points:
        amplitude, w = float(each.point.amplitude[0]), each.point.omega
        assert w**2 == pytest.approx(1 + 0.75 * 0.4 * amplitude**2, rel=1e-9)
        assert each.force == pytest.approx(0.02 * w * amplitude, rel=1e-9)
        assert each.point.status == "converged"
    assert found.points[-1].point.omega > 1.3


def test_what_has_no_backbone_says_why() -> None:
    series, frequencies = FourierSeries(4, 32), hertz(0.9, 1.5)
    two = Drive(np.ones((2, 1)), np.array([0.05, 0.02]), (1, 2))
    both = dataclasses.replace(oscillator(), drive=two)
    for structure, word in (
        (both, "forces of one harmonic alone, from 1: there are 1, 2"),
        (oscillator(gap=0.0), "touch at rest"),
    ):
        found = damped_backbone(structure, series, frequencies, (1.0,))
        assert not found.points and word in found.reasons[0]
    beside = damped_backbone(oscillator(), series, hertz(1.1, 1.5), (1.0,))
    assert beside.reasons == ("there is no phase resonance within the frequencies",)
    near = damped_backbone(oscillator(), series, hertz(0.9, 1.1), (1.0,))
    assert "omega leaves its range at 1.1" in near.reasons[0]
    assert max(each.point.level for each in near.points) < 1
    few = ArcLength(points=3)
    short = damped_backbone(oscillator(), series, frequencies, (1.0,), options=few)
    assert len(short.points) == 5 and "points = 3 steps were taken" in short.reasons[0]


def test_command_writes_the_backbone_if_it_is_wanted(
    tmp_path: Path, study_file: StudyFile, command: Command
) -> None:
    np.savez(tmp_path / "stop.npz", K=[[5.0, -4], [-4, 4]], M=np.diag([1.0, 0]), B=[[0.0, 1]])
    study = {
        "matrices": {"file": "stop.npz"},
        "contact": {"gap": 1.0},
        "reduction": {"modes": 1},
        "mode": {"harmonics": 4, "samples": 32},
        "damping": {"ratio": 0.01},
        "excitation": {"unknown": 1, "force": 0.05},
    }
    range_ = {"frequencies": {"from": 0.157, "to": 0.167, "step": 0.01}, "levels": [0.3, 0.35]}
    ended = command("response", study_file(study, response=range_))
    assert ended.code == 0 and ended.err == ""
    assert "phase resonance at level" in ended.out
    file = Path("results/study-response/resonance.csv")
    with file.open() as text:
        rows = list(csv.DictReader(text))
    assert [row["level"] for row in rows] == ["0.3", "0.35"]
    for row in rows:
        loss = 0.02 * float(row["frequency_Hz"]) * 2 * np.pi * float(row["amplitude_m"])
        assert float(row["resonance_force_N"]) == pytest.approx(0.05 * float(row["level"]))
        assert float(row["resonance_force_N"]) == pytest.approx(loss, rel=1e-6)
        assert float(row["damping_ratio"]) == pytest.approx(0.01) and row["status"] == "exact"
    without = {**range_, "levels": [0.1], "backbone": False}
    ended = command("response", study_file(study, response=without))
    assert ended.code == 0 and "phase resonance" not in ended.out and not file.exists()
