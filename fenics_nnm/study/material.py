"""Sections of the study file about materials."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, model_validator

from fenics_nnm.materials.elasticity import Isotropic, Orthotropic
from fenics_nnm.materials.library import library_material
from fenics_nnm.materials.material import STRENGTHS, Material
from fenics_nnm.materials.orientation import XYZ, Axes, Cylindrical, Orientation, euler_axes
from fenics_nnm.study.record import (
    Coordinate,
    Finite,
    FromList,
    Name,
    Names,
    Positive,
    Record,
    Stress,
    axis_vector,
)

ThreePositive = Annotated[tuple[Positive, Positive, Positive], FromList]
ThreeFinite = Annotated[tuple[Finite, Finite, Finite], FromList]
ThreeCoordinates = Annotated[tuple[Coordinate, Coordinate, Coordinate], FromList]


class OrientationSection(Record):
    """Material axes 1, 2, 3: the same everywhere, or turning about an axis."""

    axes: Annotated[tuple[ThreeFinite, ThreeFinite], FromList] | None = Field(
        None, description="[[x, y, z], [x, y, z]]: axis 1, and a vector towards axis 2"
    )
    euler: ThreeFinite | None = Field(
        None, description="three angles in degrees, about z, the new x and the new z"
    )
    cylindrical: Literal["x", "y", "z"] | ThreeFinite | None = Field(
        None, description='axis of radial, circumferential, axial: "x", "y", "z" or three numbers'
    )
    origin: ThreeCoordinates | None = Field(
        None, description="a point on the axis of cylindrical in m; the default is 0"
    )

    @model_validator(mode="after")
    def _one_way(self) -> OrientationSection:
        if sum(each is not None for each in (self.axes, self.euler, self.cylindrical)) != 1:
            raise ValueError("must have one of axes, euler and cylindrical")
        if self.origin is not None and self.cylindrical is None:
            raise ValueError("origin: belongs to cylindrical")
        if isinstance(self.cylindrical, tuple) and not any(self.cylindrical):
            raise ValueError(f"cylindrical = {list(self.cylindrical)}: must not be zero")
        if self.axes is not None:
            Axes(*self.axes)  # refuses parallel vectors
        return self

    @property
    def orientation(self) -> Orientation:
        """The axes that the section means."""
        if self.axes is not None:
            return Axes(*self.axes)
        if self.euler is not None:
            return euler_axes(self.euler)
        assert self.cylindrical is not None
        x, y, z = axis_vector(self.cylindrical)
        return Cylindrical((x, y, z), self.origin or (0.0, 0.0, 0.0))


class _MaterialSection(Record):
    cells: Names | None = Field(None, description="name of a group of cells, or a list of names")
    yield_strength: Stress | None = Field(None, description="0.2 % yield strength in Pa")
    tensile_strength: Stress | None = Field(None, description="tensile strength in Pa")
    fatigue_strength: Stress | None = Field(
        None, description="amplitude of fully reversed stress that is borne for long in Pa"
    )

    def _strong(self, material: Material) -> Material:
        """A material with the strengths that are given in place of its own."""
        given = {name: getattr(self, name) for name in STRENGTHS}
        return replace(material, **{name: value for name, value in given.items() if value})


class IsotropicSection(_MaterialSection):
    """Isotropic linear elasticity."""

    young: Positive = Field(description="Young's modulus in Pa")
    poisson: float = Field(0.0, gt=-1, lt=0.5, description="Poisson's ratio, above -1, below 0.5")
    density: Positive = Field(description="mass density in kg/m^3")
    expansion: Finite | None = Field(None, description="thermal expansion in 1/K")

    @property
    def material(self) -> Material:
        """The material that the section means."""
        expansion = None if self.expansion is None else (self.expansion,) * 3
        law = Isotropic(self.young, self.poisson)
        return self._strong(Material(law, self.density, expansion=expansion))


class OrthotropicSection(_MaterialSection):
    """Orthotropic linear elasticity by engineering constants."""

    young: ThreePositive = Field(description="[E1, E2, E3] in Pa")
    poisson: ThreeFinite = Field(description="[nu12, nu23, nu13]")
    shear: ThreePositive = Field(description="[G12, G23, G13] in Pa")
    density: Positive = Field(description="mass density in kg/m^3")
    expansion: ThreeFinite | None = Field(
        None, description="[a1, a2, a3], thermal expansion along the material axes in 1/K"
    )
    orientation: OrientationSection | None = Field(
        None, description="{ axes }, { euler } or { cylindrical, origin }; the default is x, y, z"
    )

    @model_validator(mode="after")
    def _admissible(self) -> OrthotropicSection:
        Orthotropic(self.young, self.poisson, self.shear)  # refuses negative strain energy
        return self

    @property
    def material(self) -> Material:
        """The material that the section means."""
        law = Orthotropic(self.young, self.poisson, self.shear)
        axes = _axes(self.orientation)
        return self._strong(Material(law, self.density, axes, expansion=self.expansion))


class NamedSection(_MaterialSection):
    """A material of the library."""

    name: Name = Field(description="name of a material of the library")
    orientation: OrientationSection | None = Field(
        None, description="{ axes }, { euler } or { cylindrical, origin }; the default is x, y, z"
    )

    @model_validator(mode="after")
    def _known(self) -> NamedSection:
        isotropic = isinstance(library_material(self.name).law, Isotropic)
        if isotropic and self.orientation is not None:
            raise ValueError(f'orientation: has no effect: "{self.name}" is isotropic')
        return self

    @property
    def material(self) -> Material:
        """The material that the section means."""
        return self._strong(library_material(self.name, _axes(self.orientation)))


AnyMaterial = NamedSection | OrthotropicSection | IsotropicSection

Materials = Annotated[
    tuple[AnyMaterial, ...],
    Field(min_length=1),
    BeforeValidator(lambda given: (given,) if isinstance(given, dict | Record) else given),
    FromList,
]
"""One section [material], or several [[material]]."""


def material_record(values: dict[str, Any]) -> type[AnyMaterial]:
    """Record that a section is meant for, so that messages speak of that one alone."""
    if "name" in values:
        return NamedSection
    if "shear" in values or isinstance(values.get("young"), list):
        return OrthotropicSection
    return IsotropicSection


def _axes(section: OrientationSection | None) -> Orientation:
    return section.orientation if section else XYZ
