"""A material: law, orientation and density."""

from __future__ import annotations

from dataclasses import dataclass

from fenics_nnm.materials.elasticity import Isotropic, Orthotropic
from fenics_nnm.materials.orientation import XYZ, Orientation


@dataclass(frozen=True, slots=True)
class Material:
    """A linear elastic material in SI units.

    Attributes:
        law: Elasticity in material axes.
        density: Mass density in kg/m^3.
        orientation: Material axes; without effect on an isotropic law.
        name: Name for messages and listings, empty for one without.
        source: Where the values are from, empty for values of the study.
    """

    law: Isotropic | Orthotropic
    density: float
    orientation: Orientation = XYZ
    name: str = ""
    source: str = ""
