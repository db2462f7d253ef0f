"""What tells that a file has changed since it was read."""

from __future__ import annotations

from pathlib import Path


def stamp_of(path: Path) -> tuple[int, ...]:
    """Another one when a file has changed, or another one of its size and time took its place.

    Raises:
        OSError: if there is no such file.
    """
    status = path.stat()
    return status.st_ctime_ns, status.st_mtime_ns, status.st_size
