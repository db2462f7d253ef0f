"""A digest behind the last byte of a file, by which bytes that have changed are found.

HDF5 does not look at what stands behind its own end. Files without a digest, of older versions, are
taken as they are.
"""

from __future__ import annotations

import hashlib
import os
from pathlib import Path

from fenics_nnm.errors import OutputError

_MARK = b"fenics_nnm digest "

_LENGTH = len(_MARK) + hashlib.blake2b().digest_size


def seal(path: Path) -> None:
    """Put the digest of a file behind its end.

    Raises:
        OSError: if it cannot be written.
    """
    digest = _digest(path, path.stat().st_size)
    with path.open("ab") as file:
        file.write(_MARK + digest)


def break_seal(path: Path) -> None:
    """Take the digest off, before the file is changed.

    Raises:
        OSError: if it cannot be written.
    """
    if _found(path) is not None:
        os.truncate(path, path.stat().st_size - _LENGTH)


def check_seal(path: Path) -> None:
    """Refuse a file whose bytes are not those that were written.

    Raises:
        OutputError: if they are not.
        OSError: if it cannot be read.
    """
    found = _found(path)
    if found is not None and found != _digest(path, path.stat().st_size - _LENGTH):
        raise OutputError(
            f"{path}: is damaged: its bytes are not those that were written (by their digest): "
            "copy it again, or run its study again"
        )


def _found(path: Path) -> bytes | None:
    """The digest at the end of a file."""
    size = path.stat().st_size
    if size < _LENGTH:
        return None
    with path.open("rb") as file:
        file.seek(size - _LENGTH)
        end = file.read()
    return end.removeprefix(_MARK) if end.startswith(_MARK) else None


def _digest(path: Path, size: int) -> bytes:
    total = hashlib.blake2b()
    with path.open("rb") as file:
        while size > 0 and (part := file.read(min(size, 1 << 20))):
            total.update(part)
            size -= len(part)
    return total.digest()
