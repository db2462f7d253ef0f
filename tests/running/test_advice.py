"""What is proposed where points are not verified, and that it helps to follow it once."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import PLATE, ROD, Ended, changed
from mpi4py import MPI

from fenics_nnm.backbone.branch import Branch
from fenics_nnm.backbone.causes import Cause, cause_of
from fenics_nnm.backbone.point import BranchPoint, Verdict
from fenics_nnm.nonlinear.reduction_error import ReductionError
from fenics_nnm.resolution.auto import Choice, choice
from fenics_nnm.running.advice import advice
from fenics_nnm.study import study_from

FAR = {"energies": {"from": 1.0, "to": 1.6, "step": 0.2}, "report_at": [1.2]}


def followed(base: dict[str, Any], **changes: Any) -> tuple[Choice, Branch]:
    study = study_from(changed(base, {"continuation": FAR, **changes}), Path("study.toml"))
    chosen = choice(study, MPI.COMM_SELF)
    return chosen, chosen.prepared.followed()


def statuses(branch: Branch) -> Counter[str]:
    return Counter(point.status for point in branch.points)


def proposed(sentence: str) -> dict[str, dict[str, Any]]:
    """Keys and values of a sentence, as changes of a study."""
    found: dict[str, dict[str, Any]] = {}
    for section, key, value in re.findall(r"(\w+)\.(\w+) = (\S+)", sentence):
        number = int(value) if value.isdigit() else value.strip('"')
        found.setdefault(section, {})[key] = number
    return found


@pytest.mark.parametrize(
    ("base", "given", "before", "after"),
    [
        (ROD, {}, {"verified": 2, "converged": 2}, {"verified": 4}),
        (
            PLATE,
            {"mode": {"harmonics": 8, "samples": 128}},
            {"verified": 1, "converged": 1, "failed": 2},
            {"verified": 1, "converged": 3},
        ),
        (
            ROD,
            {"reduction": {"method": "craig-bampton"}},
            {"verified": 1, "converged": 3},
            {"verified": 2, "converged": 2},
        ),
    ],
    ids=["harmonics of a rod", "harmonics of a plate", "mass"],
)
def test_following_it_once_gives_better_statuses(
    base: dict[str, Any], given: dict[str, Any], before: dict[str, int], after: dict[str, int]
) -> None:
    chosen, branch = followed(base, **given)
    assert statuses(branch) == before
    better = changed(given, proposed(advice(chosen, branch)[0]))
    _, again = followed(base, **better)
    assert statuses(again) == after


@pytest.fixture(scope="module")
def failing() -> tuple[Choice, Branch]:
    """A branch with points that integration in time contradicts."""
    return followed(PLATE, mode={"harmonics": 8, "samples": 128})


def of_reduction(point: BranchPoint, error: float) -> BranchPoint:
    known = replace(point.expected, reduction=ReductionError(0.1, error))
    return replace(point, expected=known)


def test_failed_points_are_offered_the_damped_mode(failing: tuple[Choice, Branch]) -> None:
    *_, last = advice(*failing)
    assert "fenics-nnm response" in last
    (ratio,) = re.findall(r"ratio = ([\d.]+)", last)
    needed = [p.stability.largest_multiplier for p in failing[1].points if p.stability]
    assert float(ratio) == pytest.approx(np.log(max(needed)) / (2 * np.pi), rel=0.05)
    chosen, branch = failing
    verified = replace(branch, points=branch.points[:1])
    assert advice(chosen, verified) == ()


def test_modes_that_lack_get_a_number_by_their_error(failing: tuple[Choice, Branch]) -> None:
    chosen, branch = failing
    point = replace(branch.points[1], verdict=Verdict("converged", "reduction"))
    for error, modes in ((-0.0015, 3), (0.004, 4), (0.3, 5)):
        of = replace(branch, points=(of_reduction(point, error),))
        (sentence,) = advice(chosen, of)
        assert f"set reduction.modes = {modes}" in sentence
        assert f"{abs(error):.1%}" in sentence


def test_modes_that_are_not_there_are_not_proposed(tmp_path: Path) -> None:
    """A chain of three masses with one contact row has two modes that leave it flexibility."""
    K, M = 2e6 * np.eye(3) - 1e6 * (np.eye(3, k=1) + np.eye(3, k=-1)), np.eye(3)
    np.savez(tmp_path / "chain.npz", K=K, M=M, B=np.eye(3)[-1:])
    for modes, said in ((1, "set reduction.modes = 2"), (2, "the structure has no more than 2")):
        study = {
            "matrices": {"file": str(tmp_path / "chain.npz")},
            "contact": {"gap": 1e-3},
            "reduction": {"modes": modes},
            "mode": {"harmonics": 3, "samples": 32},
            "continuation": {"energies": {"from": 1.1, "to": 1.2, "step": 0.1}},
        }
        chosen, branch = followed(study)
        lacking = replace(branch.points[0], verdict=Verdict("converged", "reduction"))
        (sentence,) = advice(chosen, replace(branch, points=(of_reduction(lacking, 0.3),)))
        assert said in sentence


def test_what_is_auto_is_given_a_number_and_never_raised(failing: tuple[Choice, Branch]) -> None:
    chosen, branch = failing
    asked = chosen.asked.model_copy(
        update={"mode": chosen.asked.mode.model_copy(update={"harmonics": "auto"})}
    )
    text = " ".join(advice(replace(chosen, asked=asked), branch))
    assert 'mode.harmonics = 20 and mode.samples = 256 in place of "auto", which took 8' in text
    assert "raise" not in text


def test_a_resonance_is_followed_or_left_aside(failing: tuple[Choice, Branch]) -> None:
    chosen, branch = failing
    inside = Verdict("inside resonance", "mode 2 draws", resonance="mode 2 in harmonic 5")
    of = replace(branch, points=(replace(branch.points[1], verdict=inside),))
    (sentence,) = advice(chosen, of)
    assert 'mode 2 in harmonic 5): continuation.internal_resonance = "follow"' in sentence
    assert cause_of(of.points[0], massless=True) is Cause.RESONANCE
    assert cause_of(replace(of.points[0], verdict=None), massless=True) is None


def test_the_terminal_and_the_summary_say_it(
    study_file: Callable[..., Path], command: Callable[..., Ended]
) -> None:
    ended = command("run", study_file(continuation=FAR), "--output", "out")
    (line,) = (line for line in ended.out.splitlines() if line.startswith("next: "))
    assert line.endswith("set mode.harmonics = 5 and mode.samples = 64")
    assert line.removeprefix("next: ") in Path("out/summary.json").read_text()
