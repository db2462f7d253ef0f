"""Driven structures against closed forms, through the study file and the command."""

import csv
import dataclasses
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib.image
import numpy as np
import pytest
from conftest import BEAM, PLATE, ROD, Ended
from mpi4py import MPI
from ranks import on_ranks
from scipy.linalg import eigh
from written_fields import arrays_of

from fenics_nnm.mechanics.force import CubicSprings
from fenics_nnm.mechanics.fourier import FourierSeries
from fenics_nnm.mechanics.linear_part import RatedPart
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.response.driven import open_response
from fenics_nnm.response.peaks import peaks
from fenics_nnm.response.point import Status
from fenics_nnm.response.structure import Drive, DrivenStructure
from fenics_nnm.structure.driven import driven_motions, driven_structure
from fenics_nnm.study import study_from

StudyFile = Callable[..., Path]
Command = Callable[..., Ended]

K = np.array([[3000.0, -1000.0], [-1000.0, 2000.0]])
M = np.array([[1.0, 0.1], [0.1, 0.5]])

TWO: dict[str, Any] = {
    "title": "Two masses",
    "matrices": {"file": "two.npz"},
    "contact": {"gap": 1.0},
    "reduction": {"modes": 2},
    "mode": {"harmonics": 3, "samples": 32},
    "damping": {"ratio": [0.01, 0.03]},
    "excitation": {"unknown": 1, "force": 10.0},
    "response": {"frequencies": {"from": 5.0, "to": 15.0, "step": 0.25}},
}

#: A damping matrix that couples the modes, with a part that is not symmetric.
COUPLING = np.array([[3.0, -1.5], [-0.5, 2.0]])

#: Results on one rank, and on two.
FOLDERS = ("results/study-response", "two")

SWEEP = {"frequencies": {"from": 100.0, "to": 2500.0, "step": 100.0}}


@pytest.fixture
def two(tmp_path: Path, study_file: StudyFile) -> Callable[..., Path]:
    """A function that writes the study of two masses with changes."""
    np.savez(tmp_path / "two.npz", K=K, M=M, B=np.array([[0.0, 1.0]]))
    return lambda **changes: study_file(TWO, **changes)


def table(folder: Path, monitor: str) -> dict[str, list[str]]:
    with (folder / "response.csv").open() as file:
        rows = [row for row in csv.DictReader(file) if row["monitor"] == monitor]
    return {key: [row[key] for row in rows] for key in rows[0]}


def complex_of(found: dict[str, list[str]]) -> np.ndarray:
    amplitude, lag = (np.array(found[key], float) for key in ("amplitude_m", "phase_deg"))
    return amplitude * np.exp(-1j * np.deg2rad(lag))


def modal_damping(ratios: list[float]) -> np.ndarray:
    """Damping matrix with these ratios: M Phi diag(2 zeta omega) Phi^T M."""
    squared, shapes = eigh(K, M)
    return np.asarray(M @ shapes @ np.diag(2 * np.array(ratios) * np.sqrt(squared)) @ shapes.T @ M)


@pytest.mark.parametrize(
    ("damping", "C"),
    [
        ({"ratio": 0.02}, modal_damping([0.02, 0.02])),
        ({"ratio": [0.01, 0.03]}, modal_damping([0.01, 0.03])),
        ({"alpha": 2.0, "beta": 1e-4}, 2.0 * M + 1e-4 * K),
        ({"alpha": 2.0}, 2.0 * M),
        ({"beta": 3e-4}, 3e-4 * K),
        ({"file": "C.npy"}, COUPLING),
    ],
)
def test_two_masses_have_amplitude_and_phase_of_the_closed_form(
    two: StudyFile, command: Command, damping: dict[str, Any], C: np.ndarray
) -> None:
    """(K - omega^2 M + i omega C) x = F as complex equations of both masses."""
    np.save("C.npy", COUPLING)
    study = two(damping={"=": damping})
    assert command("response", study).code == 0
    folder = Path("results/study-response")
    exact = []
    for frequency in np.linspace(5.0, 15.0, 41):
        omega = 2 * np.pi * frequency
        exact.append(np.linalg.solve(K - omega**2 * M + 1j * omega * C, [10.0, 0.0]))
    for column, monitor in enumerate(("excitation", "contact 1")):
        found, expected = table(folder, monitor), np.array(exact)[:, column]
        assert set(found["status"]) == {"exact"}
        np.testing.assert_allclose(np.array(found["frequency_Hz"], float)[[0, -1]], [5, 15])
        np.testing.assert_allclose(np.array(found["amplitude_m"], float), abs(expected), rtol=1e-10)
        np.testing.assert_allclose(complex_of(found) / expected, 1.0, atol=1e-10)
        gap = 1.0 - abs(np.array(exact)[:, 1])
        np.testing.assert_allclose(np.array(found["smallest_gap_m"], float), gap, rtol=1e-10)
    picture = matplotlib.image.imread(folder / "response.png")
    assert picture[:, :, :3].std() > 0.03
    assert sorted(path.name for path in folder.iterdir()) == [
        "resonance.csv",
        "response.csv",
        "response.h5",
        "response.png",
    ]


def test_table_on_the_terminal_has_the_peaks(two: StudyFile, command: Command) -> None:
    ended = command("response", two())
    assert ended.code == 0 and ended.err == ""
    rows = [line.split() for line in ended.out.splitlines() if line.strip().startswith("excit")]
    frequencies = np.linspace(5.0, 15.0, 20_001)
    C = modal_damping([0.01, 0.03])
    omega = 2 * np.pi * frequencies[:, None, None]
    exact = np.abs(np.linalg.solve(K - omega**2 * M + 1j * omega * C, np.array([10.0, 0])[:, None]))
    height = exact[:, 0, 0]
    tops = np.flatnonzero((height[1:-1] > height[:-2]) & (height[1:-1] > height[2:])) + 1
    assert len(rows) == len(tops) == 2
    for row, top in zip(rows, tops, strict=True):
        assert float(row[1]) == pytest.approx(frequencies[top], rel=1e-4)
        assert float(row[2]) == pytest.approx(height[top], rel=1e-3)


def test_forces_add_up_with_their_phases(two: StudyFile, command: Command) -> None:
    """A second force in quadrature, and one against the axis."""
    forces = [
        {"unknown": 1, "force": 10.0, "phase_deg": 0.0},
        {"unknown": 2, "force": -4.0, "phase_deg": 90.0},
    ]
    study = two(excitation=None)
    text = "\n".join(
        "[[excitation]]\n" + "\n".join(f"{key} = {value}" for key, value in force.items())
        for force in forces
    )
    study.write_text(f"{study.read_text()}\n{text}\n")
    assert command("response", study).code == 0
    omega = 2 * np.pi * np.linspace(5.0, 15.0, 41)
    C = modal_damping([0.01, 0.03])
    exact = np.array(
        [
            np.linalg.solve(K - w**2 * M + 1j * w * C, [10.0, -4.0 * np.exp(0.5j * np.pi)])
            for w in omega
        ]
    )
    folder = Path("results/study-response")
    for monitor, expected in (
        ("excitation 1", exact[:, 0]),
        ("excitation 2", -exact[:, 1]),  # along its force
        ("contact 1", exact[:, 1]),
    ):
        np.testing.assert_allclose(complex_of(table(folder, monitor)) / expected, 1, atol=1e-10)


def oscillator(ratio: float, force: float, gap: float = 1.0) -> DrivenStructure:
    """One mode of 2 Hz and 3 kg under a force."""
    omega, shape = np.array([4 * np.pi]), np.array([[3.0**-0.5]])
    model = ReducedModel(omega, shape, np.array([[1e-9]]), np.array([gap]))
    drive = Drive.simple(shape, np.array([force + 0j]))
    return DrivenStructure.of(model, RatedPart(omega, np.diag(2 * ratio * omega)), drive)


def test_phase_is_90_degrees_at_resonance_and_between_0_and_180() -> None:
    frequencies = np.array([0.01, 1.0, 2.0, 4.0, 400.0])
    points = open_response(oscillator(0.05, 1.0), FourierSeries(2, 16), frequencies)
    lag = np.array([point.phase[0] for point in points])
    assert lag[2] == pytest.approx(90.0, abs=1e-10)
    assert np.all(np.diff(lag) > 0) and 0 < lag[0] < 0.1 and 179.9 < lag[-1] < 180
    assert points[2].amplitude[0] == pytest.approx(1 / (3 * 2 * 0.05 * (4 * np.pi) ** 2), rel=1e-12)
    assert max(point.residual for point in points) < 1e-12
    (peak,) = peaks(points, 0)
    assert peak.frequency == 2.0 and peak.phase == pytest.approx(90.0)


def test_motion_touches_exactly_from_the_gap_on() -> None:
    height = 1 / (3 * 2 * 0.05 * (4 * np.pi) ** 2)
    for gap, status in ((1.000001 * height, Status.EXACT), (0.999999 * height, Status.TOUCHES)):
        structure = oscillator(0.05, 1.0, gap)
        (point,) = open_response(structure, FourierSeries(2, 16), np.array([2.0]))
        assert point.status == status
        assert bool(np.isnan(point.amplitude).all()) == (status == Status.TOUCHES)
    assert point.reason.startswith("closes the gap at contact point 1")


def test_contact_gives_no_number_and_exit_code_1(two: StudyFile, command: Command) -> None:
    ended = command("response", two(contact={"gap": 0.02}))
    assert ended.code == 1
    found = table(Path("results/study-response"), "contact 1")
    touching = np.array(found["status"]) == "touches"
    omega = 2 * np.pi * np.array(found["frequency_Hz"], float)
    C = modal_damping([0.01, 0.03])
    free = np.array([np.linalg.solve(K - w**2 * M + 1j * w * C, [10.0, 0.0])[1] for w in omega])
    np.testing.assert_array_equal(touching, abs(free) >= 0.02)
    assert 0 < touching.sum() < len(touching)
    for key in ("amplitude_m", "phase_deg", "smallest_gap_m"):
        np.testing.assert_array_equal(np.array(found[key]) == "", touching)
    (line,) = ended.err.splitlines()
    first = omega[touching][0] / 2 / np.pi
    for words in (f"{touching.sum()} of 41", f"at {first:g} Hz", "closes the gap at contact"):
        assert words in line


def test_cubic_spring_has_the_amplitude_of_the_duffing_oscillator(
    two: StudyFile, command: Command
) -> None:
    """With one harmonic: |(k - omega^2 m + 3/4 k3 a^2) + i omega c| a = F for the first mass."""
    study = two(
        mode={"harmonics": 1},
        spring={"unknown": 1, "cubic": 4e4},
        damping={"=": {"alpha": 8.0}},
        response={"frequencies": {"from": 2.0, "to": 6.0}},
    )
    assert command("response", study).code == 0
    found = table(Path("results/study-response"), "excitation")
    assert set(found["status"]) == {"converged"}
    other = complex_of(table(Path("results/study-response"), "contact 1"))
    linear_change = 0.0
    for frequency, x, y in zip(
        np.array(found["frequency_Hz"], float), complex_of(found), other, strict=True
    ):
        w = 2 * np.pi * frequency
        Z = K - w**2 * M + 8j * w * M
        spring = 0.75 * 4e4 * abs(x) ** 2
        balance = Z @ [x, y] + [spring * x, 0.0]
        np.testing.assert_allclose(balance, [10.0, 0.0], atol=1e-7)
        linear_change = max(linear_change, abs(x / np.linalg.solve(Z, [10.0, 0.0])[0] - 1))
    assert linear_change > 1e-3


def test_motion_that_is_not_found_has_no_numbers() -> None:
    """A hardening spring and a force far above what the iteration starts at."""
    plain = oscillator(0.001, 1e4, gap=1e6)
    hard = CubicSprings(np.array([[1.0]]), np.array([1e12]))
    structure = dataclasses.replace(plain, forces=(hard,))
    (point,) = open_response(structure, FourierSeries(1, 16), np.array([2.0]))
    assert point.status == Status.FAILED and not point.found
    assert np.isnan(point.amplitude).all() and np.isnan(point.gap).all()
    assert "Newton" in point.reason or "stalled" in point.reason


def rod_tip(frequency: np.ndarray, zeta: float) -> np.ndarray:
    """Tip receptance of a clamped rod of 1 m, E A = 2.1e11 9e-4, by 20 000 modes."""
    E, A, rho = 2.1e11, 9e-4, 7800.0
    number = np.arange(1, 20001) - 0.5
    natural = number * np.pi * np.sqrt(E / rho)
    omega = 2 * np.pi * frequency[:, None]
    terms = (2 / (rho * A)) / (natural**2 - omega**2 + 2j * zeta * natural * omega)
    return np.asarray(terms.sum(axis=1))


@pytest.mark.parametrize("how", [{"at": [1.0]}, {"facets": "right"}])
def test_rod_under_a_force_at_its_tip_is_the_continuous_one(
    study_file: StudyFile, command: Command, how: dict[str, Any]
) -> None:
    """The force acts at the contact point; eight modes and the static rest make up the rod."""
    study = study_file(
        ROD,
        mesh={"elements": 40},
        body={"degree": 2},
        reduction={"modes": 8},
        damping={"ratio": 0.02},
        excitation={**how, "force": [1000.0]},
        response=SWEEP,
    )
    assert command("response", study).code == 0
    found = table(Path("results/study-response"), "excitation")
    frequency = np.array(found["frequency_Hz"], float)
    exact = 1000.0 * rod_tip(frequency, 0.02)
    np.testing.assert_allclose(complex_of(found) / exact, 1.0, atol=2e-3)
    contact = table(Path("results/study-response"), "contact 1")
    np.testing.assert_allclose(complex_of(contact), complex_of(found), rtol=1e-9)


def test_static_displacement_is_exact_with_one_mode(study_file: StudyFile) -> None:
    """F L / (E A) at the tip of a rod, as the frequency goes to zero."""
    values = {
        **ROD,
        "reduction": {"modes": 1},
        "damping": {"ratio": 0.01},
        "excitation": {"at": [1.0], "force": [1000.0]},
        "response": {"frequencies": {"from": 1e-3, "to": 2e-3, "step": 1e-3}},
    }
    study = study_from(values, Path("study.toml"))
    structure = driven_structure(study, MPI.COMM_SELF)
    assert len(structure.model.omega) == 2
    points = driven_motions(study, structure).points
    assert points[0].amplitude[0] == pytest.approx(1000.0 / (2.1e11 * 9e-4), rel=1e-8)


def test_force_spread_over_facets_is_that_of_bending(
    study_file: StudyFile, command: Command
) -> None:
    """A plate strip by its mean tip displacement: static F L^3 / (3 E I) with shear."""
    study = study_file(
        PLATE,
        mesh={"elements": [8, 2]},
        damping={"beta": 1e-6},
        excitation={"facets": "right", "force": [0.0, -10.0]},
        response={"frequencies": {"from": 1.0, "to": 400.0, "step": 20.0}},
    )
    ended = command("response", study)
    assert ended.code == 0, ended.err
    folder = Path("results/study-response")
    excited, contact = (table(folder, name) for name in ("excitation", "contact 1"))
    inertia = 0.01 * 0.25**3 / 12
    bending = 10.0 / (3 * 2.1e11 * inertia)
    shear = 1.2 * 10.0 / (2.1e11 / 2.6 * 0.0025)
    assert float(excited["amplitude_m"][0]) == pytest.approx(bending + shear, rel=0.02)
    assert float(excited["phase_deg"][0]) < 1
    # the contact direction is up, and the force down
    assert float(contact["phase_deg"][0]) == pytest.approx(180.0, abs=1)


def test_list_of_ratios_has_one_for_each_mode(two: StudyFile, command: Command) -> None:
    ended = command("response", two(damping={"ratio": [0.01, 0.02, 0.03]}))
    ended.assert_one_line(2, "damping.ratio has 3 values", "reduction.modes = 2")


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"damping": None}, ["damping: is missing", "fenics-nnm response"]),
        ({"response": None, "excitation": None}, ["excitation, response: are missing"]),
        ({"damping": {"ratio": -0.1}}, ["damping.ratio"]),
        ({"damping": {"ratio": 0.0}}, ["damping.ratio"]),
        ({"damping": {"ratio": [0.1, "x"]}}, ["damping.ratio"]),
        ({"damping": {"alpha": 1.0}}, ["damping.ratio", "unknown key"]),
        ({"damping": {"=": {"alpha": 0.0}}}, ["damping.alpha = 0, beta = 0"]),
        ({"damping": {"=": {"beta": -1e-5}}}, ["damping.beta = -1e-05"]),
        ({"damping": {"=": {}}}, ["damping.ratio: is missing"]),
        ({"damping": 0.1}, ["damping"]),
        ({"excitation": {"force": 0.0}}, ["excitation.force = 0"]),
        ({"excitation": {"force": 1e-300}}, ["excitation.force = 0"]),
        ({"excitation": {"unknown": 3}}, ["excitation[1].unknown = 3", "must not be above 2"]),
        ({"excitation": {"facets": "tip"}}, ["excitation.facets", "unknown key"]),
        ({"excitation": {"force": [1.0]}}, ["excitation.force"]),
        ({"response": {"frequencies": {"from": 20.0}}}, ["response.frequencies", "below"]),
        ({"response": {"frequencies": {"step": -1.0}}}, ["response.frequencies.step = -1.0"]),
        ({"response": {"frequencies": {"step": None}}}, ["response.frequencies.step: is missing"]),
        ({"response": {"frequencies": {"step": 1e-6}}}, ["frequencies.step = 1e-06", "at most"]),
        ({"contact": {"gap": -0.1}}, ["contact.gap = -0.1: must be positive"]),
        (
            {"reduction": {"method": "craig-bampton", "interface": "contact"}},
            ['reduction.method = "craig-bampton"', '"massless"'],
        ),
    ],
)
def test_bad_input_is_one_line(
    two: StudyFile, command: Command, changes: dict[str, Any], words: list[str]
) -> None:
    command("response", two(**changes)).assert_one_line(2, *words)


@pytest.mark.parametrize(
    ("excitation", "words"),
    [
        ({"at": [1.0, 0.0, 0.0], "force": [1.0]}, ["excitation.force", "3 components"]),
        ({"at": [0.0, 0.0, 0.0], "force": [0, 0, 1.0]}, ["excitation.at", "clamped", "a force"]),
        ({"at": [9.0, 0.0, 0.0], "force": [0, 0, 1.0]}, ["excitation.at", "must be on the body"]),
        ({"facets": "left", "force": [0, 0, 1.0]}, ["excitation", "clamped"]),
        ({"facets": "right", "force": [0, 0, 1e-300]}, ["excitation.force = [0.0, 0.0, 0.0]"]),
        ({"facets": "none", "force": [0, 0, 1.0]}, ["excitation.facets", "none"]),
        ({"force": [0, 0, 1.0]}, ["excitation.at, facets"]),
        ({"facets": "left", "at": [0.0], "force": [1.0]}, ["excitation.at, facets"]),
    ],
)
def test_bad_force_on_a_mesh_is_one_line(
    study_file: StudyFile, command: Command, excitation: dict[str, Any], words: list[str]
) -> None:
    study = study_file(BEAM, damping={"ratio": 0.01}, excitation={"=": excitation}, response=SWEEP)
    command("response", study).assert_one_line(2, *words)


def backbone(name: str) -> list[dict[str, str]]:
    with Path(f"results/{name}/backbone.csv").open() as file:
        return list(csv.DictReader(file))


def test_run_is_the_same_with_the_sections_and_check_names_them(
    study_file: StudyFile, command: Command
) -> None:
    driven = {
        "damping": {"ratio": 0.02},
        "excitation": {"at": [0.5], "force": [1000.0]},
        "response": SWEEP,
        "continuation": {"damped": False},
    }
    plain, with_sections = study_file(name="plain.toml"), study_file(name="driven.toml", **driven)
    assert command("run", plain).code == command("run", with_sections).code == 0
    plain_rows, damped = (backbone(name) for name in ("plain", "driven"))
    added = {"damping_ratio", "resonance_force_N"}
    assert [{key: row[key] for key in row if key not in added} for row in damped] == [
        {key: row[key] for key in row if key not in added} for row in plain_rows
    ]
    assert {row[key] for row in plain_rows for key in added} == {"nan"}
    assert float(damped[0]["damping_ratio"]) == pytest.approx(0.02, rel=1e-9)
    checked = command("check", with_sections)
    assert "[damping], [excitation], [response]: for fenics-nnm response" in checked.out
    assert "fenics-nnm response" not in command("check", plain).out
    # a run goes on where the sections have been added since
    plain.write_text(with_sections.read_text())
    assert command("run", plain, "--resume").code == 0
    assert backbone("plain") == damped


def test_two_ranks_write_the_response_of_one(
    study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    study = study_file(
        BEAM,
        damping={"ratio": 0.01},
        excitation={"facets": "right", "force": [0.0, 0.0, 100.0]},
        response=SWEEP,
    )
    assert command("response", study).code == 0
    one = table(Path("results/study-response"), "excitation")
    arguments = ("-m", "fenics_nnm", "response", "--output", FOLDERS[1], study)
    ended = on_ranks(2, *arguments, folder=tmp_path)
    assert ended.code == 0, ended.err
    two = table(tmp_path / "two", "excitation")
    np.testing.assert_allclose(complex_of(two) / complex_of(one), 1.0, atol=1e-8)
    names = [sorted(path.name for path in Path(folder, "fields").iterdir()) for folder in FOLDERS]
    assert names[0] == names[1] and len(names[0]) == 7
    (first, second) = (
        arrays_of(next(Path(folder, "fields").glob("motion_*Hz")) / "frame_0003.vtu")
        for folder in FOLDERS
    )
    for name, values in first.items():
        size = np.abs(values).max()
        np.testing.assert_allclose(second[name], values, atol=1e-7 * size, err_msg=name)
