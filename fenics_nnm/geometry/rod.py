"""A straight rod in one dimension."""

from typing import Literal

from pydantic import Field

from fenics_nnm.geometry.lengths import LengthUnit
from fenics_nnm.geometry.parameters import Count, GeometryRecord, GmshModel, Length


class Rod(GeometryRecord):
    """Rod along x from 0 to `length`, divided into equal intervals.

    Groups: cells "body"; end points "left" (x = 0) and "right" (x = `length`).
    """

    model: Literal["rod"] = "rod"
    length_unit: LengthUnit = Field(
        default="m", description="unit of the lengths here and of the mesh"
    )
    length: Length = Field(description="length along x, in length_unit")
    elements: Count = Field(description="number of equal intervals")

    def build(self, gmsh_model: GmshModel) -> None:
        """Fill the current gmsh model with geometry, mesh and named groups."""
        geo = gmsh_model.geo
        left, right = geo.addPoint(0, 0, 0), geo.addPoint(self.length, 0, 0)
        line = geo.addLine(left, right)
        geo.synchronize()
        gmsh_model.mesh.setTransfiniteCurve(line, self.elements + 1)
        for dim, tag, name in ((1, line, "body"), (0, left, "left"), (0, right, "right")):
            gmsh_model.addPhysicalGroup(dim, [tag], name=name)
        gmsh_model.mesh.generate(1)
