"""Sections of the study file about the body: its theory and clamp."""

from __future__ import annotations

from typing import Literal

from pydantic import Field, model_validator

from fenics_nnm.study.record import Names, Positive, Record


class BodySection(Record):
    """Theory of the body, and what a mesh of lower dimension lacks."""

    theory: Literal["rod", "plane-stress", "plane-strain", "solid"] = Field(
        description="rod in 1-D, plane-stress or plane-strain in 2-D, solid in 3-D"
    )
    area: Positive | None = Field(None, description="cross-section of a rod in m^2")
    thickness: Positive | None = Field(None, description="thickness of a plane body in m")
    degree: Literal[1, 2] = Field(2, description="polynomial degree of the displacement")

    @model_validator(mode="after")
    def _extent_fits_theory(self) -> BodySection:
        wanted = {"rod": "area", "plane-stress": "thickness", "plane-strain": "thickness"}
        needed = wanted.get(self.theory)
        for key in ("area", "thickness"):
            given = getattr(self, key) is not None
            if given != (key == needed):
                verb = "needs" if key == needed else "has no"
                raise ValueError(f'theory = "{self.theory}" {verb} {key}')
        return self

    @property
    def extent(self) -> float:
        """Area of a rod in m^2, thickness of a plane body in m, 1 for a solid."""
        return self.area or self.thickness or 1.0


class ClampSection(Record):
    """Facets without displacement."""

    facets: Names = Field(description="name of a group of facets, or a list of names")
