"""The section of the study file that picks groups of facets by where they lie; lengths in m."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Literal

from pydantic import Field, model_validator

from fenics_nnm.study.record import (
    Along,
    Coordinate,
    Count,
    Distance,
    FromList,
    Length,
    Names,
    Place,
    Record,
    Vector,
)

Direction = Annotated[
    Literal["x", "y", "z"] | Vector, Field(description='"x", "y", "z" or a vector, not zero')
]


class _Directed(Record):
    """A record whose directions must not be zero."""

    @model_validator(mode="after")
    def _not_zero(self) -> _Directed:
        for name in ("normal", "axis", "direction"):
            vector = getattr(self, name, None)
            if isinstance(vector, tuple) and not any(vector):
                raise ValueError(f"{name} = {list(vector)}: must not be zero")
        return self


class PlanePick(_Directed):
    """Facets in a plane."""

    point: Place = Field(description="a point of the plane in m")
    normal: Direction


class CylinderPick(_Directed):
    """Facets on a cylinder."""

    axis: Direction
    origin: Place = Field((0.0, 0.0, 0.0), description="a point on the axis in m")
    radius: Length = Field(description="radius in m")


class RadiiPick(_Directed):
    """Facets between two radii about an axis."""

    axis: Direction
    origin: Place = Field((0.0, 0.0, 0.0), description="a point on the axis in m")
    low: Distance = Field(0.0, alias="from", description="smallest radius in m")
    high: Length = Field(alias="to", description="largest radius in m")

    @model_validator(mode="after")
    def _ascending(self) -> RadiiPick:
        if self.low > self.high:
            raise ValueError(f"from = {self.low:g} m: must not be above to = {self.high:g} m")
        return self


class BoxPick(Record):
    """Facets inside a box."""

    low: Place = Field(alias="from", description="corner with the smallest coordinates in m")
    high: Place = Field(alias="to", description="corner with the largest coordinates in m")

    @model_validator(mode="after")
    def _ascending(self) -> BoxPick:
        if len(self.low) != len(self.high) or any(
            a > b for a, b in zip(self.low, self.high, strict=True)
        ):
            raise ValueError(
                f"from = {list(self.low)} m: must have no coordinate above to = {list(self.high)} m"
            )
        return self


class NearestPick(Record):
    """The facet nearest to a point, and the smooth face that it belongs to."""

    point: Place = Field(description="a point in m")
    angle: Annotated[float, Field(ge=0, le=180)] = Field(
        20.0, description="angle in degrees between neighbours at which the face ends"
    )


class FacingPick(_Directed):
    """Facets whose outward normal is near a direction."""

    direction: Along | Vector = Field(
        description='"x", "-x", "y", "-y", "z", "-z" or a vector, not zero'
    )
    angle: Annotated[float, Field(gt=0, le=180)] = Field(
        10.0, description="largest angle in degrees between the two"
    )


class GroupSection(Record):
    """A group of facets of the surface: those for which all conditions hold."""

    x: Coordinate | None = Field(None, description="facets at this x in m")
    y: Coordinate | None = Field(None, description="facets at this y in m")
    z: Coordinate | None = Field(None, description="facets at this z in m")
    plane: PlanePick | None = Field(None, description="{ point, normal }")
    cylinder: CylinderPick | None = Field(None, description="{ axis, origin, radius }")
    radii: RadiiPick | None = Field(None, description="{ axis, origin, from, to }")
    box: BoxPick | None = Field(None, description="{ from, to }")
    nearest: NearestPick | None = Field(None, description="{ point, angle }")
    facing: FacingPick | None = Field(None, description="{ direction, angle }")
    faces: Annotated[tuple[Count, ...], FromList] | None = Field(
        None, min_length=1, description="list of numbers of CAD faces, as check shows them"
    )
    facets: Names | None = Field(None, description="name of a group of the mesh, or a list")
    tolerance: Length | None = Field(
        None,
        description="distance in m within which corners lie on a plane, cylinder or box; by "
        "default a thousandth of the size of each facet",
    )

    @model_validator(mode="after")
    def _has_condition(self) -> GroupSection:
        conditions = [name for name in type(self).model_fields if name != "tolerance"]
        if all(getattr(self, name) is None for name in conditions):
            raise ValueError(f"must have at least one of {', '.join(conditions)}")
        return self


def of_the_mesh(groups: Mapping[str, GroupSection]) -> Mapping[str, GroupSection]:
    """Groups none of which is made of another one.

    Raises:
        ValueError: if one is.
    """
    for name, group in groups.items():
        for other in group.facets or ():
            if other in groups:
                raise ValueError(
                    f'{name}.facets = "{other}": is a group of [groups] itself: must be one that '
                    "the mesh has"
                )
    return groups
