"""The folder `.running-N` that a run makes its results in, beside older ones.

Moved to their place at the end, in two steps that a later start can tell apart when a run was
killed within them: first older results go to `older`, then, once this is called `replaced`, the new
ones take their place.
"""

from __future__ import annotations

import logging
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.errors import OutputError, StudyError
from fenics_nnm.results import branch_file, journal, owner
from fenics_nnm.results.durable import remove_any, sync_folder
from fenics_nnm.results.owner import OwnerState
from fenics_nnm.results.tables import write_backbone

logger = logging.getLogger(__name__)

#: Files and folders of a results folder; a new run replaces these and nothing else.
RESULTS = (
    "branch.h5",
    "backbone.csv",
    "summary.json",
    "backbone.png",
    "fields",
    "pictures",
    "report.html",
)

_PREFIX, _OLDER, _REPLACED = ".running-", "older", "replaced"


@dataclass(frozen=True, slots=True)
class Staging:
    """A folder that belongs to this run until it is given up.

    It may be moved with the results folder while the run goes on.

    Attributes:
        claimed: Where the folder was made.
        made: Folders made for it, deepest first.
        descriptor: Of the file that says who the owner is; of use on the rank that claimed.
    """

    claimed: Path
    made: tuple[Path, ...]
    descriptor: int

    @property
    def path(self) -> Path:
        """Where the folder is now, on the rank that claimed."""
        return owner.place_of(self.descriptor, self.claimed)

    @property
    def results(self) -> Path:
        """Results folder that it is in."""
        return self.path.parent

    @property
    def branch(self) -> Path:
        """The branch.h5 of the run."""
        return self.path / "branch.h5"

    def release(self) -> None:
        """Give the folder up; what is in it stays."""
        owner.give_up(self.descriptor, self.path)


@dataclass(frozen=True, slots=True)
class Stopped:
    """What a run that was stopped or killed left in a folder of its own.

    Attributes:
        path: The folder.
        points: Number of points in its branch.h5, or beside it.
        gone: Whether the run is certainly over; it may go on where it was on another machine.
    """

    path: Path
    points: int
    gone: bool


def claim(folder: Path) -> Staging:
    """Make a new folder inside the results folder; this shows that it can be written to.

    Raises:
        StudyError: if the results folder cannot be written to.
    """
    try:
        made = tuple(path for path in (folder, *folder.parents) if not path.exists())
        folder.mkdir(parents=True, exist_ok=True)
        with owner.alone_in(folder):  # so that no folder of a run that lives lacks its owner
            path = _new_folder(folder)
            return Staging(path, made, _taken(path, made))
    except (OSError, ValueError) as error:  # a null character is a ValueError
        reason = getattr(error, "strerror", None) or error
        raise StudyError(f"output folder {folder}: cannot be written: {reason}") from error


def move_results(staging: Path, folder: Path) -> None:
    """Move the results to their folder in place of older ones: all of them, or none."""
    older, replaced = staging / _OLDER, staging / _REPLACED
    older.mkdir()
    moved: list[tuple[Path, Path]] = []

    def move(source: Path, target: Path) -> None:
        if source.exists():
            source.replace(target)
            moved.append((source, target))

    try:
        with owner.alone_in(folder):
            for name in RESULTS:
                move(folder / name, older / name)
            move(older, replaced)
            for name in RESULTS:
                move(staging / name, folder / name)
    except BaseException:
        for source, target in reversed(moved):
            target.replace(source)
        older.rmdir()
        raise
    sync_folder(folder)
    remove(staging)


def rescue(staging: Staging) -> str:
    """Keep the points of a run that was stopped, without touching older results; say where."""
    if not owner.owns(staging.descriptor, staging.path):
        return _where_published(staging)
    points = _points_in(staging.path)
    try:
        if points:
            return _keep(staging, points)
        if not _is_bare(staging.path):
            return f"what there is stays in {staging.path}"
        remove(staging.path)
        with suppress(OSError):  # another run may have begun in a folder made for this one
            for path in staging.made:
                path.rmdir()
    except (OSError, OutputError) as error:
        return f"what there is stays in {staging.path} ({error})"
    return ""


def stopped_runs(folder: Path) -> tuple[Stopped, ...]:
    """What stopped and killed runs left in a results folder.

    A run that was killed while its results were moved is mended. Folders of runs that are certainly
    over and have no point are removed.
    """
    found = []
    for path in running_folders(folder):
        state = owner.state_of(path)
        if state is OwnerState.LIVING:
            continue
        if state is OwnerState.GONE:
            _tidy(path, folder)
        if (path / "branch.h5").exists():
            found.append(Stopped(path, len(_points_in(path)), gone=state is OwnerState.GONE))
    return tuple(found)


def living_run(folder: Path, *, but: Path | None = None) -> tuple[Path, str] | None:
    """Folder and owner of a run in a results folder, other than that in `but`; none if none is."""
    for path in running_folders(folder):
        if path != but and owner.state_of(path) is OwnerState.LIVING:
            return path, str(owner.owner(path) or "a process")
    return None


def running_folders(folder: Path) -> list[Path]:
    """Folders of runs in a results folder, in the order of their numbers."""
    numbers = (path.name.removeprefix(_PREFIX) for path in folder.glob(f"{_PREFIX}*"))
    return [folder / f"{_PREFIX}{n}" for n in sorted(map(int, filter(str.isdecimal, numbers)))]


def remove(staging: Path) -> None:
    """Remove a folder; what says whose it is goes last."""
    for path in staging.iterdir():
        if path.name != owner.NAME:
            remove_any(path)
    (staging / owner.NAME).unlink(missing_ok=True)
    with suppress(FileNotFoundError):  # without an owner any run may remove it
        staging.rmdir()


def _where_published(staging: Staging) -> str:
    """Where the results of a run are whose own folder is gone."""
    written = staging.results / "branch.h5"
    if written.exists() and written.stat().st_mtime_ns >= owner.taken_at(staging.descriptor):
        return f"the results are in {staging.results}"
    return (
        f"{staging.path} was removed, or moved to another disk, while the run went on: what there "
        "was is where it was moved to"
    )


def _new_folder(folder: Path) -> Path:
    number = 1
    while True:
        try:
            (path := folder / f"{_PREFIX}{number}").mkdir()
            return path
        except FileExistsError:
            number += 1


def _taken(path: Path, made: tuple[Path, ...]) -> int:
    """Descriptor of the owner's file; where it cannot be written nothing is left."""
    try:
        return owner.take(path)
    except OSError:
        with suppress(OSError):
            remove_any(path)
            for folder in made:
                folder.rmdir()
        raise


def _keep(staging: Staging, points: tuple[BranchPoint, ...]) -> str:
    try:
        branch_file.gather(staging.branch)
    except OutputError:  # the disk is full; the points are where they are
        return f"{len(points)} points are in {staging.path}"
    for path in staging.path.iterdir():
        if path.name not in (owner.NAME, staging.branch.name):
            remove_any(path)
    table = staging.path / "backbone.csv"
    try:
        write_backbone(table, points)
    except OSError:  # the disk is full; the points are in branch.h5
        remove_any(table)
    folder = staging.results
    if any((folder / name).exists() for name in RESULTS):
        return f"{len(points)} points are in {staging.path}, older results are as they were"
    move_results(staging.path, folder)
    return f"{len(points)} points are in {folder}"


def _tidy(path: Path, folder: Path) -> None:
    """Bring the results of a run that was killed while they were moved to one side of that."""
    older, replaced = path / _OLDER, path / _REPLACED
    with _errors_as_warnings(path), _held(path) as held, owner.alone_in(folder) as alone:
        if not held:
            if alone and not (path / owner.NAME).exists():
                _remove_unowned(path)
            return
        if older.exists():
            _move_all(older, folder)
            shutil.rmtree(older)
        if replaced.exists() and _move_all(path, folder):
            logger.warning("%s: has all results now of a run that was killed at its end", folder)
        if _is_bare(path):
            remove_any(path)


def _remove_unowned(path: Path) -> None:
    """Remove the folder of a run that was killed before it could say whose it is."""
    with suppress(FileNotFoundError):
        if _is_bare(path):
            remove_any(path)


def _move_all(source: Path, folder: Path) -> bool:
    """Move results to a folder, unless newer ones are there; whether there were any."""
    names = [name for name in RESULTS if (source / name).exists()]
    if any((folder / name).exists() for name in names):
        return False
    for name in names:
        (source / name).replace(folder / name)
    return bool(names)


@contextmanager
def _errors_as_warnings(path: Path) -> Iterator[None]:
    """Errors of the operating system as a warning, as they are no matter of the present run."""
    try:
        yield
    except (OSError, OutputError) as error:
        logger.warning("%s: is left over from a run that was killed: %s", path, error)


@contextmanager
def _held(path: Path) -> Iterator[bool]:
    """Whether nobody else mends this folder, and there is something to mend."""
    descriptor = owner.retake(path)
    try:
        yield descriptor is not None
    finally:
        if descriptor is not None:
            os.close(descriptor)


def _points_in(staging: Path) -> tuple[BranchPoint, ...]:
    """Points on disk, none if the file was not begun or is broken."""
    try:
        return branch_file.read(staging / "branch.h5")[1]
    except Exception:  # HDF5 raises many kinds at a broken file
        return ()


def _is_bare(staging: Path) -> bool:
    """Whether a folder certainly has no points."""
    branch = staging / "branch.h5"
    if any(journal.folder_beside(branch).glob("*.npz")):
        return False
    try:
        return not branch.exists() or not branch_file.read(branch)[1]
    except Exception:  # of another version, or broken: worth a look
        return False
