"""Kinds of excitation and damping against closed forms, without contact."""

import csv
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import ROD, Ended
from mpi4py import MPI
from scipy.linalg import eigh

from fenics_nnm.errors import ModelError
from fenics_nnm.response.levels import Response
from fenics_nnm.structure.driven import driven_motions, driven_structure
from fenics_nnm.study import study_from

StudyFile = Callable[..., Path]
Command = Callable[..., Ended]

K = np.array([[3000.0, -1000.0], [-1000.0, 2000.0]])
M = np.array([[1.0, 0.1], [0.1, 0.5]])

E, A, RHO, L = 2.1e11, 9e-4, 7800.0, 1.0


@pytest.fixture
def two(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Response]:
    """A function from sections to the response of two masses."""
    monkeypatch.chdir(tmp_path)
    np.savez(tmp_path / "two.npz", K=K, M=M, B=np.array([[0.0, 1.0]]))
    fixed: dict[str, Any] = {
        "matrices": {"file": "two.npz"},
        "contact": {"gap": 1e6},
        "reduction": {"modes": 2},
        "mode": {"harmonics": 3, "samples": 32},
    }
    return lambda **sections: found_of({**fixed, **sections})


def found_of(values: dict[str, Any]) -> Response:
    study = study_from(values, Path("study.toml"))
    return driven_motions(study, driven_structure(study, MPI.COMM_SELF))


def first_of(found: Response, place: int) -> np.ndarray:
    return np.array([point.displacements.first[place] for point in found.points])


def omega_of(found: Response) -> np.ndarray:
    return np.array([point.omega for point in found.points])


RANGE = {"frequencies": {"from": 5.0, "to": 15.0, "step": 1.0}}
FORCE = {"unknown": 1, "force": 10.0}


def test_loss_factor_is_a_complex_stiffness(two: Callable[..., Response]) -> None:
    found = two(damping={"loss_factor": 0.04}, excitation=FORCE, response=RANGE)
    exact = [np.linalg.solve((1 + 0.04j) * K - w**2 * M, [10.0, 0])[1] for w in omega_of(found)]
    np.testing.assert_allclose(first_of(found, 1) / exact, 1.0, atol=1e-10)
    assert {point.status for point in found.points} == {"exact"}
    assert max(point.imbalance for point in found.points) < 1e-12


def test_loss_factor_has_no_motion_in_time(tmp_path: Path, two: Callable[..., Response]) -> None:
    study = study_from(
        {
            "matrices": {"file": str(tmp_path / "two.npz")},
            "contact": {"gap": 1.0},
            "reduction": {"modes": 2},
            "damping": {"loss_factor": [0.01, 0.02]},
            "excitation": FORCE,
            "response": RANGE,
        },
        tmp_path / "study.toml",
    )
    structure = driven_structure(study, MPI.COMM_SELF)
    with pytest.raises(ModelError, match=r"loss factor .* has no equation in time"):
        _ = structure.linear.rate


def test_dashpot_couples_the_modes(two: Callable[..., Response]) -> None:
    """Beside Rayleigh damping; both masses are watched."""
    found = two(
        damping={"alpha": 0.5},
        dashpot={"unknown": 2, "damping": 7.0},
        monitor={"name": "second", "unknown": 2},
        excitation=FORCE,
        response=RANGE,
    )
    C = 0.5 * M + np.diag([0.0, 7.0])
    exact = np.array(
        [np.linalg.solve(K - w**2 * M + 1j * w * C, [10.0, 0]) for w in omega_of(found)]
    )
    for place, column in ((0, 0), (1, 1), (2, 1)):
        np.testing.assert_allclose(first_of(found, place) / exact[:, column], 1.0, atol=1e-10)


def test_dashpot_alone_is_damping_enough(two: Callable[..., Response]) -> None:
    found = two(dashpot={"unknown": 1, "damping": 7.0}, excitation=FORCE, response=RANGE)
    C = np.diag([7.0, 0.0])
    exact = [np.linalg.solve(K - w**2 * M + 1j * w * C, [10.0, 0])[0] for w in omega_of(found)]
    np.testing.assert_allclose(first_of(found, 0) / exact, 1.0, atol=1e-10)


def test_engine_orders_are_multiples_of_the_speed(two: Callable[..., Response]) -> None:
    """Orders 4 and 6 at speed Omega: harmonics 2 and 3 of 2 Omega."""
    found = two(
        damping={"ratio": 0.02},
        excitation=[
            {"unknown": 1, "force": 10.0, "order": 4},
            {"unknown": 2, "force": 5.0, "order": 6, "phase_deg": 30.0},
        ],
        response={"speeds": {"from": 8.0, "to": 20.0, "step": 3.0}},
    )
    np.testing.assert_allclose([p.speed for p in found.points], [8, 11, 14, 17, 20])
    np.testing.assert_allclose(omega_of(found), 2 * np.array([8, 11, 14, 17, 20]))
    for point in found.points:
        times = np.linspace(0, 2 * np.pi / point.omega, 2001)
        x = np.zeros((2001, 2))
        for n, force in ((2, [10.0, 0]), (3, [0, 5 * np.exp(1j * np.pi / 6)])):
            w = n * point.omega
            amplitude = np.linalg.solve(K - w**2 * M + 1j * w * ratio_matrix(0.02), force)
            x += np.real(np.exp(1j * w * times)[:, None] * amplitude)
        np.testing.assert_allclose(point.displacements.highest[:2], x.max(axis=0), rtol=1e-4)
        np.testing.assert_allclose(point.displacements.lowest[:2], x.min(axis=0), rtol=1e-4)
        np.testing.assert_allclose(point.amplitude, 0.0, atol=1e-12)


def ratio_matrix(ratio: float) -> np.ndarray:
    squared, shapes = eigh(K, M)
    return np.asarray(M @ shapes @ np.diag(2 * ratio * np.sqrt(squared)) @ shapes.T @ M)


def test_constant_force_moves_the_mean(two: Callable[..., Response]) -> None:
    found = two(
        damping={"ratio": 0.02},
        excitation=[FORCE, {"unknown": 2, "force": -40.0, "harmonic": 0}],
        response=RANGE,
    )
    mean = np.linalg.solve(K, [0.0, -40.0])
    point = found.points[0]
    highest = mean[1] + point.amplitude[2]
    assert point.displacements.highest[2] == pytest.approx(highest, rel=1e-12)
    assert point.gap[0] == pytest.approx(1e6 - highest, rel=1e-14)


def test_levels_scale_a_linear_response(two: Callable[..., Response]) -> None:
    found = two(damping={"ratio": 0.02}, excitation=FORCE, response={**RANGE, "levels": [0.5, 2.0]})
    low, high = (np.array([p.amplitude[0] for p in found.at_level(x)]) for x in (0.5, 2.0))
    assert len(low) == 11
    np.testing.assert_allclose(high, 4 * low, rtol=1e-12)


ROD_STUDY: dict[str, Any] = {
    **ROD,
    "mesh": {**ROD["mesh"], "elements": 30},
    "body": {**ROD["body"], "degree": 2},
    "reduction": {"modes": 6},
    "damping": {"loss_factor": 0.02},
    "response": {"frequencies": {"from": 200.0, "to": 2600.0, "step": 400.0}},
}


def tip(omega: np.ndarray, force: float, damper: float = 0.0) -> np.ndarray:
    """Tip of a clamped rod under a force, with a damper: F / (E A k cot(k L) + i omega c)."""
    modulus = E * (1 + 0.02j)
    k = omega * np.sqrt(RHO / modulus)
    return np.asarray(force / (modulus * A * k / np.tan(k * L) + 1j * omega * damper))


@pytest.mark.parametrize("where", [{"at": [1.0]}, {"facets": "right"}])
def test_dashpot_at_the_tip_of_a_rod(where: dict[str, Any]) -> None:
    found = found_of(
        {
            **ROD_STUDY,
            "excitation": {"facets": "right", "force": [1000.0]},
            "dashpot": {**where, "damping": [5000.0]},
        }
    )
    exact = tip(omega_of(found), 1000.0, 5000.0)
    np.testing.assert_allclose(first_of(found, 0) / exact, 1.0, atol=2e-3)
    assert np.abs(exact / tip(omega_of(found), 1000.0)).min() < 0.8


def test_pressure_on_the_end_of_a_rod_is_a_force(two: StudyFile) -> None:
    pressed = {**ROD_STUDY, "excitation": {"facets": "right", "pressure": 1e6}}
    found = found_of(pressed)
    exact = tip(omega_of(found), 1e6 * A)  # inwards, as the displacement that is watched
    np.testing.assert_allclose(first_of(found, 0) / exact, 1.0, atol=2e-3)
    contact = np.array([point.displacements.first[1] for point in found.points])
    np.testing.assert_allclose(contact, -first_of(found, 0), rtol=1e-9)


def test_shaken_rod_is_that_of_its_continuous_base() -> None:
    """Tip against the base under acceleration a: a / omega^2 (1 - 1 / cos(k L))."""
    shaken = {
        **ROD_STUDY,
        "excitation": {"base": [50.0]},
        "monitor": {"name": "tip", "at": [1.0], "direction": "-x"},
    }
    found = found_of(shaken)
    omega = omega_of(found)
    k = omega * np.sqrt(RHO / (E * (1 + 0.02j)))
    # u'' = omega^2 u + a: absolute motion -a / omega^2 cos(k (L - x)) / cos(k L)
    exact = -50.0 / omega**2 * (1 / np.cos(k * L) - 1)
    np.testing.assert_allclose(-first_of(found, 1) / exact, 1.0, atol=2e-3)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"damping": {"=": {"loss_factor": -1.0}}}, ["damping.loss_factor"]),
        ({"damping": {"=": {"loss_factor": [0.1]}}}, ["damping.loss_factor has 1 values"]),
        ({"damping": {"=": {"file": "none.npy"}}}, ["none.npy", "cannot be read"]),
        ({"damping": {"=": {"file": "big.npy"}}}, ["damping matrix has shape (3, 3)"]),
        (
            {"damping": {"=": {"file": "feeding.npy"}}},
            ["damping matrix", "an eigenvalue of -1 or less"],
        ),
        ({"dashpot": {"unknown": 9, "damping": 1.0}}, ["dashpot[1].unknown = 9"]),
        ({"dashpot": {"unknown": 1, "damping": 0.0}}, ["dashpot.damping = 0"]),
        ({"monitor": {"unknown": 5, "name": "x"}}, ["monitor[1].unknown = 5"]),
        ({"monitor": {"unknown": 1, "name": "excitation"}}, ['monitor.name = "excitation"']),
        ({"excitation": {"order": 2}}, ["excitation.order = 2", "response.speeds"]),
        ({"excitation": {"harmonic": 9}}, ["mode.harmonics = 3: must be 9 or more"]),
        ({"excitation": {"harmonic": 0}}, ["excitation.harmonic = 0"]),
        ({"excitation": {"harmonic": 2, "order": 2}}, ["harmonic, order"]),
        (
            {"excitation": {"=": [{"unknown": 1, "force": 5.0}, {"unknown": 1, "force": -5.0}]}},
            ["excitation: the forces cancel each other"],
        ),
        ({"response": {"levels": [1.0, 1.0]}}, ["levels = [1.0, 1.0]: must differ"]),
        ({"response": {"levels": [0.0]}}, ["response.levels"]),
        ({"response": {"frequencies": None}}, ["frequencies, speeds: must have one"]),
        (
            {"response": {"frequencies": None, "speeds": {"from": 1.0, "to": 2.0, "step": 0.5}}},
            ["response.speeds: needs excitation.order"],
        ),
    ],
)
def test_bad_input_is_one_line(
    tmp_path: Path,
    two: object,
    study_file: StudyFile,
    command: Command,
    changes: dict[str, Any],
    words: list[str],
) -> None:
    np.save(tmp_path / "big.npy", np.eye(3))
    np.save(tmp_path / "feeding.npy", np.array([[1.0, 2.0], [2.0, 1.0]]))
    base: dict[str, Any] = {
        "matrices": {"file": "two.npz"},
        "contact": {"gap": 1e6},
        "reduction": {"modes": 2},
        "mode": {"harmonics": 3, "samples": 32},
        "damping": {"ratio": 0.02},
        "excitation": FORCE,
        "response": RANGE,
    }
    command("response", study_file(base, **changes)).assert_one_line(2, *words)


def test_table_has_all_columns(
    tmp_path: Path, two: object, study_file: StudyFile, command: Command
) -> None:
    base: dict[str, Any] = {
        "matrices": {"file": "two.npz"},
        "contact": {"gap": 1e6},
        "reduction": {"modes": 2},
        "damping": {"ratio": 0.02},
        "excitation": {**FORCE, "order": 2},
        "response": {"speeds": {"from": 10.0, "to": 20.0, "step": 5.0}, "levels": [1.0, 3.0]},
    }
    assert command("response", study_file(base)).code == 0
    with Path("results/study-response/response.csv").open() as file:
        rows = list(csv.DictReader(file))
    wanted = (
        "level,branch,point,frequency_Hz,speed_rad_s,monitor,amplitude_m,phase_deg,max_m,min_m,"
        "contact_fraction,largest_multiplier,stability,status"
    ).split(",")
    assert set(wanted) <= rows[0].keys()
    assert [row["point"] for row in rows if row["monitor"] == "excitation"] == list("123123")
    assert {row["level"] for row in rows} == {"1", "3"}
    assert float(rows[0]["frequency_Hz"]) == pytest.approx(20.0 / 2 / np.pi)
    assert rows[0]["speed_rad_s"] == "10" and rows[0]["contact_fraction"] == "0"
    assert rows[0]["largest_multiplier"] == ""
