"""A turbomachinery blade lofted through the sections of a table."""

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Literal, NamedTuple, Self

import numpy as np
from pydantic import Field, model_validator
from scipy.interpolate import make_interp_spline

from fenics_nnm.errors import GeometryError
from fenics_nnm.geometry.parameters import Count, GeometryRecord, GmshModel, Length, LengthUnit
from fenics_nnm.geometry.section_lines import MOST_EDGE_CUT, SectionLines, section_lines
from fenics_nnm.geometry.sections import Section, read_sections

_log = logging.getLogger(__name__)

_STATIONS = 31  # along each side of a section; a fine table needs no more
_GROWTH_DISTANCE = 3.0  # element sizes from the edges to the full element size
_HXT = 10  # fewer slivers than the default Delaunay algorithm
_MESH_OPTIONS: dict[str, float] = {
    "Mesh.Algorithm3D": _HXT,
    "Mesh.MeshSizeExtendFromBoundary": 0,  # the size field alone gives the size
    "Mesh.MeshSizeFromPoints": 0,
    "Mesh.MeshSizeFromCurvature": 0,
    "Mesh.MinimumCurveNodes": 2,  # the strips need no node amid their width
}


class Blade(GeometryRecord):
    """Blade between two sections of a table, fixed at the inner one and free at the outer one.

    The machine axis is x: a table point (z, r, theta) lies at x = z, y = r sin(theta),
    z = r cos(theta), so a blade near theta = 0 stands along +z. Section lines are cubic splines;
    the sides are smooth surfaces through all sections from `first_section` to `last_section`.

    Groups: cells "body"; faces "root" (first section), "tip" (last section) and "surface" (all
    others).

    What is simplified:
        The round noses are replaced by narrow flat strips across the mean line, `edge_cut` times
        the length of the mean line behind the foremost point. For NASA rotor 37 and 0.2 % that
        is 0.11 mm of 56 mm of chord at each edge; the strips are 0.2 mm to 0.5 mm wide, and less
        than 0.1 % of the volume is lost. Stresses at the edges are not those of a round nose.
        There are no fillet and no disk. The root and tip faces are made of straight lines across
        the thickness: their rims lie on the surfaces of revolution of the table, their middles
        up to 0.03 mm (root) and 0.007 mm (tip) inside. Elements have straight sides.
    """

    model: Literal["blade"] = "blade"
    length_unit: LengthUnit = Field(
        default="m", description="unit of the lengths here and of the mesh"
    )
    sections: Path = Field(
        description="CSV table with columns section, j, z_<unit>, r_<unit>, theta1_rad, theta2_rad"
    )
    first_section: Count = Field(default=1, description="number of the root section in the table")
    last_section: Count | None = Field(
        default=None,
        description="number of the tip section in the table; without it the last but one, as the "
        "last of many tables lies inside the casing",
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

    def selected_sections(self) -> list[Section]:
        """Read the table; return the sections of the blade, hub first, in length_unit.

        Raises:
            GeometryError: The table is wrong or lacks a section asked for.
        """
        sections = read_sections(self.sections, self.length_unit)
        numbers = [section.number for section in sections]
        last = self.last_section or numbers[max(len(numbers) - 2, 0)]
        for key, number in (("first_section", self.first_section), ("last_section", last)):
            if number not in numbers:
                raise GeometryError(
                    f"{self.sections}: {key} = {number}: the table has {numbers[0]}..{numbers[-1]}"
                )
        if last <= self.first_section:
            raise GeometryError(
                f"last_section = {last}: must be larger than first_section = {self.first_section}"
            )
        return [section for section in sections if self.first_section <= section.number <= last]

    def build(self, gmsh_model: GmshModel) -> None:
        """Fill the current gmsh model with geometry, mesh and named groups.

        Raises:
            GeometryError: The table is wrong, or its sections give no valid solid or mesh.
        """
        sections = self.selected_sections()
        try:
            lines = [section_lines(s, edge_cut=self.edge_cut, count=_STATIONS) for s in sections]
        except GeometryError as error:
            raise GeometryError(f"{self.sections}: {error}") from error
        try:
            solid = _loft(gmsh_model, lines)
            self._mesh(gmsh_model, solid)
        except Exception as error:  # gmsh raises no narrower class
            raise GeometryError(f"{self.sections}: gmsh cannot mesh the blade: {error}") from error
        _check_cells(gmsh_model, self.sections)

    def _mesh(self, gmsh_model: GmshModel, solid: "_Solid") -> None:
        """Name the groups and mesh them, finer towards the long edges."""
        gmsh_model.addPhysicalGroup(3, [solid.volume], name="body")
        gmsh_model.addPhysicalGroup(2, [solid.root], name="root")
        gmsh_model.addPhysicalGroup(2, [solid.tip], name="tip")
        gmsh_model.addPhysicalGroup(2, solid.surface, name="surface")
        self._add_size_field(gmsh_model.mesh.field, solid.edges)
        with _options(_MESH_OPTIONS):
            gmsh_model.mesh.generate(3)

    def _add_size_field(self, field: GmshModel, edges: list[int]) -> None:
        """Element size: edge_size on the edges, rising linearly to element_size."""
        distance = field.add("Distance")
        field.setNumbers(distance, "CurvesList", edges)
        field.setNumber(distance, "Sampling", 200)
        size = field.add("Threshold")
        field.setNumber(size, "InField", distance)
        field.setNumber(size, "SizeMin", self.edge_size or self.element_size / 3)
        field.setNumber(size, "SizeMax", self.element_size)
        field.setNumber(size, "DistMin", 0)
        field.setNumber(size, "DistMax", _GROWTH_DISTANCE * self.element_size)
        field.setAsBackgroundMesh(size)


class _Solid(NamedTuple):
    """Tags of the blade in gmsh: faces but `volume`, and `edges`, the spanwise curves."""

    volume: int
    root: int
    tip: int
    surface: list[int]
    edges: list[int]


def _loft(gmsh_model: GmshModel, lines: list[SectionLines]) -> _Solid:
    """Make the solid; OCC lofts only the sides when the end sections are not plane."""
    occ = gmsh_model.occ
    outlines = [_add_outline(occ, line) for line in lines]
    wires = [occ.addWire(outline) for outline in outlines]
    sides = occ.addThruSections(wires, makeSolid=False)
    occ.remove([(1, curve) for outline in outlines for curve in outline], recursive=True)
    occ.synchronize()
    _remove_control_points(gmsh_model, sides)
    rims = _curves(gmsh_model, sides, combined=True)
    edges = sorted(set(_curves(gmsh_model, sides, combined=False)) - set(rims))
    inner, outer = _split_rims(gmsh_model, rims, edges)
    root, tip = (occ.addBSplineFilling(occ.addWire(rim), type="Stretch") for rim in (inner, outer))
    surface = [tag for _, tag in sides]
    volume = occ.addVolume([occ.addSurfaceLoop([*surface, root, tip])])
    occ.synchronize()
    return _Solid(volume, root, tip, surface, edges)


def _add_outline(occ: GmshModel, lines: SectionLines) -> list[int]:
    """Add the closed outline of a section: two splines and two straight strips."""
    corners = [[occ.addPoint(*side[end]) for end in (0, -1)] for side in lines.sides]
    (a, b), (d, c) = corners
    there = _add_spline(occ, lines.parameter, lines.sides[0], (a, b))
    back = _add_spline(occ, 1 - lines.parameter[::-1], lines.sides[1, ::-1], (c, d))
    return [there, occ.addLine(b, c), back, occ.addLine(d, a)]


def _add_spline(
    occ: GmshModel, parameter: np.ndarray, points: np.ndarray, ends: tuple[int, int]
) -> int:
    """Add the cubic spline through `points` between two existing points.

    All sections share the knots; otherwise the loft would unite as many sets as sections.
    """
    spline = make_interp_spline(parameter, points, k=3)
    knots, multiplicities = np.unique(spline.t, return_counts=True)
    inner = [occ.addPoint(*control) for control in spline.c[1:-1]]
    return occ.addBSpline(
        [ends[0], *inner, ends[1]],
        degree=3,
        knots=knots.tolist(),
        multiplicities=multiplicities.tolist(),
    )


def _remove_control_points(gmsh_model: GmshModel, faces: list[tuple[int, int]]) -> None:
    """Remove the points that bound no face: they would become nodes of the mesh."""
    corners = gmsh_model.getBoundary(faces, recursive=True, oriented=False)
    points = set(gmsh_model.occ.getEntities(0)) - set(corners)
    gmsh_model.occ.remove(sorted(points))
    gmsh_model.occ.synchronize()


def _curves(gmsh_model: GmshModel, faces: list[tuple[int, int]], *, combined: bool) -> list[int]:
    """Curves that bound the faces; combined: only those that bound a single face."""
    boundary = gmsh_model.getBoundary(faces, combined=combined, oriented=False)
    return [tag for _, tag in boundary]


def _split_rims(
    gmsh_model: GmshModel, rims: list[int], edges: list[int]
) -> tuple[list[int], list[int]]:
    """The rim through the inner ends of the spanwise edges, and the other; each in turn."""

    def radius(point: int) -> float:
        _, y, z = gmsh_model.getValue(0, point, [])
        return float(np.hypot(y, z))

    def ends(curve: int) -> set[int]:
        return {tag for _, tag in gmsh_model.getBoundary([(1, curve)], oriented=False)}

    def in_turn(curves: list[int]) -> list[int]:
        chain, rest = curves[:1], curves[1:]
        while rest:
            chain.append(next(curve for curve in rest if ends(curve) & ends(chain[-1])))
            rest.remove(chain[-1])
        return chain

    inner_corners = {min(ends(edge), key=radius) for edge in edges}
    inner = [curve for curve in rims if ends(curve) <= inner_corners]
    return in_turn(inner), in_turn([curve for curve in rims if curve not in inner])


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


def _check_cells(gmsh_model: GmshModel, file: Path) -> None:
    """Refuse inverted elements; log the count and the worst shape."""
    _, (tags,), _ = gmsh_model.mesh.getElements(3)
    if gmsh_model.mesh.getElementQualities(tags, "minDetJac").min() <= 0:
        raise GeometryError(f"{file}: the mesh has inverted elements; try a smaller edge_size")
    worst = gmsh_model.mesh.getElementQualities(tags, "minSICN").min()
    _log.info("blade: %d tetrahedra, worst shape (SICN) %.3f", len(tags), worst)
