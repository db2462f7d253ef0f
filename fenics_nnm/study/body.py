"""Sections of the study file about the body: its theory and clamp."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BeforeValidator, Field, Tag, model_validator

from fenics_nnm.study.record import Count, FromList, Length, Names, OneOrTwo, Positive, Record
from fenics_nnm.study.tagged import by_key

_THEORIES = "rod in 1-D, plane-stress or plane-strain in 2-D, solid in 3-D"


class _Body(Record):
    """What every body has."""

    degree: OneOrTwo = Field(2, description="polynomial degree of the displacement")
    kinematics: Literal["linear", "second-order", "auto"] = Field(
        "auto",
        description='"second-order": large deflection; "linear": small deflection, and what second '
        'order would change; "auto": second order where it matters',
    )
    masters: Annotated[tuple[Count, ...], FromList] | None = Field(
        None,
        description="numbers of the modes that bend the body in second order, from 1; mode.number "
        "and those that matter beside it without",
    )

    @property
    def may_bend(self) -> bool:
        """Whether second order is taken where it matters."""
        return self.kinematics == "auto"

    @model_validator(mode="after")
    def _masters_bend(self) -> _Body:
        if self.masters is None:
            return self
        if self.kinematics == "linear":
            raise ValueError('masters: has no effect with kinematics = "linear"')
        if not self.masters or list(self.masters) != sorted(set(self.masters)):
            raise ValueError(
                f"masters = {list(self.masters)}: must be numbers of modes, ascending, one or more"
            )
        return self


class RodSection(_Body):
    """A rod in 1-D."""

    theory: Literal["rod"] = Field(description=_THEORIES)
    area: Positive = Field(description="cross-section of a rod in m^2")

    @property
    def may_bend(self) -> bool:
        """A rod does not bend."""
        return False

    @model_validator(mode="after")
    def _is_linear(self) -> RodSection:
        if self.kinematics == "second-order":
            raise ValueError(
                'kinematics = "second-order": a rod does not bend: must be "auto" or "linear"'
            )
        if self.masters:
            raise ValueError("masters: has no effect: a rod does not bend")
        return self

    @property
    def extent(self) -> float:
        """What an integral over the mesh lacks: the cross-section in m^2."""
        return self.area


class PlaneSection(_Body):
    """A plane body in 2-D."""

    theory: Literal["plane-stress", "plane-strain"] = Field(description=_THEORIES)
    thickness: Length = Field(description="thickness of a plane body in m")

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


def assert_kept(key: str, masters: tuple[int, ...] | None, modes: int | str, own: int) -> None:
    """Refuse masters that are not among the modes, or that the followed one is not among.

    Raises:
        ValueError: if there are some.
    """
    if masters and modes != "auto" and masters[-1] > int(modes):
        raise ValueError(f"{key} = {list(masters)}: must not be above reduction.modes = {modes}")
    if masters and own not in masters:
        raise ValueError(f"{key} = {list(masters)}: must have mode.number = {own} among them")
