"""Masses and springs attached to a body, against exact solutions."""

from __future__ import annotations

import csv
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import BEAM, PLATE, ROD, Ended
from mpi4py import MPI
from numpy.polynomial import legendre
from scipy.linalg import eigh
from scipy.optimize import brentq
from test_mpi import on_ranks

from fenics_nnm.analysis import linear_analysis
from fenics_nnm.fem.attachments import Attachment
from fenics_nnm.fem.mesh import generate_mesh
from fenics_nnm.fem.modes import ModalSolver
from fenics_nnm.fem.regions import Region
from fenics_nnm.fem.solid import Body, assemble_solid
from fenics_nnm.geometry import Beam
from fenics_nnm.materials.elasticity import Isotropic
from fenics_nnm.materials.material import Material
from fenics_nnm.study import read_study

StudyFile = Callable[..., Path]
Command = Callable[..., Ended]

REFERENCE = Path(__file__).parent / "reference"

#: The rod of the small study: E A in N, mass in kg, wave speed in m/s; its length is 1 m.
EA, MASS, SPEED = 2.1e11 * 9e-4, 7800.0 * 9e-4, np.sqrt(2.1e11 / 7800.0)


def frequencies(path: Path) -> np.ndarray:
    return linear_analysis(read_study(path), MPI.COMM_SELF).modes.frequencies


def rod_errors(study_file: StudyFile, exact: float, mode: int, **attached: Any) -> np.ndarray:
    errors = []
    for elements in (4, 8, 16):
        study = study_file(ROD, mesh={"elements": elements}, reduction={"modes": 3}, **attached)
        errors.append(frequencies(study)[mode] / exact - 1)
    return np.array(errors)


@pytest.mark.parametrize("place", [{"at": [1.0]}, {"facets": "right"}])
def test_mass_at_the_tip_of_a_rod(place: dict[str, Any], study_file: StudyFile) -> None:
    """beta tan(beta) = rho A L / m."""
    mass, mode = 5.0, 1
    beta = brentq(lambda b: b * np.sin(b) - MASS / mass * np.cos(b), np.pi, 1.5 * np.pi)
    exact = beta * SPEED / (2 * np.pi)
    errors = rod_errors(study_file, exact, mode, mass=[{**place, "mass": mass}])
    assert errors.min() > 0
    np.testing.assert_allclose(np.log2(errors[:-1] / errors[1:]), 2, atol=0.2)  # linear elements


@pytest.mark.parametrize(
    "spring",
    [
        {"at": [1.0], "stiffness": [3e8]},
        {"facets": "right", "stiffness": [3e8]},
        {"facets": "right", "foundation": [3e8 / 9e-4]},
    ],
)
def test_spring_at_the_tip_of_a_rod(spring: dict[str, Any], study_file: StudyFile) -> None:
    """beta cot(beta) = -k L / (E A)."""
    beta = brentq(lambda b: b * np.cos(b) + 3e8 / EA * np.sin(b), np.pi / 2, np.pi)
    errors = rod_errors(study_file, beta * SPEED / (2 * np.pi), 0, spring=[spring])
    assert errors.min() > 0
    np.testing.assert_allclose(np.log2(errors[:-1] / errors[1:]), 2, atol=0.2)


def test_springs_hold_a_body_that_has_no_clamp(study_file: StudyFile) -> None:
    """Soft springs at both ends: the rod moves as a rigid body, omega^2 = k / m."""
    springs = [{"at": [x], "stiffness": [1e3]} for x in (0.0, 1.0)]
    study = study_file(ROD, clamp=None, spring=springs)
    rigid = np.sqrt(2e3 / MASS) / (2 * np.pi)
    assert frequencies(study)[0] == pytest.approx(rigid, rel=1e-5)


def test_spread_over_a_face_is_even_and_adds_up(study_file: StudyFile) -> None:
    """A stiff block on a foundation along z with a mass on top moves up and down with k / m."""
    block = {"length": 1.0, "width": 0.5, "height": 0.5, "elements": [2, 1, 1]}
    held = {"facets": ["left", "right"], "stiffness": [5e7, 5e7, 0.0]}
    study = study_file(
        BEAM,
        mesh=block,
        clamp=None,
        spring=[{"facets": "bottom", "foundation": [0.0, 0.0, 1e6]}, held],
        mass=[{"facets": "top", "mass": 50.0}],
        reduction={"modes": 6},
    )
    total = 7800.0 * 0.25 + 50.0
    expected = np.sqrt(1e6 * 0.5 / total) / (2 * np.pi)
    assert np.abs(frequencies(study) / expected - 1).min() < 1e-5


def sdls01(support: str) -> list[float]:
    lines = (REFERENCE / "sdls01_square_plate.csv").read_text().splitlines()
    rows = csv.DictReader(line for line in lines if not line.startswith("#"))
    return [float(row["f_ref_Hz"]) for row in rows if row["bc"] == support]


def thin_plate(support: str, count: int, terms: int = 14, nu: float = 0.3) -> np.ndarray:
    """omega a^2 sqrt(rho h / D) of a thin square plate, without rigid motions.

    Ritz's method with products of Legendre polynomials on [-1, 1]^2, so a = 2; times (1 + x)^2
    for a side x = -1 that is clamped.
    """
    clamped = support == "CFFF"
    points, weights = legendre.leggauss(terms + 4)

    def integrals(factor: list[float]) -> list[np.ndarray]:
        """Integrals of products of two of the functions: P P, P P'', P' P', P'' P''."""
        rows = [legendre.legmul(factor, unit) for unit in np.eye(terms)]
        P, dP, ddP = (
            np.array([legendre.legval(points, legendre.legder(row, k)) for row in rows])
            for k in range(3)
        )
        pairs = ((P, P), (P, ddP), (dP, dP), (ddP, ddP))
        return [(left * weights) @ right.T for left, right in pairs]

    # (1 + x)^2 = 4/3 P_0 + 2 P_1 + 2/3 P_2
    X, X0, X1, X2 = integrals([4 / 3, 2.0, 2 / 3] if clamped else [1.0])
    Y, Y0, Y1, Y2 = integrals([1.0])
    bending = np.kron(X2, Y) + np.kron(X, Y2) + nu * (np.kron(X0, Y0.T) + np.kron(X0.T, Y0))
    twisting = 2 * (1 - nu) * np.kron(X1, Y1)
    squares = eigh(bending + twisting, np.kron(X, Y), eigvals_only=True)
    rigid = 0 if clamped else 3
    return 4 * np.sqrt(squares[rigid : rigid + count])


@pytest.mark.parametrize("support", ["CFFF", "FFFF"])
def test_square_plate_of_solid_elements(support: str) -> None:
    """Square plate 1 m x 1 m x 0.01 m of test SDLS01, clamped on one side or free.

    Leissa's values of 1973 are upper bounds by Ritz's method with beam functions, up to 1 % above
    converged ones. The free plate hangs on a foundation that gives its rigid motions 0.5 Hz, which
    adds less than 1.2e-4 to any other frequency.
    """
    thickness, density = 0.01, 7800.0
    elements = (20, 20, 1)
    beam = Beam(length=1.0, width=1.0, height=thickness, elements=elements, cells="hexahedron")
    tagged = generate_mesh(beam, MPI.COMM_SELF)
    soft = density * thickness * (2 * np.pi * 0.5) ** 2
    springs = Attachment("spring[1]", "spring", (soft,) * 3, facets=("bottom",), per_area=True)
    steel = Region(Material(Isotropic(2.1e11, 0.3), density))
    free = support == "FFFF"
    clamped = tagged.facets_of(("left",), "clamp") if not free else np.empty(0, dtype=np.int32)
    body = Body("solid", (steel,), attachments=(springs,) if free else ())
    leissa = np.array(sdls01(support))
    with ModalSolver(assemble_solid(tagged, body, clamped)) as solver:
        found = solver.modes(len(leissa) + 6 * free).frequencies
    if free:
        np.testing.assert_allclose(found[:6], 0.5, rtol=1e-2)
    found = found[6 * free :]
    bending = 2.1e11 * thickness**3 / 12 / (1 - 0.3**2)
    unit = np.sqrt(bending / (density * thickness)) / (2 * np.pi)
    np.testing.assert_allclose(found, unit * thin_plate(support, len(found)), rtol=4e-3)
    np.testing.assert_allclose(found, leissa, rtol=1e-2 if free else 5e-3)
    assert np.all(unit * thin_plate(support, len(found)) < leissa)


def test_two_ranks_attach_to_the_same_vertices(
    study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    study = study_file(
        PLATE,
        mass=[{"at": [0.5, 0.26], "mass": 1.0}, {"facets": "right", "mass": 2.0}],
        spring=[{"at": [1.0, 0.25], "stiffness": [0.0, 1e6]}],
    )
    alone = command("check", study)
    ended = on_ranks(2, "-m", "fenics_nnm", "check", study, folder=tmp_path)
    assert (alone.code, ended.code) == (0, 0), alone.err + ended.err
    assert ended.out.splitlines()[:16] == alone.out.splitlines()[:16]
    assert "mass[1]          1 kg at the vertex (0.5, 0.25) m" in alone.out
    assert "mass[2]          2 kg spread over right" in alone.out
    assert "spring[1]        0, 1e+06 N/m along x, y at the vertex (1, 0.25) m" in alone.out


BAD: list[tuple[dict[str, Any], tuple[str, ...]]] = [
    ({"mass": [{"at": [2.0, 0.0], "mass": 1.0}]}, ("mass[1].at = [2.0, 0.0]", "1 m away")),
    ({"mass": [{"at": [0.0, 0.0], "mass": 1.0}]}, ("is clamped", "no effect")),
    ({"mass": [{"at": [0.5], "mass": 1.0}]}, ("mass[1].at = [0.5]", "2 components")),
    ({"mass": [{"at": [0.5, 0.0], "mass": -1.0}]}, ("mass[1].mass = -1.0", "greater than 0")),
    ({"mass": [{"at": [0.5, 0.0], "kg": 1.0}]}, ("mass[1].kg: unknown key",)),
    ({"mass": [{"mass": 1.0}]}, ("mass[1].at, facets: must have one of the two",)),
    ({"mass": [{"facets": "rigth", "mass": 1.0}]}, ('mass[1].facets = "rigth"', "no such group")),
    ({"mass": 1.0}, ("mass = 1.0: must be a section",)),
    ({"spring": [{"at": [1.0, 0.0]}]}, ("spring[1].stiffness, foundation",)),
    ({"spring": [{"at": [1.0, 0.0], "foundation": [1.0, 1.0]}]}, ("needs facets",)),
    ({"spring": [{"at": [1.0, 0.0], "stiffness": [0.0, 0.0]}]}, ("must not be zero",)),
    ({"spring": [{"at": [1.0, 0.0], "stiffness": [1.0]}]}, ("spring[1].stiffness", "2 components")),
    ({"spring": [{"at": [1.0, 0.0], "stiffness": [1.0, -1.0]}]}, ("spring[1].stiffness",)),
]


@pytest.mark.parametrize(("changes", "words"), BAD)
def test_bad_attachment(
    changes: dict[str, Any], words: tuple[str, ...], study_file: StudyFile, command: Command
) -> None:
    command("check", study_file(PLATE, **changes)).assert_one_line(2, *words)
