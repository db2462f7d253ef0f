"""Sections of the study file about the body: its theory and clamp."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, Tag

from fenics_nnm.study.record import Names, Positive, Record
from fenics_nnm.study.tagged import by_key

_THEORIES = "rod in 1-D, plane-stress or plane-strain in 2-D, solid in 3-D"


class _Body(Record):
    """What every body has."""

    degree: Literal[1, 2] = Field(2, description="polynomial degree of the displacement")


class RodSection(_Body):
    """A rod in 1-D."""

    theory: Literal["rod"] = Field(description=_THEORIES)
    area: Positive = Field(description="cross-section of a rod in m^2")

    @property
    def extent(self) -> float:
        """What an integral over the mesh lacks: the cross-section in m^2."""
        return self.area


class PlaneSection(_Body):
    """A plane body in 2-D."""

    theory: Literal["plane-stress", "plane-strain"] = Field(description=_THEORIES)
    thickness: Positive = Field(description="thickness of a plane body in m")

    @property
    def extent(self) -> float:
        """What an integral over the mesh lacks: the thickness in m."""
        return self.thickness


class SolidSection(_Body):
    """A solid in 3-D."""

    theory: Literal["solid"] = Field(description=_THEORIES)

    @property
    def extent(self) -> float:
        """What an integral over the mesh lacks: nothing, 1."""
        return 1.0


BodySection = Annotated[
    Annotated[RodSection, Tag('theory = "rod"')]
    | Annotated[PlaneSection, Tag('theory = "plane-stress"')]
    | Annotated[PlaneSection, Tag('theory = "plane-strain"')]
    | Annotated[SolidSection, Tag('theory = "solid"')],
    by_key("theory"),
]
"""Theory of the body, and what a mesh of lower dimension lacks."""


class ClampSection(Record):
    """Facets without displacement."""

    facets: Names = Field(description="name of a group of facets, or a list of names")
