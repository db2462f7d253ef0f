"""A claimed folder: given up at the end, points kept where it ends by an error."""

from __future__ import annotations

import os
import shutil
import threading
from pathlib import Path
from typing import Any

import pytest
from mpi4py import MPI

from fenics_nnm.errors import OutputError, StudyError
from fenics_nnm.results import owner
from fenics_nnm.results.staging import living_run, move_results
from fenics_nnm.running.claiming import claimed

COMM = MPI.COMM_SELF


def test_it_is_held_until_the_end(tmp_path: Path) -> None:
    folder = tmp_path / "out"
    with claimed(folder, COMM) as staging:
        found = living_run(folder)
        assert found is not None and found[0] == staging.path
    assert living_run(folder) is None


@pytest.mark.parametrize("error", [StudyError("no"), KeyboardInterrupt(), ZeroDivisionError()])
def test_an_error_without_points_leaves_nothing(tmp_path: Path, error: BaseException) -> None:
    with pytest.raises(type(error)) as raised, claimed(tmp_path / "new" / "out", COMM):
        raise error
    assert raised.value is error
    assert not getattr(error, "__notes__", [])
    assert list(tmp_path.iterdir()) == []


def test_other_files_are_kept_and_said_where(tmp_path: Path) -> None:
    folder = tmp_path / "out"
    with pytest.raises(StudyError) as raised, claimed(folder, COMM) as staging:
        staging.branch.write_text("not a branch")
        raise StudyError("no")
    assert raised.value.__notes__ == [f"what there is stays in {staging.path}"]
    assert staging.branch.read_text() == "not a branch"


def test_an_error_of_the_system_names_its_file(tmp_path: Path) -> None:
    full = OSError(28, "No space left on device", "table.csv")
    with pytest.raises(OutputError) as raised, claimed(tmp_path / "out", COMM):
        raise full
    assert str(raised.value) == "table.csv: cannot be written: No space left on device"
    assert raised.value.__cause__ is full


def test_an_error_of_ours_stays_as_it_is(tmp_path: Path) -> None:
    own = OutputError("branch.h5: cannot be written")
    with pytest.raises(OutputError) as raised, claimed(tmp_path / "out", COMM):
        raise own
    assert raised.value is own


def test_a_folder_that_is_renamed_is_followed(tmp_path: Path, monkeypatch: Any) -> None:
    """Also where another run has begun in a new folder of the old name."""
    monkeypatch.chdir(tmp_path)
    with pytest.raises(StudyError) as raised, claimed(Path("old"), COMM) as staging:
        staging.branch.write_text("not a branch")
        Path("old").rename("new")
        assert staging.path == Path("new/.running-1")
        with claimed(Path("old"), COMM) as other:
            assert other.path == Path("old/.running-1")
            assert staging.results == Path("new")
        raise StudyError("no")
    assert raised.value.__notes__ == ["what there is stays in new/.running-1"]
    assert living_run(Path("new")) is None


def test_a_folder_that_is_gone_is_said_to_be(tmp_path: Path) -> None:
    folder = tmp_path / "out"
    with pytest.raises(OutputError) as raised, claimed(folder, COMM) as staging:
        (folder / "branch.h5").write_text("older results")
        os.utime(folder / "branch.h5", (1e9, 1e9))
        shutil.rmtree(staging.path)
        staging.branch.write_text("lost")
    assert "No such file or directory" in str(raised.value)
    assert "was removed, or moved to another disk" in raised.value.__notes__[0]


def test_results_that_were_moved_are_said_where(tmp_path: Path) -> None:
    folder = tmp_path / "out"
    with pytest.raises(KeyboardInterrupt) as raised, claimed(folder, COMM) as staging:
        staging.branch.write_text("a branch")
        move_results(staging.path, folder)
        raise KeyboardInterrupt
    assert raised.value.__notes__ == [f"the results are in {folder}"]


@pytest.mark.parametrize("held", [True, False])
def test_a_wait_for_a_lock_is_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture, held: bool
) -> None:
    monkeypatch.setattr(owner, "_PAUSE", 0.0)
    free = threading.Event()

    def hold(inside: threading.Event) -> None:
        with owner.alone_in(tmp_path):
            inside.set()
            free.wait(30.0)

    if held:
        inside = threading.Event()
        other = threading.Thread(target=hold, args=(inside,))
        other.start()
        assert inside.wait(30.0)
        monkeypatch.setattr(owner.logger, "warning", _freeing(free, owner.logger.warning))
    with owner.alone_in(tmp_path) as alone:
        assert alone
    said = [each.getMessage() for each in caplog.records]
    assert len(said) == held
    assert all(f"{tmp_path}: another process holds the lock" in each for each in said)


def _freeing(free: threading.Event, warn: Any) -> Any:
    """A warning after which the lock is given up."""

    def warning(*arguments: object) -> None:
        warn(*arguments)
        free.set()

    return warning
