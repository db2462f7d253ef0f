"""Sections of the study file about a mesh, or a geometry to be meshed, of another program."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, ClassVar

from pydantic import Field, model_validator

from fenics_nnm.geometry.lengths import LengthUnit
from fenics_nnm.geometry.parameters import Length
from fenics_nnm.study.record import Count, FromList, Names, OneOrTwo, Positive, Record

#: Endings of files with a geometry, which is meshed here.
CAD_ENDINGS = (".step", ".stp", ".iges", ".igs", ".brep", ".geo")

_OF_GEOMETRIES = (
    "element_size",
    "order",
    "refine",
    "curvature",
    "ignore_declared_unit",
    "trust_script",
)

_Unit = Annotated[LengthUnit, Field(description="the unit of the file's coordinates")]


class _File(Record):
    """A file that a process of its own reads, and what that may take."""

    memory: Positive | None = Field(
        None, description="GiB that reading and meshing may take; 80 % of what is free if not given"
    )
    time: Positive | None = Field(
        None, description="seconds that reading and meshing may take, each time"
    )


class MeshFile(_File):
    """A mesh made elsewhere, with named groups."""

    absent: ClassVar[Mapping[str, str]] = dict.fromkeys(
        _OF_GEOMETRIES,
        f"belongs to a geometry ({', '.join(CAD_ENDINGS)}): the file has a mesh",
    )

    file: Annotated[Path, Field(strict=False, description="a mesh file, relative to the study")]
    length_unit: _Unit


class Refinement(Record):
    """Smaller elements at some facets."""

    facets: Names = Field(description="name of a group of facets, or a list of names")
    size: Length = Field(description="edge length of the elements there, in length_unit")
    distance: Length = Field(
        description="distance over which elements grow to element_size, in length_unit"
    )


class CadFile(_File):
    """A geometry of a CAD program, or of gmsh, to be meshed."""

    file: Annotated[Path, Field(strict=False, description="a CAD file, relative to the study")]
    length_unit: _Unit
    ignore_declared_unit: bool = Field(
        False, description="true: take the file's numbers in length_unit whatever unit it declares"
    )
    trust_script: bool = Field(
        False, description="true: a .geo script may start programs, and read and write any file"
    )
    element_size: Length | None = Field(
        None, description="largest edge length of the elements, in length_unit"
    )
    order: OneOrTwo = Field(1, description="1: straight elements, 2: curved ones")
    curvature: Count | None = Field(
        None, description="number of elements on a full turn of a curved face"
    )
    refine: Annotated[tuple[Refinement, ...], FromList] = Field(
        (), description="list of { facets, size, distance }"
    )

    @model_validator(mode="after")
    def _sizes_fit(self) -> CadFile:
        if self.trust_script and self.file.suffix.lower() != ".geo":
            raise ValueError("trust_script: has no effect: the file is no script (.geo)")
        if self.element_size is None and self.file.suffix.lower() != ".geo":
            raise ValueError(
                "element_size: is missing (largest edge length of the elements, in length_unit)"
            )
        for refinement in self.refine:
            if self.element_size is None:
                raise ValueError("refine: needs element_size, the size far from the facets")
            if refinement.size >= self.element_size:
                raise ValueError(
                    f"refine.size = {refinement.size:g}: must be below element_size = "
                    f"{self.element_size:g}"
                )
        return self
