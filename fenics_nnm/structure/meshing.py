"""From the sections [mesh] and [groups] of a study to a mesh with named facets."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from mpi4py import MPI

from fenics_nnm.fem.kept_mesh import StoredMesh
from fenics_nnm.fem.mesh import TaggedMesh, generate_mesh, read_mesh, stored_mesh
from fenics_nnm.fem.native import Limits
from fenics_nnm.fem.picking import (
    Box,
    Condition,
    Facing,
    Level,
    Named,
    Nearest,
    Pick,
    Plane,
    Radii,
    with_groups,
)
from fenics_nnm.geometry import Geometry
from fenics_nnm.study import MeshStudy
from fenics_nnm.study.groups import GroupSection
from fenics_nnm.study.mesh import CadFile, MeshFile
from fenics_nnm.study.record import axis_vector

if TYPE_CHECKING:
    from fenics_nnm.fem.cad_model import Cad

Picker = Callable[[TaggedMesh], TaggedMesh]
"""Names groups of a mesh."""


def tagged_mesh(study: MeshStudy, comm: MPI.Comm, stored: StoredMesh | None = None) -> TaggedMesh:
    """Read or generate the mesh of a study, and pick the groups it asks for.

    Args:
        study: Study.
        comm: Communicator of the mesh.
        stored: The mesh of the study as an earlier run has kept it, in place of its file.

    Raises:
        MeshError: if it cannot be used, or a group picks nothing.
        GeometryError: if a built-in geometry cannot be made.
    """

    def pick(tagged: TaggedMesh) -> TaggedMesh:
        return with_groups(tagged, _picks(study.groups, tagged))

    if stored is not None:
        return pick(stored_mesh(stored, comm))
    make = _MAKE.get(type(study.mesh), _generated)
    return pick(make(study.mesh, pick, comm))


def _read_cad(section: CadFile, pick: Picker, comm: MPI.Comm) -> TaggedMesh:
    from fenics_nnm.fem.cad import Refined, read_cad  # with gmsh, of no use to other meshes

    refined = tuple(
        Refined(r.facets, r.size, r.distance, "mesh.refine.facets") for r in section.refine
    )
    return read_cad(_cad(section), refined, pick, comm, _limits(section))


def _read_mesh(section: MeshFile, pick: Picker, comm: MPI.Comm) -> TaggedMesh:
    return read_mesh(section.file, section.length_unit, comm, _limits(section))


def _generated(section: Geometry, pick: Picker, comm: MPI.Comm) -> TaggedMesh:
    return generate_mesh(section, comm)


#: How a mesh is made of each kind of section; all others are built-in geometries.
_MAKE: Mapping[type, Callable[..., TaggedMesh]] = {CadFile: _read_cad, MeshFile: _read_mesh}


def _cad(section: CadFile) -> Cad:
    from fenics_nnm.fem.cad_model import Cad  # as above

    return Cad(
        section.file,
        section.length_unit,
        trust=section.ignore_declared_unit,
        element_size=section.element_size,
        order=section.order,
        curvature=section.curvature,
        trust_script=section.trust_script,
    )


def _limits(section: CadFile | MeshFile) -> Limits:
    return Limits(section.memory, section.time)


def _picks(groups: Mapping[str, GroupSection], tagged: TaggedMesh) -> dict[str, Pick]:
    return {
        name: Pick(_conditions(name, group, tagged), group.tolerance)
        for name, group in groups.items()
    }


def _conditions(name: str, group: GroupSection, tagged: TaggedMesh) -> list[Condition]:
    """Conditions of a group, in the order of their keys."""
    levels = (group.x, group.y, group.z)
    found: list[Condition] = [Level(i, x) for i, x in enumerate(levels) if x is not None]
    if group.plane:
        found.append(Plane(group.plane.point, axis_vector(group.plane.normal)))
    if group.cylinder:
        cylinder = group.cylinder
        axis = axis_vector(cylinder.axis)
        found.append(Radii(axis, cylinder.origin, cylinder.radius, cylinder.radius))
    if group.radii:
        radii = group.radii
        found.append(Radii(axis_vector(radii.axis), radii.origin, radii.low, radii.high))
    if group.box:
        found.append(Box(group.box.low, group.box.high))
    if group.nearest:
        found.append(Nearest(group.nearest.point, group.nearest.angle))
    if group.facing:
        found.append(Facing(axis_vector(group.facing.direction), group.facing.angle))
    if group.faces:
        word = "face" if tagged.dim == 3 else "edge"
        faces = tuple(f"{word} {number}" for number in group.faces)
        found.append(Named(faces, tagged.facets_of(faces, f"groups.{name}.faces")))
    if group.facets:
        facets = tagged.facets_of(group.facets, f"groups.{name}.facets")
        found.append(Named(group.facets, facets))
    return found
