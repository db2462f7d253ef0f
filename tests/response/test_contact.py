"""Responses through contact: an oscillator with a stop through both folds, chains in time."""

import dataclasses
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import Ended
from mpi4py import MPI
from scipy.integrate import solve_ivp

from fenics_nnm.continuation.trace_options import ArcLength
from fenics_nnm.mechanics.fourier import FourierSeries
from fenics_nnm.mechanics.hysteretic import HystereticPart
from fenics_nnm.mechanics.linear_part import RatedPart
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.response.curve import curve
from fenics_nnm.response.judge import Unjudged
from fenics_nnm.response.levels import Response, response
from fenics_nnm.response.structure import Drive, DrivenStructure
from fenics_nnm.structure.driven import driven_motions, driven_structure
from fenics_nnm.study import study_from

StudyFile = Callable[..., Path]
Command = Callable[..., Ended]

REFERENCE = np.loadtxt(
    Path(__file__).parents[1] / "reference/b_bilinear_forced_frf.csv", delimiter=",", skiprows=3
)


def oscillator(gap: float = 1.0) -> DrivenStructure:
    """x'' + 0.02 x' + x + 4 (x - gap)_+ = 0.05 cos(omega t)."""
    model = ReducedModel(np.ones(1), np.ones((1, 1)), np.array([[0.25]]), np.array([gap]))
    linear = RatedPart(model.omega, np.array([[0.02]]))
    return DrivenStructure.of(model, linear, Drive.simple(np.ones((1, 1)), np.array([0.05 + 0j])))


@pytest.fixture(scope="module")
def found() -> Response:
    """Its response at every twentieth of the frequencies of the reference."""
    frequencies = np.unique(REFERENCE[::20, 0]) / (2 * np.pi)
    return response(oscillator(), FourierSeries(16, 48), frequencies)


def test_whole_curve_through_both_folds_is_the_exact_one(found: Response) -> None:
    assert not found.reasons and not found.missing
    omega = np.array([point.omega for point in found.points])
    measures = np.array(
        [
            (at.highest[0], at.lowest[0], at.contact[0], point.judgement.largest_multiplier)
            for point, at in ((point, point.displacements) for point in found.points)
        ]
    )
    for w, _, _, *exact in REFERENCE[::20]:
        near = np.abs(omega / w - 1) < 1e-9
        errors = np.abs(measures[near] - exact)
        assert near.any() and errors[errors.sum(axis=1).argmin()].max() < 1e-4, w


def test_folds_and_peak_are_located(found: Response) -> None:
    events = {point.event: point for point in found.points if "fold" not in point.event}
    folds = [point.omega for point in found.points if point.event == "fold in omega"]
    assert folds == pytest.approx([1.200297, 1.0225566], abs=1e-5)
    highest = events["peak of the largest displacement"]
    assert highest.displacements.highest[0] == pytest.approx(1.779182, abs=1e-4)
    assert highest.omega == pytest.approx(1.199978, abs=1e-5)
    assert events["peak of the amplitude"].amplitude[0] >= max(
        point.amplitude[0] for point in found.points
    )


def test_forces_put_in_what_damping_takes_out(found: Response) -> None:
    assert max(point.imbalance for point in found.points) < 1e-10
    touching = [point.displacements.contact[0] > 0 for point in found.points]
    assert {str(point.status) for point in found.points} == {"exact", "verified"}
    for point, touches in zip(found.points, touching, strict=True):
        assert point.status == ("verified" if touches else "exact")
        assert point.judgement.stability
        assert point.residual < 1e-9 and point.gap[0] >= 0


def test_level_that_touches_nothing_is_that_of_the_closed_form() -> None:
    frequencies = np.array([0.1, 0.2, 0.3])
    low, high = response(oscillator(), FourierSeries(4, 32), frequencies, (0.01, 0.02)).points[::3]
    omega = 2 * np.pi * 0.1
    for point, level in ((low, 0.01), (high, 0.02)):
        exact = level * 0.05 / (1 - omega**2 + 0.02j * omega)
        assert point.displacements.first[0] == pytest.approx(exact, abs=1e-14)


def test_structural_damping_goes_through_contact() -> None:
    """The energy that a loss factor takes at each harmonic is put in by the force."""
    plain = oscillator(0.5)
    linear = HystereticPart(RatedPart(np.ones(1), np.zeros((1, 1))), np.array([[0.05]]))
    structure = dataclasses.replace(plain, linear=linear)
    found = response(structure, FourierSeries(5, 32), np.array([0.15, 0.2]))
    assert not found.reasons
    assert {str(point.status) for point in found.points} == {"exact", "converged"}
    assert max(point.imbalance for point in found.points) < 1e-10
    assert max(point.displacements.contact[0] for point in found.points) > 0.2


def test_curve_that_does_not_arrive_says_where_it_ends() -> None:
    frequencies = np.array([0.9, 1.4]) / (2 * np.pi)
    few = ArcLength(points=12)
    found = curve(oscillator(), FourierSeries(4, 32), frequencies, options=few)
    assert "points = 12 steps were taken" in found.reason and "Hz" in found.reason
    assert {point.branch for point in found.points} == {1, 2}
    first, second = ([p.omega for p in found.points if p.branch == n] for n in (1, 2))
    assert first[0] == pytest.approx(0.9) and second[0] == pytest.approx(1.4)


def test_end_that_is_a_wanted_frequency_but_for_round_off_is_one_motion() -> None:
    """Twice the same motion would look like a peak at the end."""
    wanted = np.array([0.7, 0.8 - 1e-14, 0.8]) / (2 * np.pi)
    points = curve(oscillator(), FourierSeries(4, 32), wanted, judge=Unjudged()).points
    assert np.diff([point.frequency for point in points]).min() > 1e-6


def test_piece_at_the_highest_frequency_is_followed_too() -> None:
    """The range ends where three motions coexist: the curve leaves it on the upper one."""
    found = curve(oscillator(), FourierSeries(8, 48), np.array([0.9, 1.1]) / (2 * np.pi))
    first, second = ([p for p in found.points if p.branch == n] for n in (1, 2))
    assert not found.reason
    assert first[-1].omega == pytest.approx(1.1) and first[-1].displacements.contact[0] > 0.1
    assert second[0].omega == pytest.approx(1.1) and second[0].status == "exact"
    assert second[-1].omega == pytest.approx(1.1) and second[-1].displacements.contact[0] > 0.1
    assert [p.event for p in second if p.event] == ["fold in omega"]


CHAIN: dict[str, Any] = {
    "matrices": {"file": "chain.npz"},
    "contact": {"gap": 0.01},
    "reduction": {"modes": 2},
    "mode": {"harmonics": 20, "samples": 96},
    "damping": {"alpha": 8.0},
    "dashpot": {"unknown": 1, "damping": 6.0},
    "excitation": {"unknown": 1, "force": 20.0, "phase_deg": 20.0},
    "monitor": {"name": "second", "unknown": 2},
    "response": {"frequencies": {"from": 5.0, "to": 7.0, "step": 2.0}},
}

#: Two masses; the third unknown has none, and is held by a spring of 4000 N/m to the second.
STIFF = 4000.0
K = np.array([[3000.0, -1000, 0], [-1000, 2000 + STIFF, -STIFF], [0, -STIFF, STIFF]])
M = np.diag([1.0, 0.5, 0.0])


def test_chain_with_a_dashpot_moves_as_in_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Against Runge-Kutta steps of both masses with an elastic stop, until all is periodic."""
    monkeypatch.chdir(tmp_path)
    np.savez("chain.npz", K=K, M=M, B=np.array([[0.0, 0.0, 1.0]]))
    study = study_from(CHAIN, Path("study.toml"))
    found = driven_motions(study, driven_structure(study, MPI.COMM_SELF))
    assert not found.reasons
    point = found.points[-1]
    assert point.displacements.contact[0] > 0.1 and point.frequency == pytest.approx(7.0)
    masses, open_K = np.array([1.0, 0.5]), np.array([[3000.0, -1000.0], [-1000.0, 2000.0]])
    C = np.diag([8.0 + 6.0, 4.0])
    omega = 2 * np.pi * 7.0

    def slope(t: float, y: np.ndarray) -> np.ndarray:
        x, v = y[:2], y[2:]
        force = -open_K @ x - C @ v
        force[0] += 20.0 * np.cos(omega * t + np.deg2rad(20.0))
        force[1] -= STIFF * max(x[1] - 0.01, 0.0)
        return np.concatenate([v, force / masses])

    last = 30 / 7.0
    times = last + np.linspace(0, 1 / 7.0, 2001)
    steps = {"rtol": 1e-9, "atol": 1e-11, "max_step": 1e-3, "t_eval": times}
    x = solve_ivp(slope, (0, times[-1]), np.zeros(4), **steps).y[:2]
    for place, row in ((0, x[0]), (1, x[1])):
        assert point.displacements.highest[place] == pytest.approx(row.max(), rel=1e-4)
        assert point.displacements.lowest[place] == pytest.approx(row.min(), rel=1e-4)


def test_command_writes_levels_and_folds(
    tmp_path: Path, study_file: StudyFile, command: Command
) -> None:
    np.savez(tmp_path / "stop.npz", K=[[5.0, -4], [-4, 4]], M=np.diag([1.0, 0]), B=[[0.0, 1]])
    study = study_file(
        {
            "matrices": {"file": "stop.npz"},
            "contact": {"gap": 1.0},
            "reduction": {"modes": 1},
            "mode": {"harmonics": 4, "samples": 32},
            "damping": {"ratio": 0.01},
            "excitation": {"unknown": 1, "force": 0.05},
            "response": {
                "frequencies": {"from": 0.15, "to": 0.22, "step": 0.01},
                "levels": [0.3, 1.0],
            },
        }
    )
    ended = command("response", study)
    assert ended.code == 0 and ended.err == ""
    peaks = [line.split() for line in ended.out.splitlines() if "excitation" in line]
    assert [row[0] for row in peaks] == ["0.3", "1"]
    assert float(peaks[1][2]) == pytest.approx(1.2 / (2 * np.pi), abs=1e-4)
    text = Path("results/study-response/response.csv").read_text()
    assert text.count("fold in omega") == 2 * 2


def test_points_of_a_stiff_symmetric_tip_close_in_pairs() -> None:
    """Four points that are coupled and stiff, moved by bending and twist: a whole curve."""
    side = np.array([1.0, -1.0, 1.0, -1.0])
    Phi = np.column_stack([np.full(4, -0.19), 0.19 * side, np.full(4, 0.18)])
    R = 3e-10 * (np.eye(4) + np.abs(side[:, None] + side) / 2 - np.eye(4) / 2)
    model = ReducedModel(np.array([540.0, 3435.0, 4710.0]), Phi, R, np.full(4, 1e-3))
    linear = RatedPart(model.omega, np.diag(2 * 0.05 * model.omega))
    push = Drive.simple(np.array([Phi[0]]), np.array([1000.0 + 0j]))
    structure = DrivenStructure.of(model, linear, push)
    found = curve(structure, FourierSeries(5, 20), np.linspace(75.0, 100.0, 6))
    assert not found.reason
    touching = [point for point in found.points if point.displacements.contact.any()]
    assert len(touching) > 5
    assert max(point.imbalance for point in touching) < 1e-8
    for point in touching:
        shares = point.displacements.contact[-4:]
        np.testing.assert_allclose(shares, [shares[0], shares[1]] * 2, atol=1e-9)
        assert point.status == "verified" or point.reason
