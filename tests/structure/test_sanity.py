"""Values that look like a wrong unit or direction: a line each, and none where they are right."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from conftest import BEAM, PLATE, ROD, Ended, changed
from mpi4py import MPI

from fenics_nnm.output.html_report.words import warnings as of_report
from fenics_nnm.output.pictures.results import read_results
from fenics_nnm.structure.analysis import linear_analysis, prepared
from fenics_nnm.study import study_from

StudyFile = Callable[..., Path]
Command = Callable[..., Ended]


def warnings(base: dict[str, Any], **changes: Any) -> list[str]:
    study = study_from(changed(base, changes), Path("study.toml"))
    return list(prepared(study, linear_analysis(study, MPI.COMM_SELF)).warnings())


def about_gap(**changes: Any) -> list[str]:
    return [line.partition(": ")[0] for line in warnings(ROD, **changes)]


@pytest.mark.parametrize("base", [ROD, PLATE, BEAM])
def test_nothing_is_said_of_a_sound_study(base: dict[str, Any]) -> None:
    assert warnings(base) == []


def test_gaps_from_5_percent_and_motions_from_10_percent_of_the_body() -> None:
    """A rod of 1 m whose end moves by the gap, and no point farther, at first contact."""
    assert about_gap(contact={"gap": 0.049}) == []
    assert about_gap(contact={"gap": 0.051}) == ["contact.gap = 0.051 m"]
    assert about_gap(contact={"gap": "99 mm"}) == ["contact.gap = 0.099 m"]
    assert about_gap(contact={"gap": 0.101}) == ["contact.gap = 0.101 m"] * 2
    gap, motion = warnings(ROD, contact={"gap": 3}, length_unit="m")
    assert "smallest gap is 3 m, 3 times the largest dimension of the body (1 m)" in gap
    assert "largest motion at gamma ratio 1 is 3 m" in motion
    assert "(a number without one is in m)" in gap


def test_interference() -> None:
    (line,) = warnings(ROD, contact={"gap": -0.06})
    assert line.startswith("contact.gap = -0.06 m: the largest interference is 0.06 m, 6 % of the")


def test_facets_behind_the_contact_points() -> None:
    """The outward normal of one end of a beam, followed backwards, meets the other end."""
    (line, _) = warnings(BEAM, contact={"=": {"facets": "right", "against": "left"}})
    assert line.startswith('contact.against = ["left"]: lies up to ')
    assert "behind the contact points, 100 % of the largest dimension" in line


def test_reference_displacement() -> None:
    (line,) = warnings(ROD, contact={"gap": 0.0, "reference_displacement": "20 cm"})
    assert line.startswith("contact.reference_displacement = 0.2 m: the largest motion")


def casing(**keys: Any) -> list[str]:
    contact = {"=": {"facets": "right", "direction": [0.0, 0.0, 1.0], "casing": keys}}
    return [line.partition(": ")[0] for line in warnings(BEAM, contact=contact)]


def test_casing_in_mm() -> None:
    """A casing 1 mm above a beam, its radius taken for metres, is named by its radius."""
    about = {"shape": "cylinder", "axis": "x", "origin": [0.0, 0.075, 0.0]}
    assert casing(**about, radius="150 mm") == []
    assert casing(**about, radius=150.0) == ["contact.casing.radius = 150 m"] * 2
    plane = {"shape": "plane", "normal": [0.0, 0.0, 1.0]}
    assert casing(**plane, origin=[0.0, 0.0, 0.101]) == []
    assert casing(**plane, origin=[0.0, 0.0, 101]) == ["contact.casing.origin = [0, 0, 101] m"] * 2


@pytest.mark.parametrize(
    ("key", "value", "line"),
    [
        ("young", 210.0, "material.young = 210 Pa: is outside 100000 to 2e+12 Pa: check the unit"),
        ("young", 2.1e14, "material.young = 2.1e+14 Pa"),
        ("density", 7.8e-9, "material.density = 7.8e-09 kg/m^3: is outside 1 to 30000 kg/m^3"),
        ("density", 7.8e6, "material.density = 7.8e+06 kg/m^3"),
    ],
)
def test_materials(key: str, value: float, line: str) -> None:
    (found,) = warnings(ROD, material={key: value})
    assert found.startswith(line)


def test_orthotropic_material() -> None:
    (found,) = warnings(
        PLATE,
        material={"=": {
            "young": [126e9, 11e3, 11e3],
            "poisson": [0.28, 0.4, 0.28],
            "shear": [6e3, 3e3, 6e3],
            "density": 1580.0,
        }},
    )  # fmt: skip
    assert found.startswith("material.young = [1.26e+11, 11000, 11000] Pa: is outside")


def warm(folder: Path, rows: str, **load: Any) -> list[str]:
    """Warnings about a rod of 1 m with a table of temperatures."""
    (folder / "t.csv").write_text(rows)
    field = {"temperature_field": {"shape": "table", "file": str(folder / "t.csv")}, **load}
    return warnings(ROD, material={"expansion": 1e-6}, load=field)


def test_temperatures(tmp_path: Path) -> None:
    """Celsius taken for kelvin, and mm for m."""
    assert warm(tmp_path, "x_m,T_K\n0,51\n1,2400\n") == []
    (line,) = warm(tmp_path, "x_m,T_K\n0,20\n1,200\n")
    assert line.startswith("load.temperature_field: in the body = [20, 200] K: is outside 50 to")
    (line,) = warm(tmp_path, "x_m,T_K\n0,300\n1000,400\n")
    assert line == (
        "load.temperature_field.file: its points extend over 1000 m, 1000 times the largest "
        "dimension of the body (1 m): check the unit"
    )
    lines = warnings(
        ROD, material={"expansion": 1e-6}, load={"temperature": 20, "reference_temperature": 30}
    )
    assert [line.split(" K")[0] for line in lines] == [
        "load.reference_temperature = 30",
        "load.temperature = 20",
    ]


@pytest.mark.parametrize(("length", "warned"), [("99 m", 0), ("101 m", 1), ("9 um", 1)])
def test_sizes(length: str, warned: int) -> None:
    found = warnings(ROD, mesh={"length": length, "length_unit": "mm"}, contact={"gap": "1 um"})
    sizes = [line for line in found if line.startswith('mesh.length_unit = "mm": the largest')]
    assert len(sizes) == warned


@pytest.mark.parametrize(
    ("direction", "words"),
    [
        ([1.0, 0.0], ""),
        ("normal", ""),
        ([-1.0, 0.0], "contact.direction = [-1, 0]: points into the body, on average 180 degrees"),
        ([0.0, 1.0], ""),  # a small end that meets a stop sideways
        ([0.3, 1.0], ""),
        ([-0.3, 1.0], "contact.direction = [-0.3, 1]: points into the body, on average 107"),
    ],
)
def test_directions_of_an_end(direction: Any, words: str) -> None:
    found = warnings(PLATE, contact={"direction": direction}, mesh={"elements": [2, 1]})
    assert len(found) == bool(words)
    assert not words or found[0].startswith(words)


@pytest.mark.parametrize(
    ("direction", "words"),
    [
        ([0.1, 1.0], ""),
        ([0.0, -1.0], "contact.direction = [0, -1]: points into the body, on average 180"),
        ([1.0, 0.1], "contact.direction = [1, 0.1]: runs along its surface, on average 84.3"),
    ],
)
def test_directions_of_a_side(direction: Any, words: str) -> None:
    """Towards the end, points of a side hide behind each other."""
    groups = {"part": {"facets": "top", "box": {"from": [0.4, -1.0], "to": [2.0, 1.0]}}}
    contact = {"facets": "part", "direction": direction}
    found = warnings(PLATE, contact=contact, groups=groups, body={"kinematics": "linear"})
    assert len(found) == bool(words)
    assert not words or found[0].startswith(words)


def test_check_run_summary_and_report_have_the_line(
    study_file: StudyFile, command: Command, caplog: pytest.LogCaptureFixture
) -> None:
    path = study_file(contact={"gap": "6 cm"}, title="Rod")
    line = "contact.gap = 0.06 m: the smallest gap is 0.06 m, 6 % of the largest dimension"
    for action in ("check", "run"):
        caplog.clear()
        assert command(action, path).code == 0
        (warned,) = [each for each in caplog.messages if "contact.gap" in each]
        assert warned.startswith(line)
    (stored,) = json.loads(Path("results/study/summary.json").read_text())["warnings"]
    assert stored.startswith(line)
    assert any(each.startswith(line) for each in of_report(read_results(Path("results/study"))))
