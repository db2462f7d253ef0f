"""Numbers that are found for a response: what they promise holds, and failed points break it."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import ROD, Ended, changed
from mpi4py import MPI

from fenics_nnm.mechanics.fourier import FourierSeries
from fenics_nnm.mechanics.linear_part import RatedPart
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.mechanics.second_order import SecondOrder
from fenics_nnm.resolution.driven_auto import (
    DrivenChoice,
    _expected,
    _Models,
    _tried,
    driven_choice,
)
from fenics_nnm.resolution.finer import Finer
from fenics_nnm.response.judge import Unjudged
from fenics_nnm.response.levels import CurveEnd, Response, response
from fenics_nnm.response.phase_resonance import damped_backbone
from fenics_nnm.response.point import Judgement, Status
from fenics_nnm.response.structure import Drive, DrivenStructure
from fenics_nnm.stages import Stages
from fenics_nnm.study import study_from
from fenics_nnm.study.resolution import Resolution

StudyFile = Callable[..., Path]
Command = Callable[..., Ended]

AUTO: dict[str, Any] = changed(
    ROD,
    {
        "mesh": {"elements": 8},
        "reduction": {"modes": "auto"},
        "mode": {"harmonics": "auto", "samples": "auto", "tolerance": 2e-3},
        "damping": {"ratio": 0.03},
        "excitation": {"at": [0.5], "force": [3e4]},
        "response": {"frequencies": {"from": 1200.0, "to": 1400.0, "step": 100.0}},
    },
)


@pytest.fixture(scope="module")
def chosen() -> DrivenChoice:
    """Numbers of a rod that meets a stop."""
    return driven_choice(study_from(AUTO, Path("study.toml")), MPI.COMM_SELF, Stages())


def resonance(structure: DrivenStructure, harmonics: int) -> float:
    series, frequencies = FourierSeries(harmonics, 10 * harmonics), np.array([1200.0, 1400.0])
    found = damped_backbone(structure, series, frequencies, (1.0,), judge=Unjudged())
    (point,) = (each.point for each in found.points if each.point.level == 1.0)
    return point.frequency


def test_resonance_is_as_near_to_that_of_many_harmonics_as_is_said(chosen: DrivenChoice) -> None:
    assert chosen.expected is not None and chosen.probes == 1
    assert chosen.expected.total <= 2e-3
    numbers = chosen.study.resolution
    assert numbers.samples >= 8 * numbers.harmonics
    known = resonance(chosen.structure, 30)
    assert abs(resonance(chosen.structure, numbers.harmonics) / known - 1) < 2e-3
    line = chosen.line(Response(()))
    assert f"harmonics = {numbers.harmonics}" in line and "tolerance 0.002 is met" in line


def test_error_of_modes_counts_where_they_cannot_be_raised() -> None:
    study = study_from(AUTO, Path("study.toml"))
    finer = Finer(study, limits={"modes": "the largest number tried is 2"})
    finer.free.remove("modes")
    tried = _tried(_Models(study, MPI.COMM_SELF, Stages()), finer, Resolution(3, 24, 2))
    assert tried.expected is not None and tried.expected.modes > 2e-3
    assert "is not met: modes: the largest number tried is 2" in tried.line(Response(()))


def test_tolerance_is_not_met_where_a_motion_failed(chosen: DrivenChoice) -> None:
    found = response(chosen.structure, FourierSeries(3, 24), np.array([900.0, 950.0]))
    bad = replace(found.points[0], judgement=Judgement(Status.FAILED, "no motion"))
    refuted = replace(found, points=(bad, *found.points[1:]))
    assert "is met" in chosen.line(found)
    assert "is not met: 1 of 2 motions failed" in chosen.line(refuted)
    short = replace(found, reasons=(CurveEnd("at 1 Hz: stuck"),))
    assert "is not met: a curve ends" in chosen.line(short)


def test_given_numbers_stay_and_what_has_no_resonance_is_told(
    study_file: StudyFile, command: Command
) -> None:
    far = study_file(AUTO, response={"frequencies": {"from": 100.0, "to": 200.0, "step": 50.0}})
    command("response", far).assert_one_line(2, '"auto"', "phase resonance", "mode.harmonics")
    command("simulate", far).assert_one_line(2, '= "auto"', "simulate needs a number")
    few = study_file(
        AUTO,
        mode={"harmonics": 6, "samples": 64, "tolerance": None},
        reduction={"modes": 4},
        response={"levels": [0.1]},
    )
    ended = command("response", few, "--output", "out")
    assert ended.code == 0 and "tolerance" not in ended.out


def stiffening(modes: int) -> DrivenStructure:
    """The first mode stiffens by second order far from an obstacle; the others do not move."""
    one = np.zeros((1, 1, 1, 1))
    bent = SecondOrder(np.array([0]), one[0, :1], np.zeros((modes, 1, 1)), one + 0.1, one)
    model = ReducedModel(
        omega=2.7 ** np.arange(modes),
        Phi=np.ones((1, modes)),
        R=[[1.0]],
        gap=[100.0],
        kinematics=bent,
    )
    shape = np.eye(modes)[:1]
    linear = RatedPart(model.omega, 0.04 * np.diag(model.omega))
    return DrivenStructure.of(model, linear, Drive.simple(shape, np.array([0.04 + 0j])))


def test_frequency_that_second_order_moves_is_no_error_of_the_modes() -> None:
    """The linear frequency is 3 % below: it is not what the resonance is compared with."""
    wanted = {"from": 0.1, "to": 0.3, "step": 0.1}
    study = study_from(AUTO | {"response": {"frequencies": wanted}}, Path("study.toml"))
    one, two = stiffening(1), stiffening(2)
    looked_at, expected = _expected(study, one, two, Resolution(5, 48, 1))
    assert looked_at == (1, False)
    series, frequencies = FourierSeries(5, 48), np.array([0.1, 0.3])
    found = damped_backbone(one, series, frequencies, (1.0,), judge=Unjudged())
    (omega,) = (each.point.omega for each in found.points if each.point.level == 1.0)
    assert omega == pytest.approx(np.sqrt(1 + 0.75 * 0.1 / omega**2), rel=2e-3)
    assert expected.modes < 1e-9 and 0 < expected.harmonics < 1e-6
