"""Sections of the study file about rotation and steady loads, and what makes no sense in them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import BEAM, PLATE, ROD, Ended, changed
from loaded_studies import CASED, FILES, LOADED, RIGID
from mpi4py import MPI

from fenics_nnm.errors import StudyError
from fenics_nnm.structure.analysis import linear_analysis
from fenics_nnm.structure.coriolis import coriolis_change
from fenics_nnm.study import MeshStudy, study_from

StudyFile = Callable[..., Path]
Command = Callable[..., Ended]

SPIN = {"axis": "z", "speed": 10.0}


def test_speed_in_turns_per_minute() -> None:
    study = study_from(changed(ROD, {"rotation": {"axis": "z", "rpm": 30.0}}), Path("s.toml"))
    assert isinstance(study, MeshStudy)
    assert study.speed == pytest.approx(np.pi)


LINEAR = {"shape": "linear", "temperature": 300.0, "gradient": [10.0]}
CASING = {"shape": "cylinder", "axis": "z", "radius": 2.0, "growth": 1e-4}


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"rotation": {"axis": "z"}}, "rotation.speed, rpm: must have one of the two"),
        ({"rotation": {**SPIN, "rpm": 3.0}}, "rotation.speed, rpm: must have one of the two"),
        ({"rotation": {"axis": [0.0, 0.0, 0.0], "speed": 1.0}}, "must not be zero"),
        ({"rotation": {"axis": "z", "speed": 0.0, "coriolis": True}}, "has no effect without"),
        ({"rotation": SPIN, "clamp": None}, "needs a body that is held"),
        ({"rotation": SPIN, "solver": {"linear": "iterative"}}, "quadratic|needs factors"),
        (
            {"rotation": SPIN, "spring": [{"at": [1.0], "cubic": [1e9]}]},
            "rotation: does not go with spring.cubic",
        ),
        ({"load": {}}, r"load: must have temperature, temperature_field, \[\[load.pressure\]\] or"),
        ({"load": {"temperature": 300.0, "temperature_field": LINEAR}}, "must be one of the two"),
        ({"load": {"temperature_field": {}}}, "load.temperature_field.shape: is missing"),
        ({"load": {"temperature_field": {"shape": "cubic"}}}, "shape = .*must be 'table' or 'lin"),
        ({"load": {"temperature_field": {**LINEAR, "file": "t.csv"}}}, 'needs shape = "table"'),
        ({"load": {"temperature_field": {**LINEAR, "gradient": [0.0]}}}, "must not be zero"),
        ({"load": {"reference_temperature": 300.0}}, "has no effect without temperature"),
        ({"load": {"temperature": 293.15}}, "is reference_temperature, so has no effect"),
        ({"load": {"temperature": 1e30}}, r"load.temperature = 1e\+30: must be less than or equal"),
        ({"load": {"pressure": [{"facets": "right", "pressure": 0.0}]}}, "must not be zero"),
        ({"load": {"force": [{"force": [1.0]}]}}, "at, facets: must have one of the two"),
        ({"contact": {"gap": None, "casing": CASING, "direction": [1.0]}}, "growth = 0.0001: is"),
    ],
)
def test_what_makes_no_sense_is_refused(changes: dict[str, Any], words: str) -> None:
    with pytest.raises(StudyError, match=words) as error:
        study_from(changed(ROD, changes), Path("study.toml"))
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("base", "changes", "words"),
    [
        (ROD, {"rotation": {"axis": "x", "speed": 1.0}}, "speed has no effect"),
        (ROD, {"rotation": {**SPIN, "origin": [0.0, 1.0, 0.0]}}, "leaves the 1 dimensions"),
        (PLATE, {"rotation": {"axis": [1.0, 0.0, 1.0], "speed": 1.0}}, "leaves the 2 dimensions"),
        (ROD, {"rotation": {**SPIN, "origin": [1.0, 0.0, 0.0]}}, "rotation.axis: runs through"),
        (ROD, {"load": {"temperature": 300.0}}, "material.expansion: is missing"),
        (
            ROD,
            {"load": {"temperature": 300.0}, "material": {"expansion": -1.0}},
            "load.temperature: the change of temperature, +6.85 K, times material.expansion is a "
            "strain of 6.85: must be 0.1 at most",
        ),
        (ROD, {"load": {"temperature_field": LINEAR}}, "material.expansion: is missing"),
        (
            ROD,
            {"load": {"temperature_field": {**LINEAR, "gradient": [-400.0]}}},
            "load.temperature_field: is -100 to 300 K in the body: must be above absolute zero",
        ),
        (
            ROD,
            {"load": {"temperature_field": {**LINEAR, "gradient": [0.0, 1.0]}}},
            "load.temperature_field: depends on y: must depend on coordinates of the mesh alone",
        ),
        (
            ROD,
            {"load": {"temperature_field": {"shape": "table", "file": "none.csv"}}},
            "none.csv: cannot be read: No such file",
        ),
        (
            ROD,
            {"load": {"temperature_field": {"shape": "table", "file": "mm.csv"}}},
            "load.temperature_field.outside = 1e-05 m: 4 nodes lie farther outside of the points "
            "of the table, up to 0.999 m: points must surround the body; check their unit",
        ),
        (ROD, {"load": {"force": [{"facets": "left", "force": [1.0]}]}}, "on what is clamped"),
        (
            PLATE,
            {"load": {"pressure": [{"facets": "right", "pressure": 1.0, "follower": True}]}},
            "must not act on facets that touch",
        ),
        (
            BEAM,
            {"load": {"pressure": [{"facets": "nowhere", "pressure": 1.0}]}},
            "load.pressure[1].facets",
        ),
    ],
)
def test_what_does_not_go_with_the_body_is_refused(
    base: dict[str, Any],
    changes: dict[str, Any],
    words: str,
    study_file: StudyFile,
    command: Command,
) -> None:
    study = study_file(base, **changes)
    (study.parent / "mm.csv").write_text("x_mm,T_K\n0,300\n1,400\n")
    command("check", study).assert_one_line(2, words)


def test_a_body_that_is_held_too_little_is_told_so(study_file: StudyFile, command: Command) -> None:
    ended = command("check", study_file(PLATE, clamp={"directions": ["x"]}, rotation=SPIN))
    ended.assert_one_line(1, "0.0% of the steady loads", "or held in more directions")


@pytest.mark.parametrize(
    ("base", "changes", "words"),
    [
        (LOADED, {"rotation": {"speed": 2.0**63}}, "0.0% of the steady loads"),
        (RIGID, {"rigid": [{**RIGID["rigid"][0], "mass": 2.0**63}]}, "check lengths, units"),
    ],
)
def test_numbers_that_solvers_fail_with(
    base: dict[str, Any],
    changes: dict[str, Any],
    words: str,
    study_file: StudyFile,
    command: Command,
) -> None:
    study = study_file(base, **changes)
    (study.parent / "m.inp").write_bytes(FILES["m.inp"])
    command("check", study).assert_one_line(1, words)


def test_a_mode_that_never_touches_is_described(study_file: StudyFile, command: Command) -> None:
    """Radial gaps of 15 mm that bending opens: second order has a nearest approach alone."""
    ended = command("check", study_file(CASED))
    assert ended.code == 0, ended.err
    assert "\nnearest approach at " in ended.out
    assert "when it comes nearest, without touching" in ended.out


def test_modes_that_are_listed_are_those_of_the_study(
    study_file: StudyFile, command: Command
) -> None:
    """Craig-Bampton models have more modes, one for each retained displacement."""
    held = {"method": "craig-bampton", "modes": 2}
    ended = command("check", study_file(PLATE, rotation=SPIN, reduction=held))
    assert ended.code == 0, ended.err
    (head,) = (line for line in ended.out.splitlines() if "unloaded (Hz)" in line)
    rows = ended.out.split(head)[1].split("\n\n")[0].strip().splitlines()
    assert [row.split()[0] for row in rows] == ["1", "2"]
    speeding, unloaded = (float(each) for each in rows[0].split()[1:3])
    assert 1 < speeding / unloaded < 1 + 1e-4


def test_loads_that_cannot_be_applied_end_with_the_part_that_can(
    study_file: StudyFile, command: Command
) -> None:
    """A rod of St. Venant and Kirchhoff bears E A / (3 sqrt(3)) at most when it is pressed."""
    largest = 2.1e11 * 9e-4 / (3 * 3**0.5)
    study = study_file(ROD, load={"force": [{"at": [1.0], "force": [-2.02 * largest]}]})
    command("check", study).assert_one_line(1, "static state: 49.")


def test_coriolis_forces_are_no_part_of_nonlinear_modes(
    study_file: StudyFile, command: Command
) -> None:
    study = study_file(
        PLATE, rotation={**SPIN, "speed": 300.0, "coriolis": True}, contact={"gap": 0.1}
    )
    command("run", study).assert_one_line(2, "rotation.coriolis = true")
    shown = command("check", study)
    assert shown.code == 0
    assert "with Coriolis (Hz)" in shown.out and "unloaded (Hz)" in shown.out
    assert "rotation         300 rad/s" in shown.out
    assert "static state     largest displacement" in shown.out


def test_what_coriolis_forces_change_is_known_of_the_model() -> None:
    """By the factors of the model itself, as of all modes by those of another factorisation."""
    study = study_from(changed(PLATE, {"rotation": {"axis": "z", "speed": 300.0}}), Path("s.toml"))
    linear = linear_analysis(study, MPI.COMM_SELF)
    coupled = linear.frequencies().gyroscopic / linear.modes.frequencies - 1
    assert abs(coupled[0]) > 1e-6
    assert [
        coriolis_change(linear.coriolis, linear.modes, mode) for mode in (0, 1)
    ] == pytest.approx(coupled, rel=1e-5)
