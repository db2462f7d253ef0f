"""Section of the study file about the surface of a rigid casing."""

from __future__ import annotations

import math
from abc import abstractmethod
from pathlib import Path
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, Tag, model_validator

from fenics_nnm.arrays import Array
from fenics_nnm.casing import (
    Cone,
    Frame,
    LobedRadius,
    Passing,
    Plane,
    RadialSurface,
    Reversed,
    Surface,
    Turning,
    read_radii,
)
from fenics_nnm.errors import GeometryError
from fenics_nnm.study.messages import shown
from fenics_nnm.study.record import (
    Coordinate,
    Count,
    Finite,
    FromList,
    Length,
    Place,
    Record,
    Vector,
    axis_vector,
)
from fenics_nnm.study.tagged import by_key

Pairs = Annotated[
    tuple[Annotated[tuple[Coordinate, Length], FromList], ...], Field(min_length=2), FromList
]
Axis = Literal["x", "y", "z"] | Vector

#: Where angles about an axis begin if the study does not say so.
_ZERO: dict[str, Axis] = {"x": "y", "y": "z", "z": "x"}

_SHAPES = '"cylinder", "cone", "lobed", "table" or "plane"'
#: Harmonics of the passing of lobes that gaps may have: those above one follow from directions
#: that are not radial.
_LOBE_HARMONICS = 8

#: The axis of lobes that pass is that of the rotation to this part of their amplitude.
_CENTRED = 1e-3

_RADIUS = "radius at the origin in m, positive"


class AnyCasing(Record):
    """A rigid surface; the gap of a contact point is its distance along the contact direction.

    Attributes:
        shape: Kind of the surface.
        clearance: Added to the distance, in m.
    """

    shape: str
    clearance: Coordinate = Field(0.0, description="added to the distance, in m")

    @property
    def word(self) -> str:
        """What the surface is called."""
        return "obstacle"

    @property
    def passing_order(self) -> int:
        """Multiple of the speed at which a body turns past it; 0 if it turns with the body."""
        return 0

    def passing(self, turning: Turning) -> Passing:
        """What a body that turns meets of it.

        Raises:
            GeometryError: as `surface`.
        """
        return Passing(self.surface(), turning, range(0))

    @abstractmethod
    def surface(self) -> Surface:
        """The surface that the section means.

        Raises:
            GeometryError: if its table cannot be read, or a radius is not positive.
        """

    @model_validator(mode="after")
    def _vectors_are_not_zero(self) -> Self:
        for key in ("axis", "normal", "zero"):
            vector = getattr(self, key, None)
            if isinstance(vector, tuple) and not any(vector):
                raise ValueError(f"{key} = {list(vector)}: must not be zero")
        return self


class PlaneSection(AnyCasing):
    """A plane."""

    shape: Literal["plane"] = Field(description=_SHAPES)
    origin: Place = Field(description="a point of the plane in m")
    normal: Vector = Field(description="direction from the body to the plane")

    def surface(self) -> Surface:
        """The plane."""
        return Plane(_in_space(self.origin), _in_space(self.normal))


class _Round(AnyCasing):
    """A surface about an axis."""

    axis: Axis = Field(
        description='axis of the casing: "x", "y", "z" or a vector of finite numbers'
    )
    origin: Place | None = Field(None, description="a point on the axis in m")
    body: Literal["inside", "outside"] | None = Field(
        None, description='where the body is: "inside" a casing or "outside", around a shaft'
    )
    growth: Coordinate = Field(
        0.0, description="growth of the radius in m at the speed of [rotation], of the casing alone"
    )

    @property
    def word(self) -> str:
        """What the surface is called."""
        return "shaft" if self.body == "outside" else "casing"

    @property
    def _zero(self) -> Axis | None:
        """Direction of angle zero, None where it is not known."""
        return _ZERO[self.axis] if isinstance(self.axis, str) else None

    @abstractmethod
    def _about(self, frame: Frame) -> Surface:
        """The surface with the body inside."""

    @property
    def _frame(self) -> Frame:
        """Its axis, and where angles begin."""
        zero = _in_space(axis_vector(self._zero)) if self._zero else None
        return Frame(_in_space(self.origin or ()), _in_space(axis_vector(self.axis)), zero)

    def surface(self) -> Surface:
        """The surface about its axis."""
        inside = self._about(self._frame)
        return Reversed(inside) if self.body == "outside" else inside


class CylinderSection(_Round):
    """A cylinder."""

    shape: Literal["cylinder"] = Field(description=_SHAPES)
    radius: Length = Field(description=_RADIUS)

    def _about(self, frame: Frame) -> Surface:
        return Cone(frame, self.radius + self.growth, 0.0)


class ConeSection(_Round):
    """A cone, by its angle or two radii."""

    shape: Literal["cone"] = Field(description=_SHAPES)
    radius: Length = Field(description=_RADIUS)
    half_angle_deg: float | None = Field(
        None,
        gt=-90,
        lt=90,
        description="angle between axis and surface in degrees, positive where the radius grows",
    )
    end_radius: Length | None = Field(None, description="radius at `length` in m, positive")
    length: Length | None = Field(None, description="from radius to end_radius in m, positive")

    @property
    def slope(self) -> float:
        """Rise of the radius along the axis."""
        if self.end_radius is not None and self.length is not None:
            return (self.end_radius - self.radius) / self.length
        return math.tan(math.radians(self.half_angle_deg or 0.0))

    def _about(self, frame: Frame) -> Surface:
        return Cone(frame, self.radius + self.growth, self.slope)

    @model_validator(mode="after")
    def _is_given_once(self) -> Self:
        by_radii = (self.end_radius is not None, self.length is not None)
        if any(by_radii) != all(by_radii) or any(by_radii) == (self.half_angle_deg is not None):
            raise ValueError('shape = "cone": needs either half_angle_deg or end_radius and length')
        return self


class TurningCasing(_Round):
    """A surface whose radius changes with the angle about the axis."""

    frame: Literal["rotating", "fixed"] = Field(
        "rotating",
        description='whether it turns with the body ("rotating") or stands still ("fixed"), so '
        "that the body of [rotation] moves past it: for responses alone",
    )
    zero: Axis | None = Field(
        None, description='direction of angle zero: "x", "y", "z" or a vector of finite numbers'
    )

    @property
    def _zero(self) -> Axis | None:
        return self.zero or super()._zero

    @property
    def passing_order(self) -> int:
        """As `AnyCasing.passing_order`."""
        return self._order if self.frame == "fixed" else 0

    @property
    def _order(self) -> int:
        """How many times it is the same in a turn."""
        return 1

    @abstractmethod
    def _multiples(self) -> range:
        """Multiples of the speed in the gaps of a body that turns past it."""

    def passing(self, turning: Turning) -> Passing:
        """As `AnyCasing.passing`."""
        multiples = self._multiples() if self.frame == "fixed" else range(0)
        return Passing(self.surface(), turning, multiples)

    @model_validator(mode="after")
    def _zero_is_known(self) -> Self:
        if self.zero is None and not isinstance(self.axis, str):
            raise ValueError("zero: is missing: the direction of angle zero about such an axis")
        axis, zero = axis_vector(self.axis), axis_vector(self.zero)
        product = sum(x * y for x, y in zip(axis, zero, strict=False))
        lengths = sum(x * x for x in axis) * sum(y * y for y in zero)
        if self.zero is not None and product**2 > (1 - 1e-12) * lengths:
            raise ValueError(f"zero = {shown(self.zero)}: must not be along the axis")
        return self


class LobedSection(TurningCasing):
    """A casing with lobes."""

    shape: Literal["lobed"] = Field(description=_SHAPES)
    lobes: Count = Field(description="number of lobes, positive")
    amplitude: Length = Field(description="height of a lobe in m, positive")
    phase_deg: Finite = Field(0.0, description="angle of a largest radius in degrees")
    radius: Length | None = Field(None, description=_RADIUS)
    profile: Pairs | None = Field(
        None, description="[[x, r], ...]: axial coordinates, ascending, and mean radii in m"
    )

    def _about(self, frame: Frame) -> Surface:
        profile = self.profile or ()
        radius = LobedRadius(
            mean=tuple(r + self.growth for r in [r for _, r in profile] or [self.radius or 0.0]),
            lobes=self.lobes,
            amplitude=self.amplitude,
            phase=math.radians(self.phase_deg),
            stations=tuple(x for x, _ in profile),
        )
        return RadialSurface(frame, radius)

    @property
    def _order(self) -> int:
        return self.lobes

    def passing(self, turning: Turning) -> Passing:
        """As `AnyCasing.passing`; lobes about another axis do not come by evenly.

        Raises:
            GeometryError: if they do not, and as `surface`.
        """
        if self.frame == "fixed" and not turning.is_about(self._frame, _CENTRED * self.amplitude):
            raise GeometryError(
                'shape = "lobed" with frame = "fixed": axis and origin must be those of '
                '[rotation]; about another axis needs shape = "table"'
            )
        return super().passing(turning)

    def _multiples(self) -> range:
        return range(self.lobes, _LOBE_HARMONICS * self.lobes + 1, self.lobes)

    @model_validator(mode="after")
    def _one_mean_radius(self) -> Self:
        if (self.radius is None) == (self.profile is None):
            raise ValueError('shape = "lobed": needs either radius or profile')
        stations = [x for x, _ in self.profile or ()]
        if stations != sorted(set(stations)):
            raise ValueError("profile: axial coordinates must rise from pair to pair")
        return self


class TableSection(TurningCasing):
    """A casing by a table of radii."""

    shape: Literal["table"] = Field(description=_SHAPES)
    file: Path = Field(strict=False, description="a .csv file of radii")

    def _about(self, frame: Frame) -> Surface:
        return RadialSurface(frame, read_radii(self.file).grown(self.growth))

    def _multiples(self) -> range:
        return range(1, read_radii(self.file).angles // 2 + 1)


CasingSection = Annotated[
    Annotated[CylinderSection, Tag('shape = "cylinder"')]
    | Annotated[ConeSection, Tag('shape = "cone"')]
    | Annotated[LobedSection, Tag('shape = "lobed"')]
    | Annotated[TableSection, Tag('shape = "table"')]
    | Annotated[PlaneSection, Tag('shape = "plane"')],
    by_key("shape"),
]
"""A rigid surface; the gap of a contact point is its distance along the contact direction."""


def _in_space(vector: tuple[float, ...]) -> Array:
    return np.array([*vector, 0.0, 0.0, 0.0][:3])
