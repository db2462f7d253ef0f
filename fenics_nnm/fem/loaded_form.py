"""What steady loads and large deflection add to the linear equations of a body, in UFL.

Total Lagrangian, St. Venant and Kirchhoff's law S = C : (E - E_T) with Green and Lagrange's strain
E = sym(grad u) + grad u^T grad u / 2, about the unloaded body. With P the projection normal to
the axis of rotation and o a point on it, the residual is

    r(u; v) = int S : sym(F^T grad v) dx - Omega^2 int rho P (X - o + u) . v dx - pressures

(for instance Bonet and Wood, Nonlinear Continuum Mechanics, 2nd ed., chapter 8). It is split into
K u, with the stiffness that is assembled anyway, and the rest N(u; v), which is here: its internal
part is free of terms that are linear in u, so that K + dN/du is K to the last bit without loads.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np
import ufl
from dolfinx import fem

from fenics_nnm.errors import Code, ModelError
from fenics_nnm.fem.compat import coordinate_element
from fenics_nnm.fem.loads import Loads, Pressure, Rotation
from fenics_nnm.fem.pressed import pressed
from fenics_nnm.fem.solid import Solid
from fenics_nnm.fem.stress import Expr, stress_of_strain, thermal_stress
from fenics_nnm.fem.warming import Warming
from fenics_nnm.materials.material import Material

#: Largest strain of warming.
_LARGEST_STRAIN = 0.1

#: Cells that a linear map makes of the reference cell, where their edges are straight.
SIMPLICES = ("interval", "triangle", "tetrahedron")


def rest_form(solid: Solid, loads: Loads, u: fem.Function, level: fem.Constant) -> Expr:
    """N(u; v): the residual without K u, point forces and what is attached.

    Args:
        solid: Assembled body, without loads.
        loads: Loads.
        u: Displacement in m.
        level: Part of the loads that acts, from 0 to 1.

    Raises:
        MeshError: if a pressure acts inside the body, or on facets that are not there.
        ModelError: if a material has no thermal expansion where there is a temperature.
    """
    v = ufl.TestFunction(solid.space)
    form = large_deflection(solid, u, v)
    if loads.warming.any:
        form -= _thermal(solid, loads.warming, u, v, level)
    if loads.rotation is not None and loads.speed:
        form -= _centrifugal(solid, loads.rotation, u, v, level)
    for pressing_one in pressing(solid, loads.pressures, u, v, level):
        form += pressing_one
    return form


def large_deflection(solid: Solid, u: fem.Function, v: Expr) -> Expr:
    """Int S(E) : sym(F^T grad v) - S(sym grad u) : sym(grad v) dx, without cancellation."""
    mesh, theory = solid.tagged.mesh, solid.body.theory
    extent = fem.Constant(mesh, float(solid.body.extent))
    slope, test = ufl.grad(u), ufl.grad(v)
    second = slope.T * slope / 2
    whole = ufl.sym(slope) + second

    def integrand(material: Material) -> Expr:
        def stress(strain: Expr) -> Expr:
            return stress_of_strain(strain, material, theory, mesh)

        return extent * ufl.inner(slope * stress(whole) + stress(second), test)

    return _integral(solid, integrand)


def _thermal(solid: Solid, warming: Warming, u: fem.Function, v: Expr, level: fem.Constant) -> Expr:
    """Int (C : E_T) : sym(F^T grad v) dx."""
    mesh, theory = solid.tagged.mesh, solid.body.theory
    factor = level * warming.expression(mesh, solid.body.extent)
    F = ufl.Identity(solid.tagged.dim) + ufl.grad(u)
    change = ufl.sym(F.T * ufl.grad(v))

    def integrand(material: Material) -> Expr:
        _assert_small(max(warming.span, key=abs), material)
        return factor * ufl.inner(thermal_stress(material, theory, mesh), change)

    return _integral(solid, integrand)


def _assert_small(warming: float, material: Material) -> None:
    """Refuse warming in K that strains a material more than a linear law holds for.

    Raises:
        ModelError: if it does.
    """
    strain = abs(warming) * max(map(abs, material.expansion or (0.0,)))
    if strain > _LARGEST_STRAIN:
        raise ModelError(
            f"the change of temperature, {warming:+g} K, strains the material by {strain:.3g}: "
            f"must be {_LARGEST_STRAIN:g} at most",
            code=Code.WARMING,
        )


def _centrifugal(
    solid: Solid, rotation: Rotation, u: fem.Function, v: Expr, level: fem.Constant
) -> Expr:
    """Omega^2 int rho P (X - o + u) . v dx."""
    mesh, dim = solid.tagged.mesh, solid.tagged.dim
    P = fem.Constant(mesh, np.ascontiguousarray(rotation.normal[:dim, :dim]))
    x, origin = ufl.SpatialCoordinate(mesh), rotation.origin
    moved = ufl.as_vector([x[i] - float(origin[i]) + u[i] for i in range(dim)])
    force = ufl.dot(P * moved, v)

    def integrand(material: Material) -> Expr:
        value = material.density * solid.body.extent * rotation.speed**2
        return level * fem.Constant(mesh, float(value)) * force

    points = 2 * solid.body.degree + (coordinate_element(mesh).degree > 1)
    return solid.regions.integral(integrand, solid.body.degree, points)


def pressing(
    solid: Solid, pressures: Sequence[Pressure], u: fem.Function, v: Expr, level: fem.Constant
) -> Iterator[Expr]:
    """Int p n . v dA of each pressure, on the surface as it was or on the deformed one.

    The deformed one is that of Nanson's relation.
    """
    mesh, dim = solid.tagged.mesh, solid.tagged.dim
    normal, F = ufl.FacetNormal(mesh), ufl.Identity(dim) + ufl.grad(u)
    turned = ufl.det(F) * ufl.inv(F).T * normal if dim > 1 else normal
    for pressure, ds in zip(pressures, pressed(solid, pressures), strict=True):
        factor = level * fem.Constant(mesh, float(pressure.value * solid.body.extent))
        along = turned if pressure.follower else normal
        yield factor * ufl.dot(along, v) * ds(degree=4 * solid.body.degree)


def _integral(solid: Solid, integrand: Callable[[Material], Expr]) -> Expr:
    """Integral over all materials, with points for large deflection."""
    points = points_of_large_deflection(solid)
    return solid.regions.integral(integrand, solid.body.degree, points)


def points_of_large_deflection(solid: Solid) -> int:
    """Degree of the quadrature for terms of the fourth degree in grad u.

    On simplices with straight edges these are polynomials of degree 4 (p - 1). On other cells they
    are none, and a rule that is exact for two degrees more than mass and stiffness need is taken.
    """
    degree = solid.body.degree
    mesh = solid.tagged.mesh
    straight = mesh.topology.cell_name() in SIMPLICES and coordinate_element(mesh).degree == 1
    turns = any(material.turns for material, _ in solid.regions.parts)
    return 4 * (degree - 1) if straight and not turns else 2 * degree + 2
