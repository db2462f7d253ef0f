"""Cubic springs on meshes: the reduced model against all modes, points against facets."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import BEAM, PLATE, Ended
from mpi4py import MPI

from fenics_nnm.backbone.verdict import Judge, Judgement
from fenics_nnm.mechanics.force import CubicSprings
from fenics_nnm.results import branch_file
from fenics_nnm.structure.analysis import linear_analysis, nonlinear_mode
from fenics_nnm.study import study_from
from fenics_nnm.time_domain.bifurcations import Bifurcations

StudyFile = Callable[..., Path]
Command = Callable[..., Ended]

#: A cantilever whose lower edge is held by a cubic spring; the tip can touch.
CANTILEVER: dict[str, Any] = {
    **PLATE,
    "mesh": {"model": "plate", "length": 1.0, "height": 0.1, "elements": [8, 1]},
    "spring": [{"facets": "bottom", "cubic": [0.0, 3e13]}],
    "reduction": {"modes": 3},
    "mode": {"number": 1, "harmonics": 5, "samples": 32},
    "continuation": {"energies": {"from": 0.3, "to": 0.9, "step": 0.3}},
}


def frequencies(modes: int, spring: dict[str, Any]) -> np.ndarray:
    """Frequency ratios by harmonic balance alone: to follow twelve modes in time takes a minute."""
    study = study_from(
        {**CANTILEVER, "spring": [spring], "reduction": {"modes": modes}}, Path("study.toml")
    )
    analysis = linear_analysis(study, MPI.COMM_SELF)
    (force,) = analysis.reduction.forces
    assert isinstance(force, CubicSprings) and force.shapes.shape == (1, modes + 1)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Judge, "judged", lambda judge, found: found)
        patch.setattr(
            Judge, "judgement", lambda judge, found: Judgement(found.points, Bifurcations())
        )
        follow = sys.modules["fenics_nnm.backbone.follow"]
        patch.setattr(follow, "revised", lambda judge, motions, found, on_point: found)
        branch = nonlinear_mode(study, analysis)
    assert branch.complete, branch.reason
    linear = analysis.modes.frequencies[0]
    return np.array([point.motion.frequency / linear for point in branch.points])


def test_few_modes_and_the_shape_of_the_spring_are_nearly_all_modes() -> None:
    spring = CANTILEVER["spring"][0]
    few, many = frequencies(3, spring), frequencies(12, spring)
    assert few[-1] > 1.03  # the spring stiffens the mode before contact begins
    assert np.all(np.diff(few) > 0)
    np.testing.assert_allclose(few, many, rtol=2e-4)


def test_spring_at_a_vertex_hardens_more_the_farther_out_it_sits() -> None:
    inside, outside = (
        frequencies(4, {"at": [x, 0.0], "cubic": [0.0, 1e12]})[-1] for x in (0.5, 0.75)
    )
    assert 1 < inside < outside


def test_run_of_a_beam_is_verified(tmp_path: Path, study_file: StudyFile, command: Command) -> None:
    changes = {
        "spring": [{"at": [0.6667, 0.0, 0.0], "stiffness": [0, 0, 1e3], "cubic": [0, 0, 1e12]}],
        "continuation": {"energies": {"from": 0.4, "to": 0.8, "step": 0.4}, "report_at": [0.8]},
    }
    path = study_file(base={**BEAM, **changes})
    ended = command("run", path, "--output", tmp_path / "results")
    assert ended.code == 0, ended.err
    points = branch_file.read(tmp_path / "results" / "branch.h5")[1]
    assert [point.status for point in points] == ["verified"] * 2


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"spring": [{"facets": "bottom", "cubic": [0.0, 0.0]}]}, "must not be zero"),
        ({"spring": [{"facets": "bottom"}]}, "must have one of the two, or cubic"),
        ({"mode": {"harmonics": 8, "samples": 32}}, "must be above 4 mode.harmonics = 32"),
        ({"reduction": {"method": "craig-bampton", "modes": 3}}, "needs reduction.method"),
        ({"reduction": {"modes": "auto"}}, "does not go with spring.cubic: must be a number"),
        ({"mode": {"harmonics": "auto", "samples": 64}}, "does not go with spring.cubic"),
        (
            {"continuation": {"parameter": "frequency", "frequencies": {"from": 1.01, "to": 1.1}}},
            'must be "energy" or "arc-length"',
        ),
        ({"contact": {**PLATE["contact"], "gap": -1e-4}}, "must be positive with springs"),
        (
            {"spring": [{"at": [1.0, 0.0], "cubic": [0.0, 1.0]}], "contact": PLATE["contact"]},
            "acts at contact points",
        ),
    ],
)
def test_what_cannot_be_is_refused(
    changes: dict[str, Any], words: str, study_file: StudyFile, command: Command
) -> None:
    path = study_file(base={**CANTILEVER, **changes})
    command("run", path).assert_one_line(2, words)
