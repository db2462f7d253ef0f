"""Which process a folder belongs to, and whether that process still lives.

The process keeps a lock on the file `owner.json`, which the system takes away when it ends, however
it ends. The file names host and process too, for file systems without locks.
"""

from __future__ import annotations

import errno
import fcntl
import json
import logging
import os
import socket
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass
from enum import Enum
from pathlib import Path

from fenics_nnm.results.durable import PART

logger = logging.getLogger(__name__)

NAME = "owner.json"

#: How often a lock is tried, every so many seconds, before a wait for it is reported.
_TRIES, _PAUSE = 20, 0.05

_WAITS = (
    "another process holds the lock of this folder, as while a run begins there or moves its "
    "results: waiting until it is free, without a limit"
)


class OwnerState(Enum):
    """What is known about the process that a folder belongs to."""

    LIVING = "living"
    GONE = "gone"
    #: No lock is held, but the process was on another machine, where it cannot be looked for.
    ELSEWHERE = "elsewhere"


@dataclass(frozen=True, slots=True)
class Owner:
    """A process, so that no other one is taken for it.

    Attributes:
        host: Name of its machine.
        boot: What the system calls itself since it was started.
        namespace: Set of processes in which its number counts; containers have their own.
        process: Its number.
        started: When it was started, in clock ticks of the system.
    """

    host: str
    boot: str
    namespace: str
    process: int
    started: int

    def __str__(self) -> str:
        return f"process {self.process} on {self.host}"


def take(folder: Path) -> int:
    """Make this process the owner of a folder.

    Returns:
        Descriptor of the file; the folder is given up when it is closed.

    Raises:
        OSError: if the file cannot be written.
    """
    part = folder / (NAME + PART)
    descriptor = os.open(part, os.O_CREAT | os.O_RDWR | os.O_TRUNC | os.O_CLOEXEC, 0o666)
    try:
        _lock(descriptor, fcntl.LOCK_EX)
        os.write(descriptor, json.dumps(asdict(_this_process())).encode())
        os.fsync(descriptor)
        part.rename(folder / NAME)  # nobody sees it without its lock
    except BaseException:
        os.close(descriptor)
        raise
    return descriptor


def owns(descriptor: int, folder: Path) -> bool:
    """Whether a folder is the one that `take` gave this descriptor of."""
    try:
        return os.path.samestat(os.fstat(descriptor), os.stat(folder / NAME))
    except OSError:
        return False


def place_of(descriptor: int, folder: Path) -> Path:
    """Where a folder of this process is now: it may have been moved with those that it is in.

    Args:
        descriptor: What `take` gave; on other processes any number.
        folder: Where the folder was.

    Returns:
        Where it is; where it was if it is not known.
    """
    if owns(descriptor, folder):
        return folder
    try:
        found = Path(os.readlink(f"/proc/self/fd/{descriptor}")).parent
        if not owns(descriptor, found):
            return folder
        here = Path.cwd()
    except OSError:
        return folder
    return found.relative_to(here) if found.is_relative_to(here) else found


def taken_at(descriptor: int) -> int:
    """When a folder was taken, in ns; it may be gone."""
    return os.fstat(descriptor).st_mtime_ns


def give_up(descriptor: int, folder: Path) -> None:
    """Give a folder up; what is in it stays."""
    with suppress(OSError):
        if owns(descriptor, folder):
            (folder / NAME).unlink()
    os.close(descriptor)


def retake(folder: Path) -> int | None:
    """Hold the folder of a process that is gone, so that nobody else does.

    Returns:
        Descriptor to be closed, or none if somebody else holds the folder or it has no owner.
    """
    try:
        descriptor = os.open(folder / NAME, os.O_RDWR | os.O_CLOEXEC)
    except OSError:
        return None
    if _lock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB) is False:
        os.close(descriptor)
        return None
    return descriptor


@contextmanager
def alone_in(folder: Path) -> Iterator[bool]:
    """Keep other runs from beginning, or moving results, in a folder until the context ends.

    Where another one does so, this waits for it, and says so.

    Yields:
        Whether they are kept from it: not where there are no locks.
    """
    descriptor = os.open(folder, os.O_RDONLY | os.O_CLOEXEC)
    try:
        yield _locked_in_time(descriptor, folder) is True
    finally:
        os.close(descriptor)


def owner(folder: Path) -> Owner | None:
    """The owner of a folder, none if it was given up or cannot be read."""
    try:
        return Owner(**json.loads((folder / NAME).read_bytes()))
    except (OSError, ValueError, TypeError):
        return None


def state_of(folder: Path) -> OwnerState:
    """What is known about the owner of a folder; one that was given up has none any more."""
    try:
        descriptor = os.open(folder / NAME, os.O_RDONLY | os.O_CLOEXEC)
    except FileNotFoundError:
        return OwnerState.GONE
    except OSError:
        return OwnerState.ELSEWHERE
    try:
        free = _lock(descriptor, fcntl.LOCK_SH | fcntl.LOCK_NB)
    finally:
        os.close(descriptor)
    return OwnerState.LIVING if free is False else _by_process(owner(folder), locks=free is True)


def _by_process(known: Owner | None, *, locks: bool) -> OwnerState:
    """Look for a process that holds no lock, or cannot hold one."""
    here = _this_process()
    if known is None:
        return OwnerState.ELSEWHERE
    if known.boot != here.boot:
        return OwnerState.GONE if known.host == here.host else OwnerState.ELSEWHERE
    if known.namespace == here.namespace:
        runs = _started(known.process) == known.started
        return OwnerState.LIVING if runs else OwnerState.GONE
    return OwnerState.GONE if locks else OwnerState.ELSEWHERE


def _locked_in_time(descriptor: int, folder: Path) -> bool | None:
    """As `_lock`, for this process alone; a wait of more than a moment is reported first."""
    for _ in range(_TRIES):
        got = _lock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        if got is not False:
            return got
        time.sleep(_PAUSE)
    logger.warning("%s: %s", folder, _WAITS)
    return _lock(descriptor, fcntl.LOCK_EX)


def _lock(descriptor: int, kind: int) -> bool | None:
    """Whether a lock was got; none where there are no locks."""
    try:
        fcntl.flock(descriptor, kind)
    except OSError as error:
        return False if error.errno in (errno.EWOULDBLOCK, errno.EACCES) else None
    return True


def _this_process() -> Owner:
    number = os.getpid()
    return Owner(
        host=socket.gethostname(),
        boot=Path("/proc/sys/kernel/random/boot_id").read_text().strip(),
        namespace=str(Path("/proc/self/ns/pid").readlink()),
        process=number,
        started=_started(number) or 0,
    )


def _started(process: int) -> int | None:
    """When a process was started, none if it does not run any more; proc(5)."""
    try:
        text = Path(f"/proc/{process}/stat").read_text()
    except OSError:
        return None
    values = text.rpartition(")")[2].split()
    state, started = values[0], values[19]
    return None if state in "ZX" else int(started)
