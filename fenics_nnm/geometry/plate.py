"""A rectangle in two dimensions."""

import math
from typing import Literal, Self

from pydantic import Field, model_validator

from fenics_nnm.geometry.lengths import LengthUnit
from fenics_nnm.geometry.parameters import Count, GeometryRecord, GmshModel, Length, check_count


class Plate(GeometryRecord):
    """Rectangle from the origin to (`length`, `height`), meshed in a regular grid.

    Groups: cells "body"; edges "left" (x = 0), "right" (x = `length`), "bottom" (y = 0) and
    "top" (y = `height`).
    """

    model: Literal["plate"] = "plate"
    length_unit: LengthUnit = Field(
        default="m", description="unit of the lengths here and of the mesh"
    )
    length: Length = Field(description="size along x, in length_unit")
    height: Length = Field(description="size along y, in length_unit")
    elements: tuple[Count, Count] = Field(description="grid intervals along x and y")
    cells: Literal["triangle", "quadrilateral"] = Field(
        default="quadrilateral", description="each grid cell is one quadrilateral or two triangles"
    )

    @model_validator(mode="after")
    def _few_elements(self) -> Self:
        check_count("elements", math.prod(self.elements))
        return self

    def build(self, gmsh_model: GmshModel) -> None:
        """Fill the current gmsh model with geometry, mesh and named groups."""
        sides = self._add_sides(gmsh_model.geo)
        surface = gmsh_model.geo.addPlaneSurface(
            [gmsh_model.geo.addCurveLoop(list(sides.values()))]
        )
        gmsh_model.geo.synchronize()
        for name, curve in sides.items():
            intervals = self.elements[0] if name in ("bottom", "top") else self.elements[1]
            gmsh_model.mesh.setTransfiniteCurve(curve, intervals + 1)
            gmsh_model.addPhysicalGroup(1, [curve], name=name)
        gmsh_model.addPhysicalGroup(2, [surface], name="body")
        gmsh_model.mesh.setTransfiniteSurface(surface, "Alternate")
        if self.cells == "quadrilateral":
            gmsh_model.mesh.setRecombine(2, surface)
        gmsh_model.mesh.generate(2)

    def _add_sides(self, geo: GmshModel) -> dict[str, int]:
        """Add the four edges, anticlockwise; return their tags by name."""
        corners = ((0, 0), (self.length, 0), (self.length, self.height), (0, self.height))
        points = [geo.addPoint(x, y, 0) for x, y in corners]
        names = ("bottom", "right", "top", "left")
        return {name: geo.addLine(points[i], points[(i + 1) % 4]) for i, name in enumerate(names)}
