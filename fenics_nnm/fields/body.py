"""What the field files of one branch share: the mesh, and the way to stresses on it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.fields.recovery import FieldMesh, StressRecovery, field_mesh, stress_recovery
from fenics_nnm.fields.vtu import GridFile, grid_file
from fenics_nnm.results.stored_branch import StoredBranch


@dataclass(frozen=True, slots=True)
class FieldBody:
    """The body of a branch as field files show it.

    Attributes:
        mesh: Mesh of the files; nodes at which materials meet are there once for each material.
        grid: The same as it is written.
        elasticity: Elasticities there are, as in `branch_file`.
        elasticity_row: Row of it at each sampling point of each cell.
        steady: Stress of steady loads in Pa at each sampling point of each cell, shape
            (cells, s, 6); none, shape (0, s, 6), without such loads.
    """

    mesh: FieldMesh
    grid: GridFile
    elasticity: Array
    elasticity_row: Indices
    steady: Array

    def on_grid(self, values: Array) -> Array:
        """Values at the nodes of the branch's mesh, (n, ...), at those of the grid."""
        return values[self.mesh.origin]

    def recovery(self, nodes: Indices) -> StressRecovery:
        """The way to stresses at some nodes of the grid, in ascending order."""
        return stress_recovery(self.mesh, self.elasticity, self.elasticity_row, nodes)


def field_body(branch: StoredBranch) -> FieldBody:
    """Prepare the files of a branch."""
    mesh = field_mesh(branch.nodes, branch.cells, branch.cell_type, branch.region)
    grid = grid_file(mesh.nodes, mesh.cells, mesh.cell.written)
    none = np.empty((0, branch.elasticity_row.shape[1], 6))
    steady = none if branch.state is None else branch.state.stress
    return FieldBody(mesh, grid, branch.elasticity, branch.elasticity_row, steady)
