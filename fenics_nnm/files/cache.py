"""Results of long computations, kept in a folder for commands that need the same again.

What is kept is found by a key, a digest of all that it depends on, and is there in full or not at
all: a file is written under a name of its own and then renamed, so that several commands may write
at once. Its first bytes are a digest of its key and contents; one that is damaged is removed and
counts as not there. The folder holds a bounded number of bytes: what was not needed for the longest
time goes first.

The variable FENICS_NNM_CACHE names another folder, or is "off". The folder lies below the home
folder and not beside results, as `check` writes no results, and runs of one body into several
folders share what they need.
"""

from __future__ import annotations

import hashlib
import io
import logging
import os
import stat
import tempfile
import time
import zipfile
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fenics_nnm.errors import StudyError

logger = logging.getLogger(__name__)

#: Name of the variable with the folder, and its value that turns the cache off.
VARIABLE, OFF = "FENICS_NNM_CACHE", "off"

#: Name of the folder in the user's folder of caches.
_NAME = "fenics-nnm"

#: Bytes that the files may have together; one alone may have a quarter of them.
_MOST = 2 * 2**30

#: How a file begins, before the digest, and what its name ends with.
_HEAD, _ENDING = b"fenics-nnm cache 1\n", ".kept"

#: What the name of a file ends with while it is written, and seconds after which nobody writes it.
_PART, _LEFT = ".part", 86400.0


@dataclass(frozen=True, slots=True)
class Cache:
    """A folder with arrays by keys.

    Attributes:
        folder: The folder, made if need be.
        most: Bytes that its files may have together.
    """

    folder: Path
    most: int = _MOST

    def read(self, key: str) -> dict[str, Any] | None:
        """The arrays of a key; None if there are none, or they are damaged."""
        path = self._path(key)
        try:
            self._assert_own()
            found = _unsealed(path.read_bytes(), key)
        except (FileNotFoundError, NotADirectoryError):
            return None
        except (OSError, ValueError, KeyError, zipfile.BadZipFile, EOFError) as error:
            logger.info("%s is left out: %s", path, error)
            with suppress(OSError):
                path.unlink()
            return None
        with suppress(OSError):
            os.utime(path)
        return found

    def write(self, key: str, arrays: Mapping[str, Any]) -> None:
        """Keep arrays under a key; where that cannot be, nothing is kept."""
        sealed = _sealed(key, arrays)
        if len(sealed) > self.most // 4:
            return
        try:
            self.folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            self._assert_own()
            self._write(self._path(key), sealed)
            self._shorten()
        except OSError as error:
            logger.info("nothing is kept in %s: %s", self.folder, error)

    def files(self) -> list[Path]:
        """Its files, those that were needed last at the end."""
        found = []
        for path in self.folder.glob(f"*{_ENDING}"):
            with suppress(OSError):  # another command may have removed it
                found.append((path.stat().st_mtime_ns, path))
        return [path for _, path in sorted(found)]

    def clear(self) -> int:
        """Remove all files; how many there were, besides what killed commands left."""
        files = self.files()
        for path in [*files, *self.folder.glob(f"*{_PART}")]:
            path.unlink(missing_ok=True)
        return len(files)

    def size(self) -> int:
        """Bytes of all files."""
        return sum(_bytes_of(path) for path in self.files())

    def _path(self, key: str) -> Path:
        return self.folder / f"{key}{_ENDING}"

    def _assert_own(self) -> None:
        """Refuse a folder of somebody else, who could put anything there.

        Raises:
            OSError: if there is none, or it is not this user's.
        """
        found = self.folder.stat()
        if found.st_uid != os.getuid() or found.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
            raise OSError(f"{self.folder} can be written to by others")

    def _write(self, path: Path, data: bytes) -> None:
        handle, name = tempfile.mkstemp(dir=self.folder, suffix=_PART)
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(data)
            Path(name).replace(path)
        except BaseException:
            Path(name).unlink(missing_ok=True)
            raise

    def _shorten(self) -> None:
        """Remove what was not needed for the longest time, as far as there is too much."""
        for path in self.folder.glob(f"*{_PART}"):
            if time.time() - path.stat().st_mtime > _LEFT:
                path.unlink(missing_ok=True)
        excess = self.size() - self.most
        for path in self.files():
            if excess <= 0:
                return
            excess -= _bytes_of(path)
            path.unlink(missing_ok=True)


def cache_of_user() -> Cache | None:
    """The cache that the environment names; None if it is off.

    Raises:
        StudyError: if it names a relative path, which would be another folder for each command.
    """
    named = os.environ.get(VARIABLE, "")
    if named == OFF:
        return None
    if named:
        return Cache(_absolute(named))
    home = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    return Cache(Path(home) / _NAME)


def _absolute(named: str) -> Path:
    """The folder that the variable names, with ~ for the home folder.

    Raises:
        StudyError: if it is a relative path.
    """
    folder = Path(os.path.expanduser(named))
    if not folder.is_absolute():
        raise StudyError(f'{VARIABLE} = {named}: must be an absolute path, ~/NAME or "{OFF}"')
    return folder


def turn_off() -> None:
    """Keep nothing, and take nothing: in this process and in those that it starts."""
    os.environ[VARIABLE] = OFF


def key_of(*parts: bytes | str) -> str:
    """A key: the digest of parts, none of which can be taken for a piece of another one."""
    total = hashlib.sha256()
    for part in parts:
        data = part.encode() if isinstance(part, str) else part
        total.update(len(data).to_bytes(8, "little") + data)
    return total.hexdigest()


def _sealed(key: str, arrays: Mapping[str, Any]) -> bytes:
    payload = io.BytesIO()
    np.savez(payload, **arrays)
    data = payload.getvalue()
    return _HEAD + _digest(key, data) + data


def _unsealed(sealed: bytes, key: str) -> dict[str, Any]:
    """The arrays of a file.

    Raises:
        ValueError: if it is damaged.
    """
    end = len(_HEAD) + hashlib.sha256().digest_size
    data = sealed[end:]
    if sealed[:end] != _HEAD + _digest(key, data):
        raise ValueError("it is damaged")
    with np.load(io.BytesIO(data), allow_pickle=False) as file:
        return {name: file[name] for name in file.files}


def _digest(key: str, data: bytes) -> bytes:
    return hashlib.sha256(key.encode() + data).digest()


def _bytes_of(path: Path) -> int:
    try:
        return path.stat().st_size
    except OSError:  # another command has removed it
        return 0
