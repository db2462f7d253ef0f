"""Files that a study names, and whether they have changed."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from contextlib import suppress
from functools import lru_cache
from pathlib import Path

from fenics_nnm.files.stamp import stamp_of
from fenics_nnm.study.leaves import leaves
from fenics_nnm.study.study import Study


def input_files(study: Study) -> dict[str, Path]:
    """Files that a study is to be read with, by the keys that name them."""
    return {
        key: value
        for section, values in study.model_dump(exclude={"output"}).items()
        for key, value in _paths(section, values)
    }


def input_digests(study: Study) -> dict[str, str]:
    """SHA-256 of each file that a study names, in hexadecimal digits, by key.

    What such a file includes is not looked at. A file that cannot be read has no entry.
    """
    found = {}
    for key, path in input_files(study).items():
        with suppress(OSError):
            found[key] = _digest(path.absolute(), stamp_of(path))
    return found


@lru_cache(maxsize=128)
def _digest(path: Path, stamp: tuple[int, ...]) -> str:
    """Digest of a file; `stamp` is another one when the file has changed."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _paths(section: str, values: object) -> Iterator[tuple[str, Path]]:
    return ((key, value) for key, value in leaves(section, values) if isinstance(value, Path))
