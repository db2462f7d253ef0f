"""Sections of the study file about contact."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, model_validator

from fenics_nnm.study.casing import CasingSection
from fenics_nnm.study.messages import shown
from fenics_nnm.study.record import (
    Along,
    Coordinate,
    Count,
    Finite,
    FromList,
    Label,
    Length,
    Names,
    Place,
    Record,
    Vector,
    axis_vector,
)
from fenics_nnm.study.reduction import Law

Gaps = Annotated[tuple[Coordinate, ...], Field(min_length=1), FromList]
Growths = Annotated[tuple[Finite, ...], Field(min_length=1), FromList]


class GapMotionSection(Record):
    """A harmonic of gaps that move with the rotation."""

    order: Annotated[int, Field(gt=0, le=1000)] = Field(
        description="multiple of the speed of rotation, from 1"
    )
    amplitude: Coordinate | Gaps = Field(
        description="amplitude a in m, 0-peak, of a cos(order speed t + phase) beside the gap: one "
        "number, or a list with one a contact row"
    )
    phase_deg: Finite | Growths = Field(
        0.0, description="phase in degrees: one number, or a list with one a contact row"
    )


class LawSection(Record):
    """Contact law, of a mesh and of matrices alike."""

    law: Law | None = Field(None, description="by default the one that fits reduction.method")
    reference_displacement: Length | None = Field(
        None,
        description="displacement in m, at gamma ratio 1, of points that touch without force at "
        "rest (gap 0); positive",
    )

    @property
    def patches(self) -> dict[str, PatchSection]:
        """Patches of a mesh by their places in the study file, none with matrices."""
        return {}

    @property
    def passing_orders(self) -> tuple[int, ...]:
        """Multiples of the speed at which gaps move in a response, none where they stand still."""
        orders = (each.casing.passing_order for each in self.patches.values() if each.casing)
        return tuple(order for order in orders if order)


class PatchSection(Record):
    """Facets that can meet a rigid obstacle, or other facets of the body."""

    name: Label | None = Field(None, description="name of the patch, for the results")
    facets: Names = Field(description="name of a group of facets, or a list of names")
    against: Names | None = Field(
        None, description="facets of the same mesh that they can meet: a name, or a list of names"
    )
    direction: Literal["normal", "radial", "casing"] | Along | Vector = Field(
        "normal",
        description='towards the obstacle: "normal", "radial", "casing", "x", "-x", "y", "-y", '
        '"z", "-z", or a vector of finite numbers, such as [0, 1, 0]',
    )
    axis: Literal["x", "y", "z"] | Vector | None = Field(
        None, description='axis of a radial direction: "x", "y", "z" or a vector of finite numbers'
    )
    origin: Place | None = Field(None, description="a point on the axis in m; the default is 0")
    gap: Coordinate | None = Field(
        None, description="initial gap in m, negative for an interference"
    )
    casing: CasingSection | None = Field(
        None, description="a section that describes a rigid surface"
    )
    points: Count | Literal["all"] = Field(
        "all", description='positive number of points spread over the facets, or "all" vertices'
    )
    rows: Literal["vertices", "averaged"] = Field(
        "vertices",
        description='displacement of a contact point: "vertices", that of its vertex, or '
        '"averaged", the mean about it',
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
    def _axis_fits_direction(self) -> PatchSection:
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

    @model_validator(mode="after")
    def _gap_is_given_once(self) -> PatchSection:
        if self.direction == "casing" and self.casing is None:
            raise ValueError('direction = "casing": needs a section casing')
        if self.direction == "casing" and self.casing and self.casing.passing_order:
            raise ValueError(
                'direction = "casing": does not go with casing.frame = "fixed", whose normals pass '
                'by: must be "radial", "normal" or a vector'
            )
        if self.casing is not None and (self.gap is not None or self.against is not None):
            key = "gap" if self.gap is not None else "against"
            raise ValueError(
                f"{key}: does not go with casing, whose distance is the gap (casing.clearance "
                "adds to it)"
            )
        if self.rows == "averaged" and self.against is not None:
            raise ValueError(
                'rows = "averaged": does not go with against: must be "vertices", whose '
                "counterparts are single places"
            )
        if self.gap is None and self.casing is None and self.against is None:
            raise ValueError("gap: is missing (initial gap; or a section casing, or against)")
        return self

    @property
    def axis_vector(self) -> tuple[float, ...]:
        """The axis as a vector, empty without one."""
        return axis_vector(self.axis)


class MatrixContactSection(LawSection):
    """Gaps of the contact rows of [matrices]."""

    absent: ClassVar[Mapping[str, str]] = dict.fromkeys(
        (PatchSection.model_fields.keys() - {"gap"}) | {"patch"},
        "belongs to [mesh]: with [matrices] each contact row is a contact point, with its "
        "direction",
    )

    gap: Coordinate | Gaps = Field(
        description="initial gap in m, negative for an interference: one number, or a list "
        "with one a contact row"
    )
    gap_growth: Finite | Growths | None = Field(
        None,
        description="what the square of matrices.speed adds to the gap, m s^2: one number, or a "
        "list with one a contact row",
    )
    gap_motion: Annotated[tuple[GapMotionSection, ...], FromList] = Field(
        (), description="sections [[contact.gap_motion]]: how gaps move in a response"
    )

    @property
    def passing_orders(self) -> tuple[int, ...]:
        """Multiples of the speed at which gaps move in a response, none where they stand still."""
        return tuple(each.order for each in self.gap_motion)

    @model_validator(mode="after")
    def _orders_differ(self) -> MatrixContactSection:
        orders = self.passing_orders
        for order in orders:
            if orders.count(order) > 1:
                raise ValueError(f"gap_motion: {orders.count(order)} have order = {order}")
        return self


class ContactSection(LawSection, PatchSection):
    """One patch, with the contact law."""

    @property
    def patches(self) -> dict[str, PatchSection]:
        """The patch by its place in the study file."""
        return {"contact": self}


class PatchesSection(LawSection):
    """Several patches, with the contact law of all."""

    absent: ClassVar[Mapping[str, str]] = dict.fromkeys(
        PatchSection.model_fields,
        "belongs to one of the patches: must stand under [[contact.patch]]",
    )

    patch: Annotated[tuple[PatchSection, ...], Field(min_length=1), FromList] = Field(
        description="sections [[contact.patch]]"
    )

    @model_validator(mode="after")
    def _names_differ(self) -> PatchesSection:
        names = [patch.name for patch in self.patch if patch.name is not None]
        for name in names:
            if names.count(name) > 1:
                raise ValueError(f'patch: {names.count(name)} have the name "{name}": must differ')
        return self

    @property
    def patches(self) -> dict[str, PatchSection]:
        """The patches by their places in the study file."""
        return {f"contact.patch[{i + 1}]": patch for i, patch in enumerate(self.patch)}
