"""What can be told and written of a structure given by matrices."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.backbone.follow import Branch
from fenics_nnm.fem.blocks import Data
from fenics_nnm.reduction.matrix_analysis import MatrixAnalysis
from fenics_nnm.stages import Stages
from fenics_nnm.study import Study


@dataclass(frozen=True, slots=True)
class MatrixReport:
    """Report of an analysis of matrices.

    Attributes:
        analysis: Analysis, the same on all ranks.
    """

    analysis: MatrixAnalysis

    def sizes(self) -> dict[str, Any]:
        """Numbers of unknowns and contact rows."""
        matrices = self.analysis.matrices
        return {"dofs": matrices.size, "contact_points": matrices.points}

    def heading(self) -> list[str]:
        """Matrices and contact rows in words."""
        matrices = self.analysis.matrices
        low, high = matrices.gap.min(), matrices.gap.max()
        gaps = f"{low:.4g} m" if low == high else f"{low:.4g} to {high:.4g} m"
        return [
            f"matrices         {matrices.size} unknowns, {matrices.size - matrices.massive} "
            "without mass",
            f"contact          {matrices.points} rows, gap {gaps}",
        ]

    def groups(self) -> list[str]:
        """Nothing: matrices have no groups."""
        return []

    def place(self, point: int) -> str:
        """Number of a contact row."""
        return f"contact row {point + 1}"

    def largest(self, q: Array, force: Array) -> str:
        """Largest unknown of coordinates in kg^1/2 m and contact forces in N."""
        largest = np.abs(self.analysis.reduction.displacement(q, force)).max()
        return f"{largest:.4g} m (rad, if it is a rotation)"

    def data(self) -> Data:
        """Shapes and residual shapes in the order of the unknowns."""
        reduction = self.analysis.reduction
        return Data(
            {
                "basis/shapes": reduction.shapes.T,
                "basis/residual_shapes": reduction.residual_shapes.T,
            }
        )

    def write_fields(self, file: Path, study: Study, branch: Branch, stages: Stages) -> None:
        """Nothing: without a mesh there is nothing to see in ParaView."""
