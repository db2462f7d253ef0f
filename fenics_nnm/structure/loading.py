"""From the sections of a study about steady loads to the loads of its body."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from fenics_nnm.arrays import in_space
from fenics_nnm.errors import MeshError, ModelError
from fenics_nnm.fem.attachment import Attachment
from fenics_nnm.fem.contact_sites import ContactSites
from fenics_nnm.fem.loads import Loads, Pressure, Rotation
from fenics_nnm.fem.mesh import TaggedMesh
from fenics_nnm.fem.patch_sites import Patch
from fenics_nnm.fem.solid import Solid
from fenics_nnm.structure.temperature import warming_of
from fenics_nnm.study import MeshStudy
from fenics_nnm.study.loading import LoadSection, RotationSection
from fenics_nnm.study.record import axis_vector, fitted

#: A point is on the axis within this part of the distances of others from a point on the axis.
_ON_AXIS = 1e-9

#: A component of a projection, or a distance in m, that is zero to round-off.
_ZERO = 1e-12


def loads_of(study: MeshStudy, solid: Solid) -> Loads:
    """The steady loads of a study on its assembled body; none at rest. To be called on all ranks.

    Raises:
        GeometryError, ModelError: as `structure.temperature.warming_of`.
        ModelError: if a vector does not fit the dimension, or a centrifugal force leaves it.
    """
    dim = solid.tagged.dim
    rotation = _rotation(study.rotation, dim) if study.rotation else None
    if study.load is None:
        return Loads(rotation)
    pressures = tuple(_pressures(study.load))
    forces = tuple(_forces(study.load, dim))
    return Loads(rotation, warming_of(study.load, solid), pressures, forces)


def assert_off_axis(loads: Loads, sites: ContactSites) -> None:
    """Refuse an axis of rotation that runs through vertices that touch.

    Raises:
        ModelError: if it does.
    """
    if loads.rotation is None:
        return
    points = in_space(np.concatenate([part.points for part in sites.parts]))
    away = np.linalg.norm(loads.rotation.arm(points), axis=1)
    nearest = int(np.argmin(away))
    size = float(np.linalg.norm(points - np.array(loads.rotation.origin), axis=1).max())
    if away[nearest] <= _ON_AXIS * size:
        place = ", ".join(f"{x:.6g}" for x in points[nearest])
        raise ModelError(
            f"rotation.axis: runs through the contact facets at ({place}) m: must not meet facets "
            "that touch"
        )


def assert_followers_apart(loads: Loads, tagged: TaggedMesh, patches: Sequence[Patch]) -> None:
    """Refuse pressures that follow a surface which touches; called on all ranks.

    Raises:
        MeshError: if a facet of one is also a contact facet, or is not there.
    """
    for each in loads.pressures:
        what = f"{each.key}.facets"
        facets = tagged.facets_of(each.facets, what)
        for patch in patches:
            sides = [patch.facets] + ([patch.opposite.facets] if patch.opposite else [])
            shared = len(np.intersect1d(facets, np.concatenate(sides)))
            if each.follower and tagged.mesh.comm.allreduce(shared):
                raise MeshError(
                    f"{what} = {', '.join(each.facets)}: has facets of {patch.key}: a follower "
                    "pressure must not act on facets that touch"
                )


def _rotation(section: RotationSection, dim: int) -> Rotation:
    x, y, z = axis_vector(section.axis)
    found = Rotation((x, y, z), section.origin, section.omega, section.coriolis)
    _assert_within(found, dim)
    return found


def _assert_within(rotation: Rotation, dim: int) -> None:
    """Refuse an axis whose centrifugal force leaves the dimensions of a body, or has no part there.

    Raises:
        ModelError: if it is such an axis.
    """
    P, out, axis = rotation.normal, slice(dim, 3), list(rotation.axis)
    offset = np.abs((P @ np.array(rotation.origin))[out]).max(initial=0.0)
    if np.abs(P[out, :dim]).max(initial=0.0) > _ZERO or offset > _ZERO:
        needs = "normal to x and through y = z = 0" if dim == 1 else "z, or lie in z = 0"
        raise ModelError(
            f"rotation.axis = {axis} through rotation.origin = {list(rotation.origin)}: its "
            f"centrifugal force leaves the {dim} dimensions of the mesh: must be {needs}"
        )
    if np.abs(P[:dim, :dim]).max() <= _ZERO:
        raise ModelError(
            f"rotation.axis = {axis}: the body lies along it, so that speed has no effect: must "
            "not be along x"
        )


def _pressures(load: LoadSection) -> Iterator[Pressure]:
    for number, each in enumerate(load.pressure, start=1):
        yield Pressure(f"load.pressure[{number}]", each.facets, each.pressure, each.follower)


def _forces(load: LoadSection, dim: int) -> Iterator[Attachment]:
    for number, each in enumerate(load.force, start=1):
        key = f"load.force[{number}]"
        point = () if each.at is None else fitted(each.at, dim, f"{key}.at")
        force = fitted(each.force, dim, f"{key}.force")
        yield Attachment(key, "force", force, point, each.facets or ())
