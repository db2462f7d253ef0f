"""Sections of the study file about masses and springs attached to the body."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, model_validator

from fenics_nnm.study.record import (
    Count,
    Finite,
    FromList,
    Names,
    NotNegative,
    Place,
    Positive,
    Record,
)

Stiffnesses = Annotated[
    tuple[NotNegative, ...],
    Field(min_length=1, max_length=3),
    FromList,
]

Cubics = Annotated[tuple[Finite, ...], Field(min_length=1, max_length=3), FromList]


class _Attached(Record):
    at: Place | None = Field(None, description="coordinates in m: the nearest vertex is taken")
    facets: Names | None = Field(None, description="name of a group of facets, or a list of names")

    @model_validator(mode="after")
    def _one_place(self) -> _Attached:
        if (self.at is None) == (self.facets is None):
            raise ValueError("at, facets: must have one of the two")
        return self


class MassSection(_Attached):
    """A mass at a vertex, or spread evenly over facets."""

    mass: Positive = Field(description="mass in kg, that of all facets together")


class SpringSection(_Attached):
    """Springs to the ground at a vertex, or spread evenly over facets."""

    stiffness: Stiffnesses | None = Field(
        None, description="[kx, ky, kz] in N/m, of all facets together; as many as dimensions"
    )
    foundation: Stiffnesses | None = Field(
        None, description="[kx, ky, kz] in N/m^3, per area of facets; as many as dimensions"
    )

    cubic: Cubics | None = Field(
        None,
        description="[kx, ky, kz] in N/m^3: force k x^3 besides the linear one, of the vertex or "
        "of the mean displacement of all facets; as many as dimensions",
    )

    @model_validator(mode="after")
    def _one_stiffness(self) -> SpringSection:
        if self.cubic and not any(self.cubic):
            raise ValueError(f"cubic = {list(self.cubic)}: must not be zero")
        if self.cubic and self.stiffness is None and self.foundation is None:
            return self
        if (self.stiffness is None) == (self.foundation is None):
            raise ValueError("stiffness, foundation: must have one of the two, or cubic")
        if self.foundation is not None and self.facets is None:
            raise ValueError("foundation: is per area: needs facets")
        if not any(self.values):
            name = "stiffness" if self.foundation is None else "foundation"
            raise ValueError(f"{name} = {list(self.values)}: must not be zero")
        return self

    @property
    def values(self) -> tuple[float, ...]:
        """Stiffness along the axes in N/m, or N/m^3 of a foundation."""
        return self.stiffness or self.foundation or ()


class MatrixSpringSection(Record):
    """A cubic spring to the ground at an unknown of matrices, which hold all that is linear."""

    unknown: Count = Field(description="number of the unknown: row of the stiffness, from 1")
    cubic: Finite = Field(description="k in N/m^3: force k x^3 besides the linear one")

    @model_validator(mode="after")
    def _has_effect(self) -> MatrixSpringSection:
        if not self.cubic:
            raise ValueError("cubic = 0: must not be zero")
        return self
