"""HDF5 files that are whole or not there: errors in one line, full disks found beforehand."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import h5py
import numpy as np

from fenics_nnm.errors import NonlinearModeError, OutputError
from fenics_nnm.fem.blocks import Blocks
from fenics_nnm.files.bounds import check_hdf5
from fenics_nnm.results.seal import check_seal

#: More bytes than HDF5 needs for a file as a whole.
ONCE = 32768

#: The same for a data set without attributes, and for its group.
_OF_SET, _OF_GROUP = 1024, 4096


@contextmanager
def reading(path: Path) -> Iterator[None]:
    """Turns what HDF5 and NumPy raise at a damaged file into one line that names the file.

    Raises:
        OutputError: that line.
    """
    try:
        yield
    except (NonlinearModeError, MemoryError) as error:
        if isinstance(error, OutputError | MemoryError):
            raise
        raise OutputError(f"{path}: is damaged: {error}") from error
    except OSError as error:
        raise OutputError(f"{path}: cannot be read: {error}") from error
    except (KeyError, ValueError, TypeError, RuntimeError, IndexError, AttributeError) as error:
        reason = " ".join(str(error).strip("'\"").split())
        raise OutputError(
            f"{path}: is damaged, or was written by another program: {reason}"
        ) from error


@contextmanager
def sealed(path: Path, kind: str) -> Iterator[h5py.File]:
    """The file of a format, to be read, if it is whole.

    Raises:
        OutputError: if it cannot be read or is of another kind.
    """
    with reading(path):
        check_seal(path)
        check_hdf5(path, mapped=True)
        with h5py.File(path, "r") as file:
            _assert_format(path, file, kind)
            yield file


def _assert_format(path: Path, file: h5py.File, kind: str) -> None:
    """Refuse a file of another format, or of another version of it.

    Raises:
        OutputError: if it is one.
    """
    found = str(file.attrs.get("format", ""))
    if found == kind:
        return
    if found.startswith(kind.rstrip("0123456789")):
        raise OutputError(
            f"{path}: has the format {found!r}, of another version; this one reads {kind!r}: "
            "run its study again, in another folder"
        )
    raise OutputError(f"{path}: is not a file of the format {kind!r}")


def add_blocks(path: Path, blocks: Mapping[str, Blocks]) -> None:
    """Add data sets to a file, so many rows at a time as all ranks make together."""
    if not blocks:
        return
    size = sum(each.bytes_ for each in blocks.values())
    with opened(path, size + _OF_SET * len(blocks) + _OF_GROUP) as file:
        for name, each in blocks.items():
            values = file.create_dataset(name, each.shape, dtype=np.float64)
            for few in each.slices():
                values[few] = each.rows(few)


def opened(path: Path, size: int) -> h5py.File:
    """The file, to add `size` bytes to; a full disk is found before HDF5 breaks the file.

    HDF5 cuts off what it did not need.
    """
    with path.open("r+b") as file:
        os.posix_fallocate(file.fileno(), path.stat().st_size, size)
    return h5py.File(path, "r+")


class Writing:
    """Turns HDF5's errors into one line that names the file."""

    def __init__(self, path: Path) -> None:
        """Of a file."""
        self._path = path

    def __enter__(self) -> None:
        pass

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        if isinstance(error, OSError | RuntimeError):
            reason = getattr(error, "strerror", None) or error
            raise OutputError(f"{self._path}: cannot be written: {reason}") from error
