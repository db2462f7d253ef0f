"""A turbomachinery blade lofted through the sections of a table."""

import logging
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from typing import Annotated, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from fenics_nnm.errors import GeometryError
from fenics_nnm.geometry.bladed_sector import Part, RootBlock, between_sections, in_passage
from fenics_nnm.geometry.csv_table import CsvTable, read_table
from fenics_nnm.geometry.design import (
    DesignSection,
    Profile,
    design_lines,
    is_design,
    read_design,
)
from fenics_nnm.geometry.lengths import LengthUnit
from fenics_nnm.geometry.parameters import Count, GeometryRecord, GmshModel, Length, check_count
from fenics_nnm.geometry.section_lines import MOST_EDGE_CUT, SectionLines, section_lines
from fenics_nnm.geometry.sections import Section, sections_of
from fenics_nnm.geometry.walls import WallLine, wall_of

_log = logging.getLogger(__name__)

_STATIONS = 31  # along each side of a section; a fine table needs no more
_GROWTH_DISTANCE = 3.0  # element sizes from the edges to the full element size
_FILLET_SIZE = 0.7  # element size in a fillet over its radius
_HXT = 10  # fewer slivers than the default Delaunay algorithm
_MESH_OPTIONS: dict[str, float] = {
    "Mesh.Algorithm3D": _HXT,
    "Mesh.MeshSizeExtendFromBoundary": 0,  # the size field alone gives the size
    "Mesh.MeshSizeFromPoints": 0,
    "Mesh.MeshSizeFromCurvature": 0,
    "Mesh.MinimumCurveNodes": 2,  # the strips need no node amid their width
}


class Blade(GeometryRecord):
    """Blade through sections, on its own between two ends or on a disk sector.

    The machine axis is x: a table point (z, r, theta) lies at x = z, y = r sin(theta),
    z = r cos(theta), so a blade near theta = 0 stands along +z. Sections are those of a table of
    stream surfaces or of a design table; their lines are cubic splines, and the sides are smooth
    surfaces through all of them. An end is the first or last section, or a surface of revolution
    that cuts the blade: `hub`, and `clearance` inside `casing`.

    Groups: cells "body"; faces "root" (inner end), "tip" (outer end) and "surface" (the airfoil).
    With `block` cells "block", "blade" and, around a fillet, "collar", which together are "body";
    faces "bore", "sides" (the two cuts through the disk), "ends" (its faces along the axis),
    "platform", "fillet", and "root", which is bore and sides.

    What is simplified:
        The round noses are replaced by narrow flat strips across the mean line, `edge_cut` times
        the length of the mean line behind the foremost point. For NASA rotor 37 and 0.2 % that
        is 0.11 mm of 56 mm of chord at each edge; the strips are 0.2 mm to 0.5 mm wide, and less
        than 0.1 % of the volume is lost. Stresses at the edges are not those of a round nose.
        An end that is a section is made of straight lines across the thickness: its rim lies on
        the surface of revolution of the table, its middle up to 0.03 mm (rotor 37, root) and
        0.007 mm (tip) inside. A fillet is a circular arc where airfoil and hub are perpendicular,
        and mitred at the edges. Elements have straight sides.
    """

    native: ClassVar[bool] = True

    model: Literal["blade"] = "blade"
    length_unit: LengthUnit = Field(
        default="m", description="unit of the lengths here and of the mesh"
    )
    sections: Path | None = Field(
        default=None,
        description="CSV table of sections: columns section, j, z_<unit>, r_<unit>, theta1_rad, "
        "theta2_rad, or those of a design table",
    )
    design: Annotated[tuple[DesignSection, ...], Field(min_length=2)] | None = Field(
        default=None, description="design table in the study: [{ r, chord, stagger, ... }, ...]"
    )
    profile: Profile | None = Field(
        default=None, description='thickness of a design table: "naca" (default) or "biconvex"'
    )
    first_section: Count | None = Field(
        default=None, description="number of the first section in the table; without it the first"
    )
    last_section: Count | None = Field(
        default=None,
        description="number of the last section in the table; without it the last but one, as the "
        "last of many tables lies inside the casing, or the last if casing is given",
    )
    hub: WallLine | None = Field(
        default=None, description="line of the hub: [[x, r], ...] in length_unit, or a CSV table"
    )
    casing: WallLine | None = Field(
        default=None, description="line of the casing: [[x, r], ...] in length_unit, or a CSV table"
    )
    clearance: Length | None = Field(
        default=None, description="radial distance of the tip from the casing, in length_unit"
    )
    block: RootBlock | None = Field(
        default=None, description="disk sector: { blades, bore, overhang, fillet }"
    )
    element_size: Length = Field(description="edge length of the elements, in length_unit")
    edge_size: Length | None = Field(
        default=None,
        description="edge length at the leading and trailing edges, in length_unit; without it a "
        "third of element_size",
    )
    edge_cut: Annotated[float, Field(gt=0, le=MOST_EDGE_CUT, strict=True)] = Field(
        default=0.002, description="fraction of the mean line left out at each edge (no unit)"
    )

    @model_validator(mode="after")
    def _edges_are_not_coarser(self) -> Self:
        if self.edge_size is not None and self.edge_size > self.element_size:
            raise ValueError(
                f"edge_size = {self.edge_size}: must be at most element_size = {self.element_size}"
            )
        return self

    @model_validator(mode="after")
    def _one_table(self) -> Self:
        if self.sections is None and self.design is None:
            raise ValueError("sections: is missing: a table in a file, or design in its place")
        if self.sections is not None and self.design is not None:
            raise ValueError("design: does not go with sections, the table of a file")
        if self.design is not None:
            for key in ("first_section", "last_section"):
                if getattr(self, key) is not None:
                    raise ValueError(f"{key}: belongs to a table of sections, not to design")
            radii = [section.r for section in self.design]
            if any(outer <= inner for inner, outer in pairwise(radii)):
                raise ValueError("design: r must rise from section to section")
        return self

    @model_validator(mode="after")
    def _walls_go_together(self) -> Self:
        if (self.casing is None) != (self.clearance is None):
            missing = "casing" if self.casing is None else "clearance"
            raise ValueError(f"{missing}: is missing: casing and clearance give the tip together")
        if self.block is not None and self.hub is None:
            raise ValueError("hub: is missing: block needs it as its outer surface")
        return self

    def selected_sections(self) -> list[Section]:
        """Read the table; return the sections of the blade, hub first, in length_unit.

        Raises:
            GeometryError: The table is wrong or lacks a section asked for.
        """
        if self.sections is None:
            raise GeometryError("mesh.sections: is missing: the blade has a design table")
        return self._selected(read_table(self.sections, "mesh.sections"))

    def _selected(self, table: CsvTable) -> list[Section]:
        sections = sections_of(table, self.length_unit)
        numbers = [section.number for section in sections]
        before_last = numbers[max(len(numbers) - 2, 0)]
        first = self.first_section or numbers[0]
        last = self.last_section or (numbers[-1] if self.casing is not None else before_last)
        for key, number in (("first_section", first), ("last_section", last)):
            if number not in numbers:
                raise GeometryError(
                    f"{table.file}: {key} = {number}: the table has {numbers[0]}..{numbers[-1]}"
                )
        if last <= first:
            raise GeometryError(
                f"last_section = {last}: must be larger than first_section = {first}"
            )
        return [section for section in sections if first <= section.number <= last]

    def lines(self) -> list[SectionLines]:
        """Both sides of all sections, hub first, in length_unit.

        Raises:
            GeometryError: The table is wrong.
        """
        if self.design is not None:
            return self._design_lines(self.design)
        table = read_table(Path(str(self.sections)), "mesh.sections")
        if is_design(table):
            if self.first_section or self.last_section:
                raise GeometryError(f"{table.file}: is a design table: has no first_section")
            return self._design_lines(read_design(table, self.length_unit))
        if self.profile is not None:
            raise GeometryError(
                f'mesh.profile = "{self.profile}": belongs to a design table; {table.file} gives '
                "both sides"
            )
        try:
            return [
                section_lines(section, edge_cut=self.edge_cut, count=_STATIONS)
                for section in self._selected(table)
            ]
        except GeometryError as error:
            raise GeometryError(f"{table.file}: {error}") from error

    def _design_lines(self, sections: Sequence[DesignSection]) -> list[SectionLines]:
        profile = self.profile or "naca"
        return design_lines(sections, profile=profile, edge_cut=self.edge_cut, count=_STATIONS)

    def build(self, gmsh_model: GmshModel) -> None:
        """Fill the current gmsh model with geometry, mesh and named groups.

        Raises:
            GeometryError: The table is wrong, or its sections give no valid solid or mesh.
        """
        lines = self.lines()
        try:
            part = self._part(gmsh_model, lines)
            self._mesh(gmsh_model, part)
        except GeometryError:
            raise
        except Exception as error:  # gmsh raises no narrower class
            raise GeometryError(f"{self._name()}: gmsh cannot mesh the blade: {error}") from error
        _check_cells(gmsh_model, self._name())

    def _name(self) -> str:
        """What the blade is made of, for messages."""
        return "mesh.design" if self.sections is None else str(self.sections)

    def _part(self, gmsh_model: GmshModel, lines: list[SectionLines]) -> Part:
        """The solid, between its end sections or cut by the walls."""
        if self.hub is None and self.casing is None:
            return between_sections(gmsh_model, lines)
        walls = [
            None if given is None else wall_of(key, given, self.length_unit)
            for key, given in (("hub", self.hub), ("casing", self.casing))
        ]
        hub, casing = walls
        tip = None if casing is None else casing.raised(-(self.clearance or 0.0))
        return in_passage(gmsh_model, lines, hub, tip, self.block)

    def _mesh(self, gmsh_model: GmshModel, part: Part) -> None:
        """Name the groups and mesh them, finer towards the long edges and in a fillet."""
        everything = [tag for tags in part.cells.values() for tag in tags]
        gmsh_model.addPhysicalGroup(3, everything, name="body")
        if len(part.cells) > 1:
            for name, tags in part.cells.items():
                gmsh_model.addPhysicalGroup(3, tags, name=name)
        for name, tags in part.faces.items():
            gmsh_model.addPhysicalGroup(2, tags, name=name)
        field = gmsh_model.mesh.field
        sizes = [self._size_near(field, part.edges, self.edge_size or self.element_size / 3)]
        if part.foot and self.block is not None and self.block.fillet is not None:
            fine = min(self.element_size, _FILLET_SIZE * self.block.fillet)
            sizes.append(self._size_near(field, part.foot, fine))
        smallest = field.add("Min")
        field.setNumbers(smallest, "FieldsList", sizes)
        field.setAsBackgroundMesh(smallest)
        self._check_count(gmsh_model, everything)
        with _options(_MESH_OPTIONS):
            gmsh_model.mesh.generate(3)

    def _check_count(self, gmsh_model: GmshModel, solids: list[int]) -> None:
        """Refuse sizes that give more elements than anybody means."""
        volume = sum(gmsh_model.occ.getMass(3, tag) for tag in solids)
        size = self.element_size
        try:
            check_count(f"mesh.element_size = {size:g}", 6 * volume / size**3)
        except ValueError as error:
            raise GeometryError(str(error)) from error

    def _size_near(self, field: GmshModel, curves: list[int], size: float) -> int:
        """Element size: `size` on the curves, rising linearly to element_size."""
        distance = field.add("Distance")
        field.setNumbers(distance, "CurvesList", curves)
        field.setNumber(distance, "Sampling", 200)
        threshold = field.add("Threshold")
        field.setNumber(threshold, "InField", distance)
        field.setNumber(threshold, "SizeMin", size)
        field.setNumber(threshold, "SizeMax", self.element_size)
        field.setNumber(threshold, "DistMin", 0)
        field.setNumber(threshold, "DistMax", _GROWTH_DISTANCE * self.element_size)
        return int(threshold)


@contextmanager
def _options(values: dict[str, float]) -> Iterator[None]:
    """Set gmsh options for a while."""
    import gmsh  # heavy, and studies are read on machines and ranks that never mesh

    before = {name: gmsh.option.getNumber(name) for name in values}
    try:
        for name, value in values.items():
            gmsh.option.setNumber(name, value)
        yield
    finally:
        for name, value in before.items():
            gmsh.option.setNumber(name, value)


def _check_cells(gmsh_model: GmshModel, name: str) -> None:
    """Refuse inverted elements; log the count and the worst shape."""
    tags = np.concatenate(gmsh_model.mesh.getElements(3)[1])
    if gmsh_model.mesh.getElementQualities(tags, "minDetJac").min() <= 0:
        raise GeometryError(f"{name}: the mesh has inverted elements; try a smaller edge_size")
    worst = gmsh_model.mesh.getElementQualities(tags, "minSICN").min()
    _log.info("blade: %d tetrahedra, worst shape (SICN) %.3f", len(tags), worst)
