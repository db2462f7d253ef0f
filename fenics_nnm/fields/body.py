"""What the field files of one branch share: the mesh, and the way to stresses on it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.fields.recovery import StressRecovery, field_mesh, stress_recovery
from fenics_nnm.fields.vtu import GridFile, grid_file
from fenics_nnm.output.stored_branch import StoredBranch

#: Displacements whose stresses are recovered together.
_AT_ONCE = 4


@dataclass(frozen=True, slots=True)
class FieldBody:
    """The body of a branch as field files show it.

    Attributes:
        grid: Grid of the files; nodes at which materials meet are there once for each material.
        recovery: From displacements at its nodes to stresses there.
    """

    grid: GridFile
    recovery: StressRecovery

    def on_grid(self, values: Array) -> Array:
        """Values at the nodes of the branch's mesh, (n, ...), at those of the grid."""
        return values[self.recovery.mesh.origin]

    def stress(self, displacement: Array) -> Array:
        """Stress in Pa at the nodes of the grid of a displacement (n, dim) in m of the mesh."""
        return self.recovery.at_nodes(self.on_grid(displacement))

    def stresses(self, displacements: Array) -> Array:
        """Stress of each of k displacements, shape (k, n, dim), at the nodes: (k, nodes, 6)."""
        found = np.empty((len(displacements), self.grid.nodes, 6))
        for start in range(0, len(displacements), _AT_ONCE):
            few = displacements[start : start + _AT_ONCE, self.recovery.mesh.origin]
            found[start : start + _AT_ONCE] = self.recovery.at_nodes_of_each(few)
        return found


def field_body(branch: StoredBranch) -> FieldBody:
    """Prepare the files of a branch."""
    mesh = field_mesh(branch.nodes, branch.cells, branch.cell_type, branch.region)
    grid = grid_file(mesh.nodes, mesh.cells, mesh.cell.written)
    return FieldBody(grid, stress_recovery(mesh, branch.elasticity[branch.elasticity_row]))
