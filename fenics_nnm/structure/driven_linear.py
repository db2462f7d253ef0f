"""All that is linear of a driven structure: what it is reduced to, and its shapes for files."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from fenics_nnm.fem.blocks import Data
from fenics_nnm.reduction.driven import DrivenBasis


class DrivenLinear(Protocol):
    """All that is linear of a driven structure."""

    @property
    def basis(self) -> DrivenBasis:
        """What it is reduced to."""

    @property
    def doubt(self) -> str:
        """Why no motion in contact can be verified, or nothing."""

    @property
    def has_mesh(self) -> bool:
        """Whether there is a mesh, to write fields on."""

    def data(self) -> Data:
        """Data sets for the file of its motions; to be called on all ranks."""


@dataclass(frozen=True, slots=True)
class DrivenMatrices:
    """Driven matrices of another code.

    Attributes:
        basis: What they are reduced to.
        doubt: Nothing: matrices have the kinematics that they are given with.
    """

    basis: DrivenBasis
    doubt: str = ""
    has_mesh: bool = False

    def data(self) -> Data:
        """Shapes and residual shapes in the order of the unknowns."""
        basis = self.basis
        bent = {"basis/bent_shapes": basis.bent_shapes.T} if basis.bent_shapes.size else {}
        return Data(
            {
                "basis/shapes": basis.shapes.T,
                "basis/residual_shapes": basis.residual_shapes.T,
                **bent,
            }
        )
