"""Second and third derivatives of the internal force of a body at its state of rest."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property, partial

import numpy as np
import ufl
from dolfinx import fem
from dolfinx.fem.petsc import assemble_vector
from mpi4py import MPI
from petsc4py import PETSc

from fenics_nnm.arrays import Array
from fenics_nnm.fem.cached_deflection import DeflectionKeeper
from fenics_nnm.fem.jit import quick
from fenics_nnm.fem.loaded_form import large_deflection, pressing
from fenics_nnm.fem.point_deflection import PointDeflection
from fenics_nnm.fem.solid import Solid
from fenics_nnm.fem.stress import Expr
from fenics_nnm.reduction.modal_derivatives import by_triples, polarised
from fenics_nnm.reduction.operators import Operators, Product

#: Values of so many sets of masters are kept: those of the followed mode alone, and of all.
_KEPT = 2


class BodyForces:
    """Derivatives of the internal force of a body along masters, remembered for the latest ones."""

    def __init__(self, solid: Solid) -> None:
        """Prepare for a body about its static state, or unloaded."""
        self._solid = solid
        comm = solid.tagged.mesh.comm
        self._keeper = DeflectionKeeper(solid)
        second = partial(self._keeper.kept, "second derivatives", self._pairs)
        third = partial(self._keeper.kept, "third derivatives", self._all)
        self._second, self._third = _Latest(second, comm), _Latest(third, comm)
        self._bent, self._inertia = _OfSame(), _OfSame()

    def second(self, phi: Array) -> Array:
        """f''[phi_i, phi_j] in N of shapes (n_owned, k) by their pairs; on all ranks."""
        return self._second(phi)

    def third(self, phi: Array) -> Array:
        """phi_i . f'''[phi_j, phi_k, phi_l], shape (k, k, k, k); on all ranks."""
        return self._third(phi)

    def remembering(self, operators: Operators, solver: str) -> Operators:
        """Operators that make no static displacement again for the forces of `second`.

        Contact points that are chosen anew leave these and their inertia as they are.

        Args:
            operators: Products of the body, always the same but for its contact points.
            solver: What makes its static displacements.
        """
        static, mass = operators.static, operators.mass
        static = partial(self._keeper.kept, f"static displacements by {solver}", static)
        return replace(
            operators,
            static=lambda forces: self._bent(forces, static),
            mass=lambda columns: self._inertia(columns, mass),
        )

    @cached_property
    def _forms(self) -> FormDeflection:
        return FormDeflection(self._solid)

    def _pairs(self, phi: Array) -> Array:
        return polarised(self._forms.second, self._inner, phi)

    def _all(self, phi: Array) -> Array:
        if any(material.turns for material, _ in self._solid.regions.parts):
            return by_triples(self._forms.third, self._inner, phi)
        # of n dA of a deformed surface, which is quadratic in grad u, it is zero
        return PointDeflection(self._solid).third(phi)

    def _inner(self, one: Array, other: Array) -> Array:
        return np.asarray(self._solid.tagged.mesh.comm.allreduce(one.T @ other))


class _OfSame:
    """A product whose latest value is kept for the very same columns."""

    def __init__(self) -> None:
        self._kept: tuple[Array, Array] | None = None

    def __call__(self, columns: Array, function: Product) -> Array:
        """Its value; to be called on all ranks."""
        if self._kept is None or self._kept[0] is not columns:
            self._kept = columns, function(columns)
        return self._kept[1]


class _Latest:
    """A function of shapes whose latest values are kept."""

    def __init__(self, function: Product, comm: MPI.Comm) -> None:
        self._function, self._comm = function, comm
        self._kept: list[tuple[Array, Array]] = []

    def __call__(self, phi: Array) -> Array:
        """Its value; to be called on all ranks."""
        for shapes, value in self._kept:
            if self._comm.allreduce(np.array_equal(shapes, phi), op=MPI.LAND):
                return value
        self._kept = [(phi.copy(), self._function(phi)), *self._kept[: _KEPT - 1]]
        return self._kept[0][1]


class FormDeflection:
    """f''(u_s)[a, a] and f'''(u_s)[a, b, c] of a body, by derivatives of its residual's form."""

    def __init__(self, solid: Solid) -> None:
        """Prepare for a body about its static state, or unloaded."""
        self._solid = solid
        u = fem.Function(solid.space) if solid.state is None else solid.state.displacement
        v, whole = ufl.TestFunction(solid.space), fem.Constant(solid.tagged.mesh, 1.0)
        form = large_deflection(solid, u, v)
        pressures = solid.state.loads.pressures if solid.state else ()
        following = [pressure for pressure in pressures if pressure.follower]
        for pressing_one in pressing(solid, following, u, v, whole):
            form += pressing_one
        self._along = tuple(fem.Function(solid.space) for _ in range(3))
        self._u, self._form = u, form
        self._second = fem.form(self._derivative(0, 0), jit_options=quick())

    @cached_property
    def _third(self) -> fem.Form:
        return fem.form(self._derivative(0, 1, 2), jit_options=quick())

    def _derivative(self, *along: int) -> Expr:
        """Derivative of the residual along some of the functions, one after the other."""
        found = self._form
        for each in along:
            found = ufl.derivative(found, self._u, self._along[each])
        return found

    def second(self, a: Array) -> Array:
        """f''[a, a] in N of a displacement at the owned degrees of freedom; on all ranks."""
        return self._assembled(self._second, (a,))

    def third(self, a: Array, b: Array, c: Array) -> Array:
        """f'''[a, b, c]."""
        return self._assembled(self._third, (a, b, c))

    def _assembled(self, form: fem.Form, along: tuple[Array, ...]) -> Array:
        solid = self._solid
        for function, values in zip(self._along, along, strict=False):
            function.x.array[: solid.owned] = values
            function.x.scatter_forward()
        vector = assemble_vector(form)
        vector.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)
        found = np.array(vector.array)
        vector.destroy()
        found[solid.clamped[solid.clamped < solid.owned]] = 0.0
        return found
