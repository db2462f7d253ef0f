"""Stress of a displacement in one material, in UFL."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Literal, NamedTuple

import numpy as np
import ufl
from dolfinx import fem
from dolfinx import mesh as dmesh

from fenics_nnm.arrays import Array
from fenics_nnm.errors import Code, ModelError
from fenics_nnm.materials.elasticity import (
    IN_PLANE,
    PLACES,
    Isotropic,
    Orthotropic,
    plane_strain,
    plane_stress,
    rotated,
    uniaxial,
)
from fenics_nnm.materials.material import Material
from fenics_nnm.materials.orientation import XYZ, Axes, Cylindrical, Orientation

Theory = Literal["rod", "plane-stress", "plane-strain", "solid"]

Expr = Any
"""An expression of UFL."""

#: Places of the components that each dimension has.
STRAINS_OF = {1: PLACES[:1], 2: tuple(PLACES[i] for i in IN_PLANE), 3: PLACES}


class _Stress(NamedTuple):
    """Stress of a theory, and the stress along z that plane strain needs; None for others."""

    plane: Expr
    along: Expr | None


def strain(u: Expr) -> Expr:
    """Small-strain tensor of a displacement."""
    return ufl.sym(ufl.grad(u))


def stress(u: Expr, material: Material, theory: Theory, mesh: dmesh.Mesh) -> Expr:
    """Stress in Pa that does work on the strains of the theory, a (dim, dim) tensor.

    Plane theories take the three-dimensional law without stress on the plane, or without
    strain along z; a rod has the stress E u', with E = 1 / S_11 in its direction.

    Raises:
        ModelError: if the material's orientation does not go with the theory.
    """
    return stress_of_strain(strain(u), material, theory, mesh)


def stress_of_strain(epsilon: Expr, material: Material, theory: Theory, mesh: dmesh.Mesh) -> Expr:
    """The same of a strain tensor (dim, dim), be it the small one or that of Green and Lagrange."""
    return _stress_of(epsilon, material, theory, mesh).plane


def constant_law(material: Material, theory: Theory) -> Array:
    """Stress by strain of a material that does not turn, with engineering shear strains.

    Components are those of `STRAINS_OF`; in Pa, shape (m, m).

    Raises:
        ModelError: if the material's orientation does not go with the theory.
    """
    law, axes = material.law, material.orientation if material.law.directional else XYZ
    return _reduced(_FIXED_AXES_OF[type(axes)](law.stiffness, axes), theory)


def thermal_stress(material: Material, theory: Theory, mesh: dmesh.Mesh) -> Expr:
    """Stress in Pa per kelvin that would suppress thermal expansion, a (dim, dim) tensor.

    Raises:
        ModelError: if the expansion of the material is not known.
    """
    return _thermal(material, theory, mesh).plane


def cauchy_stress(u: Expr, material: Material, theory: Theory, mesh: dmesh.Mesh) -> Expr:
    """Stress in Pa as a 3 x 3 tensor, with sigma_zz of plane strain."""
    return strain_stress(strain(u), material, theory, mesh)


def strain_stress(epsilon: Expr, material: Material, theory: Theory, mesh: dmesh.Mesh) -> Expr:
    """The same of a strain tensor."""
    return _in_space(_stress_of(epsilon, material, theory, mesh), theory)


def warm_stress(
    epsilon: Expr, warming: Expr, material: Material, theory: Theory, mesh: dmesh.Mesh
) -> Expr:
    """The same of a strain tensor at a temperature, in K above that without stress.

    Raises:
        ModelError: if the expansion of the material is not known.
    """
    found = strain_stress(epsilon, material, theory, mesh)
    return found - warming * _in_space(_thermal(material, theory, mesh), theory)


def _in_space(stress: _Stress, theory: Theory) -> Expr:
    """A stress as a 3 x 3 tensor."""
    if theory == "solid":
        return stress.plane
    size = stress.plane.ufl_shape[0]
    rows = [[stress.plane[i, j] if max(i, j) < size else 0 for j in range(3)] for i in range(3)]
    if theory == "plane-strain":
        rows[2][2] = stress.along
    return ufl.as_tensor(rows)


def assert_off_axis(material: Material, points: Array) -> None:
    """Refuse cylindrical material axes where they are not defined: on their axis.

    Args:
        material: Material.
        points: Points of its part of the body on this rank in m, shape (n, 3).

    Raises:
        ModelError: if a point is on the axis.
    """
    if material.law.directional and np.any(material.orientation.undefined_at(points)):
        raise ModelError(
            "cylindrical axes: the axis runs through the material, where the radial direction is "
            "not defined: must lie outside",
            code=Code.CYLINDRICAL_AXES,
        )


def _stress_of(epsilon: Expr, material: Material, theory: Theory, mesh: dmesh.Mesh) -> _Stress:
    law = material.law
    return _STRESS_OF[type(law)](epsilon, law, material.orientation, theory, mesh)


def _isotropic(
    epsilon: Expr, law: Isotropic, turning: Orientation, theory: Theory, mesh: dmesh.Mesh
) -> _Stress:
    """Hooke's law, whatever the orientation."""
    plane = _hooke(epsilon, law, theory, mesh)
    if theory != "plane-strain":
        return _Stress(plane, None)
    # tr(sigma) / 2 = (lambda + mu) tr(strain), and lambda / (lambda + mu) = 2 nu
    return _Stress(plane, fem.Constant(mesh, float(law.poisson)) * ufl.tr(plane))


def _hooke(epsilon: Expr, law: Isotropic, theory: Theory, mesh: dmesh.Mesh) -> Expr:
    """Hooke's law; in plane stress 2 lambda mu / (lambda + 2 mu) takes the place of lambda."""
    if theory == "rod":
        return fem.Constant(mesh, float(law.young)) * epsilon
    lam, mu = law.lame
    if theory == "plane-stress":
        lam = law.young * law.poisson / (1 - law.poisson**2)
    first, second = fem.Constant(mesh, float(lam)), fem.Constant(mesh, float(2 * mu))
    return first * ufl.tr(epsilon) * ufl.Identity(epsilon.ufl_shape[0]) + second * epsilon


def _anisotropic(
    epsilon: Expr, law: Orthotropic, turning: Orientation, theory: Theory, mesh: dmesh.Mesh
) -> _Stress:
    """The law in its material axes."""
    return _IN_AXES_OF[type(turning)](epsilon, law.stiffness, turning, theory, mesh)


def _in_fixed_axes(
    epsilon: Expr, stiffness: Array, axes: Axes, theory: Theory, mesh: dmesh.Mesh
) -> _Stress:
    return _linear(epsilon, rotated(stiffness, axes.matrix), theory, mesh)


def _in_cylindrical_axes(
    epsilon: Expr, stiffness: Array, turning: Cylindrical, theory: Theory, mesh: dmesh.Mesh
) -> _Stress:
    local = _cylindrical_axes(turning, mesh)
    found = _linear(local * epsilon * local.T, stiffness, theory, mesh)
    return _Stress(local.T * found.plane * local, found.along)


def _linear(epsilon: Expr, stiffness: Array, theory: Theory, mesh: dmesh.Mesh) -> _Stress:
    """The stress of a strain by a matrix of shape (6, 6), both in the same axes."""
    places = STRAINS_OF[epsilon.ufl_shape[0]]
    strains = ufl.as_vector([(1 if i == j else 2) * epsilon[i, j] for i, j in places])
    sigma = _symmetric(
        fem.Constant(mesh, np.ascontiguousarray(_reduced(stiffness, theory))) * strains, places
    )
    along = None
    if theory == "plane-strain":
        along = ufl.dot(fem.Constant(mesh, stiffness[2, list(IN_PLANE)]), strains)
    return _Stress(sigma, along)


def _reduced(stiffness: Array, theory: Theory) -> Array:
    """The law of a theory: of strains that it has to stresses that work on them."""
    if theory == "rod":
        return np.array([[uniaxial(stiffness)]])
    if theory == "plane-stress":
        return plane_stress(stiffness)
    return plane_strain(stiffness) if theory == "plane-strain" else stiffness


def _symmetric(components: Expr, places: tuple[tuple[int, int], ...]) -> Expr:
    number = {place: index for index, place in enumerate(places)}
    size = 1 + max(i for i, _ in places)
    return ufl.as_tensor(
        [[components[number[min(i, j), max(i, j)]] for j in range(size)] for i in range(size)]
    )


def _cylindrical_axes(turning: Cylindrical, mesh: dmesh.Mesh) -> Expr:
    """Rows e_r, e_theta and, in three dimensions, e_axis at each point."""
    dim, axis = mesh.geometry.dim, turning.unit
    if dim == 1 or (dim == 2 and np.any(axis[:2])):
        needs = "a body in 2-D or 3-D" if dim == 1 else "the axis z in 2-D"
        raise ModelError(
            f"cylindrical axes: axis = {list(turning.axis)}: needs {needs}",
            code=Code.CYLINDRICAL_AXES,
        )
    x, origin = ufl.SpatialCoordinate(mesh), turning.origin
    away = ufl.as_vector([x[i] - float(origin[i]) if i < dim else 0.0 for i in range(3)])
    along = ufl.as_vector([float(a) for a in axis])
    radial = away - ufl.dot(away, along) * along
    # on the axis the length is kept from 0, since other materials may lie there
    radial = radial / ufl.sqrt(ufl.max_value(ufl.dot(radial, radial), np.finfo(float).tiny))
    hoop = ufl.cross(along, radial)
    rows = [radial, hoop, along][:dim]
    return ufl.as_matrix([[row[i] for i in range(dim)] for row in rows])


def _thermal(material: Material, theory: Theory, mesh: dmesh.Mesh) -> _Stress:
    """Stress per kelvin that would suppress thermal expansion."""
    if material.expansion is None:
        called = f' "{material.name}"' if material.name else ""
        raise ModelError(
            f"no thermal expansion is known of the material{called}: a temperature needs it",
            code=Code.EXPANSION,
        )
    law, turning = material.law, material.orientation if material.law.directional else XYZ
    return _THERMAL_IN_AXES_OF[type(turning)](
        law.stiffness, np.diag(material.expansion), turning, theory, mesh
    )


def _thermal_in_fixed_axes(
    stiffness: Array, expansion: Array, axes: Axes, theory: Theory, mesh: dmesh.Mesh
) -> _Stress:
    turned = axes.matrix.T @ expansion @ axes.matrix
    return _suppressing(rotated(stiffness, axes.matrix), turned, theory, mesh)


def _thermal_in_cylindrical_axes(
    stiffness: Array, expansion: Array, turning: Cylindrical, theory: Theory, mesh: dmesh.Mesh
) -> _Stress:
    local = _cylindrical_axes(turning, mesh)
    found = _suppressing(stiffness, expansion, theory, mesh)
    return _Stress(local.T * found.plane * local, found.along)


def _suppressing(stiffness: Array, expansion: Array, theory: Theory, mesh: dmesh.Mesh) -> _Stress:
    """Stress of a constant strain (3, 3) that a theory allows, both in the same axes."""
    strains = np.array([(1 if i == j else 2) * expansion[i, j] for i, j in PLACES])
    places = STRAINS_OF[mesh.geometry.dim]
    kept = [PLACES.index(place) for place in places]
    along = None
    if theory in ("rod", "plane-stress"):
        components = _reduced(stiffness, theory) @ strains[kept]
    else:  # where the strain along z is kept from arising, so that it makes stress, too
        _reduced(stiffness, theory)  # refuses an orientation that does not go with the theory
        whole = stiffness @ strains
        components, along = whole[kept], fem.Constant(mesh, float(whole[2]))
    plane = _symmetric(fem.Constant(mesh, np.ascontiguousarray(components)), places)
    return _Stress(plane, along)


#: The stress of each law, and that of an anisotropic one by its orientation.
_STRESS_OF: Mapping[type, Callable[..., _Stress]] = {
    Isotropic: _isotropic,
    Orthotropic: _anisotropic,
}
_IN_AXES_OF: Mapping[type, Callable[..., _Stress]] = {
    Axes: _in_fixed_axes,
    Cylindrical: _in_cylindrical_axes,
}

#: The stiffness in global axes by the orientation of axes that do not turn.
_FIXED_AXES_OF: Mapping[type, Callable[..., Array]] = {
    Axes: lambda stiffness, axes: rotated(stiffness, axes.matrix),
}

#: Thermal stress by the orientation of the axes.
_THERMAL_IN_AXES_OF: Mapping[type, Callable[..., Expr]] = {
    Axes: _thermal_in_fixed_axes,
    Cylindrical: _thermal_in_cylindrical_axes,
}
