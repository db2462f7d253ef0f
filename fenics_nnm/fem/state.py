"""Where a body rests under steady loads."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from dolfinx import fem
from petsc4py import PETSc

from fenics_nnm.arrays import Array
from fenics_nnm.fem.loads import Loads


@dataclass(frozen=True, slots=True)
class StaticState:
    """Where a body rests under steady loads, geometrically exact.

    Attributes:
        loads: Loads.
        displacement: u_s in m, from the unloaded body.
        unloaded: K of the unloaded body in N/m.
        steps: Solutions of linear equations that it took, of all load steps together.
        load_steps: Steps in which the loads were applied.
        asymmetry: Norm of the part of the stiffness that is not symmetric (of follower pressures),
            which is left out, over what the loads change in the stiffness.
    """

    loads: Loads
    displacement: fem.Function
    unloaded: PETSc.Mat
    steps: int
    load_steps: int
    asymmetry: float = 0.0

    def owned(self, count: int) -> Array:
        """u_s in m at the owned degrees of freedom, shape (n_owned,)."""
        return np.array(self.displacement.x.array[:count])
