"""Sections of the study file about contact."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from fenics_nnm.study.messages import shown
from fenics_nnm.study.record import Count, Finite, FromList, Names, Positive, Record, Vector

Gaps = Annotated[tuple[Finite, ...], Field(min_length=1), FromList]

_AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


class LawSection(Record):
    """Contact law, of a mesh and of matrices alike."""

    law: Literal["complementarity", "augmented-lagrangian"] | None = Field(
        None, description="by default the one that fits reduction.method"
    )
    reference_displacement: Positive | None = Field(
        None,
        description="displacement in m, at gamma ratio 1, of points that touch without force at "
        "rest (gap 0); positive",
    )


class MatrixContactSection(LawSection):
    """Gaps of the contact rows of [matrices]."""

    gap: Finite | Gaps = Field(
        description="initial gap in m, negative for an interference: one number, or a list "
        "with one a contact row"
    )

    @model_validator(mode="before")
    @classmethod
    def _nothing_of_a_mesh(cls, values: Any) -> Any:
        for key in ("facets", "direction", "axis", "origin", "points"):
            if isinstance(values, dict) and key in values:
                raise ValueError(
                    f"{key}: belongs to [mesh]: with [matrices] each contact row is a contact "
                    "point, with its direction"
                )
        return values


class ContactSection(LawSection):
    """Facets that can meet a rigid obstacle."""

    facets: Names = Field(description="name of a group of facets, or a list of names")
    direction: Literal["normal", "radial"] | Vector = Field(
        "normal",
        description='towards the obstacle: "normal", "radial", or a vector of finite numbers',
    )
    axis: Literal["x", "y", "z"] | Vector | None = Field(
        None, description='axis of a radial direction: "x", "y", "z" or a vector of finite numbers'
    )
    origin: Vector | None = Field(None, description="a point on the axis in m; the default is 0")
    gap: Finite = Field(description="initial gap in m, negative for an interference")
    points: Count | Literal["all"] = Field(
        "all", description='positive number of points spread over the facets, or "all" vertices'
    )

    @model_validator(mode="before")
    @classmethod
    def _one_gap(cls, values: Any) -> Any:
        if isinstance(values, dict) and isinstance(values.get("gap"), list):
            raise ValueError(
                f"gap = {shown(values['gap'])}: must be one number in m: a list, with one gap a "
                "contact row, belongs to [matrices]"
            )
        return values

    @model_validator(mode="after")
    def _axis_fits_direction(self) -> ContactSection:
        radial = self.direction == "radial"
        if radial and self.axis is None:
            raise ValueError('direction = "radial" needs axis = "x", "y", "z" or a vector')
        if not radial and (self.axis is not None or self.origin is not None):
            raise ValueError('axis and origin belong to direction = "radial"')
        for name in ("direction", "axis"):
            vector = getattr(self, name)
            if isinstance(vector, tuple) and not any(vector):
                raise ValueError(f"{name} = {list(vector)}: must not be zero")
        return self

    @property
    def axis_vector(self) -> tuple[float, ...]:
        """The axis as a vector, empty without one."""
        return _AXES[self.axis] if isinstance(self.axis, str) else self.axis or ()
