"""Points of a run that is not finished: one small file each, in a folder beside branch.h5.

`branch.points/000000.npz` ... in the order in which the points converged, each with q, force,
free, multipliers and `scalars`, numbers and texts of the point as JSON in UTF-8. A file is there
in full once its point was reported, and survives a power cut from then on; its size does not depend
on the mesh.
"""

from __future__ import annotations

import io
import itertools
import json
import logging
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.results.durable import PART, sync_folder, write_whole
from fenics_nnm.results.stored_point import ARRAYS, arrays_of, point_from, scalars_of

logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Journal:
    """Writer of the points of one run.

    Attributes:
        where: Gives the folder of the points, which may be moved while the run goes on.
        numbers: Numbers of the points to come.
    """

    where: Callable[[], Path]
    numbers: Iterator[int]

    @property
    def folder(self) -> Path:
        """Folder of the points."""
        return self.where()

    def append(self, point: BranchPoint) -> None:
        """Keep a point, whatever happens to the run from now on.

        Raises:
            OSError: if it cannot be written; the points before it are as they were.
        """
        write_whole(self.folder / f"{next(self.numbers):06d}.npz", packed(point))


def folder_beside(branch: Path) -> Path:
    """Folder of the points that a branch.h5 does not have yet."""
    return branch.with_suffix(".points")


def begin(branch: Path, known: Iterable[BranchPoint] = ()) -> None:
    """Make the journal of a new branch.h5.

    Args:
        branch: The branch.h5 that the points are for.
        known: Points of an earlier run; they are all in the journal at the same instant.

    Raises:
        OSError: if it cannot be written.
    """
    folder = folder_beside(branch)
    part = folder.with_name(folder.name + PART)
    part.mkdir()
    journal = Journal(lambda: part, itertools.count())
    for point in known:
        journal.append(point)
    part.rename(folder)
    sync_folder(folder.parent)


def opened(branch: Callable[[], Path]) -> Journal:
    """The journal of a branch.h5, to add points to.

    Args:
        branch: Gives the branch.h5, which may be moved while the run goes on.
    """

    def where() -> Path:
        return folder_beside(branch())

    return Journal(where, itertools.count(len(list(where().glob("*.npz")))))


def read(branch: Path) -> tuple[BranchPoint, ...]:
    """Points beside a branch.h5 in the order in which they converged; broken files are reported."""
    folder = folder_beside(branch)
    found = [(path, _read_if_there(path)) for path in sorted(folder.glob("[0-9]*.npz"))]
    points = [(path, _unpacked(data)) for path, data in found if data is not None]
    broken = [path.name for path, point in points if point is None]
    if broken:
        logger.warning("%s: %s cannot be read: left out", folder, ", ".join(broken))
    return tuple(point for _, point in points if point is not None)


def packed(point: BranchPoint) -> bytes:
    """A point as the bytes of a .npz file."""
    scalars = json.dumps(scalars_of(point), default=np.generic.item)
    encoded = np.frombuffer(scalars.encode(), dtype=np.uint8)
    buffer = io.BytesIO()
    arrays: dict[str, Any] = arrays_of(point)
    np.savez(buffer, scalars=encoded, **arrays)
    return buffer.getvalue()


def _unpacked(data: bytes) -> BranchPoint | None:
    """The point in a .npz file, none if the file is broken."""
    try:
        with np.load(io.BytesIO(data), allow_pickle=False) as file:
            scalars = json.loads(file["scalars"].tobytes())
            return point_from(scalars, {name: file[name] for name in ARRAYS if name in file})
    except Exception:  # zip files can be broken in many ways
        return None


def _read_if_there(path: Path) -> bytes | None:
    """Bytes of a file; none if a run that is just finishing took it into branch.h5."""
    try:
        return path.read_bytes()
    except FileNotFoundError:
        return None
