"""Section of the study file about facets that move as a rigid body."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from fenics_nnm.study.record import FromList, Names, NotNegative, Place, Positive, Record

Moments = Annotated[tuple[NotNegative, ...], Field(min_length=1, max_length=3), FromList]

#: Names of the axes of a point, in the order of its coordinates.
AXIS_NAMES = ("x", "y", "z", "rx", "ry", "rz")

Held = Annotated[
    tuple[Literal["x", "y", "z", "rx", "ry", "rz"], ...], Field(min_length=1), FromList
]


#: A moment may be larger than the sum of the others by this, relative to the sum: round-off.
_ROUND_OFF = 1e-9


class RigidSection(Record):
    """Facets that follow a point as a rigid body, with a mass there or a clamp of the point."""

    facets: Names = Field(description="name of a group of facets, or a list of names")
    at: Place = Field(description="coordinates of the point in m, anywhere")
    mass: Positive | None = Field(None, description="mass at the point in kg")
    inertia: Moments | None = Field(
        None,
        description="[Jx, Jy, Jz] in kg m^2 about axes through the point; [Jz] of a mesh in 2-D",
    )
    directions: Held | None = Field(
        None, description='what is zero at the point: list of "x", "y", "z", "rx", "ry", "rz"'
    )

    @model_validator(mode="after")
    def _directions_differ(self) -> RigidSection:
        if self.directions and len(set(self.directions)) < len(self.directions):
            raise ValueError(f"directions = {list(self.directions)}: must be different ones")
        return self

    @model_validator(mode="after")
    def _inertia_is_of_a_body(self) -> RigidSection:
        """J_x <= J_y + J_z and so on: the difference is twice an integral of x^2 over the mass."""
        moments = self.inertia or ()
        for axis, largest in zip("xyz", moments, strict=False):
            others = sum(moments) - largest
            if len(moments) == 3 and largest > others * (1 + _ROUND_OFF):
                raise ValueError(
                    f"inertia = {list(moments)}: no body has J{axis} = {largest:.10g}: must be "
                    f"at most the sum of the other two, {others:.10g}"
                )
        return self
