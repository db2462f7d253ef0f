"""Sections of the study file about what loads a body steadily."""

from __future__ import annotations

import math
from abc import abstractmethod
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, Tag, model_validator

from fenics_nnm.geometry.temperature import (
    HOTTEST,
    LinearTemperatures,
    TabulatedTemperatures,
    Temperatures,
    read_temperatures,
)
from fenics_nnm.study.record import (
    Coordinate,
    Distance,
    Finite,
    FromList,
    Names,
    Place,
    Positive,
    Record,
    Vector,
    axis_vector,
)
from fenics_nnm.study.tagged import by_key

ThreeFinite = Annotated[tuple[Finite, Finite, Finite], FromList]
ThreeCoordinates = Annotated[tuple[Coordinate, Coordinate, Coordinate], FromList]

#: Solids have temperatures below this one in K.
Temperature = Annotated[Positive, Field(le=HOTTEST)]

#: Temperature in K at which bodies are free of stress if the study does not say so.
_ROOM = 293.15

_SHAPES = '"table" or "linear"'


class RotationSection(Record):
    """Steady rotation of the body about a fixed axis."""

    axis: Literal["x", "y", "z"] | ThreeFinite = Field(
        description='axis of rotation: "x", "y", "z" or a vector of three finite numbers'
    )
    origin: ThreeCoordinates = Field((0.0, 0.0, 0.0), description="a point on the axis in m")
    speed: Finite | None = Field(None, description="speed in rad/s")
    rpm: Finite | None = Field(None, description="speed in turns per minute")
    coriolis: bool = Field(
        False,
        description="whether Coriolis forces belong to linear modes and responses: true or false",
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


class AnyTemperature(Record):
    """A temperature that changes from place to place.

    Attributes:
        shape: How it is given.
    """

    shape: str

    @abstractmethod
    def temperatures(self) -> Temperatures:
        """Temperature at each place.

        Raises:
            GeometryError: if its table cannot be read.
        """


class TemperatureTable(AnyTemperature):
    """Temperatures at points, linear in between."""

    shape: Literal["table"] = Field(description=_SHAPES)
    file: Path = Field(
        strict=False, description="a .csv file with x_m, y_m, z_m, or some of them, and T_K or T_C"
    )
    outside: Distance | None = Field(
        None,
        description="nodes may lie so far outside of the points, in m; the default is 1 % of "
        "their extent",
    )

    def temperatures(self) -> Temperatures:
        """As `AnyTemperature`."""
        return TabulatedTemperatures(
            read_temperatures(self.file, "load.temperature_field.file"), self.outside
        )


class LinearTemperature(AnyTemperature):
    """A temperature that is linear in the place."""

    shape: Literal["linear"] = Field(description=_SHAPES)
    temperature: Temperature = Field(description="temperature in K at `at`")
    at: Place = Field((0.0, 0.0, 0.0), description="a place in m; the default is 0")
    gradient: Vector = Field(description="[gx, gy, gz], change of temperature in K/m")

    @model_validator(mode="after")
    def _changes(self) -> LinearTemperature:
        if not any(self.gradient):
            raise ValueError(
                f"gradient = {list(self.gradient)}: must not be zero; load.temperature is the same "
                "everywhere"
            )
        return self

    def temperatures(self) -> Temperatures:
        """As `AnyTemperature`."""
        x, y, z = (*self.at, 0.0, 0.0)[:3]
        gx, gy, gz = (*self.gradient, 0.0, 0.0)[:3]
        return LinearTemperatures((x, y, z), self.temperature, (gx, gy, gz))


TemperatureField = Annotated[
    Annotated[TemperatureTable, Tag('shape = "table"')]
    | Annotated[LinearTemperature, Tag('shape = "linear"')],
    by_key("shape"),
]
"""A temperature that changes from place to place."""


class LoadSection(Record):
    """Steady loads besides rotation."""

    temperature: Temperature | None = Field(None, description="temperature of the body in K")
    temperature_field: TemperatureField | None = Field(
        None, description="a section: a temperature that changes from place to place"
    )
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
        warm = self.temperature is not None or self.temperature_field is not None
        if self.temperature is not None and self.temperature_field is not None:
            raise ValueError("temperature, temperature_field: must be one of the two")
        if not warm and "reference_temperature" in self.model_fields_set:
            raise ValueError("reference_temperature: has no effect without temperature")
        if not warm and not self.pressure and not self.force:
            raise ValueError(
                "must have temperature, temperature_field, [[load.pressure]] or [[load.force]]"
            )
        if self.temperature is not None and not self.warming:
            raise ValueError(
                f"temperature = {self.temperature:g}: is reference_temperature, so has no effect: "
                "must differ"
            )
        return self

    @property
    def extent(self) -> float:
        """Largest extent in m of the points that temperatures are given at; 0 for anywhere.

        Raises:
            GeometryError: if they cannot be read.
        """
        return self.temperature_field.temperatures().extent if self.temperature_field else 0.0

    @property
    def warming(self) -> float:
        """Temperature less that at which the body is free of stress, in K."""
        if self.temperature is None:
            return 0.0
        return self.temperature - self.reference_temperature
