"""From the contact section of a study to the patches of a mesh and the surfaces they can meet."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import TypeVar

import numpy as np

from fenics_nnm.arrays import Array, Complex, in_space
from fenics_nnm.casing import Passing, Surface, Turning
from fenics_nnm.errors import GeometryError, ModelError
from fenics_nnm.fem.direction import Direction
from fenics_nnm.fem.mesh import TaggedMesh
from fenics_nnm.fem.parallel import on_root
from fenics_nnm.fem.patch_sites import Field, Nearing, Opposite, Passed, Patch, standing
from fenics_nnm.study import MeshStudy
from fenics_nnm.study.contact import PatchSection
from fenics_nnm.study.loading import RotationSection
from fenics_nnm.study.record import axis_vector, fitted

Result = TypeVar("Result")


def contact_patches(study: MeshStudy, tagged: TaggedMesh) -> tuple[Patch, ...]:
    """Patches of a study on its mesh; called on all ranks.

    Raises:
        MeshError: if the mesh lacks a group.
        ModelError: if a vector does not fit the dimension of the mesh.
        GeometryError: if a casing cannot be made, or its table not read.
    """
    rotation = study.rotation
    return tuple(_patch(*each, tagged, rotation) for each in study.contact.patches.items())


def _patch(
    key: str, patch: PatchSection, tagged: TaggedMesh, rotation: RotationSection | None
) -> Patch:
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
        surface = on_root(comm, _naming, f"{key}.casing", made.surface)
    gap: Field | None = _gap(key, patch, surface)
    passing: Passed = standing
    if casing is not None and casing.passing_order and rotation is not None:
        passed = on_root(
            tagged.mesh.comm, _naming, f"{key}.casing", partial(casing.passing, _turning(rotation))
        )
        gap, passing = _mean_gap(key, casing.clearance, passed), _amplitudes(passed)
    return Patch(
        key=key,
        name=patch.name or ", ".join(patch.facets),
        facets=facets,
        what=_quoted(patch.facets),
        direction=_direction(key, patch, tagged.dim, surface),
        gap=gap,
        count=None if patch.points == "all" else patch.points,
        opposite=opposite,
        averaged=patch.rows == "averaged",
        nearing=None if patch.gap is None else _nearing(key, patch, tagged.dim),
        passing=passing,
    )


def _turning(rotation: RotationSection) -> Turning:
    """How a body turns, in the sense of its speed."""
    axis = np.array(axis_vector(rotation.axis)) * np.copysign(1.0, rotation.omega)
    return Turning(np.array(rotation.origin), axis)


def _mean_gap(key: str, clearance: float, passed: Passing) -> Field:
    """Mean gaps in a turn at points along unit vectors."""

    def mean(points: Array, directions: Array) -> Array:
        def measured() -> Array:
            return passed.mean(in_space(points), in_space(directions)) + clearance

        return _naming(f"{key}.casing", measured)

    return mean


def _amplitudes(passed: Passing) -> Passed:
    """Complex amplitudes in m by the multiple of the speed."""

    def found(points: Array, directions: Array) -> Mapping[int, Complex]:
        parts = passed.amplitudes(points, directions)
        return dict(zip(passed.multiples, parts, strict=True))

    return found


def _nearing(key: str, patch: PatchSection, dim: int) -> Nearing:
    """How much nearer to an obstacle points come that are moved, which is at a given gap before.

    Towards an axis it is what the distance from it grows by, else the motion along the direction.
    """
    if patch.direction != "radial":
        return lambda points, places, directions: np.sum((places - points) * directions, axis=1)
    radial = _radial(key, patch, dim)
    return lambda points, places, directions: radial.distance(places) - radial.distance(points)


def _radial(key: str, patch: PatchSection, dim: int) -> Direction:
    origin = fitted(patch.origin or (0.0,) * dim, dim, f"{key}.origin")
    out_of_plane = dim == 2 and not any(patch.axis_vector[:2])
    axis = () if out_of_plane else fitted(patch.axis_vector, dim, f"{key}.axis")
    return Direction("radial", axis, origin, key)


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
        return _radial(key, patch, dim).at
    vector = fitted(patch.direction, dim, f"{key}.direction")
    return Direction("vector", vector, key=key).at


def _naming(key: str, work: Callable[[], Result]) -> Result:
    """Do work whose errors are about a key of the study file."""
    try:
        return work()
    except GeometryError as error:
        raise GeometryError(f"{key}: {error}") from error


def _quoted(names: tuple[str, ...]) -> str:
    return ", ".join(f'"{name}"' for name in names)
