"""Kinematics of a body, as its study asks for them: a slender cantilever that bends far."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from conftest import PLATE, Ended, changed
from mpi4py import MPI

from fenics_nnm.backbone.point import CONVERGED, VERIFIED
from fenics_nnm.errors import ModelError, StudyError
from fenics_nnm.output.html_report.words import sentences
from fenics_nnm.output.pictures.results import read_results
from fenics_nnm.structure.analysis import linear_analysis, prepared
from fenics_nnm.structure.kinematics_lines import kinematics_lines
from fenics_nnm.structure.prepared import Prepared
from fenics_nnm.study import study_from

#: Its tip can touch beyond its end, 10 degrees off the axis: bending opens the gap again.
SLENDER: dict[str, Any] = changed(
    PLATE,
    {
        "mesh": {"height": 0.02, "elements": [8, 1]},
        "contact": {"direction": [0.985, 0.174], "points": 1, "gap": 6e-3},
        "reduction": {"modes": 2},
        "mode": {"harmonics": 5, "samples": 64},
        "continuation": {
            "energies": {"from": 0.4, "to": 0.9, "step": 0.5},
            "report_at": [],
            "shooting": True,
        },
    },
)


def body(kinematics: str | None, **changes: Any) -> Prepared:
    asked = {"body": {"kinematics": kinematics}} if kinematics else {}
    study = study_from(changed(changed(SLENDER, asked), changes), Path("study.toml"))
    return prepared(study, linear_analysis(study, MPI.COMM_SELF))


def test_linear_kinematics_are_doubted_where_bending_changes_the_closing() -> None:
    unasked, linear = body(None), body("linear")
    assert not kinematics_lines(unasked.linear.reduction)
    (line,) = kinematics_lines(linear.linear.reduction)
    assert line.startswith("kinematics       linear: asked for; at gamma ratio 1 second")
    points = unasked.followed().points
    doubted = linear.followed().points
    assert [p.motion.frequency for p in doubted] == [p.motion.frequency for p in points]
    for point, other in zip(points, doubted, strict=True):
        assert point.verdict is not None and other.verdict is not None
        assert point.verdict.status == VERIFIED and other.verdict.status == CONVERGED
        assert "second order would change the closing at grazing by -" in other.verdict.reason


def test_auto_takes_second_order_where_it_matters() -> None:
    far, near = body("auto"), body("auto", contact={"gap": 1e-6})
    assert far.linear.model.kinematics.masters.tolist() == [0]
    assert "more than 0.5 % and 0.0001" in far.linear.reduction.choice.reason
    assert not len(near.linear.model.kinematics.masters)
    assert "no more than 0.5 % and 0.0001" in near.linear.reduction.choice.reason
    found = far.followed()
    assert found.complete, found.reason
    for point in found.points:
        assert point.verdict is not None and point.verdict.status == VERIFIED, point.verdict
        assert point.balance.virial_error < 1e-8
    # the gap is reached at a larger amplitude than linear kinematics say
    assert far.linear.model.grazing_amplitude() > 1.02 * body(None).linear.model.grazing_amplitude()


def test_masters_are_those_of_the_study_and_what_makes_no_sense_is_refused() -> None:
    both = body("second-order", body={"masters": [1, 2]})
    assert both.linear.model.kinematics.masters.tolist() == [0, 1]
    assert "second order in mode 1, 2" in kinematics_lines(both.linear.reduction)[0]
    for changes, message in (
        ({"body": {"masters": [1]}}, "masters: has no effect"),
        ({"body": {"kinematics": "auto", "masters": [3]}}, "must not be above reduction.modes"),
        ({"body": {"kinematics": "auto", "masters": [2]}}, "must have mode.number = 1 among them"),
        ({"body": {"kinematics": "auto"}, "mode": {"harmonics": 16}}, "must be above 4"),
        (
            {"body": {"kinematics": "auto"}, "reduction": {"method": "craig-bampton"}},
            "second-order kinematics: need",
        ),
    ):
        with pytest.raises(StudyError, match=message):
            study_from(changed(SLENDER, changes), Path("study.toml"))
    with pytest.raises(ModelError, match="gaps that are positive"):
        body("second-order", contact={"gap": -1e-5})
    unknown = body("auto", contact={"gap": -1e-5}).linear.reduction.choice
    assert not unknown.second_order and "is not known" in unknown.reason


def test_kinematics_are_told_with_the_results(
    study_file: Callable[..., Path], command: Callable[..., Ended]
) -> None:
    study = study_file(body={"kinematics": "second-order"})
    assert command("run", study).code == 0
    words = "second order in mode 1: asked for"
    assert json.loads(Path("results/study/summary.json").read_text())["kinematics"] == words
    assert f"Kinematics: {words}." in sentences(read_results(Path("results/study")))[0]
