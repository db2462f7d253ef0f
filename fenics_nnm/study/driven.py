"""Sections of the study file about driven motions: excitation, frequencies, places watched."""

from __future__ import annotations

import math
from typing import Annotated

import numpy as np
from pydantic import Field, model_validator

from fenics_nnm.arrays import Array
from fenics_nnm.study.continuation import Range
from fenics_nnm.study.record import (
    Along,
    Count,
    Finite,
    FromList,
    Label,
    Names,
    Place,
    Positive,
    Record,
    Vector,
    axis_vector,
)

_PHASE = "phase of the force in degrees: F cos(n omega t + phase)"

#: Highest harmonic, or engine order, of an excitation.
_HIGHEST = 1000

Harmonic = Annotated[int, Field(ge=0, le=_HIGHEST)]
Order = Annotated[int, Field(gt=0, le=_HIGHEST)]


class _Harmonic(Record):
    """When a force acts: at a multiple of the frequency, or of the speed."""

    phase_deg: Finite = Field(0.0, description=_PHASE)
    harmonic: Harmonic = Field(
        1, description="multiple n of the frequency of the response, from 0 (a constant force)"
    )
    order: Order | None = Field(
        None,
        description="engine order: multiple of the speed of rotation, from 1, with response.speeds",
    )

    @property
    def turn(self) -> complex:
        """exp(i phase)."""
        return complex(np.exp(1j * np.deg2rad(self.phase_deg)))

    @model_validator(mode="after")
    def _one_multiple(self) -> _Harmonic:
        if self.order is not None and "harmonic" in self.model_fields_set:
            raise ValueError("harmonic, order: must have one of the two")
        return self


class ExcitationSection(_Harmonic):
    """A harmonic force at a vertex or on facets, a pressure on facets, or a shaken base."""

    at: Place | None = Field(None, description="coordinates in m: the nearest vertex is taken")
    facets: Names | None = Field(None, description="name of a group of facets, or a list of names")
    force: Vector | None = Field(
        None,
        description="[fx, fy, fz] in N, 0-peak, of all facets together; as many as dimensions",
    )
    pressure: Finite | None = Field(
        None, description="pressure on facets in Pa, 0-peak, positive towards the body"
    )
    base: Vector | None = Field(
        None,
        description="[ax, ay, az], acceleration of the base (m/s^2), 0-peak: displacements are "
        "those against the base; as many as dimensions",
    )

    @model_validator(mode="after")
    def _is_one_force(self) -> ExcitationSection:
        given = [key for key in ("force", "pressure", "base") if getattr(self, key) is not None]
        if len(given) != 1:
            raise ValueError("force, pressure, base: must have one of the three")
        (key,) = given
        if self.base is not None and (self.at is not None or self.facets is not None):
            raise ValueError("base: moves the whole body: at and facets have no effect")
        if self.base is None and (self.at is None) == (self.facets is None):
            raise ValueError("at, facets: must have one of the two")
        if self.pressure is not None and self.facets is None:
            raise ValueError("pressure: acts on facets: must have facets")
        value = getattr(self, key)
        if not np.any(value):
            shown = list(value) if isinstance(value, tuple) else value
            raise ValueError(f"{key} = {shown}: must not be zero")
        return self


class MatrixExcitationSection(_Harmonic):
    """A harmonic force at an unknown of matrices."""

    unknown: Count = Field(description="number of the unknown: row of the stiffness, from 1")
    force: Finite = Field(description="force along the unknown in N, 0-peak, not zero")

    @model_validator(mode="after")
    def _has_effect(self) -> MatrixExcitationSection:
        if not self.force:
            raise ValueError("force = 0: must not be zero")
        return self


class MonitorSection(Record):
    """A place whose displacement is watched."""

    name: Label = Field(description="name in response.csv")
    at: Place | None = Field(None, description="coordinates in m: the nearest vertex is taken")
    facets: Names | None = Field(
        None, description="name of a group of facets, or a list: their mean displacement"
    )
    direction: Along | Vector = Field(
        description='direction of the displacement: "x", "-x", "y", "-y", "z", "-z", or a vector '
        "of any length"
    )

    @model_validator(mode="after")
    def _is_one_place(self) -> MonitorSection:
        if (self.at is None) == (self.facets is None):
            raise ValueError("at, facets: must have one of the two")
        if not any(axis_vector(self.direction)):
            raise ValueError(f"direction = {list(self.direction)}: must not be zero")
        return self


class MatrixMonitorSection(Record):
    """An unknown of matrices that is watched."""

    name: Label = Field(description="name in response.csv")
    unknown: Count = Field(description="number of the unknown: row of the stiffness, from 1")


class Hertz(Range):
    """Range of frequencies in Hz."""

    start: Positive = Field(alias="from", description="lowest frequency in Hz")
    stop: Positive = Field(alias="to", description="highest frequency in Hz")
    step: Positive = Field(description="step in Hz")

    @property
    def values(self) -> Array:
        """Equal steps of at most `step`, with both ends, shape (f,)."""
        steps = int(np.ceil((self.stop - self.start) / self.step - 1e-9))
        return np.linspace(self.start, self.stop, steps + 1)


class Speeds(Hertz):
    """Range of speeds in rad/s."""

    start: Positive = Field(alias="from", description="lowest speed in rad/s")
    stop: Positive = Field(alias="to", description="highest speed in rad/s")
    step: Positive = Field(description="step in rad/s")


Levels = Annotated[tuple[Positive, ...], Field(min_length=1, max_length=100), FromList]


class ResponseSection(Record):
    """At which frequencies or speeds, and levels of the forces, driven motions are found."""

    frequencies: Hertz | None = Field(None, description="range { from, to, step } in Hz")
    speeds: Speeds | None = Field(
        None, description="range { from, to, step } in rad/s, for excitation by engine orders"
    )
    levels: Levels = Field((1.0,), description="list of factors of all forces, positive")
    report_at: Annotated[tuple[Positive, ...], FromList] = Field(
        (),
        description="frequencies in Hz, or speeds in rad/s with speeds, whose motions are written "
        "for ParaView; the default is the highest peak of each level",
    )
    backbone: bool = Field(
        True, description="whether motions in phase resonance are followed up to the highest level"
    )

    @model_validator(mode="after")
    def _one_range(self) -> ResponseSection:
        if (self.frequencies is None) == (self.speeds is None):
            raise ValueError("frequencies, speeds: must have one of the two")
        if len(set(self.levels)) < len(self.levels):
            raise ValueError(f"levels = {list(self.levels)}: must differ")
        for value in self.report_at:
            if not self.range.start <= value <= self.range.stop:
                raise ValueError(
                    f"report_at = {value:g}: must be from {self.range.start:g} to "
                    f"{self.range.stop:g}, as the response is"
                )
        return self

    @property
    def range(self) -> Hertz:
        """The range of frequencies or speeds."""
        found = self.frequencies or self.speeds
        assert found is not None  # one of the two is given
        return found


def base_order(orders: tuple[int, ...]) -> int:
    """The multiple of the speed that all engine orders are multiples of."""
    return math.gcd(*orders)
