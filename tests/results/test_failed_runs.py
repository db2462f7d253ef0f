"""Runs that fail on the way: one line, exit code 1, older results untouched, points kept."""

from __future__ import annotations

import csv
import os
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from conftest import Ended, contents
from killed_runs import failing_after

import fenics_nnm.running.publishing
from fenics_nnm.fields.linear import write_linear_modes
from fenics_nnm.results import branch_file, journal

StudyFile = Callable[..., Path]
Command = Callable[..., Ended]

RESULTS = {"backbone.csv", "backbone.png", "branch.h5", "fields", "summary.json"}


@contextmanager
def largest_file(size: int) -> Iterator[None]:
    """No file can grow beyond a size, as on a disk that fills up."""
    _, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (hard, hard))


def failing_at(monkeypatch: Any, name: str, error: BaseException) -> None:
    """Make a function of a run raise."""

    def fail(*arguments: Any, **keywords: Any) -> Any:
        raise error

    monkeypatch.setattr(f"fenics_nnm.{name}", fail)


def assert_points(folder: Path, count: int) -> None:
    """branch.h5 opens, and it and backbone.csv hold so many points."""
    _, points = branch_file.read(folder / "branch.h5")
    rows = list(csv.DictReader((folder / "backbone.csv").read_text().splitlines()))
    assert len(points) == len(rows) == count
    ratios = [float(row["gamma_ratio"]) for row in rows]
    assert ratios == pytest.approx([point.gamma_ratio for point in points])


@pytest.fixture
def finished(study_file: StudyFile, command: Command, tmp_path: Path) -> Path:
    """A folder of results of a run that went well."""
    assert command("run", study_file(), "--output", "out").code == 0
    assert {path.name for path in (tmp_path / "out").iterdir()} == RESULTS
    return tmp_path / "out"


def test_new_run_replaces_older_results(
    finished: Path, study_file: StudyFile, command: Command
) -> None:
    before = contents(finished)
    (finished / "notes.txt").write_text("mine")
    study = study_file(continuation={"energies": {"to": 1.0}, "report_at": [1.0]})
    assert command("run", study, "--output", "out").code == 0
    after = contents(finished)
    assert after.pop("notes.txt") == b"mine"
    assert after["backbone.csv"] != before["backbone.csv"]
    assert "fields/motion_1.pvd" in after and "fields/motion_1.1.pvd" not in after
    assert {path.name for path in finished.iterdir()} == {*RESULTS, "notes.txt"}


@pytest.mark.parametrize("place", ["plain", "plain/deeper/still", "x" * 300])
def test_output_under_a_plain_file(
    place: str, study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    (tmp_path / "plain").write_text("a file")
    study = study_file(output={"folder": place})
    begins = f"output folder {place[:40]}"  # long words are shortened
    command("run", study).assert_one_line(2, begins, "cannot be written: ")
    assert (tmp_path / "plain").read_text() == "a file"


@pytest.mark.parametrize(
    "changes", [{"contact": {"facets": "nothing"}}, {"material": {"young": -1.0}}]
)
def test_bad_input_leaves_older_results(
    changes: dict[str, Any], finished: Path, study_file: StudyFile, command: Command
) -> None:
    before = contents(finished)
    assert command("run", study_file(**changes), "--output", "out").code == 2
    assert contents(finished) == before


def test_disk_full(study_file: StudyFile, command: Command, tmp_path: Path) -> None:
    """The larger the disk, the more points are kept; nothing at all is left where it is small."""
    study, found = study_file(), []
    for size in (1000, 8000, 15_000, 30_000, 65_000, 70_000):
        with largest_file(size):
            ended = command("run", study, "--output", f"{size}/deep")
        ended.assert_one_line(1, "cannot be written: File too large")
        folder = tmp_path / f"{size}/deep"
        found.append(_kept(folder, ended))
        assert (tmp_path / f"{size}").exists() == (found[-1] > 0)
    assert found == [0, 0, 0, 4, 4, 4]


def _kept(folder: Path, ended: Ended) -> int:
    """Number of points that a failed run left, after a look at the files and at what it said."""
    if not folder.exists():
        return 0
    running = folder / ".running-1"
    place = running if running.exists() else folder
    count = len(branch_file.read(place / "branch.h5")[1])
    where = place.relative_to(Path.cwd())
    assert not count or f"{count} points are in {where}" in ended.err
    names = {path.name for path in place.iterdir()}
    if "branch.points" in names:  # there was no room to put them together
        assert place == running
        return count
    assert names == {"branch.h5", "backbone.csv"}
    assert_points(place, count)
    return count


@pytest.mark.parametrize("size", [1000, 30_000, 70_000])
def test_disk_full_leaves_older_results(
    size: int, finished: Path, study_file: StudyFile, command: Command
) -> None:
    before = contents(finished)
    study = study_file()
    with largest_file(size):
        ended = command("run", study, "--output", "out")
    ended.assert_one_line(1, "cannot be written: File too large")
    after = contents(finished)
    assert {name: after.pop(name) for name in before} == before
    assert bool(after) == (size > 1000)
    assert not after or _kept(finished, ended) == 4


def test_disk_full_between_two_points(
    study_file: StudyFile, command: Command, monkeypatch: Any, tmp_path: Path
) -> None:
    """A point that does not fit leaves nothing of it, and the others as they were."""
    original = journal.packed

    def packed(point: Any) -> bytes:
        return original(point) + bytes(200_000 if point.gamma_ratio > 0.95 else 0)

    monkeypatch.setattr(journal, "packed", packed)
    with largest_file(100_000):
        ended = command("run", study_file(), "--output", "out")
    ended.assert_one_line(
        1, "branch.points: cannot be written: File too large", "2 points are in out"
    )
    assert_points(tmp_path / "out", 2)
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"branch.h5", "backbone.csv"}


def test_disk_full_at_the_end(
    study_file: StudyFile, command: Command, monkeypatch: Any, tmp_path: Path
) -> None:
    error = OSError(28, "No space left on device", "modes.pvd")
    failing_at(monkeypatch, "running.publishing.write_linear_modes", error)
    ended = command("run", study_file(), "--output", "out")
    ended.assert_one_line(1, "modes.pvd: cannot be written: No space left", "4 points are in out")
    assert _kept(tmp_path / "out", ended) == 4


@pytest.mark.parametrize("size", [100, 1000])
def test_paraview_file_cut_short_is_noticed(size: int, tmp_path: Path, plate_analysis: Any) -> None:
    with largest_file(size), pytest.raises(OSError):
        write_linear_modes(tmp_path / "modes.vtu", plate_analysis)


@pytest.mark.parametrize("points", [0, 1, 3])
def test_interrupted(
    points: int, study_file: StudyFile, command: Command, monkeypatch: Any, tmp_path: Path
) -> None:
    failing_after(monkeypatch, points, KeyboardInterrupt())
    ended = command("run", study_file(), "--output", "out")
    ended.assert_one_line(1, "interrupted", f"{points} points are in out" if points else "")
    if points:
        assert_points(tmp_path / "out", points)
    else:
        assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_interrupt_signal(number: int, study_file: StudyFile, tmp_path: Path) -> None:
    """A real Ctrl-C, or the end of a batch job, in the middle of a real process."""
    study = study_file(continuation={"energies": {"step": 1e-3}, "report_at": []})
    # a job in the background is started with the interrupt ignored
    program = ["env", "--default-signal=INT", sys.executable, "-m", "fenics_nnm"]
    process = subprocess.Popen(
        [*program, "run", str(study), "--output", str(tmp_path / "out")],
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        while process.poll() is None and _stored(tmp_path / "out") < 20:
            time.sleep(0.02)
        process.send_signal(number)
        _, err = process.communicate(timeout=60)
    finally:
        process.kill()
    Ended(process.returncode, "", err).assert_one_line(1, "interrupted", "points are in")
    _, kept = branch_file.read(tmp_path / "out" / "branch.h5")
    assert 20 <= len(kept) < 300
    assert_points(tmp_path / "out", len(kept))


def _stored(folder: Path) -> int:
    return len(list(folder.glob(".running-1/branch.points/*.npz")))


def test_interrupt_while_results_are_moved(
    study_file: StudyFile, command: Command, monkeypatch: Any, tmp_path: Path
) -> None:
    move_results = fenics_nnm.running.publishing.move_results

    def interrupted(*folders: Path) -> None:
        os.kill(os.getpid(), signal.SIGINT)
        move_results(*folders)

    monkeypatch.setattr(fenics_nnm.running.publishing, "move_results", interrupted)
    ended = command("run", study_file(), "--output", "out")
    ended.assert_one_line(1, "interrupted; the results are in out")
    assert {path.name for path in (tmp_path / "out").iterdir()} == RESULTS


@pytest.mark.parametrize(
    ("name", "kept"),
    [
        ("resolution.auto.linear_analysis", 0),
        ("structure.mesh_structure.gathered_basis", 0),
        ("running.publishing.write_linear_modes", 4),
    ],
)
def test_defect(
    name: str,
    kept: int,
    finished: Path,
    study_file: StudyFile,
    command: Command,
    monkeypatch: Any,
    tmp_path: Path,
) -> None:
    before = contents(finished)
    failing_at(monkeypatch, name, ZeroDivisionError("one\nover nothing"))
    words = ["defect of fenics-nnm", "ZeroDivisionError: one over nothing", "--verbose"]
    command("run", study_file(), "--output", "out").assert_one_line(1, *words)
    after = contents(finished)
    assert {name: after[name] for name in before} == before
    ended = command("run", study_file(), "--output", "new", "--verbose")
    assert ended.code == 1 and "Traceback" in ended.err
    if kept:
        assert_points(tmp_path / "new", kept)
    else:
        assert not (tmp_path / "new").exists()


def test_out_of_memory(study_file: StudyFile, command: Command, monkeypatch: Any) -> None:
    failing_at(monkeypatch, "resolution.auto.linear_analysis", MemoryError())
    command("run", study_file()).assert_one_line(1, "out of memory", "coarser mesh")


def test_results_that_cannot_be_moved(
    finished: Path, study_file: StudyFile, command: Command, monkeypatch: Any
) -> None:
    """The third move fails; what was moved before goes back."""
    before, original, calls = contents(finished), Path.replace, 0

    def replace(self: Path, target: Path) -> Path:
        nonlocal calls
        calls += self.suffix != ".part"
        if calls == 3:
            raise PermissionError(13, "Permission denied", str(target))
        return original(self, target)

    monkeypatch.setattr(Path, "replace", replace)
    ended = command("run", study_file(), "--output", "out")
    ended.assert_one_line(1, "Permission denied", "4 points are in out/.running-1")
    after = contents(finished)
    assert {name: after[name] for name in before} == before


def test_branch_that_does_not_converge(
    study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    """An incomplete branch is a result: all files are there, and the reason is on stderr."""
    study = study_file(
        reduction={"method": "craig-bampton", "modes": 2},
        augmented_lagrangian={"iterations": 1},
        continuation={"energies": {"to": 1.4, "step": 0.2}, "report_at": []},
    )
    ended = command("run", study, "--output", "out")
    assert ended.code == 1
    assert "fenics-nnm: incomplete: no point at gamma ratio 1.2" in ended.err
    assert "the multiplier loop stalled after 1 steps" in ended.err
    assert {path.name for path in (tmp_path / "out").iterdir()} == RESULTS
    _, points = branch_file.read(tmp_path / "out" / "branch.h5")
    assert_points(tmp_path / "out", len(points))
