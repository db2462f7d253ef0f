"""branch.h5: everything needed to plot, export or restart without solving the mesh again.

Layout (SI units):

    /                    attributes: format, study (TOML), versions (JSON), reason, inputs (JSON:
                         digest of each file that the study names, by key)
    /model               omega, Phi, R, gap of the reduced model; kinematics, if of second order:
                         Theta, alpha, beta, D; attribute: masters (from 0)
    /contact             points, directions, areas, patches (their numbers, from 0), patch_names;
                         facets (their nodes in VTK order), facet_patch and facet_side (0 for its
                         own, 1 for those opposite); pressures, three rows: node, contact point,
                         pressure in Pa there per N of its force; of a mesh only
    /series              attributes: mode (from 1), harmonics, samples, modes (of the reduction),
                         series
    /mesh                points, cells (VTK order), cell_type (VTK), region of each cell; of a
                         mesh only; cells as in the input mesh, nodes as these cells name them
    /input_mesh          the mesh as it was read, before it was spread over ranks: kind (gmsh's
                         number of the cells, dimension), points, cells (gmsh order), parts (nodes
                         of the facets, cells and nodes of named groups), words (JSON: their names
                         and shapes, masses, springs, constraints, notes), metres in one unit of
                         points; of a mesh only
    /material            elasticity (rows, 6, strains), stress in Pa in the order XX YY ZZ XY YZ XZ
                         of the strains xx; xx, yy, 2 xy; or xx, yy, zz, 2 xy, 2 yz, 2 xz; row of
                         each cell at each point where its stress is taken; of a mesh only
    /basis               shapes (J, nodes, dim), residual_shapes (n_c, nodes, dim) of a mesh;
                         shapes (J, n), residual_shapes (n_c, n) in the order of the n unknowns of
                         matrices: u = shapes^T q - residual_shapes^T lambda; with second-order
                         kinematics bent_shapes (p, nodes, dim) or (p, n) of the pairs i <= j of
                         masters in the order (0, 0), (0, 1) .. (1, 1) ..: theta_ij q_i q_j is
                         added for i < j, and half of it for i = j
    /inertia/000000 ...  harmonics in m, (N + 1, nodes, dim), of the displacement that full order
                         adds to the point at the attribute position, if it has ParaView files
    /points/000000 ...   q (N + 1, J), force (m // 2 + 1, n_c), free (N + 1, n_c), multipliers
                         (2 J - 2, complex; none if not known); attributes: scalars of the point;
                         by position

The file of a finished run has all of this. While a run goes on, and after it was killed, points
are in the folder `branch.points` beside it (see `journal`), and `read` looks there. In the end it
is replaced at one instant by a file with the points, so that it opens whenever a run is killed.
"""

from __future__ import annotations

import json
import os
import shutil
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from fenics_nnm.backbone.follow import Branch
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.errors import NonlinearModeError, OutputError
from fenics_nnm.fem.blocks import Blocks, Data
from fenics_nnm.files.bounds import check_hdf5
from fenics_nnm.mechanics.contact_points import MASSIVE, MASSLESS, ContactPoints
from fenics_nnm.mechanics.fourier import CosineSeries, FourierSeries, Series
from fenics_nnm.mechanics.kinematics import LINEAR, Kinematics
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.mechanics.second_order import SecondOrder
from fenics_nnm.results import journal
from fenics_nnm.results.durable import replacing
from fenics_nnm.results.journal import Journal
from fenics_nnm.results.seal import break_seal, check_seal, seal
from fenics_nnm.results.stored_point import (
    ARRAYS,
    SCALARS,
    arrays_of,
    point_from,
    scalars_of,
)
from fenics_nnm.results.stored_text import values_of
from fenics_nnm.study.resolution import Resolution

FORMAT = "fenics_nnm branch 6"

#: More bytes than HDF5 needs to note a point besides its arrays, and for the file as a whole.
_OVERHEAD, _ONCE = 8192, 32768

#: The same for a data set without attributes, and for its group.
_OF_SET, _OF_GROUP = 1024, 4096

#: Bytes below which a data set is not compressed, which needs more than that itself.
_SMALL = 4096

#: How data sets that are compressed are stored: what takes little time.
_PACKING: dict[str, Any] = {"compression": "gzip", "compression_opts": 1, "shuffle": True}


@dataclass(frozen=True, slots=True)
class BranchHeader:
    """What a branch file holds besides its points.

    Attributes:
        study: Text of the study file.
        versions: Versions of the program and its libraries.
        mode: Number of the linear mode, from 1.
        harmonics: Number of harmonics N.
        samples: Time samples of a period m.
        modes: Number of modes of the reduction; those of the model are more where it has
            constraint modes too.
        series: "time-reversible" or "general".
        model: Reduced model in SI units.
        inputs: Digests of the files that the study names, by key; none in files of earlier
            versions.
    """

    study: str
    versions: dict[str, str]
    mode: int
    harmonics: int
    samples: int
    modes: int
    series: str
    model: ReducedModel
    inputs: Mapping[str, str] = field(default_factory=dict)

    @property
    def values(self) -> Mapping[str, Any]:
        """Values of the study file."""
        return values_of(self.study)

    @property
    def resolution(self) -> Resolution:
        """Harmonics, samples and modes."""
        return Resolution(self.harmonics, self.samples, self.modes)

    @property
    def time_series(self) -> Series:
        """Series in time that the points are written in."""
        kind = FourierSeries if self.series == "general" else CosineSeries
        return kind(self.harmonics, self.samples)


def create(path: Path, header: BranchHeader, data: Data, known: Sequence[BranchPoint] = ()) -> None:
    """Make a new file without points, and the journal beside it that its points go to.

    Args:
        path: File to make, in a folder without one.
        header: What holds for all points.
        data: Further data sets by their place in the file, such as "mesh/points".
        known: Points of an earlier run to begin with.

    Raises:
        OutputError: if it cannot be written.
    """
    with _writing(path):
        with replacing(path) as part:
            part.write_bytes(_image(header, data))
            _add(part, data.blocks)
            seal(part)
        journal.begin(path, known)


def append(points: Journal, point: BranchPoint) -> None:
    """Keep a converged point; it cannot be lost once this returns.

    Raises:
        OutputError: if it cannot be written.
    """
    with _writing(points.folder):
        points.append(point)


def finish(path: Path, branch: Branch) -> None:
    """Put the points of a branch in the file, with the reason of its end.

    Raises:
        OutputError: if it cannot be written; the points are still in the journal.
    """
    _fill(path, branch.points, reason=branch.reason)


def add_inertia(path: Path, inertia: Mapping[float, Blocks]) -> None:
    """Add what full order adds to the displacement of points, by their position.

    Raises:
        OutputError: if it cannot be written; the file is as it was then.
    """
    names = [f"inertia/{number:06d}" for number in range(len(inertia))]
    with _writing(path), replacing(path) as part:
        shutil.copyfile(path, part)
        break_seal(part)
        _add(part, dict(zip(names, inertia.values(), strict=True)))
        with _opened(part, _ONCE) as file:
            for name, position in zip(names, inertia, strict=True):
                file[name].attrs["position"] = position
        seal(part)


def gather(path: Path) -> None:
    """Put what a run that was stopped left in its journal in the file.

    Raises:
        OutputError: if it cannot be written; the points are still in the journal.
    """
    if journal.folder_beside(path).exists():
        _fill(path, read(path)[1])


def read(path: Path) -> tuple[BranchHeader, tuple[BranchPoint, ...]]:
    """Header and the points that hold, by position, of any run, finished or not.

    Raises:
        OutputError: if the file cannot be read or is of another kind.
    """
    with reading(path):
        unfinished = journal.read(path)  # first, as a run may be just finishing
        check_seal(path)
        check_hdf5(path, fits=False)
        with h5py.File(path, "r") as file:
            _assert_format(path, str(file.attrs.get("format", "")))
            points = [_point(group) for group in file["points"].values()] or unfinished
            latest = {point.position: point for point in points}
            return _header(file), tuple(latest[place] for place in sorted(latest))


def study_text(path: Path) -> str:
    """Text of the study file of any run, finished or not; its points are not read.

    Raises:
        OutputError: if the file cannot be read or is of another kind.
    """
    with reading(path):
        check_seal(path)
        check_hdf5(path, fits=False)
        with h5py.File(path, "r") as file:
            _assert_format(path, str(file.attrs.get("format", "")))
            return str(file.attrs["study"])


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


def _assert_format(path: Path, found: str) -> None:
    if found == FORMAT:
        return
    if found.startswith(FORMAT.rstrip("0123456789")):
        raise OutputError(
            f"{path}: has the format {found!r}, of another version; this one reads {FORMAT!r}: "
            "run its study again, in another folder"
        )
    raise OutputError(f"{path}: is not a file of the format {FORMAT!r}")


def _fill(path: Path, points: Sequence[BranchPoint], **attributes: str) -> None:
    """Replace the file by one with these points; the journal is not needed any more then."""
    size = sum(array.nbytes for point in points for array in arrays_of(point).values())
    with _writing(path), replacing(path) as part:
        shutil.copyfile(path, part)
        break_seal(part)
        with _opened(part, size + _OVERHEAD * len(points) + _ONCE) as file:
            file.attrs.update(attributes)
            del file["points"]
            for number, point in enumerate(points):
                group = file.create_group(f"points/{number:06d}")
                for name, array in arrays_of(point).items():
                    group[name] = array
                group.attrs.update(scalars_of(point))
            file.require_group("points")
        seal(part)
    shutil.rmtree(journal.folder_beside(path), ignore_errors=True)


def _add(path: Path, blocks: Mapping[str, Blocks]) -> None:
    """Add data sets to a file, so many rows at a time as all ranks make together."""
    if not blocks:
        return
    size = sum(each.bytes_ for each in blocks.values())
    with _opened(path, size + _OF_SET * len(blocks) + _OF_GROUP) as file:
        for name, each in blocks.items():
            values = file.create_dataset(name, each.shape, dtype=np.float64)
            for few in each.slices():
                values[few] = each.rows(few)


def _image(header: BranchHeader, data: Data) -> bytes:
    """Bytes of a file without points and blocks.

    HDF5 may crash where it writes to a full disk itself.
    """
    with h5py.File("branch.h5", "w", driver="core", backing_store=False) as file:
        file.attrs["format"] = FORMAT
        file.attrs["study"] = header.study
        file.attrs["versions"] = json.dumps(header.versions)
        file.attrs["inputs"] = json.dumps(dict(header.inputs))
        for name in ("omega", "Phi", "R", "gap"):
            file[f"model/{name}"] = getattr(header.model, name)
        for name, tensor in header.model.kinematics.tensors.items():
            file[f"model/kinematics/{name}"] = tensor
            file["model/kinematics"].attrs["masters"] = header.model.kinematics.masters
        file["model"].attrs["massless"] = header.model.massless
        if header.model.reference is not None:
            file["model"].attrs["reference"] = header.model.reference
        series = file.create_group("series")
        for name in ("mode", "harmonics", "samples", "modes", "series"):
            series.attrs[name] = getattr(header, name)
        for name, values in data.arrays.items():
            file[name] = values
        for name, values in data.packed.items():
            packing = _PACKING if values.nbytes > _SMALL else {}
            file.create_dataset(name, data=values, **packing)
        file.create_group("points")
        file.flush()
        return bytes(file.id.get_file_image())


def _opened(path: Path, size: int) -> h5py.File:
    """The file, to add `size` bytes to; a full disk is found before HDF5 breaks the file.

    HDF5 cuts off what it did not need.
    """
    with path.open("r+b") as file:
        os.posix_fallocate(file.fileno(), path.stat().st_size, size)
    return h5py.File(path, "r+")


def _header(file: h5py.File) -> BranchHeader:
    series, model = file["series"].attrs, file["model"]
    tomllib.loads(file.attrs["study"])  # of a damaged file it may be none
    return BranchHeader(
        study=file.attrs["study"],
        versions=json.loads(file.attrs["versions"]),
        mode=int(series["mode"]),
        harmonics=int(series["harmonics"]),
        samples=int(series["samples"]),
        modes=int(series["modes"]),
        series=str(series["series"]),
        inputs=json.loads(file.attrs.get("inputs", "{}")),
        model=ReducedModel(
            omega=np.array(model["omega"]),
            Phi=np.array(model["Phi"]),
            R=np.array(model["R"]),
            gap=np.array(model["gap"]),
            reference=float(model.attrs["reference"]) if "reference" in model.attrs else None,
            contact=_contact_points(model),
            kinematics=_kinematics(model),
        ),
    )


def _kinematics(model: h5py.Group) -> Kinematics:
    """Kinematics of the model; linear where none are stored."""
    if "kinematics" not in model:
        return LINEAR
    stored = model["kinematics"]
    tensors = {name: np.array(stored[name]) for name in ("Theta", "alpha", "beta", "D")}
    return SecondOrder(masters=np.array(stored.attrs["masters"]), **tensors)


def _contact_points(model: h5py.Group) -> ContactPoints:
    """Kind of the contact points; files of earlier versions have R = 0 for points with mass."""
    massless = model.attrs["massless"] if "massless" in model.attrs else np.any(model["R"])
    return MASSLESS if massless else MASSIVE


def _point(group: h5py.Group) -> BranchPoint:
    scalars: dict[str, Any] = {name: group.attrs[name] for name in SCALARS}
    for name, value in scalars.items():
        scalars[name] = value.item() if isinstance(value, np.generic) else value
    return point_from(scalars, {name: np.array(group[name]) for name in ARRAYS})


class _writing:
    """Turns HDF5's errors into one line that names the file."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def __enter__(self) -> None:
        pass

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        if isinstance(error, OSError | RuntimeError):
            reason = getattr(error, "strerror", None) or error
            raise OutputError(f"{self._path}: cannot be written: {reason}") from error
