"""Geometries of CAD programs in gmsh: read, named, meshed."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import gmsh
import numpy as np
from scipy.spatial import KDTree

from fenics_nnm.arrays import Array
from fenics_nnm.errors import Code, MeshError
from fenics_nnm.fem.cached_mesh import contents
from fenics_nnm.fem.cad_units import declared_unit
from fenics_nnm.fem.curved import mend
from fenics_nnm.fem.given_file import PrivateFolder
from fenics_nnm.fem.gmsh_mesh import extracted, gmsh_session
from fenics_nnm.fem.native_errors import FileErrors
from fenics_nnm.fem.raw_mesh import RawMesh
from fenics_nnm.geometry.lengths import METRES

#: OpenCASCADE's names of units.
_OCC_UNITS = {"m": "M", "cm": "CM", "mm": "MM", "in": "INCH", "ft": "FT", "um": "UM", "mil": "MIL"}

_IGES = (".iges", ".igs")

#: Distance between edges of faces that are sewn to a solid, over the size of the body.
_SEWING = 1e-6

#: More elements than this are a misprint of the size.
_MOST_ELEMENTS = 5_000_000


@dataclass(frozen=True, slots=True)
class Cad:
    """A file with a geometry, and how to mesh it; lengths in `length_unit`.

    Attributes:
        path: STEP, IGES, BREP or .geo file.
        length_unit: Unit of its numbers, a key of `METRES`.
        trust: Whether `length_unit` holds whatever unit the file declares.
        element_size: Largest edge length, or None for the sizes of a .geo file.
        order: Order of the elements, 1 or 2.
        curvature: Elements on a full turn of a curved face, or None.
        trust_script: Whether a .geo file may do all that this user may.
    """

    path: Path
    length_unit: str
    trust: bool = False
    element_size: float | None = None
    order: int = 1
    curvature: int | None = None
    trust_script: bool = False


@dataclass(frozen=True, slots=True)
class Near:
    """Smaller elements near points; lengths in the unit of the file.

    Attributes:
        points: Places all over some facets, shape (n, dim).
        area: Area of the facets; length in 2-D.
        size: Edge length at the points.
        distance: Distance over which the edge length grows to that of the rest.
    """

    points: Array
    area: float
    size: float
    distance: float

    def count(self, largest: float, volume: float, dim: int) -> float:
        """About how many elements are near: six on each cube of their edge length.

        The edge length h grows linearly to `largest` with the distance x from the facets:
        6 area times the integral of h^-dim over x, as far as the body of this volume reaches.
        """
        slope = (largest - self.size) / self.distance
        reach = self.size + slope * min(self.distance, volume / self.area)
        with np.errstate(over="ignore"):
            lines = np.array([self.size, reach]) ** (1.0 - dim)
        return 6 * self.area / (slope * (dim - 1)) * float(lines[0] - lines[1])


@dataclass(frozen=True, slots=True)
class MeshCad:
    """The job of meshing a geometry.

    Attributes:
        cad: File and sizes.
        near: Where elements are smaller.
    """

    cad: Cad
    near: tuple[Near, ...] = ()

    @property
    def errors(self) -> FileErrors:
        """Errors of the file."""
        return FileErrors(self.cad.path)

    @property
    def advice(self) -> str:
        """What to try."""
        order = ", elements of order 1" if self.cad.order == 2 else ""
        return (
            f"try another element size{order}, or heal the geometry (edges much shorter than the "
            "rest, faces that overlap) and export it again"
        )

    def fault(self) -> str:
        """Nothing is known without OpenCASCADE."""
        return ""

    @property
    def trusted(self) -> bool:
        """Whether the study trusts a script."""
        return self.cad.trust_script and self.cad.path.suffix.lower() == ".geo"

    def identity(self) -> str:
        """As `cached_mesh.Identified`; a script that may do all may depend on anything."""
        file = "" if self.trusted else contents(self.cad.path)
        near = [
            (hashlib.sha256(n.points.tobytes()).hexdigest(), n.size, n.distance) for n in self.near
        ]
        return file and f"{file} {self.cad!r} {near!r}"

    def __call__(self, folder: Path) -> RawMesh:
        """Mesh it.

        Raises:
            MeshError: if the file cannot be read or meshed; the message says why.
        """
        name = str(self.cad.path)
        with gmsh_session(name, talks=True):
            _open(self.cad, PrivateFolder(folder), trusted=self.trusted)
            dim = gmsh.model.getDimension()
            _name_entities(name, dim)
            _check_size(self.cad, self.near, dim)
            with _smaller(self.cad, self.near, dim):
                _generate(self.cad, dim, folder)
            return replace(extracted(name), notes=_left_out(dim))


def _left_out(dim: int) -> tuple[str, ...]:
    """A line about faces that bound no solid; edges that bound no face of a plane body."""
    shapes = gmsh.model.getEntities(dim - 1) if dim > 1 else []
    alone = [shape for shape in shapes if not len(gmsh.model.getAdjacencies(*shape)[0])]
    if not alone:
        return ()
    word, whole = ("face", "solid") if dim == 3 else ("edge", "face")
    one = len(alone) == 1
    what = (
        f"1 {word} that bounds no {whole} is"
        if one
        else (f"{len(alone)} {word}s that bound no {whole} are")
    )
    centre = np.reshape(gmsh.model.getBoundingBox(*alone[0]), (2, 3)).mean(axis=0)
    place = ", ".join(f"{x:.4g}" for x in centre)
    return (f"{what} left out, the first about ({place}) in the file",)


def _open(cad: Cad, folder: PrivateFolder, *, trusted: bool) -> None:
    """Read the geometry with the numbers that stand in the file."""
    declared = declared_unit(cad.path)
    given = folder.trusted(cad.path) if trusted else folder.given(cad.path)
    try:
        _merge_sewn(given, declared or "mm")
    except Exception as error:  # gmsh raises bare Exception
        reason = str(error).replace(str(given), str(cad.path))
        raise MeshError(
            f"mesh file {cad.path}: gmsh cannot read it: {reason}", code=Code.MESH_FILE
        ) from error
    if gmsh.model.getDimension() < 1:
        raise MeshError(f"mesh file {cad.path}: holds no geometry", code=Code.MESH_FILE)
    if declared and declared != cad.length_unit and not cad.trust:
        raise MeshError(
            f'length unit "{cad.length_unit}": {cad.path} declares "{declared}": must be '
            f"that, with a body of {_extent(declared)}; or, if its numbers are in "
            f"{cad.length_unit} all the same, with a body of {_extent(cad.length_unit)}, "
            "the declared unit must be ignored",
            code=Code.LENGTH_UNIT,
        )


def _merge_sewn(path: Path, unit: str) -> None:
    """Merge a file with lengths in a unit; faces alone are read again and sewn to a solid."""
    gmsh.option.setNumber("Geometry.OCCMakeSolids", 1)
    _merge(path, unit)
    known = path.suffix.lower() == ".geo" or gmsh.model.occ.getEntities(3)
    if known or len(gmsh.model.occ.getEntities(2)) < 2:
        return
    size = np.ptp(np.reshape(gmsh.model.getBoundingBox(-1, -1), (2, 3)), axis=0).max()
    gmsh.model.occ.remove(gmsh.model.occ.getEntities(), recursive=True)
    gmsh.option.setNumber("Geometry.OCCSewFaces", 1)
    gmsh.option.setNumber("Geometry.Tolerance", _SEWING * float(size))
    _merge(path, unit)


def _merge(path: Path, unit: str) -> None:
    """Merge a file with lengths in a unit.

    OpenCASCADE converts to mm unless set otherwise, and cannot be set before its first STEP file
    is read: IGES files are read in mm and scaled.
    """
    if path.suffix.lower() not in _IGES:
        gmsh.option.setString("Geometry.OCCTargetUnit", _OCC_UNITS[unit])
        gmsh.merge(str(path))
        return
    gmsh.option.setString("Geometry.OCCTargetUnit", _OCC_UNITS["mm"])
    try:
        gmsh.merge(str(path))
    except Exception:  # gmsh raises bare Exception, here since no STEP file was read before
        gmsh.option.setString("Geometry.OCCTargetUnit", "")
        gmsh.merge(str(path))
    scale = METRES["mm"] / METRES[unit]
    if scale != 1:
        gmsh.model.occ.dilate(gmsh.model.occ.getEntities(), 0, 0, 0, scale, scale, scale)
        gmsh.model.occ.synchronize()


def _extent(unit: str) -> str:
    """Sizes of the bounding box in m."""
    box = np.array(gmsh.model.getBoundingBox(-1, -1)) * METRES[unit]
    return " x ".join(f"{x:.4g}" for x in box[3:] - box[:3]) + " m"


def _name_entities(name: str, dim: int) -> None:
    """Name solids and outer faces; solids that touch get common nodes."""
    if dim == 2 and len(gmsh.model.getEntities(2)) > 1:
        _check_plane(name)
    bodies = _joined(name, dim) if not gmsh.model.getPhysicalGroups() else {}
    for label, entities in bodies.items():
        gmsh.model.addPhysicalGroup(dim, entities, name=label)
    word = "face" if dim == 3 else "edge"
    for _, tag in gmsh.model.getEntities(dim - 1):
        if len(gmsh.model.getAdjacencies(dim - 1, tag)[0]) == 1:
            gmsh.model.addPhysicalGroup(dim - 1, [tag], name=f"{word} {tag}")


def _check_plane(name: str) -> None:
    """Refuse faces that should have closed to a solid."""
    box = gmsh.model.getBoundingBox(-1, -1)
    if abs(box[5] - box[2]) > 1e-6 * max(box[3] - box[0], box[4] - box[1]):
        raise MeshError(
            f"{name}: holds {len(gmsh.model.getEntities(2))} faces, and they close to no solid: "
            "export a solid, or heal the geometry"
        )


def _joined(name: str, dim: int) -> dict[str, list[int]]:
    """Entities of the body and of each of its parts, after parts that touch are joined."""
    parts = gmsh.model.getEntities(dim)
    labels = [gmsh.model.getEntityName(*part).rpartition("/")[2] for part in parts]
    pieces = [[part] for part in parts]
    if len(parts) > 1 and gmsh.model.occ.getEntities(dim):
        _, pieces = gmsh.model.occ.fragment(parts[:1], parts[1:])
        gmsh.model.occ.synchronize()
    owned = [piece for of_part in pieces for piece in of_part]
    if len(set(owned)) < len(owned):
        raise MeshError(f"{name}: solids overlap: they may only touch")
    found = {"body": [tag for _, tag in owned]}
    for number, (label, of_part) in enumerate(zip(labels, pieces, strict=True), start=1):
        if len(parts) > 1:
            known = label if label and label not in found else f"part {number}"
            found[known] = [tag for _, tag in of_part]
    return found


def _check_size(cad: Cad, near: tuple[Near, ...], dim: int) -> None:
    """Refuse sizes that would give more elements than anybody means."""
    parts = gmsh.model.occ.getEntities(dim)
    if cad.element_size is None or not parts:
        return
    volume = sum(gmsh.model.occ.getMass(*part) for part in parts)
    least = (6 * volume / _MOST_ELEMENTS) ** (1 / dim)
    if cad.element_size < least:
        raise MeshError(
            f"element size = {cad.element_size:g}: gives more than {_MOST_ELEMENTS} elements: the "
            f"body has {_extent(cad.length_unit)}: must be larger than {least:.2g}",
            code=Code.ELEMENT_SIZE,
        )
    for part in near:
        if dim > 1 and part.count(cad.element_size, volume, dim) > _MOST_ELEMENTS:
            raise MeshError(
                f"refined size = {part.size:g}: gives more than {_MOST_ELEMENTS} elements within "
                f"{part.distance:g} of the facets: must be larger, or the distance smaller",
                code=Code.REFINED_SIZE,
            )


def _generate(cad: Cad, dim: int, folder: Path) -> None:
    """Mesh the current model."""
    options: dict[str, float] = {"Mesh.ElementOrder": cad.order}
    if cad.element_size is not None:
        options["Mesh.MeshSizeMax"] = cad.element_size
    if cad.curvature is not None:
        options["Mesh.MeshSizeFromCurvature"] = cad.curvature
    for option, value in options.items():
        gmsh.option.setNumber(option, value)
    try:
        gmsh.model.mesh.generate(dim)
    except Exception as error:  # gmsh raises bare Exception
        raise MeshError(
            f"mesh file {cad.path}: gmsh cannot mesh it: {error}: heal the geometry, or change "
            "the element size",
            code=Code.MESHING,
        ) from error
    if cad.order == 2:
        mend(cad.path, dim, folder, cad.length_unit)


@contextmanager
def _smaller(cad: Cad, near: tuple[Near, ...], dim: int) -> Iterator[None]:
    """Element sizes that grow linearly with the distance from points."""
    if not near:
        yield
        return
    trees = [(KDTree(part.points), part) for part in near]
    largest = cad.element_size or np.inf

    def size(_: int, tag: int, x: float, y: float, z: float, usual: float) -> float:
        for tree, part in trees:
            distance, _row = tree.query((x, y, z)[:dim])
            share = min(1.0, distance / part.distance)
            usual = min(usual, part.size + share * (largest - part.size))
        return usual

    gmsh.model.mesh.setSizeCallback(size)
    try:
        yield
    finally:
        gmsh.model.mesh.removeSizeCallback()
