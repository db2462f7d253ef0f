"""Files that are there in full or not at all, whenever a run is killed."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

#: Added to the name of a file while it is written; nothing reads such files.
PART = ".part"


def write_whole(path: Path, data: bytes) -> None:
    """Write a file so that it survives even a power cut once this returns.

    Raises:
        OSError: if it cannot be written; nothing new is there then.
    """
    with replacing(path) as part:
        part.write_bytes(data)


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A path to write to that takes the place of `path` at the end, at one instant.

    Raises:
        OSError: if it cannot be written; an older file at `path` is as it was then.
    """
    part = path.with_name(path.name + PART)
    try:
        yield part
        _sync(part)
        part.replace(path)
    except BaseException:
        with suppress(OSError):
            part.unlink(missing_ok=True)
        raise
    sync_folder(path.parent)


def remove_any(path: Path) -> None:
    """Remove a file, if there is one, or a folder with all that it has.

    Raises:
        OSError: if it cannot be removed.
    """
    if path.is_dir():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


def sync_folder(folder: Path) -> None:
    """Bring to the disk which files a folder has, where its file system can do that."""
    with suppress(OSError):
        _sync(folder)


def _sync(path: Path) -> None:
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
