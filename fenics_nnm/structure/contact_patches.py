"""From the contact section of a study to the patches of a mesh and the surfaces they can meet."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TypeVar

import numpy as np

from fenics_nnm.arrays import Array, in_space
from fenics_nnm.casing import (
    Cone,
    Frame,
    LobedRadius,
    Plane,
    RadialSurface,
    Reversed,
    Surface,
    read_radii,
)
from fenics_nnm.errors import GeometryError, ModelError
from fenics_nnm.fem.contact_patch import Field, Opposite, Patch
from fenics_nnm.fem.direction import Direction
from fenics_nnm.fem.mesh import TaggedMesh
from fenics_nnm.fem.parallel import on_root
from fenics_nnm.study.casing import CasingSection
from fenics_nnm.study.contact import ContactSection, PatchesSection, PatchSection
from fenics_nnm.study.record import axis_vector, fitted

Result = TypeVar("Result")

#: Where angles about an axis begin if the study does not tell.
_ZERO = {"x": "y", "y": "z", "z": "x"}


def contact_patches(
    contact: ContactSection | PatchesSection, tagged: TaggedMesh
) -> tuple[Patch, ...]:
    """Patches of a study on its mesh; called on all ranks.

    Raises:
        MeshError: if the mesh lacks a group.
        ModelError: if a vector does not fit the dimension of the mesh.
        GeometryError: if a casing cannot be made, or its table not read.
    """
    return tuple(_patch(key, patch, tagged) for key, patch in contact.patches.items())


def _patch(key: str, patch: PatchSection, tagged: TaggedMesh) -> Patch:
    facets = tagged.facets_of(patch.facets, f"{key}.facets")
    opposite = None
    if patch.against is not None:
        against = tagged.facets_of(patch.against, f"{key}.against")
        opposite = Opposite(against, _quoted(patch.against))
    casing = patch.casing
    surface = None
    if casing is not None:
        made = casing
        comm = tagged.mesh.comm
        surface = on_root(comm, _naming, f"{key}.casing", lambda: casing_surface(made))
    return Patch(
        key=key,
        name=patch.name or ", ".join(patch.facets),
        facets=facets,
        what=_quoted(patch.facets),
        direction=_direction(key, patch, tagged.dim, surface),
        gap=_gap(key, patch, surface),
        count=None if patch.points == "all" else patch.points,
        opposite=opposite,
        averaged=patch.rows == "averaged",
    )


def casing_surface(casing: CasingSection) -> Surface:
    """The surface that a section describes.

    Raises:
        GeometryError: if its table cannot be read, or a radius is not positive.
    """
    origin = _in_space(casing.origin or ())
    if casing.shape == "plane":
        return Plane(origin, _in_space(casing.normal or ()))
    zero = casing.zero or (_ZERO[casing.axis] if isinstance(casing.axis, str) else None)
    frame = Frame(
        origin,
        _in_space(axis_vector(casing.axis)),
        _in_space(axis_vector(zero)) if zero else None,
    )
    surface = _round_surface(casing, frame)
    return Reversed(surface) if casing.body == "outside" else surface


def _round_surface(casing: CasingSection, frame: Frame) -> Surface:
    if casing.file is not None:
        return RadialSurface(frame, read_radii(casing.file))
    if casing.lobes is not None:
        assert casing.amplitude is not None
        profile = casing.profile or ()
        return RadialSurface(
            frame,
            LobedRadius(
                mean=tuple(r for _, r in profile) or (casing.radius or 0.0,),
                lobes=casing.lobes,
                amplitude=casing.amplitude,
                phase=math.radians(casing.phase_deg or 0.0),
                stations=tuple(x for x, _ in profile),
            ),
        )
    assert casing.radius is not None
    return Cone(frame, casing.radius, _slope(casing))


def _slope(casing: CasingSection) -> float:
    """Rise of the radius along the axis."""
    if casing.end_radius is not None and casing.length is not None:
        return (casing.end_radius - (casing.radius or 0.0)) / casing.length
    return math.tan(math.radians(casing.half_angle_deg or 0.0))


def _gap(key: str, patch: PatchSection, surface: Surface | None) -> Field | None:
    """Gaps at points along unit vectors; None where they are measured between facets."""
    if surface is None or patch.casing is None:
        value = patch.gap
        return None if value is None else lambda points, directions: np.full(len(points), value)
    clearance = patch.casing.clearance

    def to_casing(points: Array, directions: Array) -> Array:
        def measured() -> Array:
            return surface.distance(in_space(points), in_space(directions)) + clearance

        return _naming(f"{key}.casing", measured)

    return to_casing


def _direction(key: str, patch: PatchSection, dim: int, surface: Surface | None) -> Field:
    if patch.direction == "casing":
        assert surface is not None

        def to_casing(points: Array, normals: Array) -> Array:
            found = _naming(f"{key}.casing", lambda: surface.outward(in_space(points)))
            if np.abs(found[:, dim:]).max(initial=0.0) > 1e-9:
                raise ModelError(
                    f'{key}.direction = "casing": the normal of the casing leaves the {dim} '
                    "dimensions of the mesh: must be given as a vector"
                )
            return found[:, :dim]

        return to_casing
    if patch.direction == "normal":
        return Direction("normal", key=key).at
    if patch.direction == "radial":
        origin = fitted(patch.origin or (0.0,) * dim, dim, f"{key}.origin")
        out_of_plane = dim == 2 and not any(patch.axis_vector[:2])
        axis = () if out_of_plane else fitted(patch.axis_vector, dim, f"{key}.axis")
        return Direction("radial", axis, origin, key).at
    vector = fitted(patch.direction, dim, f"{key}.direction")
    return Direction("vector", vector, key=key).at


def _naming(key: str, work: Callable[[], Result]) -> Result:
    """Do work whose errors are about a key of the study file."""
    try:
        return work()
    except GeometryError as error:
        raise GeometryError(f"{key}: {error}") from error


def _in_space(vector: tuple[float, ...]) -> Array:
    return np.array([*vector, 0.0, 0.0, 0.0][:3])


def _quoted(names: tuple[str, ...]) -> str:
    return ", ".join(f'"{name}"' for name in names)
