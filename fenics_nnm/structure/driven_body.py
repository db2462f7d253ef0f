"""A driven body on its mesh: what it is reduced to, and its shapes for files."""

from __future__ import annotations

from dataclasses import dataclass

from fenics_nnm.fem.blocks import Data
from fenics_nnm.fem.contact import ContactInterface
from fenics_nnm.fem.gathering import gathered_shapes
from fenics_nnm.fem.solid import Solid
from fenics_nnm.reduction.driven import DrivenBasis
from fenics_nnm.structure.mesh_data import with_mesh


@dataclass(frozen=True, slots=True)
class DrivenBody:
    """A driven body on its mesh.

    Attributes:
        solid: Body.
        interface: Its contact points.
        basis: What it is reduced to, with the unknowns that this rank owns.
    """

    solid: Solid
    interface: ContactInterface
    basis: DrivenBasis
    has_mesh: bool = True

    @property
    def doubt(self) -> str:
        """Why no motion in contact can be verified, or nothing."""
        return self.basis.choice.doubt

    def data(self) -> Data:
        """Contact points and mesh in memory, shapes in blocks, and the mesh as it was read."""
        basis = self.basis
        shapes = {"shapes": basis.shapes, "residual_shapes": basis.residual_shapes}
        if basis.bent_shapes.size:
            shapes["bent_shapes"] = basis.bent_shapes
        gathered = gathered_shapes(self.solid, self.interface, shapes)
        return with_mesh(gathered, self.solid, self.interface)
