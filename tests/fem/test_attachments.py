"""Masses and springs attached to a body, against exact solutions."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import square_plate
from conftest import BEAM, PLATE, ROD, Ended
from mpi4py import MPI
from scipy.optimize import brentq

from fenics_nnm.structure.analysis import linear_analysis
from fenics_nnm.study import read_study

StudyFile = Callable[..., Path]
Command = Callable[..., Ended]

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


@pytest.mark.parametrize("support", ["CFFF", "FFFF"])
def test_square_plate_of_solid_elements(support: str) -> None:
    """Square plate of test SDLS01, clamped on one side or free.

    The published values are upper bounds, up to 1 % above converged ones.
    """
    published, found = square_plate.published(support), square_plate.solid_plate(support, 20)
    thin = square_plate.thin_plate(support, len(published))
    if support == "FFFF":
        np.testing.assert_allclose(found[:6], square_plate.RIGID, rtol=1e-2)
    found = found[-len(published) :]
    np.testing.assert_allclose(found, thin, rtol=4e-3)
    np.testing.assert_allclose(found, published, rtol=5e-3 if support == "CFFF" else 1e-2)
    assert np.all(thin < published)


def test_mass_on_a_contact_point_leaves_it_little_flexibility(
    study_file: StudyFile, command: Command
) -> None:
    """The residual flexibility falls like 1 / J of a free tip, and like J^-3 under a mass."""
    rates = []
    for attached in ({}, {"mass": [{"at": [1.0], "mass": 7.0}]}):
        R = []
        for modes in (8, 16):
            study = study_file(ROD, mesh={"elements": 100}, reduction={"modes": modes}, **attached)
            R.append(linear_analysis(read_study(study), MPI.COMM_SELF).model.R[0, 0])
        rates.append(np.log2(R[0] / R[1]))
    np.testing.assert_allclose(rates, [1, 3], atol=0.2)
    assert "a contact point: contact there is an impact" in command("check", study).out


BAD: list[tuple[dict[str, Any], tuple[str, ...]]] = [
    ({"mass": [{"at": [2.0, 0.0], "mass": 1.0}]}, ("mass[1].at = [2.0, 0.0]", "1 m away")),
    ({"mass": [{"at": [0.0, 0.0], "mass": 1.0}]}, ("is clamped", "no effect")),
    ({"mass": [{"at": [0.5], "mass": 1.0}]}, ("mass[1].at = [0.5]", "2 components")),
    ({"mass": [{"at": [0.5, 0.0], "mass": -1.0}]}, ("mass[1].mass = -1.0", "greater than 0")),
    ({"mass": [{"at": [0.5, 0.0], "kg": 1.0}]}, ("mass[1].kg: unknown key",)),
    ({"mass": [{"mass": 1.0}]}, ("mass[1].at, facets: must have one of the two",)),
    ({"mass": [{"facets": "rigth", "mass": 1.0}]}, ('mass[1].facets = "rigth"', "no such group")),
    ({"mass": [{"facets": "left", "mass": 1.0}]}, ("mass[1].facets: all are clamped",)),
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
