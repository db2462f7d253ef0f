"""Runs that are killed at random moments and resumed: the branch of a run that was not."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from pathlib import Path
from random import Random

import numpy as np
import pytest
from killed_runs import ForkedRuns, assert_all_open, branch_in, noted_points, numbers

from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.results import branch_file
from fenics_nnm.results.staging import running_folders
from fenics_nnm.results.stored_branch import read_stored_branch

StudyFile = Callable[..., Path]

#: Seconds of CPU of a run until its first point, its last one, and its end.
Times = tuple[float, float, float]


@pytest.fixture
def runs() -> Iterator[ForkedRuns]:
    with ForkedRuns() as forked:
        yield forked


def whole_run(runs: ForkedRuns, folder: Path, study: Path) -> tuple[tuple[BranchPoint, ...], Times]:
    """Points and times of a run that nobody kills."""
    folder.mkdir()
    code, seconds = runs.run(folder, "run", study, "--output", "out")
    assert code == 0
    moments = [float(line) for line in (folder / "moments").read_text().split()]
    return branch_file.read(folder / "out" / "branch.h5")[1], (moments[0], moments[-1], seconds)


def random_moments(times: Times) -> list[float]:
    """Seconds of CPU at which runs are killed: 4 before the branch, 10 in it, 6 after it."""
    chance = Random(20110)
    spans = zip((4, 10, 6), (0.0, *times), times, strict=False)
    return [
        begin + (end - begin) * (part + chance.random()) / count
        for count, begin, end in spans
        for part in range(count)
    ]


def assert_nothing_is_lost(folder: Path) -> int:
    """All that a killed run reported is there; returns how many points are."""
    assert_all_open(folder / "out")
    noted = {values[0]: values for values in noted_points(folder)}
    if not noted:
        return 0
    path = branch_in(folder / "out")
    _, points = branch_file.read(path)
    found = {point.gamma_ratio: numbers(point) for point in points}
    assert {ratio: found.get(ratio) for ratio in noted} == noted
    assert len(found) - len(noted) in (0, 1)  # one more may be stored and not noted yet
    assert read_stored_branch(path).displacement(points[-1], np.zeros(1)).shape == (1, 5, 1)
    return len(found)


def assert_same(points: tuple[BranchPoint, ...], others: tuple[BranchPoint, ...]) -> None:
    assert [point.gamma_ratio for point in points] == [point.gamma_ratio for point in others]
    for point, other in zip(points, others, strict=True):
        assert point.motion.frequency == pytest.approx(other.motion.frequency, rel=1e-9)
        assert point.motion.energy == pytest.approx(other.motion.energy, rel=1e-9)
        np.testing.assert_allclose(
            point.motion.q, other.motion.q, rtol=0, atol=1e-9 * np.abs(other.motion.q).max()
        )
        assert point.returned.after_one == pytest.approx(
            other.returned.after_one, rel=1e-6, abs=1e-9
        )
        assert (point.status, point.resonance) == (other.status, other.resonance)


def test_killed_at_random_moments_and_resumed(
    runs: ForkedRuns, study_file: StudyFile, tmp_path: Path
) -> None:
    energies = {"from": 0.8, "to": 1.8, "step": 0.05}
    study = study_file(
        reduction={"modes": 3},
        mode={"harmonics": 5, "samples": 64},
        continuation={"energies": energies, "report_at": []},
    )
    every = [whole_run(runs, tmp_path / name, study) for name in ("whole", "again")]
    whole, times = min(every, key=lambda each: each[1][-1])  # the first one may load more slowly
    counts, killed = [], 0
    for number, moment in enumerate(random_moments(times)):
        folder = tmp_path / f"{number:02d}"
        folder.mkdir()
        code, _ = runs.run(folder, "run", study, "--output", "out", moment=moment)
        assert code in (0, -signal.SIGPROF)  # the last moments may come after the end
        killed += code != 0
        counts.append(assert_nothing_is_lost(folder))
        code, _ = runs.run(folder, "run", study, "--output", "out", "--resume")
        assert code == 0
        assert running_folders(folder / "out") == []
        assert_same(branch_file.read(folder / "out" / "branch.h5")[1], whole)
    assert killed >= 17
    assert len(set(counts)) > 6, counts
    assert min(counts) == 0 and max(counts) == len(whole)
