"""Obstacles that move past a structure: responses by closed forms and by another integrator."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import PLATE, Ended
from mpi4py import MPI
from scipy.integrate import solve_ivp

from fenics_nnm.fields.driven import of_response
from fenics_nnm.mechanics.fourier import FourierSeries
from fenics_nnm.mechanics.linear_part import RatedPart
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.mechanics.motion import forces_at, free_displacement
from fenics_nnm.mechanics.moving_gap import GapMotion
from fenics_nnm.nonlinear.timed import TimedEquations
from fenics_nnm.nonlinear.unknowns import Unknowns
from fenics_nnm.response.driven import point_of
from fenics_nnm.response.first_motion import first_motion
from fenics_nnm.response.in_time import state_at
from fenics_nnm.response.judge import judge_of
from fenics_nnm.response.levels import response
from fenics_nnm.response.phase_resonance import damped_backbone
from fenics_nnm.response.structure import Drive, DrivenStructure
from fenics_nnm.results.header import BranchHeader
from fenics_nnm.structure.driven import driven_motions, driven_structure
from fenics_nnm.study import study_from

StudyFile = Callable[..., Path]
Command = Callable[..., Ended]

STIFFNESS, DAMPING = 4.0, 0.06

#: x'' + 0.06 x' + x + 4 (x - g)_+ = 0,  g = gap + 0.5 cos(w t) - 0.1 sin(2 w t).
MOTION = GapMotion((1, 2), np.array([[0.5], [0.1j]]))


def oscillator(gap: float) -> DrivenStructure:
    model = ReducedModel(np.ones(1), np.ones((1, 1)), np.array([[1 / STIFFNESS]]), np.array([gap]))
    none = Drive.simple(np.zeros((0, 1)), np.zeros(0, complex))
    linear = RatedPart(model.omega, np.array([[DAMPING]]))
    return replace(DrivenStructure.of(model, linear, none), gap_motion=MOTION)


def test_obstacle_that_always_presses_is_a_linear_spring_that_moves() -> None:
    """With all contact: x_n (5 - n^2 w^2 + 0.06 i n w) = 4 G_n about x_0 = 4 gap / 5."""
    series, gap = FourierSeries(3, 32), -8.0
    structure = oscillator(gap)
    judge = judge_of(structure.mechanics)
    for w in (0.7, 3.0):
        found = first_motion(structure, TimedEquations.of(structure.mechanics, series), w)
        point = point_of(structure, series, found, judge.of_contact(series, found.q, w))
        assert point.displacements.contact[0] == pytest.approx(1.0)
        exact = np.zeros(7)
        exact[0] = 4 * gap / 5
        for n, amplitude in zip(MOTION.harmonics, MOTION.amplitudes[:, 0], strict=True):
            x = 4 * amplitude / (5 - (n * w) ** 2 + DAMPING * 1j * n * w)
            exact[series.order == n] = x.real, -x.imag
        np.testing.assert_allclose(point.q[:, 0], exact, atol=1e-9)
        assert point.status == "verified" and point.imbalance < 1e-10


def test_derivative_of_the_equations_is_that_of_differences() -> None:
    mechanics = oscillator(0.3).mechanics
    equations = TimedEquations.of(mechanics, FourierSeries(6, 48))
    q = 0.4 * np.random.default_rng(1).normal(size=(13, 1))

    def residual(moved: np.ndarray) -> np.ndarray:
        at = Unknowns.of(moved, 1.1)
        return equations.residual(at, equations.forces(at)).ravel()

    at = Unknowns.of(q, 1.1)
    found = equations.jacobian(at, equations.forces(at))
    assert equations.forces(at).force.any() and np.abs(equations.given).max() == 0.5
    for column, step in enumerate(1e-6 * np.eye(13)):
        change = step[:, None]
        difference = (residual(q + change) - residual(q - change)) / 2e-6
        np.testing.assert_allclose(found[:, column], difference, atol=1e-6)


def test_motion_past_an_obstacle_is_that_of_another_integrator() -> None:
    """Over a period from its state at phase 0, by the equation of motion with the gap in it."""
    series = FourierSeries(40, 160)
    found = response(oscillator(0.3), series, np.array([1.28, 1.3]) / (2 * np.pi))
    touching = [point.displacements.contact[0] for point in found.points]
    assert not found.reasons and 0.2 < min(touching) and max(touching) < 0.4
    assert max(point.imbalance for point in found.points) < 1e-10
    for point in (found.points[0], found.points[-1]):
        w = point.omega

        def rate(time: float, state: np.ndarray, w: float = w) -> list[float]:
            gap = 0.3 + 0.5 * np.cos(w * time) - 0.1 * np.sin(2 * w * time)
            pressed = STIFFNESS * max(0.0, state[0] - gap)
            return [state[1], -DAMPING * state[1] - state[0] - pressed]

        start = np.concatenate(state_at(series, point.q, w, 0.0))
        times = np.linspace(0, 2 * np.pi / w, 9)
        exact = solve_ivp(rate, times[[0, -1]], start, "DOP853", times, rtol=1e-9, atol=1e-11).y
        moved = series.basis_at(w * times) @ point.q
        size = np.abs(exact[0]).max()
        np.testing.assert_allclose(moved[:, 0], exact[0], atol=1e-4 * size)
        assert point.status == "verified" and point.judgement.stability == "stable"
        assert point.gap[0] == 0 and point.displacements.highest[0] <= 0.9


def test_levels_scale_the_obstacle_and_one_that_does_not_arrive_moves_nothing() -> None:
    frequencies = np.array([0.1985, 0.2])
    found = response(oscillator(0.7), FourierSeries(8, 32), frequencies, (1.0, 1.5))
    low, high = found.at_level(1.0), found.at_level(1.5)
    assert {str(point.status) for point in low} == {"exact"} and len(low) == 2
    assert low[0].amplitude[0] == 0 and low[0].imbalance == 0
    turn = np.linspace(0, 2 * np.pi, 100_001)
    least = (0.5 * np.cos(turn) - 0.1 * np.sin(2 * turn)).min()
    assert low[0].gap[0] == pytest.approx(0.7 + least, abs=1e-7)
    assert MOTION.lowest[0] == pytest.approx(least, abs=1e-6)
    assert -1.5 * least > 0.7 and min(point.displacements.contact[0] for point in high) > 0
    assert (
        "casing"
        in damped_backbone(oscillator(0.7), FourierSeries(4, 32), frequencies, (1.0,)).reasons[0]
    )


@pytest.fixture
def mass(tmp_path: Path, study_file: StudyFile) -> Callable[..., Path]:
    """A function from sections to a study of a mass between springs whose obstacle moves."""
    K = np.array([[5.0, -4.0], [-4.0, 4.0]])
    np.savez(tmp_path / "mass.npz", K=K, M=np.diag([1.0, 0.0]), B=np.array([[0.0, 1.0]]))
    base: dict[str, Any] = {
        "matrices": {"file": "mass.npz"},
        "contact": {
            "gap": -8.0,
            "gap_motion": [{"order": 3, "amplitude": 0.5}, {"order": 6, "amplitude": 0.1}],
        },
        "reduction": {"modes": 1},
        "mode": {"harmonics": 4, "samples": 32},
        "damping": {"ratio": 0.03},
        "response": {"speeds": {"from": 0.2, "to": 0.25, "step": 0.05}},
    }
    return lambda **changes: study_file(base, **changes)


def test_matrices_have_gaps_that_follow_the_speed(mass: StudyFile, command: Command) -> None:
    """The same mass, held through the spring of 4 to its obstacle; speed 0.2 passes at 0.6."""
    ended = command("response", mass(), "--output", "out")
    assert ended.code == 0, ended.err
    lines = Path("out/response.csv").read_text().splitlines()
    row = dict(zip(lines[0].split(","), lines[1].split(","), strict=True))
    assert float(row["speed_rad_s"]) == pytest.approx(0.2)
    assert float(row["frequency_Hz"]) == pytest.approx(0.6 / (2 * np.pi))
    assert float(row["amplitude_m"]) == pytest.approx(0.5)  # the contact point follows the obstacle
    assert row["status"] == "verified" and float(row["energy_balance"]) < 1e-9


def test_check_says_that_gaps_move(mass: StudyFile, command: Command) -> None:
    ended = command("check", mass(contact={"gap": 1.0}))
    assert ended.code == 0 and "gaps move at 3, 6 times the speed" in ended.out


def test_simulation_from_rest_follows_the_obstacle(mass: StudyFile, command: Command) -> None:
    """Pressed all the time: the contact point moves as the gap, 0.5 cos + 0.1 cos 2, 0.5 about."""
    hertz = 0.6 / (2 * np.pi)
    ended = command("simulate", mass(), "--frequency", hertz, "--periods", 60)
    assert ended.code == 0, ended.err
    (row,) = [line.split() for line in ended.out.splitlines() if line.strip().startswith("const")]
    assert row[1:3] == ["contact", "1"] and row[-2:] == ["0.5", "100.0%"]
    assert "repeats after a period" in ended.out


@pytest.mark.parametrize(
    ("verb", "changes", "words"),
    [
        ("run", {}, ["contact.gap_motion", "fenics-nnm response"]),
        ("convergence", {}, ["contact.gap_motion", "fenics-nnm response"]),
        (
            "response",
            {"response": {"frequencies": {"from": 1.0, "to": 2.0, "step": 0.5}, "speeds": None}},
            ["response.frequencies", "response.speeds"],
        ),
        ("response", {"mode": {"harmonics": 1}}, ["mode.harmonics = 1", "2 or more"]),
        ("response", {"contact": {"gap": 1.0}}, ["leave 0.6", "nothing moves"]),
        (
            "response",
            {"contact": {"gap_motion": [{"order": 3, "amplitude": [0.5, 0.1]}]}},
            ["gap_motion[1].amplitude", "has 2 numbers", "1, one a contact row"],
        ),
        (
            "response",
            {"contact": {"gap_motion": [{"order": 3, "amplitude": 0.5}] * 2}},
            ["2 have order = 3"],
        ),
    ],
)
def test_what_a_moving_gap_does_not_go_with_is_one_line(
    mass: StudyFile, command: Command, verb: str, changes: dict[str, Any], words: list[str]
) -> None:
    command(verb, mass(**changes)).assert_one_line(2, *words)


def turning(**casing: Any) -> dict[str, Any]:
    """A plate that turns about z, its corner at radius sqrt(1 + 1/16) towards a lobed casing."""
    lobed = {"shape": "lobed", "frame": "fixed", "axis": "z", "zero": "x", "lobes": 4}
    own = {"radius": 1.0309, "amplitude": 2e-4, "phase_deg": 10.0}
    return {
        **PLATE,
        "rotation": {"axis": "z", "speed": 1e-3},
        "contact": {
            "facets": ["right"],
            "direction": "radial",
            "axis": "z",
            "casing": {**lobed, **own, **casing},
        },
        "damping": {"ratio": 0.02},
        "response": {"speeds": {"from": 310.0, "to": 312.0, "step": 2.0}},
        "mode": {"harmonics": 6, "samples": 48},
    }


def structure_of(values: dict[str, Any]) -> DrivenStructure:
    return driven_structure(study_from(values, Path("study.toml")), MPI.COMM_SELF)


@pytest.mark.parametrize("sense", [1, -1])
def test_lobed_casing_passes_with_its_lobes(sense: int) -> None:
    """A corner at angle a meets r + A cos(4 (a + turn - 10 degrees)), a mean gap of r - |x|."""
    values = turning()
    values["rotation"]["speed"] *= sense
    found = structure_of(values)
    gap, motion = found.model.gap, found.gap_motion
    corner = int(np.argmin(gap))
    assert gap[corner] == pytest.approx(1.0309 - np.sqrt(1 + 1 / 16), abs=1e-9)
    assert motion.harmonics[0] == 1
    angle = np.arctan2(0.25, 1.0)
    exact = 2e-4 * np.exp(4j * sense * (angle - np.deg2rad(10)))
    assert motion.amplitudes[0, corner] == pytest.approx(exact, abs=1e-9)
    assert np.abs(motion.amplitudes[1:]).max(initial=0.0) < 1e-9


def test_table_passes_with_the_harmonics_of_its_angles(tmp_path: Path) -> None:
    """24 angles of a radius with 1 and 3 lobes: multiples of the speed up to 12."""
    theta = np.arange(0, 360, 15.0)
    r = 1.0309 + 2e-4 * np.cos(np.deg2rad(theta)) + 1e-4 * np.cos(np.deg2rad(3 * theta))
    rows = [f"{a},{x},{b:.9f}" for a, b in zip(theta, r, strict=True) for x in (-1, 1)]
    (tmp_path / "casing.csv").write_text("\n".join(["theta_deg,x_m,r_m", *rows]))
    values = turning()
    values["contact"]["casing"] = {
        "shape": "table",
        "frame": "fixed",
        "axis": "z",
        "zero": "x",
        "file": str(tmp_path / "casing.csv"),
    }
    values["mode"] = {"harmonics": 12, "samples": 48}
    motion = structure_of(values).gap_motion
    assert motion.highest <= 12
    first, third = motion.harmonics.index(1), motion.harmonics.index(3)
    corner = int(np.argmin(structure_of(values).model.gap))
    assert abs(motion.amplitudes[first, corner]) == pytest.approx(2e-4, rel=1e-3)
    assert abs(motion.amplitudes[third, corner]) == pytest.approx(1e-4, rel=3e-3)


def test_plate_is_driven_by_the_lobes_alone(tmp_path: Path) -> None:
    """Near its first mode; fields have forces that never pull, and gaps that are never negative."""
    study = study_from(turning(), Path("study.toml"))
    structure = driven_structure(study, MPI.COMM_SELF)
    found = driven_motions(study, structure)
    assert not found.reasons and found.points[0].speed == pytest.approx(310.0)
    assert max(point.imbalance for point in found.points) < 1e-6
    assert {str(p.status) for p in found.points} <= {"verified", "converged"}
    model = structure.model
    header = BranchHeader("", {}, 1, 6, 48, 2, "general", model, {})
    (named,) = of_response(header, found.points, [0], structure.gap_motion)
    phase = np.linspace(0, 2 * np.pi, 200)
    motion = named.point.motion
    force = forces_at(model, header.time_series, motion, phase)
    left = model.gap - free_displacement(model, header.time_series, motion, phase) + force @ model.R
    assert force.max() > 0 and force.min() >= 0 and left.min() > -1e-12
    assert (force.max(axis=1) > 0).mean() == pytest.approx(
        found.points[0].displacements.contact.max(), abs=0.02
    )


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"rotation": None}, ['casing.frame = "fixed"', "rotation.speed"]),
        ({"contact": {"direction": "casing", "axis": None}}, ['direction = "casing"', '"radial"']),
        ({"contact": {"casing": {"origin": [1e-5, 0.0]}}}, ["contact.casing", "[rotation]"]),
        ({"contact": {"casing": {"amplitude": 1e-5}}}, ["nothing moves the structure"]),
    ],
)
def test_what_a_fixed_casing_does_not_go_with_is_one_line(
    study_file: StudyFile, command: Command, changes: dict[str, Any], words: list[str]
) -> None:
    ended = command("response", study_file(turning(), **changes))
    ended.assert_one_line(2, *words)
