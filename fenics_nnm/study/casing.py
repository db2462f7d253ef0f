"""Section of the study file about the surface of a rigid casing."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, model_validator

from fenics_nnm.study.messages import shown
from fenics_nnm.study.record import Count, Finite, FromList, Positive, Record, Vector, axis_vector

Pairs = Annotated[
    tuple[Annotated[tuple[Finite, Positive], FromList], ...], Field(min_length=2), FromList
]
Axis = Literal["x", "y", "z"] | Vector

#: Keys that a shape needs, and those that it may have besides.
_ROUND = {"origin", "clearance", "body"}
_KEYS: dict[str, tuple[set[str], set[str]]] = {
    "cylinder": ({"axis", "radius"}, _ROUND),
    "cone": ({"axis", "radius"}, {*_ROUND, "half_angle_deg", "end_radius", "length"}),
    "lobed": ({"axis", "lobes", "amplitude"}, {*_ROUND, "radius", "profile", "phase_deg", "zero"}),
    "table": ({"axis", "file"}, {*_ROUND, "zero"}),
    "plane": ({"origin", "normal"}, {"clearance"}),
}


class CasingSection(Record):
    """A rigid surface; the gap of a contact point is its distance along the contact direction."""

    shape: Literal["cylinder", "cone", "lobed", "table", "plane"] = Field(
        description='"cylinder", "cone", "lobed", "table" or "plane"'
    )
    axis: Axis | None = Field(
        None, description='axis of the casing: "x", "y", "z" or a vector of finite numbers'
    )
    origin: Vector | None = Field(None, description="a point on the axis, or of the plane, in m")
    radius: Positive | None = Field(None, description="radius at the origin in m, positive")
    half_angle_deg: float | None = Field(
        None,
        gt=-90,
        lt=90,
        description="angle between axis and surface in degrees, positive where the radius grows",
    )
    end_radius: Positive | None = Field(None, description="radius at `length` in m, positive")
    length: Positive | None = Field(None, description="from radius to end_radius in m, positive")
    lobes: Count | None = Field(None, description="number of lobes, positive")
    amplitude: Positive | None = Field(None, description="height of a lobe in m, positive")
    phase_deg: Finite | None = Field(None, description="angle of a largest radius in degrees")
    profile: Pairs | None = Field(
        None, description="[[x, r], ...]: axial coordinates, ascending, and mean radii in m"
    )
    file: Annotated[Path | None, Field(strict=False, description="a .csv file of radii")] = None
    zero: Axis | None = Field(
        None, description='direction of angle zero: "x", "y", "z" or a vector of finite numbers'
    )
    normal: Vector | None = Field(None, description="direction from the body to the plane")
    body: Literal["inside", "outside"] | None = Field(
        None, description='where the body is: "inside" a casing or "outside", around a shaft'
    )
    clearance: Finite = Field(0.0, description="added to the distance, in m")

    @model_validator(mode="after")
    def _keys_fit_shape(self) -> CasingSection:
        needed, possible = _KEYS[self.shape]
        for key in sorted(needed):
            if getattr(self, key) is None:
                raise ValueError(f'{key}: is missing: shape = "{self.shape}" needs it')
        for key in sorted(type(self).model_fields.keys() - needed - possible - {"shape"}):
            if getattr(self, key) != type(self).model_fields[key].default:
                known = ", ".join(sorted(needed | possible))
                raise ValueError(
                    f'{key}: does not belong to shape = "{self.shape}": it has {known}'
                )
        for key in ("axis", "normal", "zero"):
            vector = getattr(self, key)
            if isinstance(vector, tuple) and not any(vector):
                raise ValueError(f"{key} = {list(vector)}: must not be zero")
        return self

    @model_validator(mode="after")
    def _cone_is_given_once(self) -> CasingSection:
        by_radii = (self.end_radius is not None, self.length is not None)
        if self.shape == "cone" and (
            any(by_radii) != all(by_radii) or any(by_radii) == (self.half_angle_deg is not None)
        ):
            raise ValueError('shape = "cone": needs either half_angle_deg or end_radius and length')
        return self

    @model_validator(mode="after")
    def _lobes_have_one_mean_radius(self) -> CasingSection:
        if self.shape != "lobed":
            return self
        if (self.radius is None) == (self.profile is None):
            raise ValueError('shape = "lobed": needs either radius or profile')
        stations = [x for x, _ in self.profile or ()]
        if stations != sorted(set(stations)):
            raise ValueError("profile: axial coordinates must rise from pair to pair")
        return self

    @model_validator(mode="after")
    def _zero_is_known(self) -> CasingSection:
        if self.shape not in ("lobed", "table"):
            return self
        if self.zero is None and not isinstance(self.axis, str):
            raise ValueError("zero: is missing: the direction of angle zero about such an axis")
        axis, zero = axis_vector(self.axis), axis_vector(self.zero)
        product = sum(x * y for x, y in zip(axis, zero, strict=False))
        lengths = sum(x * x for x in axis) * sum(y * y for y in zero)
        if self.zero is not None and product**2 > (1 - 1e-12) * lengths:
            raise ValueError(f"zero = {shown(self.zero)}: must not be along the axis")
        return self
