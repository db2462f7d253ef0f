"""Sections of the study file about what loads a body steadily."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field, model_validator

from fenics_nnm.study.record import (
    Coordinate,
    Finite,
    FromList,
    Names,
    Place,
    Positive,
    Record,
    Vector,
    axis_vector,
)

ThreeFinite = Annotated[tuple[Finite, Finite, Finite], FromList]
ThreeCoordinates = Annotated[tuple[Coordinate, Coordinate, Coordinate], FromList]

#: Solids have temperatures below this one in K.
Temperature = Annotated[Positive, Field(le=1e4)]

#: Temperature in K at which bodies are free of stress if the study does not say so.
_ROOM = 293.15


class RotationSection(Record):
    """Steady rotation of the body about a fixed axis."""

    axis: Literal["x", "y", "z"] | ThreeFinite = Field(
        description='axis of rotation: "x", "y", "z" or a vector of three finite numbers'
    )
    origin: ThreeCoordinates = Field((0.0, 0.0, 0.0), description="a point on the axis in m")
    speed: Finite | None = Field(None, description="speed in rad/s")
    rpm: Finite | None = Field(None, description="speed in turns per minute")
    coriolis: bool = Field(
        False, description="whether Coriolis forces belong to the linear modes: true or false"
    )

    @model_validator(mode="after")
    def _one_speed(self) -> RotationSection:
        if (self.speed is None) == (self.rpm is None):
            raise ValueError("speed, rpm: must have one of the two")
        if not any(axis_vector(self.axis)):
            raise ValueError(f"axis = {list(self.axis)}: must not be zero")
        if self.coriolis and not self.omega:
            raise ValueError("coriolis = true: has no effect without speed: must be false")
        return self

    @property
    def omega(self) -> float:
        """Speed in rad/s."""
        return self.speed if self.speed is not None else (self.rpm or 0.0) * math.pi / 30


class PressureSection(Record):
    """A steady pressure on facets."""

    facets: Names = Field(description="name of a group of facets, or a list of names")
    pressure: Finite = Field(description="pressure in Pa, positive towards the body")
    follower: bool = Field(
        False,
        description="whether it stays normal to the deformed surface (true) or keeps the direction "
        "and the area of the unloaded one (false)",
    )

    @model_validator(mode="after")
    def _has_effect(self) -> PressureSection:
        if not self.pressure:
            raise ValueError("pressure = 0: must not be zero")
        return self


class SteadyForceSection(Record):
    """A steady force at a vertex, or spread evenly over facets; it keeps its direction."""

    at: Place | None = Field(None, description="coordinates in m: the nearest vertex is taken")
    facets: Names | None = Field(None, description="name of a group of facets, or a list of names")
    force: Vector = Field(
        description="[fx, fy, fz] in N, of all facets together; as many as dimensions"
    )

    @model_validator(mode="after")
    def _is_a_force_at_one_place(self) -> SteadyForceSection:
        if (self.at is None) == (self.facets is None):
            raise ValueError("at, facets: must have one of the two")
        if not any(self.force):
            raise ValueError(f"force = {list(self.force)}: must not be zero")
        return self


class LoadSection(Record):
    """Steady loads besides rotation."""

    temperature: Temperature | None = Field(None, description="temperature of the body in K")
    reference_temperature: Temperature = Field(
        _ROOM, description="temperature in K at which the body is free of stress"
    )
    pressure: Annotated[tuple[PressureSection, ...], FromList] = Field(
        (), description="sections [[load.pressure]]"
    )
    force: Annotated[tuple[SteadyForceSection, ...], FromList] = Field(
        (), description="sections [[load.force]]"
    )

    @model_validator(mode="after")
    def _loads(self) -> LoadSection:
        if self.temperature is None and "reference_temperature" in self.model_fields_set:
            raise ValueError("reference_temperature: has no effect without temperature")
        if self.temperature is None and not self.pressure and not self.force:
            raise ValueError("must have temperature, [[load.pressure]] or [[load.force]]")
        if self.temperature is not None and not self.warming:
            raise ValueError(
                f"temperature = {self.temperature:g}: is reference_temperature, so has no effect: "
                "must differ"
            )
        return self

    @property
    def warming(self) -> float:
        """Temperature less that at which the body is free of stress, in K."""
        if self.temperature is None:
            return 0.0
        return self.temperature - self.reference_temperature
