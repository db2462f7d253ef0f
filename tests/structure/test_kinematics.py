"""Kinematics of a body, as its study asks for them: a slender cantilever that bends far."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import PLATE, ROD, Ended, changed
from mpi4py import MPI

from fenics_nnm.backbone.point import CONVERGED, VERIFIED
from fenics_nnm.errors import ModelError, StudyError
from fenics_nnm.output.html_report.words import sentences
from fenics_nnm.output.pictures.results import read_results
from fenics_nnm.response.point import Status
from fenics_nnm.response.structure import NO_FLEXIBILITY
from fenics_nnm.results import response_file
from fenics_nnm.running.responding import ResponseJob, respond
from fenics_nnm.stages import Stages
from fenics_nnm.structure.analysis import linear_analysis, prepared
from fenics_nnm.structure.driven import driven_linear, driven_structure
from fenics_nnm.structure.kinematics_lines import kinematics_lines
from fenics_nnm.structure.motions_at_speed import Quantity, ReachedByTargets, Target
from fenics_nnm.structure.prepared import Prepared
from fenics_nnm.structure.spinning_mesh import SpinningMesh
from fenics_nnm.study import MeshStudy, study_from

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
    linear = body("linear")
    (line,) = kinematics_lines(linear.linear.reduction)
    assert line.startswith("kinematics       linear: asked for; at gamma ratio 1 of linear")
    for point in linear.followed().points:
        assert point.verdict is not None and point.verdict.status == CONVERGED
        assert "second order would change the closing at grazing by -" in point.verdict.reason


def test_second_order_is_taken_where_it_matters_if_nothing_is_said() -> None:
    far, near = body(None), body(None, contact={"gap": 1e-6})
    assert far.linear.model.kinematics.masters.tolist() == [0]
    assert "more than 0.5 % or 0.0001" in far.linear.reduction.choice.reason
    assert not len(near.linear.model.kinematics.masters)
    assert "no more than 0.5 % and 0.0001" in near.linear.reduction.choice.reason
    found = far.followed()
    assert found.complete, found.reason
    for point in found.points:
        assert point.verdict is not None and point.verdict.status == VERIFIED, point.verdict
        assert point.balance.virial_error < 1e-8
    # the gap is reached at a larger amplitude than linear kinematics say
    straight = body("linear").linear.model.grazing_amplitude()
    assert far.linear.model.grazing_amplitude() > 1.02 * straight


def closing(doubt: str) -> float:
    """Change of the closing at grazing in per cent of the gap."""
    return float(doubt.split()[-5])


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"reduction": {"method": "craig-bampton"}}, 'but second order needs reduction.method = "'),
        ({"reduction": {"method": "none"}}, "but full order is linear but for contact"),
        ({"mode": {"harmonics": 16}}, "but second order needs mode.samples above 4 mode.harmonics"),
        (
            {"rigid": [{"facets": "right", "at": [1.0, 0.01]}], "contact": {"points": 1}},
            "but constraints (rigid) are those of small rotations",
        ),
    ],
)
def test_what_cannot_be_of_second_order_is_linear_and_says_how_much_it_lacks(
    changes: dict[str, Any], reason: str
) -> None:
    """The change of the closing is that of the massless model; no point can be verified."""
    found = body(None, **changes).linear.reduction
    assert not len(found.model.kinematics.masters)
    assert reason in found.choice.reason
    massless = body("linear").linear.reduction.choice
    assert closing(found.choice.doubt) == pytest.approx(closing(massless.doubt), rel=0.012)
    assert "kinematics are linear, and second order would change" in found.choice.doubt


def test_rigid_facets_refuse_second_order() -> None:
    """A linear rotation makes them larger: beta would be 708 omega^2 in place of 2.5 omega^2."""
    rigid = {"rigid": [{"facets": "right", "at": [1.0, 0.01]}], "contact": {"points": 1}}
    with pytest.raises(ModelError, match=r"second-order.*constraints \(rigid\) .* must be .auto"):
        body("second-order", **rigid)


def test_driven_motions_are_doubted_as_those_of_a_branch(tmp_path: Path) -> None:
    """The same number as for a branch; motions without contact, and failed ones, are left alone."""
    driven = {
        "body": {"kinematics": "linear"},
        "mode": {"harmonics": 3, "samples": 32},
        "damping": {"ratio": 0.05},
        "excitation": {"facets": "right", "force": [0.0, 600.0]},
        "response": {
            "frequencies": {"from": 15.0, "to": 18.0, "step": 3.0},
            "levels": [0.01, 1.0],
            "backbone": False,
        },
    }
    study = study_from(changed(SLENDER, driven), Path("study.toml"))
    doubt = driven_linear(study, MPI.COMM_SELF).doubt
    assert closing(doubt) == pytest.approx(closing(body("linear").linear.reduction.choice.doubt))
    near = study_from(changed(changed(SLENDER, driven), {"contact": {"gap": 1e-6}}), Path("s.toml"))
    assert not driven_linear(near, MPI.COMM_SELF).doubt
    job = ResponseJob(study, "", resume=False, comm=MPI.COMM_SELF, stages=Stages())
    found = respond(job, tmp_path / "driven")
    touching = [point for point in found.found.points if point.touches]
    assert touching and all(point.status is not Status.VERIFIED for point in touching)
    assert {p.status for p in found.found.points if not p.touches} == {Status.EXACT}
    assert any("no motion in contact is verified" in line for line in found.notes)


def test_driven_motions_have_second_order_where_it_matters(tmp_path: Path) -> None:
    """Beside a resonance and at it: foreshortening of 0.581 a^2 / L, and nothing in doubt."""
    driven = {
        "mode": {"harmonics": 4, "samples": 32},
        "damping": {"ratio": 0.01},
        "excitation": {"facets": "right", "force": [0.0, 2.0]},
        "monitor": [{"name": "axial", "facets": "right", "direction": [1.0, 0.0]}],
        "response": {"frequencies": {"from": 16.0, "to": 18.0, "step": 1.0}, "backbone": False},
    }
    study = study_from(changed(SLENDER, driven), Path("study.toml"))
    job = ResponseJob(study, "", resume=False, comm=MPI.COMM_SELF, stages=Stages())
    found = respond(job, tmp_path / "driven")
    assert found.structure.model.kinematics.masters.tolist() == [0]
    assert any(
        "kinematics are of second order: level 1 moves mode 1" in line for line in found.notes
    )
    points = found.found.points
    assert {point.status for point in points} == {Status.VERIFIED}
    assert max(point.imbalance for point in points) < 1e-10
    highest = max(points, key=lambda point: point.amplitude[0])
    assert highest.judgement.largest_multiplier == pytest.approx(np.exp(-0.02 * np.pi), rel=1e-3)
    shortened = highest.displacements.lowest[1] / highest.amplitude[0] ** 2
    assert shortened == pytest.approx(-0.5810, rel=0.01)
    stored = response_file.read(tmp_path / "driven" / "response.h5")
    np.testing.assert_allclose(stored.watched.bent, found.structure.watched.bent)


def test_driven_motions_that_cannot_bend_are_linear_or_refused() -> None:
    """A force that takes part in the motion of the contact point leaves it no flexibility."""
    driven = {
        "damping": {"ratio": 0.01},
        "excitation": {"at": [1.0, 0.0], "force": [0.985, 0.174]},
        "response": {"frequencies": {"from": 16.0, "to": 18.0, "step": 1.0}},
    }
    found = driven_structure(study_from(changed(SLENDER, driven), Path("s.toml")), MPI.COMM_SELF)
    assert not found.bends and found.objection == NO_FLEXIBILITY
    asked = changed(SLENDER, {**driven, "body": {"kinematics": "second-order"}})
    with pytest.raises(StudyError, match="a driven body cannot have it: second-order kinematics"):
        driven_structure(study_from(asked, Path("s.toml")), MPI.COMM_SELF)


def test_full_order_is_doubted_too() -> None:
    at_full_order = body(None, reduction={"method": "none"})
    with at_full_order.linear.flexibility(5) as flexibility:
        assert flexibility is not None
        points = at_full_order.followed(flexibility=flexibility).points
    for point in points:
        assert point.verdict is not None and point.verdict.status != VERIFIED


def test_linear_kinematics_of_rods_and_pressed_points_say_why() -> None:
    for base, changes, reason in (
        (ROD, {}, "a rod does not bend"),
        (PLATE, {"contact": {"gap": -1e-5}}, "is not known where gaps are not positive"),
    ):
        study = study_from(changed(base, changes), Path("study.toml"))
        (line,) = kinematics_lines(linear_analysis(study, MPI.COMM_SELF).reduction)
        assert line.startswith("kinematics       linear: ") and line.endswith(reason)


def test_masters_are_those_of_the_study_and_what_makes_no_sense_is_refused() -> None:
    both = body("second-order", body={"masters": [1, 2]})
    assert both.linear.model.kinematics.masters.tolist() == [0, 1]
    assert "second order in mode 1, 2" in kinematics_lines(both.linear.reduction)[0]
    asked = {"kinematics": "second-order"}
    for changes, message in (
        ({"body": {"masters": [1], "kinematics": "linear"}}, "masters: has no effect"),
        ({"body": {"masters": [3]}}, "must not be above reduction.modes"),
        ({"body": {"masters": [2]}}, "must have mode.number = 1 among them"),
        ({"body": asked, "mode": {"harmonics": 16}}, "must be above 4"),
        (
            {"body": asked, "reduction": {"method": "craig-bampton"}},
            "second-order kinematics: need",
        ),
    ):
        with pytest.raises(StudyError, match=message):
            study_from(changed(SLENDER, changes), Path("study.toml"))
    with pytest.raises(ModelError, match="gaps that are positive"):
        body("second-order", contact={"gap": -1e-5})


def test_energies_of_a_campbell_diagram_decide_at_each_speed() -> None:
    """Second order is taken for a line of 100 times the energy of the study, at 0.011 % a unit."""
    rotation = {"axis": "z", "speed": 1.0, "origin": [-0.5, 0.0, 0.0]}
    study = study_from(changed(PLATE, {"rotation": rotation}), Path("study.toml"))
    assert isinstance(study, MeshStudy)
    spin = SpinningMesh.of(study, MPI.COMM_SELF, Stages()).at(1.0, 1)
    plain = spin.analyse(study, MPI.COMM_SELF)
    assert not plain.reduction.choice.second_order
    energy = plain.first_contact(0).energy
    lengths = np.linalg.norm(plain.reduction.shapes[:, 0].reshape(-1, 2), axis=1)
    moved = plain.model.grazing_amplitude() * lengths.max()
    for quantity, value, ratio in (
        (Quantity.ENERGY, 100 * energy, 100),
        (Quantity.AMPLITUDE, 10 * moved, 100),
        (Quantity.ENERGY, energy, 1),
    ):
        reached = ReachedByTargets((Target(quantity, value),))
        assert reached(study, plain) == pytest.approx(ratio)
        found = spin.analyse(study, MPI.COMM_SELF, reached=reached).reduction.choice
        assert found.second_order == (ratio > 1)
        assert found.reason.startswith(f"at gamma ratio {ratio} ")


def test_kinematics_are_told_with_the_results(
    study_file: Callable[..., Path], command: Callable[..., Ended]
) -> None:
    study = study_file(PLATE, body={"kinematics": "second-order"})
    assert command("run", study).code == 0
    words = "second order in mode 1: asked for; no other mode moves far enough to bend it as well"
    summary = json.loads(Path("results/study/summary.json").read_text())
    assert summary["kinematics"] == words
    assert summary["at_gamma_ratio_1"] == "static first contact"
    found = " ".join(sentences(read_results(Path("results/study"))))
    assert f"Kinematics: {words}." in found
    assert "With all other modes following statically contact begins at an energy of" in found
