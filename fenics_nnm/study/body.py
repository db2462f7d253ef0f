"""Sections of the study file about the body: its theory and clamp."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BeforeValidator, Field, model_validator

from fenics_nnm.study.record import FromList, Names, Positive, Record


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


Directions = Annotated[tuple[Literal["x", "y", "z"], ...], Field(min_length=1), FromList]


class ClampSection(Record):
    """Facets or nodes without displacement, in all directions or some."""

    facets: Names | None = Field(None, description="name of a group of facets, or a list of names")
    nodes: Names | None = Field(None, description="name of a set of nodes, or a list of names")
    directions: Directions | None = Field(
        None, description='list of "x", "y", "z"; all of them without'
    )

    @model_validator(mode="after")
    def _has_a_place(self) -> ClampSection:
        if self.facets is None and self.nodes is None:
            raise ValueError("facets: is missing (name of a group of facets, or a list of names)")
        if self.directions and len(set(self.directions)) < len(self.directions):
            raise ValueError(f"directions = {list(self.directions)}: must be different ones")
        return self


Clamps = Annotated[
    tuple[ClampSection, ...],
    BeforeValidator(lambda value: (value,) if isinstance(value, dict) else value),
    FromList,
]
"""One clamp, or several."""
