"""response.h5: everything needed to report, export or continue a response without its mesh.

Layout (SI units):

    /                    attributes: format, study, versions, inputs as in branch.h5; lines (JSON:
                         what was said of the response)
    /model, /series, /mesh, /input_mesh, /material, /contact, /basis, /state
                         as in branch.h5; the model is that of free modes and the shapes that
                         forces at points add to them
    /gap_motion          harmonics (F), amplitudes (F, n_c, complex) of gaps that move, at level 1
    /watched             shapes (w, J), residual (w, n_c) of the places that are watched; attribute
                         names (JSON); with second-order kinematics masters (k), bent (w, k, k)
    /levels/000000 ...   motions of a level in the order of its curves, P of them:
                         q (P, 2 N + 1, J), first (P, w, complex), highest, lowest, contact (P, w),
                         gap (P, n_c), frequency, level, branch, speed, residual, imbalance and
                         largest_multiplier (P); peaks (number of the place, frequency, amplitude,
                         phase, level a row); texts (JSON)
    /backbone            motions in phase resonance: the same, with force and damping_ratio (P)

While a response goes on, and after it was interrupted, levels that are complete are in the folder
`response.levels` beside it, `000000.npz` ... with the same names.
"""

from __future__ import annotations

import io
import json
import logging
import shutil
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.fem.blocks import Data
from fenics_nnm.mechanics.moving_gap import STILL, GapMotion
from fenics_nnm.response.levels import Response
from fenics_nnm.response.watched import Watched
from fenics_nnm.results.durable import replacing, write_whole
from fenics_nnm.results.hdf5 import ONCE, Writing, add_blocks, opened, sealed
from fenics_nnm.results.header import BranchHeader, header_in, image
from fenics_nnm.results.seal import break_seal, seal
from fenics_nnm.results.stored_branch import StoredBranch, body_in
from fenics_nnm.results.stored_response import (
    packed,
    packed_backbone,
    unpacked,
    unpacked_backbone,
)

logger = logging.getLogger(__name__)

FORMAT = "fenics_nnm response 1"

#: Name of the file in a folder of results.
NAME = "response.h5"

#: More bytes than HDF5 needs to note the arrays of a level.
_OVERHEAD = 65536


@dataclass(frozen=True, slots=True)
class StoredResponse:
    """A response as its file has it.

    Attributes:
        header: What holds for all motions.
        watched: Places that are watched.
        found: The motions.
        lines: What was said of it, a line each.
        gap_motion: How gaps move at level 1.
    """

    header: BranchHeader
    watched: Watched
    found: Response
    lines: tuple[str, ...] = ()
    gap_motion: GapMotion = STILL


def create(path: Path, header: BranchHeader, watched: Watched, data: Data) -> None:
    """Make a new file without motions, and the folder beside it that levels go to.

    Args:
        path: File to make, in a folder without one.
        header: What holds for all motions.
        watched: Places that are watched.
        data: Further data sets by their place in the file, such as "mesh/points".

    Raises:
        OutputError: if it cannot be written.
    """
    arrays: dict[str, Any] = {
        "watched/shapes": watched.shapes,
        "watched/residual": watched.residual,
        "watched/masters": watched.masters,
        "watched/bent": watched.bent,
    }
    with Writing(path):
        with replacing(path) as part:
            part.write_bytes(image(header, replace(data, arrays={**data.arrays, **arrays}), FORMAT))
            add_blocks(part, data.blocks)
            with opened(part, ONCE) as file:
                file["watched"].attrs["names"] = json.dumps(watched.names)
            seal(part)
        levels_beside(path).mkdir()


def levels_beside(path: Path) -> Path:
    """Folder of the levels that a file does not have yet."""
    return path.with_suffix(".levels")


def keep(path: Path, number: int, level: Response) -> None:
    """Keep a level that is complete, whatever happens from now on.

    Raises:
        OutputError: if it cannot be written.
    """
    buffer = io.BytesIO()
    np.savez(buffer, **packed(level))
    with Writing(path):
        write_whole(levels_beside(path) / f"{number:06d}.npz", buffer.getvalue())


def finish(path: Path, found: Response, lines: Sequence[str] = ()) -> None:
    """Put all motions in the file; its levels are not needed any more then.

    Raises:
        OutputError: if it cannot be written.
    """
    groups = {f"levels/{n:06d}": packed(each) for n, each in enumerate(found.by_level())}
    groups["backbone"] = packed_backbone(found.backbone)
    size = sum(array.nbytes + _OVERHEAD for each in groups.values() for array in each.values())
    with Writing(path), replacing(path) as part:
        shutil.copyfile(path, part)
        break_seal(part)
        with opened(part, size + ONCE) as file:
            file.attrs["lines"] = json.dumps(list(lines))
            for name, arrays in groups.items():
                for key, values in arrays.items():
                    file[f"{name}/{key}"] = values
        seal(part)
    shutil.rmtree(levels_beside(path), ignore_errors=True)


def read(path: Path) -> StoredResponse:
    """The motions of a response, finished or not.

    Raises:
        OutputError: if the file cannot be read or is of another kind.
    """
    with sealed(path, FORMAT) as file:
        return StoredResponse(
            header_in(file),
            _watched(file["watched"]),
            _found(path, file),
            tuple(json.loads(file.attrs.get("lines", "[]"))),
            _gap_motion(file),
        )


def read_body(path: Path) -> StoredBranch:
    """The mesh and the shapes that the motions of a response are made of.

    Raises:
        OutputError: if the file cannot be read, or has no mesh.
    """
    return body_in(path, read(path).header, driven=True)


def with_signs(found: Response, signs: Array) -> Response:
    """Motions in modal coordinates of other signs, shape (J,)."""
    points = (replace(each, q=each.q * signs) for each in found.points)
    own = (replace(e, point=replace(e.point, q=e.point.q * signs)) for e in found.backbone.points)
    backbone = replace(found.backbone, points=tuple(own))
    return replace(found, points=tuple(points), backbone=backbone)


def _watched(group: h5py.Group) -> Watched:
    names = tuple(json.loads(group.attrs["names"]))
    shapes, residual = np.array(group["shapes"]), np.array(group["residual"])
    if "masters" not in group:  # files from before there were any
        return Watched(names, shapes, residual)
    return Watched(names, shapes, residual, np.array(group["masters"]), np.array(group["bent"]))


def gap_arrays(motion: GapMotion) -> dict[str, Array]:
    """How gaps move as data sets by their place in a file; none where they stand still."""
    if not motion.moves:
        return {}
    return {
        "gap_motion/harmonics": np.array(motion.harmonics),
        "gap_motion/amplitudes": np.asarray(motion.amplitudes),
    }


def _gap_motion(file: h5py.File) -> GapMotion:
    if "gap_motion" not in file:
        return STILL
    group = file["gap_motion"]
    return GapMotion(tuple(map(int, group["harmonics"])), np.array(group["amplitudes"]))


def _found(path: Path, file: h5py.File) -> Response:
    """The motions in a file; those beside it where it is not finished."""
    if "backbone" not in file:
        return _joined(_kept(path))
    found = _joined(unpacked(group) for group in file.get("levels", {}).values())
    return replace(found, backbone=unpacked_backbone(file["backbone"]))


def _joined(found: Iterable[Response]) -> Response:
    return reduce(Response.followed_by, found, Response(()))


def _kept(path: Path) -> list[Response]:
    """Levels beside a file, in their order; broken ones are reported."""
    folder = levels_beside(path)
    found = [(each.name, _level(each)) for each in sorted(folder.glob("[0-9]*.npz"))]
    broken = [name for name, level in found if level is None]
    if broken:
        logger.warning("%s: %s cannot be read: left out", folder, ", ".join(broken))
    return [level for _, level in found if level is not None]


def _level(path: Path) -> Response | None:
    """A level; none if its file is broken."""
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays: Mapping[str, Any] = dict(file)
            return unpacked(arrays)
    except Exception:  # zip files can be broken in many ways
        return None
