"""A tuning fork in two or three dimensions."""

from typing import Literal

from pydantic import Field

from fenics_nnm.geometry.parameters import GeometryRecord, GmshModel, Length, LengthUnit
from fenics_nnm.geometry.rectangles import Rectangles


class Fork(GeometryRecord):
    """Two tines along +y on a foot, symmetric about x = 0; the foot's upper edge is at y = 0.

    Groups: cells "body"; "foot" (lowest facets), "left inner" and "right inner" (the tines'
    facing sides), "left outer" and "right outer", "left tip" and "right tip" (their ends).
    """

    model: Literal["fork"] = "fork"
    length_unit: LengthUnit = Field(
        default="m", description="unit of the lengths here and of the mesh"
    )
    length: Length = Field(description="length of the tines along y, in length_unit")
    width: Length = Field(description="width of a tine along x, in length_unit")
    distance: Length = Field(description="distance between the tines, in length_unit")
    foot: Length = Field(description="length of the foot along y, in length_unit")
    depth: Length | None = Field(
        default=None, description="length along z, in length_unit; without it a plane body"
    )
    element_size: Length = Field(description="largest edge length of the elements, in length_unit")

    def build(self, gmsh_model: GmshModel) -> None:
        """Fill the current gmsh model with geometry, mesh and named groups."""
        inner = self.distance / 2
        outer = inner + self.width
        body = Rectangles(
            x=(-outer, -inner, inner, outer),
            y=(-self.foot, 0.0, self.length),
            filled=((0, 0), (1, 0), (2, 0), (0, 1), (2, 1)),
            size=self.element_size,
            depth=self.depth,
        )
        body.build(
            gmsh_model,
            {
                "foot": [("x", 0, 0), ("x", 1, 0), ("x", 2, 0)],
                "left inner": [("y", 1, 1)],
                "right inner": [("y", 2, 1)],
                "left outer": [("y", 0, 1)],
                "right outer": [("y", 3, 1)],
                "left tip": [("x", 0, 2)],
                "right tip": [("x", 2, 2)],
            },
        )
