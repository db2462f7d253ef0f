"""Numbers that are found for damped motions: judged by these, which are exact in time."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from conftest import ROD, changed
from mpi4py import MPI

from fenics_nnm.backbone.damped_branch import DampedMaker, damped_branch
from fenics_nnm.backbone.damped_motions import damped_motions
from fenics_nnm.errors import StudyError
from fenics_nnm.resolution.auto import choice
from fenics_nnm.resolution.damped_auto import Tried, damped_numbers, probed_ratios
from fenics_nnm.resolution.finer import least
from fenics_nnm.structure.analysis import linear_analysis
from fenics_nnm.structure.damped_choice import damped_run
from fenics_nnm.study import Study, study_from
from fenics_nnm.study.resolution import Resolution

AUTO: dict[str, Any] = changed(
    ROD,
    {
        "mesh": {"elements": 24},
        "reduction": {"modes": "auto"},
        "mode": {"harmonics": "auto", "samples": "auto", "tolerance": 1e-2},
        "damping": {"ratio": 0.1},
        "continuation": {"energies": {"from": 1.2, "to": 1.3, "step": 0.1}, "report_at": [1.2]},
    },
)


def study(values: dict[str, Any] | None = None) -> Study:
    return study_from(changed(AUTO, values or {}), Path("study.toml"))


def maker(given: Study, modes: int) -> DampedMaker:
    at = given.with_resolution(Resolution(8, 64, modes))
    found = damped_run(at, linear_analysis(at, MPI.COMM_SELF)).maker
    assert found is not None
    return found


def test_frequency_is_as_near_to_that_of_many_modes_as_is_said() -> None:
    chosen = choice(study(), MPI.COMM_SELF)
    assert chosen.expected is not None and chosen.limits == {}
    assert 0 < chosen.expected.total == chosen.expected.modes <= 1e-2
    numbers = chosen.study.resolution
    assert numbers.modes == 15 and numbers.samples >= 8 * numbers.harmonics
    run = damped_run(chosen.study, chosen.linear)
    assert run.maker is not None and run.ratios == chosen.energies == (1.2, 1.3)
    branch = damped_branch(run.maker, run.ratios)
    assert [point.status for point in branch.points] == ["verified"] * 2
    fewer = replace(run.maker, series=type(run.maker.series)(numbers.harmonics // 2, 1024))
    assert "verified" != damped_branch(fewer, (1.3,)).points[0].status
    (known,) = damped_motions(maker(study(), 20).damped, (1.3,))
    assert branch.points[1].motion.frequency * 6.283185307 == pytest.approx(
        known.motion.omega, rel=1e-2
    )


def test_numbers_that_are_given_stay_and_bound_the_others() -> None:
    given = study({"reduction": {"modes": 4}, "mode": {"samples": 13}})
    chosen = choice(given, MPI.COMM_SELF)
    numbers = chosen.study.resolution
    assert (numbers.modes, numbers.samples, numbers.harmonics) == (4, 13, 6)
    assert chosen.limits == {"harmonics": "the largest number tried is 6"}
    assert chosen.expected is not None and chosen.expected.total == 0


def test_without_any_damped_motion_numbers_are_asked_for() -> None:
    given, lost = study(), maker(study(), 4)
    (found,) = damped_motions(lost.damped, (1.2,))
    failed = replace(found, motion=replace(found.motion, failure="lost"))
    assert failed.told == "none at gamma ratio 1.2" and "Hz at gamma ratio 1.2" in found.told
    with pytest.raises(StudyError, match=r"found with damped motions: lost: give mode\.harmonics"):
        damped_numbers(
            given, least(given), MPI.COMM_SELF, lambda modes: Tried(modes, lost, (failed,))
        )


def test_probes_are_spread() -> None:
    assert probed_ratios((1.0, 2.0)) == (1.0, 2.0)
    assert probed_ratios((1.0, 1.1, 1.2, 1.3, 1.4)) == (1.0, 1.2, 1.4)
