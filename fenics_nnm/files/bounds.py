"""How much the arrays of a file may take, found from its head before they are read."""

from __future__ import annotations

import math
import zipfile
from pathlib import Path
from typing import Any, BinaryIO

import h5py
import numpy as np

from fenics_nnm.files.free_memory import free_memory

#: Share of the free memory that one file may fill.
_PART = 0.5

#: Bytes that a file may fill where the free memory is not known.
_USUAL = 16 * 2**30

#: Most rows or columns of a matrix.
_MOST_ROWS = 50_000_000

#: Most groups and data sets of an HDF5 file.
_MOST_OBJECTS = 1_000_000


class UnsafeFileError(ValueError):
    """A file whose arrays are too large, or that refers to other files."""


def assert_fits(count: float, what: str) -> None:
    """Refuse arrays that do not fit in memory.

    Args:
        count: Their bytes.
        what: What they are, for the message.

    Raises:
        UnsafeFileError: if they do not.
    """
    most = _PART * (free_memory() or 2 * _USUAL)
    if count > most:
        raise UnsafeFileError(
            f"{what} would take {count / 2**30:.3g} GiB: may take {most / 2**30:.3g} GiB here"
        )


def check_npy(path: Path) -> None:
    """Check a .npy file.

    Raises:
        UnsafeFileError: if it has fewer bytes than its head says.
        ValueError, OSError: if it is no such file.
    """
    with path.open("rb") as file:
        _check_array(file, path.stat().st_size, path.name)


def check_npz(path: Path) -> None:
    """Check a .npz file, which may unpack to far more than it has.

    Raises:
        UnsafeFileError: as for `check_npy`, or if all arrays together do not fit in memory.
        ValueError, OSError, BadZipFile: if it is no such file.
    """
    with zipfile.ZipFile(path) as archive:
        members = archive.infolist()
        assert_fits(sum(member.file_size for member in members), "unpacked it")
        for member in members:
            with archive.open(member) as file:
                if file.read(6) == b"\x93NUMPY":
                    file.seek(0)
                    _check_array(file, member.file_size, member.filename)  # type: ignore[arg-type]


def check_matrix_market(path: Path) -> None:
    """Check the sizes of a .mtx file against its length.

    Raises:
        UnsafeFileError: if it names more entries than it can have.
        ValueError, OSError: if it is no such file.
    """
    with path.open("rb") as file:
        if not file.readline(1000).lower().startswith(b"%%matrixmarket"):
            raise UnsafeFileError("does not begin with %%MatrixMarket")
        line = b"%"
        while line.startswith(b"%") or line == b"\n":
            line = file.readline(100_000)
    sizes = [int(word) for word in line.split()]
    check_shape(tuple(sizes[:2]))
    named = sizes[2] if len(sizes) > 2 else math.prod(sizes)
    if named > path.stat().st_size:
        raise UnsafeFileError(f"names {named} entries: has {path.stat().st_size} bytes alone")


def check_shape(shape: tuple[int, ...]) -> None:
    """Refuse matrices of more rows or columns than anybody has.

    Raises:
        UnsafeFileError: if there are more.
    """
    if max(shape, default=0) > _MOST_ROWS or min(shape, default=0) < 0:
        raise UnsafeFileError(f"has the shape {shape}: at most {_MOST_ROWS} rows and columns")


def check_hdf5(path: Path, *, mapped: bool = False) -> None:
    """Check that an HDF5 file is all in itself, and that each of its data sets fits in memory.

    Args:
        path: The file.
        mapped: Whether data sets as large as their place in the file need not fit: they are mapped.

    Raises:
        UnsafeFileError: if it refers to other files, or has too many or too large data sets.
        OSError, RuntimeError, KeyError, ValueError: if it is damaged.
    """
    with h5py.File(path, "r") as file:
        seen: set[int] = set()
        waiting: list[h5py.Group] = [file]
        while waiting:
            group = waiting.pop()
            address = int(h5py.h5o.get_info(group.id).addr)
            if address in seen:
                continue
            seen.add(address)
            if len(seen) > _MOST_OBJECTS:
                raise UnsafeFileError(f"has more than {_MOST_OBJECTS} groups")
            for name in group:
                _check_link(group, name, waiting, mapped=mapped)


def _check_link(group: h5py.Group, name: str, waiting: list[h5py.Group], *, mapped: bool) -> None:
    where = f"{group.name.rstrip('/')}/{name}"
    link = group.get(name, getlink=True)
    if isinstance(link, h5py.ExternalLink):
        raise UnsafeFileError(f"{where} is a link to the file {link.filename}")
    if isinstance(link, h5py.SoftLink):
        return  # to a place of this file, which is visited by its own name
    found = group[name]
    if isinstance(found, h5py.Group):
        waiting.append(found)
    elif isinstance(found, h5py.Dataset):
        if found.external or found.is_virtual:
            raise UnsafeFileError(f"{where} has its values in other files")
        if not mapped or found.nbytes > found.id.get_storage_size():
            assert_fits(found.nbytes, where)


def _check_array(file: BinaryIO, size: int, name: str) -> None:
    version = np.lib.format.read_magic(file)
    read: Any = {
        (1, 0): np.lib.format.read_array_header_1_0,
        (2, 0): np.lib.format.read_array_header_2_0,
    }[version]
    shape, _, kind = read(file)
    if kind.hasobject:
        return  # NumPy refuses them where it is not asked for them
    wanted = math.prod(shape) * kind.itemsize
    if wanted > size - file.tell():
        raise UnsafeFileError(f"{name} has fewer bytes than its shape {shape} needs")
    assert_fits(wanted, name)
