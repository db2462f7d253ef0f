"""The folder `.response-N` that a response is made in, beside older results.

Each level that is complete is in there, so that a response that is interrupted can go on.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from fenics_nnm.errors import OutputError, StudyError
from fenics_nnm.response.levels import Response
from fenics_nnm.results import owner, response_file
from fenics_nnm.results.durable import remove_any
from fenics_nnm.results.header import BranchHeader
from fenics_nnm.results.own_files import RESPONSE, assert_own
from fenics_nnm.results.owner import OwnerState
from fenics_nnm.results.response_file import NAME, StoredResponse

logger = logging.getLogger(__name__)

_PREFIX = ".response-"

#: What a response moves to its folder at the end, besides its tables and pictures.
_MOVED = (NAME, "fields")


@dataclass(frozen=True, slots=True)
class Workplace:
    """A folder that belongs to this process until it is given up.

    Attributes:
        results: Folder of the results.
        path: The folder, in there.
        descriptor: Of the file that says who the owner is; of use on the rank that claimed.
    """

    results: Path
    path: Path
    descriptor: int

    @property
    def file(self) -> Path:
        """The response.h5 that is made."""
        return self.path / NAME

    def publish(self) -> None:
        """Move what was made to its folder, in place of older files, and give the folder up.

        Raises:
            OSError: if it cannot be moved.
        """
        for name in _MOVED:
            remove_any(self.results / name)
            if (self.path / name).exists():
                (self.path / name).replace(self.results / name)
        self.give_up()
        remove_any(self.path)

    def leave(self) -> str:
        """Give the folder up, and say where levels are that are complete; nothing without."""
        self.give_up()
        levels = _levels_in(self.path)
        if levels:
            return f"{_counted(levels)} in {self.path}; --resume goes on from there"
        remove_any(self.path)
        with suppress(OSError):  # older results may be in it
            self.results.rmdir()
        return ""

    def give_up(self) -> None:
        """Give the folder up; what is in it stays."""
        owner.give_up(self.descriptor, self.path)


def claim(folder: Path) -> Workplace:
    """Make a new folder inside the results folder.

    Raises:
        StudyError: if it cannot be written to, another response is going on there, or a run has
            its results there.
    """
    _assert_free(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        number = 1 + max(
            (int(each.name[len(_PREFIX) :]) for each in interrupted(folder)), default=0
        )
        path = folder / f"{_PREFIX}{number}"
        path.mkdir()
        return Workplace(folder, path, owner.take(path))
    except (OSError, ValueError) as error:  # a null character is a ValueError
        reason = getattr(error, "strerror", None) or error
        raise StudyError(f"output folder {folder}: cannot be written: {reason}") from error


def interrupted(folder: Path) -> list[Path]:
    """Folders of responses in a results folder, in the order of their numbers."""
    found = [each for each in folder.glob(f"{_PREFIX}*") if each.name[len(_PREFIX) :].isdecimal()]
    return sorted(found, key=lambda each: int(each.name[len(_PREFIX) :]))


def stored(folder: Path, but: Path | None = None) -> list[tuple[Path, StoredResponse]]:
    """Responses that one can go on from: interrupted ones, most levels first, then the finished.

    Args:
        folder: Folder of the results.
        but: Folder of the response that asks.
    """
    paths = [each / NAME for each in interrupted(folder) if each != but]
    found = [(path, each) for path in paths if (each := _read(path))]
    found.sort(key=lambda pair: -len(pair[1].found.levels))
    finished = folder / NAME
    if finished.exists():
        found.append((finished, response_file.read(finished)))
    return [pair for pair in found if pair[1].found.levels]


def remove_interrupted(folder: Path, found: Response, same: Callable[[BranchHeader], bool]) -> None:
    """Remove what interrupted responses left, where all their levels are in a new one.

    Args:
        folder: Folder of the results.
        found: The new response.
        same: Whether a header is that of the same study.
    """
    for path in interrupted(folder):
        if owner.state_of(path) is not OwnerState.GONE:
            continue
        stored = _read(path / NAME)
        if not _levels_in(path) or (stored and same(stored.header) and _has(found, stored.found)):
            remove_any(path)


def _has(found: Response, other: Response) -> bool:
    return set(other.levels) <= set(found.levels)


def report(folder: Path, but: Path) -> None:
    """Say where levels of interrupted responses are."""
    for path in interrupted(folder):
        if path != but and (levels := _levels_in(path)):
            logger.warning(
                "%s: of a response that was interrupted: %s in there; left as it is; --resume "
                "goes on",
                path,
                _counted(levels),
            )


def _assert_free(folder: Path) -> None:
    for path in interrupted(folder):
        if owner.state_of(path) is not OwnerState.GONE:
            who = str(owner.owner(path) or "a process")
            raise StudyError(
                f"{path}: is of a response that may be going on ({who}): let it end, or remove the "
                "folder"
            )
    assert_own(folder, RESPONSE)
    if (folder / "fields").exists() and not (folder / NAME).exists():
        raise StudyError(
            f"output folder {folder}: has fields that no response has written: must be another "
            "folder, or these be moved away"
        )


def _counted(levels: int) -> str:
    return "1 level is" if levels == 1 else f"{levels} levels are"


def _levels_in(path: Path) -> int:
    """Number of levels that are complete, beside the file or in it."""
    beside = response_file.levels_beside(path / NAME)
    if beside.exists():
        return len(list(beside.glob("[0-9]*.npz")))
    found = _read(path / NAME)
    return len(found.found.levels) if found else 0


def _read(path: Path) -> StoredResponse | None:
    """A response; none if it was not begun or is damaged, which is reported."""
    if not path.exists():
        return None
    try:
        return response_file.read(path)
    except OutputError as error:
        logger.warning("%s", error)
        return None
