"""Residual and tangent stiffness of a body under steady loads, assembled."""

from __future__ import annotations

import numpy as np
import ufl
from dolfinx import fem
from dolfinx.fem.petsc import assemble_matrix, assemble_vector
from petsc4py import PETSc

from fenics_nnm.arrays import Array
from fenics_nnm.fem.jit import quick
from fenics_nnm.fem.loaded_form import rest_form
from fenics_nnm.fem.loads import Loads
from fenics_nnm.fem.point_loads import point_loads
from fenics_nnm.fem.solid import Solid


class LoadedResidual:
    """r(u) = K u + N(u) - level (f + D u), and its derivative by u.

    Attributes:
        displacement: u in m.
        tangent: The derivative where it was assembled last, its symmetric part.
        asymmetry: Norm of the other part over that of the derivative of N.
    """

    def __init__(self, solid: Solid, loads: Loads) -> None:
        """Prepare for a body, without loads yet.

        Args:
            solid: Assembled body, without loads.
            loads: Loads.

        Raises:
            MeshError, ModelError: if a load does not go with the body.
        """
        self._solid, self._loads = solid, loads
        self.displacement = fem.Function(solid.space)
        self._level = fem.Constant(solid.tagged.mesh, 0.0)
        form = rest_form(solid, loads, self.displacement, self._level)
        self._rest = fem.form(form, jit_options=quick())
        slope = ufl.derivative(form, self.displacement)
        self._slope = fem.form(slope, jit_options=quick())
        self._points = point_loads(solid, loads)
        self.tangent: PETSc.Mat = solid.stiffness.duplicate()
        self.asymmetry = 0.0

    @property
    def owned(self) -> Array:
        """U at the owned degrees of freedom, to read; `move` changes it."""
        values: Array = self.displacement.x.array[: self._solid.owned]
        return values

    def apply(self, level: float) -> None:
        """Let a part of the loads act, from 0 to 1."""
        self._level.value = level

    def move(self, displacement: Array) -> None:
        """Set u at the owned degrees of freedom."""
        self.displacement.x.array[: self._solid.owned] = displacement
        self.displacement.x.scatter_forward()

    def norm(self, owned: Array) -> float:
        """Euclidean norm of values at the owned degrees of freedom."""
        return float(np.sqrt(self._solid.tagged.mesh.comm.allreduce(owned @ owned)))

    def value(self) -> Array:
        """r(u) in N at the owned degrees of freedom, zero where they are held."""
        moved, pulled = self._solid.stiffness.createVecs()
        moved.array[:] = self.owned
        self._solid.stiffness.mult(moved, pulled)
        found = self._free(self._without_stiffness() + pulled.array)
        moved.destroy()
        pulled.destroy()
        return found

    def rest(self) -> Array:
        """r(u) - K u in N at the owned degrees of freedom, zero where they are held."""
        return self._free(self._without_stiffness())

    def _without_stiffness(self) -> Array:
        vector = assemble_vector(self._rest)
        vector.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)
        found = np.array(vector.array)
        vector.destroy()
        return found - float(self._level.value) * self._points.forces(self.owned)

    def _free(self, force: Array) -> Array:
        """A force, changed in place to zero where the body is held."""
        force[self._solid.clamped[self._solid.clamped < self._solid.owned]] = 0.0
        return force

    def assemble(self) -> PETSc.Mat:
        """The symmetric part of K + dN/du - level D, as `tangent`."""
        stiffness, same = self._solid.stiffness, PETSc.Mat.Structure.SAME_NONZERO_PATTERN
        stiffness.copy(self.tangent, same)
        assemble_matrix(self.tangent, self._slope, self._solid.held, 1.0)
        self.tangent.assemble()
        self._points.add_slope(self.tangent, -float(self._level.value))
        if self._loads.follows:
            self.asymmetry = _made_symmetric(self.tangent, stiffness)
        self.tangent.setOption(PETSc.Mat.Option.SYMMETRIC, True)
        return self.tangent


def _made_symmetric(matrix: PETSc.Mat, stiffness: PETSc.Mat) -> float:
    """Replace a matrix by its symmetric part; the norm of the other one over that of N's slope."""
    same = PETSc.Mat.Structure.SAME_NONZERO_PATTERN
    slope, difference = matrix.copy(), PETSc.Mat()
    slope.axpy(-1.0, stiffness, same)
    matrix.transpose(difference)
    difference.axpy(-1.0, matrix, same)
    matrix.axpy(0.5, difference, same)
    whole, part = float(slope.norm()), float(difference.norm()) / 2
    slope.destroy()
    difference.destroy()
    return part / whole if whole else 0.0
