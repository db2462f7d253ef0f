"""Sizes of files in words."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path


def size_words(size: int) -> str:
    """Bytes in a unit that suits them."""
    for factor, unit in ((1e9, "GB"), (1e6, "MB")):
        if size >= factor:
            return f"{size / factor:.3g} {unit}"
    return f"{size / 1e3:.3g} kB"


def size_of_folder(folder: Path) -> int:
    """Bytes of all files in a folder and the folders in it."""
    return _sum(folder.rglob("*"))


def size_of_files(folder: Path) -> int:
    """Bytes of the files in a folder, without the folders in it."""
    return _sum(folder.glob("*"))


def _sum(paths: Iterable[Path]) -> int:
    total = 0
    for path in paths:
        with suppress(OSError):  # one of another run, which is gone now
            total += path.lstat().st_size if path.is_file() else 0
    return total
