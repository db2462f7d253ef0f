"""Runs that are killed, at any moment: every point that was reported is there, every file opens."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from conftest import Ended, contents
from killed_runs import (
    NOTING,
    branch_in,
    noted_points,
    numbers,
    run_noting,
    wait_for,
    wait_for_owners,
)

from fenics_nnm.results import branch_file, owner
from fenics_nnm.results.owner import OwnerState
from fenics_nnm.results.staging import move_results, running_folders, stopped_runs

StudyFile = Callable[..., Path]
Command = Callable[..., Ended]

RESULTS = {"backbone.csv", "backbone.png", "branch.h5", "fields", "summary.json"}

#: Goes through the storage of a run, killed at the step given; 0 counts the steps.
STEPS = """
import os, signal, sys
from pathlib import Path
import numpy as np
from fenics_nnm.backbone.follow import Branch
from fenics_nnm.fem.blocks import Data
from fenics_nnm.results import branch_file, journal, staging, stored_point
from fenics_nnm.mechanics.model import ReducedModel

WATCHED = ("open", "os.", "shutil.")
armed, steps, last = False, 0, 0

def watch(event, arguments):
    global steps
    if armed and event.startswith(WATCHED):
        steps += 1
        if steps == last:
            os.kill(os.getpid(), signal.SIGKILL)

def point(ratio, value):
    scalars = {name: value for name in stored_point.SCALARS}
    scalars.update(position=ratio, gamma_ratio=ratio, iterations=1, reason="")
    scalars.update(status="converged", resonance="", skipped="", event="", stability="")
    scalars.update(asked="", damped=False)
    arrays = {name: np.full((3, 2), value) for name in stored_point.ARRAYS}
    arrays.update(stored_point.ADDED_ARRAYS)
    return stored_point.point_from(scalars, arrays)

def whole_run(folder):
    own = staging.claim(folder)
    model = ReducedModel(np.ones(2), np.ones((2, 2)), np.eye(2), np.ones(2))
    header = branch_file.BranchHeader("", {}, 1, 2, 4, 1, "time-reversible", model)
    points = [point(1.0 + n / 10, float(n)) for n in range(3)]
    branch_file.create(own.branch, header, Data({"mesh/points": np.zeros((5, 3))}))
    written = journal.opened(lambda: own.branch)
    for number, each in enumerate(points):
        branch_file.append(written, each)
        os.write(noted, b"x")
    branch_file.finish(own.branch, Branch(tuple(points), (), "reached"))
    for name in ("backbone.csv", "summary.json"):
        (own.path / name).write_text("new")
    (own.path / "fields").mkdir()
    staging.move_results(own.path, folder)
    own.release()

sys.addaudithook(watch)
root, last = Path(sys.argv[1]), 0
while True:
    folder, child = root / f"{last:03d}", None
    folder.mkdir()
    if sys.argv[2] == "older":
        for name in ("backbone.csv", "summary.json", "branch.h5"):
            (folder / name).write_text("old")
    noted = os.open(root / f"{last:03d}.noted", os.O_CREAT | os.O_WRONLY)
    child = os.fork()
    if child == 0:
        armed = True
        whole_run(folder)
        if last == 0:
            (root / "steps").write_text(str(steps))
        os._exit(0)
    _, status = os.waitpid(child, 0)
    total = int((root / "steps").read_text())
    assert (status == 0) == (last in (0, total + 1)), (last, total, status)
    last += 1
    if last > total:
        break
"""


@pytest.fixture(scope="module", params=["older", "empty"])
def killed_at_every_step(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> tuple[Path, bool]:
    """Folders of runs of three points, each killed at another step of their storage."""
    root = tmp_path_factory.mktemp("steps")
    command = [sys.executable, "-c", STEPS, root, request.param]
    subprocess.run(command, check=True, timeout=120)
    return root, request.param == "older"


def test_killed_at_every_step(killed_at_every_step: tuple[Path, bool]) -> None:
    """Before and after a later start tidies up; older results stay, all or none of them."""
    root, had_older = killed_at_every_step
    total = int((root / "steps").read_text())
    assert total > 50
    ends = []
    for step in range(1, total + 1):
        folder = root / f"{step:03d}"
        count = len((root / f"{step:03d}.noted").read_bytes())
        mended = _assert_consistent(folder, count, had_older=had_older)
        ends.append((count, mended))
    # killed late enough the new results are there, before that the older ones
    assert ends == sorted(ends)
    assert {mended for _, mended in ends} == {False, True}


def _assert_consistent(folder: Path, count: int, *, had_older: bool) -> bool:
    """Look at a folder after a kill; whether it has the new results."""
    stopped = stopped_runs(folder)
    names = {path.name for path in folder.iterdir() if not path.name.startswith(".")}
    published = "branch.h5" in names and (folder / "branch.h5").read_bytes() != b"old"
    if published:
        assert names == {"branch.h5", "backbone.csv", "summary.json", "fields"}
        assert {(folder / name).read_text() for name in ("backbone.csv", "summary.json")} == {"new"}
        assert stopped == () and not [p for p in running_folders(folder) if any(p.iterdir())]
        assert len(branch_file.read(folder / "branch.h5")[1]) == count == 3
        return True
    assert names == ({"branch.h5", "backbone.csv", "summary.json"} if had_older else set())
    assert {(folder / name).read_text() for name in names} <= {"old"}
    found = sum(run.points for run in stopped)
    assert found in (count, count + 1) and found <= 3
    for run in stopped:
        assert run.gone and run.points
        _, points = branch_file.read(run.path / "branch.h5")
        values = [(p.gamma_ratio, p.motion.energy, p.motion.q.tolist()) for p in points]
        assert values == [(1.0 + n / 10, float(n), [[n, n]] * 3) for n in range(found)]
    return False


@pytest.fixture
def killed(study_file: StudyFile, tmp_path: Path) -> Path:
    """Results folder of a run that was killed after its fifth point."""
    study = study_file(continuation={"energies": {"to": 1.1, "step": 0.02}, "report_at": []})
    process = run_noting(tmp_path, study)
    wait_for(lambda: len(noted_points(tmp_path)) >= 5, process)
    process.kill()
    process.wait()
    assert process.returncode == -signal.SIGKILL
    return tmp_path / "out"


def test_next_run_tells_of_a_killed_one(
    killed: Path, study_file: StudyFile, command: Command, caplog: Any
) -> None:
    (path,) = running_folders(killed)
    before, count = contents(path), len(branch_file.read(path / "branch.h5")[1])
    for _ in range(2):
        caplog.clear()
        assert command("run", study_file(), "--output", "out").code == 0
        (line,) = caplog.messages
        assert line.startswith(f"out/.running-1: has {count} points of a run that was")
        assert contents(path) == before
        assert {found.name for found in killed.iterdir()} == {*RESULTS, ".running-1"}


def test_torn_points_are_left_out(
    killed: Path, study_file: StudyFile, command: Command, caplog: Any
) -> None:
    (path,) = running_folders(killed)
    whole = [numbers(point) for point in branch_file.read(path / "branch.h5")[1]]
    entries = sorted((path / "branch.points").glob("*.npz"))
    data = entries[2].read_bytes()
    flipped = bytearray(data)
    flipped[200] ^= 255
    for torn in (data[:-1], data[: len(data) // 2], data[:3], b"", b"nothing", bytes(flipped)):
        entries[2].write_bytes(torn)
        (path / "branch.points" / "000099.npz.part").write_bytes(torn)
        (run,) = stopped_runs(killed)
        assert run.points == len(whole) - 1
        points = branch_file.read(path / "branch.h5")[1]
        assert [numbers(point) for point in points] == [*whole[:2], *whole[3:]]
    caplog.clear()
    assert command("run", study_file(), "--output", "out").code == 0
    torn_line, found_line = caplog.messages
    assert "branch.points: 000002.npz cannot be read: left out" in torn_line
    assert f"has {len(whole) - 1} points" in found_line


def test_unreadable_file_of_a_killed_run_is_not_removed(
    killed: Path, study_file: StudyFile, command: Command, caplog: Any
) -> None:
    (path,) = running_folders(killed)
    (path / "branch.h5").write_bytes(b"torn")
    before = contents(path)
    assert command("run", study_file(), "--output", "out").code == 0
    assert caplog.messages[0].startswith("out/.running-1: has a file that cannot be read")
    assert contents(path) == before


def test_killed_before_its_first_point_leaves_nothing_for_long(
    study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    """The folder of a process that is gone, with nothing but its name."""
    path = tmp_path / "out" / ".running-1"
    path.mkdir(parents=True)
    os.close(owner.take(path))
    known = json.loads((path / owner.NAME).read_text())
    assert owner.state_of(path) is OwnerState.LIVING  # this very process
    (path / owner.NAME).write_text(json.dumps({**known, "started": known["started"] - 1}))
    assert owner.state_of(path) is OwnerState.GONE  # another one had its number before
    ended = command("run", study_file(), "--output", "out")
    assert (ended.code, ended.err) == (0, "")
    assert {found.name for found in path.parent.iterdir()} == RESULTS


@pytest.mark.parametrize("begun", [True, False])
def test_killed_before_it_said_whose_its_folder_is(
    begun: bool, study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    path = tmp_path / "out" / ".running-1"
    path.mkdir(parents=True)
    if begun:
        (path / "owner.json.part").touch()
    ended = command("run", study_file(), "--output", "out")
    assert (ended.code, ended.err) == (0, "")
    assert {found.name for found in path.parent.iterdir()} == RESULTS


@pytest.fixture
def owned(tmp_path: Path) -> Iterator[tuple[Path, dict[str, Any]]]:
    """A folder that this process has a lock on, and what it says about its owner."""
    descriptor = owner.take(tmp_path)
    yield tmp_path, json.loads((tmp_path / owner.NAME).read_text())
    os.close(descriptor)


def test_owner_with_a_lock_lives(owned: tuple[Path, dict[str, Any]]) -> None:
    folder, known = owned
    assert known["process"] == os.getpid()
    for change in ({"process": 2**22 + 1}, {"boot": "other", "host": "other"}, {"host": 1}):
        with (folder / owner.NAME).open("r+") as file:  # the same file: the lock stays
            file.truncate()
            json.dump({**known, **change}, file)
        assert owner.state_of(folder) is OwnerState.LIVING
        assert owner.retake(folder) is None


@pytest.mark.parametrize(
    ("change", "with_locks", "without"),
    [
        ({}, OwnerState.LIVING, OwnerState.LIVING),
        ({"process": 2**22 + 1}, OwnerState.GONE, OwnerState.GONE),
        ({"boot": "earlier"}, OwnerState.GONE, OwnerState.GONE),
        ({"namespace": "pid:[1]"}, OwnerState.GONE, OwnerState.ELSEWHERE),
        ({"boot": "other", "host": "other"}, OwnerState.ELSEWHERE, OwnerState.ELSEWHERE),
    ],
)
def test_owner_without_a_lock(
    change: dict[str, Any],
    with_locks: OwnerState,
    without: OwnerState,
    tmp_path: Path,
    monkeypatch: Any,
) -> None:
    os.close(owner.take(tmp_path))
    known = json.loads((tmp_path / owner.NAME).read_text())
    (tmp_path / owner.NAME).write_text(json.dumps({**known, **change}))
    assert owner.state_of(tmp_path) is with_locks
    monkeypatch.setattr(owner, "_lock", lambda descriptor, kind: None)
    assert owner.state_of(tmp_path) is without


def test_two_runs_at_once_have_folders_of_their_own(
    study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    study = study_file(continuation={"energies": {"to": 1.1, "step": 0.01}, "report_at": []})
    process = run_noting(tmp_path, study)
    try:
        wait_for(lambda: len(noted_points(tmp_path)) >= 2, process)
        process.send_signal(signal.SIGSTOP)
        first = contents(tmp_path / "out" / ".running-1")
        ended = command("run", study_file(), "--output", "out")
        assert (ended.code, ended.err) == (0, "")
        assert contents(tmp_path / "out" / ".running-1") == first
        process.send_signal(signal.SIGCONT)
        assert process.wait(timeout=60) == 0
    finally:
        process.kill()
        process.wait()
    assert {path.name for path in (tmp_path / "out").iterdir()} == RESULTS
    assert len(branch_file.read(tmp_path / "out" / "branch.h5")[1]) == 31


def test_results_are_moved_by_one_run_at_a_time(tmp_path: Path) -> None:
    mine = tmp_path / ".running-1"
    mine.mkdir()
    (mine / "summary.json").write_text("mine")
    moving = threading.Thread(target=move_results, args=(mine, tmp_path))
    with owner.alone_in(tmp_path):
        moving.start()
        moving.join(0.2)
        assert moving.is_alive() and not (tmp_path / "summary.json").exists()
    moving.join(10)
    assert (tmp_path / "summary.json").read_text() == "mine" and not mine.exists()


def test_run_on_another_machine_is_told_and_left_alone(
    killed: Path, study_file: StudyFile, command: Command, caplog: Any
) -> None:
    (path,) = running_folders(killed)
    known = json.loads((path / owner.NAME).read_text())
    (path / owner.NAME).write_text(json.dumps({**known, "boot": "other", "host": "other"}))
    before = contents(path)
    caplog.clear()
    assert command("run", study_file(), "--output", "out").code == 0
    (line,) = caplog.messages
    assert "on another machine, perhaps going on" in line
    assert contents(path) == before


def test_full_disk_at_the_very_beginning(
    study_file: StudyFile, command: Command, monkeypatch: Any, tmp_path: Path
) -> None:
    def fail(descriptor: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", fail)
    ended = command("run", study_file(), "--output", "deep/out")
    ended.assert_one_line(2, "output folder deep/out: cannot be written: No space left")
    assert not (tmp_path / "deep").exists()


@pytest.mark.parametrize("killed_rank", [False, True])
def test_interrupted_ranks(
    killed_rank: bool, study_file: StudyFile, command: Command, tmp_path: Path, caplog: Any
) -> None:
    """Ctrl-C at mpirun, or rank 0 killed: what is left is found like that of one process."""
    study = study_file(continuation={"energies": {"to": 1.4, "step": 1e-3}, "report_at": []})
    script = tmp_path / "noting.py"
    script.write_text(NOTING)
    ranks = ["mpirun", "-n", "2", "--oversubscribe", sys.executable, script]
    process = subprocess.Popen(
        [*ranks, "run", study, "--output", "out"],
        cwd=tmp_path,
        env={**os.environ, "OMP_NUM_THREADS": "1"},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        wait_for(lambda: len(noted_points(tmp_path)) >= 5, process)
        rank = owner.owner(tmp_path / "out" / ".running-1")
        assert rank is not None and rank.process != process.pid
        os.kill(
            rank.process if killed_rank else process.pid,
            signal.SIGKILL if killed_rank else signal.SIGINT,
        )
        assert process.wait(timeout=60) != 0
    finally:
        process.terminate()
        process.wait()
    wait_for_owners(tmp_path / "out")  # mpirun may end before its ranks do
    noted = noted_points(tmp_path)
    _, points = branch_file.read(branch_in(tmp_path / "out"))
    found = {point.gamma_ratio: numbers(point) for point in points}
    assert {values[0]: found.get(values[0]) for values in noted} == {v[0]: v for v in noted}
    assert 5 <= len(found) < 600
    told = running_folders(tmp_path / "out")
    assert told or not killed_rank
    caplog.clear()
    assert command("run", study_file(), "--output", "out").code == 0
    assert [f"has {len(found)} points" in line for line in caplog.messages] == [True] * len(told)


def test_cost_of_a_point_does_not_grow_with_the_mesh(
    study_file: StudyFile, command: Command, monkeypatch: Any
) -> None:
    """Bytes handed to the system while points are stored, on two meshes."""
    original, spent = branch_file.append, []

    def append(points: Any, point: Any) -> None:
        before = _written()
        original(points, point)
        spent.append(_written() - before)

    monkeypatch.setattr(branch_file, "append", append)
    sizes = {}
    for elements in (4, 2000):
        spent.clear()
        mesh = {"elements": elements}
        study = study_file(mesh=mesh, continuation={"energies": {"to": 1.0}, "report_at": []})
        assert command("run", study, "--output", f"{elements}").code == 0
        sizes[elements] = (len(spent), max(spent), Path(f"{elements}/branch.h5").stat().st_size)
    (count, small, file), (count_fine, large, file_fine) = sizes.values()
    assert count == count_fine == 3
    assert file_fine > file + 50_000
    assert 500 < small < 4000 and abs(large - small) < 100


def _written() -> int:
    """Bytes that this process has written so far."""
    lines = Path("/proc/self/io").read_text().splitlines()
    return int(dict(line.split(": ") for line in lines)["wchar"])
