"""A material: law, orientation and density."""

from __future__ import annotations

from dataclasses import dataclass

from fenics_nnm.materials.elasticity import Law
from fenics_nnm.materials.orientation import XYZ, Orientation, Three

#: Strengths that a material may have.
STRENGTHS = ("yield_strength", "tensile_strength", "fatigue_strength")


@dataclass(frozen=True, slots=True)
class Material:
    """A linear elastic material in SI units.

    Attributes:
        law: Elasticity in material axes.
        density: Mass density in kg/m^3.
        orientation: Material axes; without effect on an isotropic law.
        name: Name for messages and listings, empty for one without.
        expansion: Thermal expansion along the material axes 1, 2, 3 in 1/K; None where it is not
            known.
        source: Where the values are from, empty for values of the study.
        yield_strength: Yield strength in Pa; None where it is not known, as the other strengths.
        tensile_strength: Tensile (ultimate) strength in Pa.
        fatigue_strength: Amplitude in Pa of fully reversed stress that is borne for long.
        strength_source: Where the strengths are from.
    """

    law: Law
    density: float
    orientation: Orientation = XYZ
    name: str = ""
    source: str = ""
    expansion: Three | None = None
    yield_strength: float | None = None
    tensile_strength: float | None = None
    fatigue_strength: float | None = None
    strength_source: str = ""

    @property
    def turns(self) -> bool:
        """Whether its stiffness in global axes differs from point to point."""
        return self.law.directional and self.orientation.turns
