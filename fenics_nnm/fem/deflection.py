"""Second and third derivatives of the internal force of a body at its state of rest."""

from __future__ import annotations

import numpy as np
import ufl
from dolfinx import fem
from dolfinx.fem.petsc import assemble_vector
from petsc4py import PETSc

from fenics_nnm.arrays import Array
from fenics_nnm.fem.loaded_form import large_deflection, pressing
from fenics_nnm.fem.solid import Solid


class BodyDeflection:
    """f''(u_s)[a, b] and f'''(u_s)[a, b, c] of a body, by derivatives of its residual's form."""

    def __init__(self, solid: Solid) -> None:
        """Prepare for a body about its static state, or unloaded."""
        self._solid = solid
        u = fem.Function(solid.space) if solid.state is None else solid.state.displacement
        v, whole = ufl.TestFunction(solid.space), fem.Constant(solid.tagged.mesh, 1.0)
        form = large_deflection(solid, u, v)
        for pressure in solid.state.loads.pressures if solid.state else ():
            if pressure.follower:
                form += pressing(solid, pressure, u, v, whole)
        self._along = tuple(fem.Function(solid.space) for _ in range(3))
        a, b, c = self._along
        second = ufl.derivative(ufl.derivative(form, u, a), u, b)
        self._second = fem.form(second)
        self._third = fem.form(ufl.derivative(second, u, c))

    def second(self, a: Array, b: Array) -> Array:
        """f''[a, b] in N of displacements at the owned degrees of freedom; on all ranks."""
        return self._assembled(self._second, (a, b))

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
